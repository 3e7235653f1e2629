// Curves, a panel for each quantity.

// points of a curve between two times: at most the least and the largest of each pixel column, in their order
const thinned = (time, values, from, to, columns) => {
  const first = Math.max(lowerBound(time, from) - 1, 0);
  const last = Math.min(lowerBound(time, to) + 1, time.length);
  const xs = [], ys = [];
  if (last - first <= 2 * columns) {
    for (let i = first; i < last; ++i) { xs.push(time[i]); ys.push(values[i]); }
    return {xs, ys};
  }
  const step = (last - first) / columns;
  for (let k = 0; k < columns; ++k) {
    let least = -1, most = -1;
    const begin = first + Math.floor(k * step), end = first + Math.floor((k + 1) * step);
    for (let i = begin; i < end; ++i) {
      if (Number.isNaN(values[i])) continue;
      if (least < 0 || values[i] < values[least]) least = i;
      if (most < 0 || values[i] > values[most]) most = i;
    }
    if (least < 0) { xs.push(time[begin]); ys.push(NaN); continue; }
    for (const i of least < most ? [least, most] : most < least ? [most, least] : [least]) { xs.push(time[i]); ys.push(values[i]); }
  }
  return {xs, ys};
};
// curves with times of their own as rows of one table; null: a curve has no point there
const merged = curves => {
  const at = curves.map(() => 0);
  const rows = [];
  for (;;) {
    let x = Infinity;
    curves.forEach((curve, k) => { if (at[k] < curve.xs.length && curve.xs[at[k]] < x) x = curve.xs[at[k]]; });
    if (x === Infinity) return rows;
    rows.push([x, ...curves.map((curve, k) => at[k] < curve.xs.length && curve.xs[at[k]] === x ? curve.ys[at[k]++] : null)]);
  }
};

// a curve's points, wherever they are: of a run, or of what was measured along the shown run's motion
const curveOf = (owner, motion, name) => {
  if (!owner) return null;
  const values = column(owner.curves || owner.frames, name);
  return values && {time: owner.curves ? motion.curveTime : motion.time, values};
};
const seriesOf = panel => [
  {key: 'plates', owner: shown.motion.plates, motion: shown.motion, ink: colour('measured'), width: 4},
  {key: 'published', owner: shown.motion.published, motion: shown.motion, ink: colour('quiet'), width: 1.5, pattern: [2, 3]},
  {key: 'asked', owner: shown.motion.asked, motion: shown.motion, ink: colour('quiet'), width: 1.4, pattern: [5, 3]},
  ...runs.filter(isVisible).sort((a, b) => (a === shown) - (b === shown))
    .map(run => ({key: 'run ' + run.index, owner: run, motion: run.motion, ink: runColour(run), width: run === shown ? 2 : 1.4})),
].map(series => ({...series, curve: curveOf(series.owner, series.motion, panel.name)})).filter(series => series.curve);

const panels = [];
const grids = new Map(); // of panels, by their section's title
const addSection = title => {
  const id = 'section-' + grids.size;
  const grid = make('div', {class: 'panels'});
  byId('plots').append(make('section', {class: 'card', 'aria-labelledby': id}, make('h2', {id, text: title}), grid));
  grids.set(title, grid);
};
const addPanel = (grid, curve, wide) => {
  const chart = make('div', {class: 'chart'});
  const cursor = make('div', {class: 'cursor'});
  const plot = make('div', {class: 'plot', role: 'img', 'aria-label': `${curve.title} over time, ${curve.unit}`}, chart, cursor);
  const values = make('span', {class: 'values'});
  grid.append(make('figure', wide ? {class: 'wide'} : {},
    make('figcaption', {}, make('span', {class: 'title', text: `${curve.title}, ${curve.unit}`}), values), plot));
  const panel = {...curve, chart, cursor, plot, values, dygraph: null};
  panels.push(panel);
  plot.addEventListener('pointerdown', event => {
    pause();
    plot.setPointerCapture(event.pointerId);
    scrub(panel, event);
  });
  plot.addEventListener('pointermove', event => { if (event.buttons & 1) scrub(panel, event); });
  plot.addEventListener('dblclick', () => setView([begin, end]));
  plot.addEventListener('wheel', event => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoom(Math.exp(0.002 * event.deltaY), timeUnder(panel, event));
  }, {passive: false});
};
const timeUnder = (panel, event) => panel.dygraph.toDataXCoord(event.clientX - panel.plot.getBoundingClientRect().left);
const scrub = (panel, event) => setTime(Math.min(Math.max(timeUnder(panel, event), view[0]), view[1]));

