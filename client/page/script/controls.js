// Choices, keys, and the start.

const fillRuns = () => {
  const choice = byId('shown');
  for (const run of runs) {
    choice.append(make('option', {value: run.index, text: run.name}));
    const box = make('input', {type: 'checkbox'});
    box.checked = true;
    box.addEventListener('change', () => { if (box.checked) hidden.delete(run.index); else hidden.add(run.index); ranges.clear(); plotAll(); });
    byId('runs').append(make('label', {}, box, make('span', {class: 'swatch', mark: `var(--run-${run.index % 10})`}), run.name));
  }
  choice.addEventListener('change', () => show(runs[Number(choice.value)]));
  byId('choice').hidden = runs.length < 2;
};
const show = run => {
  shown = run;
  ranges.clear();
  byId('time').max = run.motion.time.length - 1;
  fillKey();
  showView();
  setTime(now);
};
const fillKey = () => {
  const key = byId('key');
  key.replaceChildren(
    make('span', {mark: `var(--run-${shown.index % 10})`, text: `ground reaction, ${shown.name}`}),
    ...(shown.motion.plates ? [make('span', {mark: 'var(--measured)', text: 'measured by force plates'})] : []),
    make('span', {mark: 'var(--positive)', text: 'torque, counter-clockwise'}),
    make('span', {mark: 'var(--negative)', text: 'torque, clockwise'}),
    make('span', {mark: 'var(--left)', text: 'left leg'}));
};
const fillLayers = () => {
  const names = {forces: 'ground reactions', measured: 'measured ones', cones: 'friction cones', torques: 'torques', poses: 'other instants'};
  for (const [layer, name] of Object.entries(names)) {
    if (layer === 'measured' && !motions.some(motion => motion.plates)) continue;
    const box = make('input', {type: 'checkbox'});
    box.checked = true;
    box.addEventListener('change', () => { layers[layer] = box.checked; drawStage(); });
    byId('layers').append(make('label', {}, box, name));
  }
};

const setTheme = theme => {
  document.documentElement.dataset.theme = theme;
  byId('theme').textContent = theme === 'dark' ? 'Light' : 'Dark';
};

setTheme(window.matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light');
const summary = () => [robot.name, ...motions.map(motion =>
  `${motion.source}: ${motion.samples} samples in ${motion.seconds.toFixed(3)} s${motion.curveTime && !report.live ? ', thinned for drawing' : ''}`)].join(' · ');
// the first motion is here
const begun = () => {
  fillRuns();
  fillLayers();
  view = [begin, report.live || end - begin <= 20 ? end : begin + 10];
  now = begin;
  byId('content').hidden = false;
  refresh();
};
const redraw = () => {
  if (!shown) return;
  plotAll();
  setTime(now);
};
const refresh = () => {
  buildPanels();
  byId('summary').textContent = summary();
  fillFigures();
  show(shown);
};
if (report.live) {
  byId('pace').hidden = true;
  byId('summary').textContent = `${robot.name} · nothing heard yet: waiting for desired states`;
  setFollowing(true);
  fetchLast();
  setInterval(warn, 250);
} else {
  load(report);
  begun();
}
byId('theme').addEventListener('click', () => {
  setTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark');
  redraw();
});
byId('play').addEventListener('click', () => toggle());
byId('back').addEventListener('click', () => step(-1));
byId('forth').addEventListener('click', () => step(1));
byId('closer').addEventListener('click', () => zoom(0.5));
byId('wider').addEventListener('click', () => zoom(2));
byId('all').addEventListener('click', () => setView([begin, end]));
byId('time').addEventListener('input', event => { pause(); setTime(shown.motion.time[Number(event.target.value)]); });
const strip = byId('strip');
const scrubStrip = event => {
  const {left, width} = strip.getBoundingClientRect();
  const share = (event.clientX - left - STRIP_LEFT) / (width - STRIP_LEFT - STRIP_RIGHT);
  setTime(view[0] + Math.min(Math.max(share, 0), 1) * (view[1] - view[0]));
};
strip.addEventListener('pointerdown', event => { pause(); strip.setPointerCapture(event.pointerId); scrubStrip(event); });
strip.addEventListener('pointermove', event => { if (event.buttons & 1) scrubStrip(event); });
document.addEventListener('keydown', event => {
  if (!shown || event.ctrlKey || event.altKey || event.metaKey || event.target.closest('input, select, button')) return;
  const actions = {' ': toggle, ArrowLeft: () => step(-1), ArrowRight: () => step(1), '+': () => zoom(0.5), '-': () => zoom(2), 0: () => setView([begin, end])};
  if (!actions[event.key]) return;
  event.preventDefault();
  actions[event.key]();
});
let width = window.innerWidth;
window.addEventListener('resize', () => {
  if (window.innerWidth === width) return;
  width = window.innerWidth;
  panels.forEach(panel => panel.dygraph.resize());
  redraw();
});
