// One cursor for all that is drawn, and how it moves.

const showCursor = () => {
  const few = runs.filter(isVisible).length <= 3;
  for (const panel of panels) {
    if (!panel.dygraph) continue;
    const inside = now >= view[0] && now <= view[1];
    panel.cursor.style.visibility = inside ? 'visible' : 'hidden';
    if (inside) panel.cursor.style.transform = `translateX(${panel.dygraph.toDomXCoord(now)}px)`;
    const written = seriesOf(panel).filter(({key, owner}) => few || owner === shown || !key.startsWith('run'))
      .sort((a, b) => (a.owner.index ?? -1) - (b.owner.index ?? -1))
      .map(({key, owner, motion, ink}) => ({key, ink, value: valueAt(owner.frames, panel.name, frameAt(motion, now))}));
    while (panel.values.children.length > written.length) panel.values.lastChild.remove();
    while (panel.values.children.length < written.length) panel.values.append(make('span'));
    written.forEach(({key, ink, value}, k) => {
      const span = panel.values.children[k];
      span.dataset.of = key;
      span.dataset.value = value;
      const ofRun = key.startsWith('run');
      span.style.color = ofRun ? ink : colour('quiet');
      span.textContent = ` ${ofRun ? '' : key + ' '}${text(value, 4)} `;
    });
  }
};
const setTime = t => {
  now = Math.min(Math.max(t, begin), end);
  const length = view[1] - view[0];
  if (now > view[1] || now < view[0]) {
    const from = Math.min(Math.max(now - 0.1 * length, begin), end - length);
    setView([from, from + length]);
  }
  const motion = shown.motion, frame = frameAt(motion, now);
  const slider = byId('time');
  slider.value = frame;
  slider.setAttribute('aria-valuetext', `${motion.time[frame].toFixed(3)} s`);
  byId('clock').textContent = `${motion.time[frame].toFixed(3)} of ${end.toFixed(3)} s`;
  showCursor();
  drawStage();
  drawStrip();
};
const setView = ([from, to]) => {
  const length = Math.min(Math.max(to - from, 1e-3), end - begin);
  const first = Math.min(Math.max(from, begin), end - length);
  view = [first, first + length];
  showView();
};
const showView = () => {
  byId('window').textContent = view[1] - view[0] < end - begin ? `${view[0].toFixed(3)} to ${view[1].toFixed(3)} s` : '';
  plotAll();
  drawStrip();
};
const zoom = (factor, about = now) => setView([about - factor * (about - view[0]), about + factor * (view[1] - about)]);
const step = by => {
  pause();
  const {time} = shown.motion;
  setTime(time[Math.min(Math.max(frameAt(shown.motion, now) + by, 0), time.length - 1)]);
};

// ---- playing ----

let playing = false;
let lastTick = null;
const tick = stamp => {
  if (!playing) return;
  if (lastTick !== null) {
    const next = now + Number(byId('speed').value) * Math.min((stamp - lastTick) / 1000, 0.1);
    setTime(next > end ? begin : next);
  }
  lastTick = stamp;
  requestAnimationFrame(tick);
};
const setPlaying = on => {
  playing = on;
  lastTick = null;
  byId('play').textContent = on ? 'Pause' : 'Play';
  if (on) requestAnimationFrame(tick);
};
const pause = () => {
  if (playing) setPlaying(false);
  if (following) setFollowing(false);
};
const toggle = () => report.live ? setFollowing(!following) : setPlaying(!playing);