// panels for the curves that runs have; of a live motion these may become more
const buildPanels = () => {
  for (const {title, curves} of report.sections) {
    if (!grids.has(title)) addSection(title);
    const grid = grids.get(title);
    for (const curve of curves) {
      const alone = curve.side !== null && !curves.some(other => other !== curve && other.group === curve.group);
      const known = panels.some(panel => panel.name === curve.name);
      if (!known && runs.some(run => run.frames[curve.name] !== undefined)) addPanel(grid, curve, alone);
    }
    grid.parentElement.hidden = grid.children.length === 0;
  }
};

// the range that all panels of a group show; until another run is shown, or other ones are visible
const ranges = new Map();
const rangeOf = group => {
  if (!ranges.has(group)) ranges.set(group, findRange(group));
  return ranges.get(group);
};
const findRange = group => {
  let low = Infinity, high = -Infinity;
  for (const panel of panels.filter(candidate => candidate.group === group))
    for (const {curve} of seriesOf(panel))
      for (const value of curve.values) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
  if (!(low <= high)) return [-1, 1];
  if (low >= 0 && low < 0.3 * high) low = 0;
  const margin = 0.06 * (high - low) || 0.1 * Math.abs(high) || 1;
  return [low === 0 ? 0 : low - margin, high + margin];
};
const underlay = panel => (pen, area, dygraph) => {
  if (panel.side) {
    const motion = shown.motion;
    for (const [from, to, contact] of motion.stances[panel.side]) {
      const a = Math.max(dygraph.toDomXCoord(motion.time[from]), area.x);
      const b = Math.min(dygraph.toDomXCoord(endOf(motion, to)), area.x + area.w);
      if (b <= a) continue;
      pen.globalAlpha = contact === 'sole' ? 0.13 : 0.07;
      pen.fillStyle = colour('contact');
      pen.fillRect(a, area.y, b - a, area.h);
      pen.globalAlpha = 1;
    }
  }
  for (const number of [0, ...panel.bounds]) {
    const y = dygraph.toDomYCoord(number);
    if (!(y > area.y && y < area.y + area.h)) continue;
    pen.strokeStyle = number === 0 ? colour('ground') : colour('warning');
    pen.lineWidth = 1;
    pen.setLineDash(number === 0 ? [] : [6, 4]);
    pen.beginPath();
    pen.moveTo(area.x, Math.round(y) + 0.5);
    pen.lineTo(area.x + area.w, Math.round(y) + 0.5);
    pen.stroke();
    pen.setLineDash([]);
  }
};
const plotPanel = panel => {
  const series = seriesOf(panel);
  const width = Math.max(panel.plot.clientWidth - 60, 50);
  const rows = merged(series.map(({curve}) => thinned(curve.time, curve.values, view[0], view[1], width)));
  const options = {
    file: rows.length ? rows : [[0, ...series.map(() => NaN)]],
    labels: ['time', ...series.map(({key}) => key)],
    colors: series.map(({ink}) => ink),
    series: Object.fromEntries(series.map(({key, width: strokeWidth, pattern}) => [key, {strokeWidth, strokePattern: pattern || null}])),
    dateWindow: view,
    valueRange: rangeOf(panel.group),
    gridLineColor: colour('grid'),
    axisLineColor: colour('edge'),
  };
  if (panel.dygraph) {
    panel.dygraph.updateOptions(options);
    return;
  }
  const {file, ...rest} = options;
  panel.dygraph = new Dygraph(panel.chart, file, {
    ...rest,
    legend: 'never', interactionModel: {}, connectSeparatedPoints: true, highlightCircleSize: 0, rightGap: 6, xRangePad: 0,
    axes: {
      x: {axisLabelFormatter: t => text(t, 5), pixelsPerLabel: 60, axisLabelWidth: 50},
      y: {axisLabelFormatter: value => text(value, 4), pixelsPerLabel: 26, axisLabelWidth: 48},
    },
    underlayCallback: underlay(panel),
  });
};
const plotAll = () => { panels.forEach(plotPanel); showCursor(); };
