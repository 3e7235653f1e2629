// view: the last seconds are fetched anew, four times a second, and shown a little late so that they run smoothly.

const LATE = 0.35; // s
const AGED = 1;    // s, from which on an age is told
let following = false, lastFrame = null;
let liveness = null, heardAt = performance.now(); // of the last document
const fetchLast = async () => {
  let heard = null;
  try {
    heard = await (await fetch('document', {cache: 'no-store', signal: AbortSignal.timeout(5000)})).json();
    ({liveness} = heard);
    heardAt = performance.now();
  } catch {
    // warn() tells how long there has been no document
  }
  warn();
  if (heard && following && JSON.stringify(heard.robot) !== JSON.stringify(robot)) { location.reload(); return; }
  if (heard && heard.motions.length > 0 && following) {
    const first = motions.length === 0;
    const closer = view[1] - view[0] < end - begin ? view[1] - view[0] : Infinity;
    load(heard);
    if (first) begun();
    view = [Math.max(begin, end - closer), end];
    if (Math.abs(now - (end - LATE)) > 0.5) now = end - LATE;
    refresh();
  }
  setTimeout(fetchLast, following ? 250 : 500);
};
// tells why what is shown is not what happens now
const warn = () => {
  const since = (performance.now() - heardAt) / 1000;
  const seconds = age => `${age.toFixed(age < 10 ? 1 : 0)} s`;
  const warnings = [];
  if (since > AGED) {
    warnings.push(`torquectl view has not answered for ${seconds(since)}; this page goes on when it is back`);
  } else if (liveness) {
    const status = liveness.status_age + since;
    if (liveness.stopping) warnings.push(`torqued ended ${seconds(status)} ago`);
    else if (status > AGED) warnings.push(`torqued has been silent for ${seconds(status)}: stopped, killed, or cut off from this bus`);
    const answer = liveness.answer_age === null ? null : liveness.answer_age + since;
    if (answer > AGED) warnings.push(`last answer ${seconds(answer)} ago`);
    else if (answer === null && motions.length > 0) warnings.push('no answer so far');
  }
  byId('warning-text').textContent = warnings.join(' · ');
  byId('warning').hidden = warnings.length === 0;
};
const flow = stamp => {
  if (!following) return;
  if (lastFrame !== null && motions.length > 0) {
    const passed = (stamp - lastFrame) / 1000;
    setTime(now + passed + 0.05 * (end - LATE - now - passed)); // towards where it should be
  }
  lastFrame = stamp;
  requestAnimationFrame(flow);
};
const setFollowing = on => {
  if (following === on) return;
  following = on;
  lastFrame = null;
  byId('play').textContent = on ? 'Freeze' : 'Live';
  if (on) {
    requestAnimationFrame(flow);
  }
};
