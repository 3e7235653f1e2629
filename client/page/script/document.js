// What the page is about: the document (report_page.h), and which part of it is shown.
//
// The document: robot {links, joints, feet}; sections of curves {name, title, unit, side, group, bounds}; names of contacts
// by number, and of flags by bit; motions, each with times and poses by frame, the runs that answered it and, where answers
// have other accelerations than it, those that were `asked` for. A run's columns are `frames` by name and, of a motion too
// long to be held whole, `curves`: the least and the largest value of each stretch, at the times `curve_time`. Of view also
// `liveness`: the ages, in s, of the last answer and of torqued's last status, and whether that said that torqued was
// stopping.

const bytes = text => {
  const binary = atob(text);
  const array = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) array[i] = binary.charCodeAt(i);
  return array.buffer;
};

const report = JSON.parse(byId('report').textContent);
const robot = report.robot;
const decoded = new Map(); // columns, as soon as they are needed
const column = (table, name) => {
  const text = table && table[name];
  if (text === undefined) return null;
  if (!decoded.has(text)) decoded.set(text, new Float32Array(bytes(text)));
  return decoded.get(text);
};

const LETTER = {left: 'L', right: 'R'}; // of a side's columns
let motions = [], runs = [];
let begin = 0, end = 1;     // s, of what there is
let shown = null;           // the run whose torques and forces the robot shows
let now = 0;                // s
let view = [0, 1];          // s, what the curves show
const hidden = new Set();   // runs that are not among the curves, by index
const layers = {forces: true, measured: true, cones: true, torques: true, poses: true};

const bySide = of => ({left: of('left'), right: of('right')});

// takes a document's motions, and works out what is drawn again and again
const load = document => {
  decoded.clear();
  motions = document.motions.map(motion => {
    const shift = t => t + motion.start;
    return {
      ...motion,
      time: new Float64Array(bytes(motion.time)).map(shift),
      curveTime: motion.curve_time ? new Float64Array(bytes(motion.curve_time)).map(shift) : null,
      poses: new Float32Array(bytes(motion.poses)),
      contacts: bySide(side => column(motion.frames, 'contact' + LETTER[side])),
    };
  });
  for (const motion of motions) {
    motion.top = topOf(motion);
    motion.path = pathOf(motion);
    motion.strobes = strobesOf(motion);
    motion.stances = bySide(side => stretches(motion.contacts[side]).map(([from, to, value]) => [from, to, report.contacts[value]])
      .filter(stance => stance[2] !== 'none'));
  }
  runs = motions.flatMap(motion => motion.runs.map(run => ({...run, motion})));
  runs.forEach((run, index) => {
    run.index = index;
    run.flagRows = flagRowsOf(run);
  });
  shown = runs[shown ? Math.min(shown.index, runs.length - 1) : 0] || null;
  begin = Math.min(...motions.map(motion => motion.time[0]));
  end = Math.max(begin + 1e-6, ...motions.map(motion => motion.time[motion.time.length - 1]));
};
const isVisible = run => !hidden.has(run.index);

// the first index whose time is not before t
const lowerBound = (time, t) => {
  let low = 0, high = time.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (time[middle] < t) low = middle + 1; else high = middle;
  }
  return low;
};
// the frame nearest to t
const frameAt = (motion, t) => {
  const next = Math.min(lowerBound(motion.time, t), motion.time.length - 1);
  return next > 0 && t - motion.time[next - 1] < motion.time[next] - t ? next - 1 : next;
};
const valueAt = (table, name, frame) => {
  const values = column(table, name);
  return values ? values[frame] : NaN;
};

const contactAt = (motion, side, frame) => report.contacts[motion.contacts[side][frame]];
const isFlagged = (run, name, frame) => (valueAt(run.frames, 'flags', frame) >> report.flags.indexOf(name) & 1) !== 0;

const stretches = values => { // [from, to, value] of equal values, by frame
  const found = [];
  for (let i = 0, from = 0; i < values.length; ++i)
    if (i + 1 === values.length || values[i + 1] !== values[i]) {
      found.push([from, i, values[i]]);
      from = i + 1;
    }
  return found;
};
const endOf = (motion, frame) => motion.time[Math.min(frame + 1, motion.time.length - 1)];
const flagRowsOf = run => {
  const values = column(run.frames, 'flags');
  const set = test => stretches(Float32Array.from(values, v => test(v) ? 1 : 0)).filter(stretch => stretch[2] === 1);
  return [{name: 'no answer', found: set(Number.isNaN)}, ...report.flags.map((name, bit) => ({name, found: set(v => v >> bit & 1)}))]
    .filter(row => row.found.length > 0);
};
