// The page of torquectl report and view: the robot walks on the stage, curves and figures follow the same cursor. For
// view it fetches the last seconds anew, four times a second.
//
// The document (report_page.h): robot {links, joints, feet}; motions, each with times and poses by frame and the runs that
// answered it. A run's columns are `frames` by name and, of a motion too long to be held whole, `curves`: the least and
// the largest value of each stretch, at the times `curve_time`. Of view also `liveness`: the ages, in s, of the last answer
// and of torqued's last status, and whether that said that torqued was stopping.
'use strict';
(() => {
  const byId = id => document.getElementById(id);
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

  const CONTACTS = ['none', 'heel', 'sole', 'toe'];
  const SIDES = ['L', 'R'];
  const FLAGS = ['SLIPS', 'LIFTS', 'TIPS', 'OVER_TORQUE', 'CLAMPED', 'RELAXED', 'INCONSISTENT', 'LATE', 'OVER_RATE', 'PROJECTED',
    'ADJUSTED', 'CONTACT_ACCELERATION', 'PRIOR'];
  let motions = [], runs = [];
  let begin = 0, end = 1;     // s, of what there is
  let shown = null;           // the run whose torques and forces the robot shows
  let now = 0;                // s
  let view = [0, 1];          // s, what the curves show
  let playing = false;
  const hidden = new Set();   // runs that are not among the curves, by index
  const layers = {forces: true, measured: true, cones: true, torques: true, poses: true};

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
        contacts: SIDES.map(side => column(motion.frames, 'contact' + side)),
      };
    });
    for (const motion of motions) {
      motion.top = topOf(motion);
      motion.path = pathOf(motion);
      motion.strobes = strobesOf(motion);
      motion.stances = motion.contacts.map(stretches);
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

  // ---- numbers ----

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
  const text = (value, digits = 4) => {
    if (value === null || value === undefined || Number.isNaN(value)) return '–';
    if (value === 0) return '0';
    const magnitude = Math.abs(value);
    const rounded = Number(value.toPrecision(digits));
    const written = magnitude >= 1e6 || magnitude < 1e-3 ? Number(value.toPrecision(3)).toExponential() : String(rounded);
    return written.replace('-', '−');
  };
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
  const runColour = run => colour('run-' + run.index % 10);
  const make = (tag, attributes = {}, ...children) => {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name === 'text') element.textContent = value;
      else if (name === 'mark') element.style.setProperty('--mark', value);
      else element.setAttribute(name, value);
    }
    element.append(...children);
    return element;
  };

  // ---- the stage ----

  const fitCanvas = (canvas, height) => {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    if (height) canvas.style.height = height + 'px';
    const tall = height || canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(tall * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(tall * ratio);
    }
    const pen = canvas.getContext('2d');
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, tall);
    return {pen, width, height: tall};
  };

  const pose = (motion, frame, link) => {
    const at = 3 * (frame * robot.links.length + link);
    return {x: motion.poses[at], z: motion.poses[at + 1], angle: motion.poses[at + 2]};
  };
  const inWorld = (frame, point) => {
    const c = Math.cos(frame.angle), s = Math.sin(frame.angle);
    return [frame.x + c * point[0] - s * point[1], frame.z + s * point[0] + c * point[1]];
  };
  const root = robot.links.findIndex(link => link.parent < 0);
  // top of the robot as it stands at the beginning, m
  const topOf = motion => {
    let highest = robot.leg_length;
    robot.links.forEach((link, index) => link.segments.forEach(([x1, z1, x2, z2]) => {
      for (const point of [[x1, z1], [x2, z2]]) {
        const z = inWorld(pose(motion, 0, index), point)[1];
        if (z > highest) highest = z;
      }
    }));
    return highest;
  };
  // the root's x, smoothed over half a second so that the camera glides
  const pathOf = motion => {
    const {time} = motion;
    const x = Float64Array.from(time, (_, i) => pose(motion, i, root).x);
    const smooth = new Float64Array(x.length);
    let from = 0, to = 0, sum = 0, count = 0;
    for (let i = 0; i < x.length; ++i) {
      for (; to < x.length && time[to] <= time[i] + 0.25; ++to) if (!Number.isNaN(x[to])) { sum += x[to]; ++count; }
      for (; time[from] < time[i] - 0.25; ++from) if (!Number.isNaN(x[from])) { sum -= x[from]; --count; }
      smooth[i] = count > 0 ? sum / count : i > 0 ? smooth[i - 1] : 0;
    }
    return smooth;
  };
  // frames about a quarter of a leg apart: the path of the walk, as in a chronophotograph
  const strobesOf = motion => {
    const apart = 0.27 * robot.leg_length;
    const frames = [];
    let last = NaN;
    motion.path.forEach((x, i) => {
      const cell = Math.floor(x / apart); // the same places whatever the motion begins with
      if (cell === last) return;
      frames.push(i);
      last = cell;
    });
    return frames;
  };

  const drawLinks = (pen, motion, frame, place, scale, strokeOf) => {
    for (const side of ['left', null, 'right'])
      robot.links.forEach((link, index) => {
        if (link.side !== side) return;
        const at = pose(motion, frame, index);
        if (Number.isNaN(at.x)) return;
        pen.strokeStyle = strokeOf(side);
        pen.lineCap = 'round';
        for (const [x1, z1, x2, z2, width] of link.segments) {
          pen.lineWidth = Math.max(2.5, width * scale);
          pen.beginPath();
          pen.moveTo(...place(inWorld(at, [x1, z1])));
          pen.lineTo(...place(inWorld(at, [x2, z2])));
          pen.stroke();
        }
        if (link.rolling) {
          pen.lineWidth = 1.5;
          const centre = inWorld(pose(motion, frame, link.parent), link.at);
          for (const [point, radius] of [[[at.x, at.z], link.radius], [centre, link.parent_radius]]) {
            pen.beginPath();
            pen.arc(...place(point), radius * scale, 0, 2 * Math.PI);
            pen.stroke();
          }
        }
      });
  };

  const jointPlace = (motion, frame, joint) => {
    const link = robot.links[joint.child];
    const at = pose(motion, frame, joint.child);
    if (!link.rolling || link.parent < 0) return [at.x, at.z];
    const centre = inWorld(pose(motion, frame, link.parent), link.at);
    const share = link.parent_radius / (link.parent_radius + link.radius);
    return [centre[0] + share * (at.x - centre[0]), centre[1] + share * (at.z - centre[1])];
  };

  // where on the sole, so far from below the ankle, in the world
  const onSole = (motion, frame, foot, along) => {
    const length = Math.hypot(foot.toe[0] - foot.heel[0], foot.toe[1] - foot.heel[1]);
    const point = length > 0 ? [foot.ankle[0] + along, foot.heel[1]] : foot.ankle;
    return inWorld(pose(motion, frame, foot.link), point);
  };

  const arrow = (pen, from, to, width) => {
    const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
    if (length < 1) return;
    const head = Math.min(4 * width, length);
    const [ux, uy] = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    const neck = [to[0] - head * ux, to[1] - head * uy];
    pen.lineWidth = width;
    pen.lineCap = 'butt';
    pen.beginPath();
    pen.moveTo(...from);
    pen.lineTo(...neck);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(...to);
    pen.lineTo(neck[0] - 0.45 * head * uy, neck[1] + 0.45 * head * ux);
    pen.lineTo(neck[0] + 0.45 * head * uy, neck[1] - 0.45 * head * ux);
    pen.fill();
  };

  const drawStage = () => {
    const {pen, width, height} = fitCanvas(byId('stage'));
    const motion = shown.motion;
    const frame = frameAt(motion, now);
    const ground = height - 34;
    const scale = (ground - 12) / (1.04 * motion.top);
    const middle = motion.path[frame];
    const place = ([x, z]) => [width / 2 + (x - middle) * scale, ground - z * scale];
    const newtons = 0.75 * robot.leg_length / robot.weight * scale; // px per N

    // the ground, with a mark every half metre
    pen.fillStyle = colour('ground');
    pen.fillRect(0, ground, width, 1.5);
    pen.font = '11px system-ui, sans-serif';
    pen.textAlign = 'center';
    const reach = width / 2 / scale;
    for (let mark = Math.ceil(2 * (middle - reach)); mark <= 2 * (middle + reach); ++mark) {
      const [x] = place([mark / 2, 0]);
      pen.fillStyle = colour('ground');
      pen.fillRect(x, ground, 1, 5);
      pen.fillStyle = colour('quiet');
      pen.fillText(mark / 2 + (mark === Math.ceil(2 * (middle - reach)) + 1 ? ' m' : ''), x, ground + 18);
    }

    if (layers.poses) {
      pen.globalAlpha = 0.13;
      for (const strobe of motion.strobes)
        if (Math.abs(motion.path[strobe] - middle) < reach + robot.leg_length)
          drawLinks(pen, motion, strobe, place, scale, () => colour('quiet'));
      pen.globalAlpha = 1;
    }

    // where forces must point so that a foot does not slip
    robot.feet.forEach(foot => {
      const s = foot.side === 'left' ? 0 : 1;
      const contact = motion.contacts[s][frame];
      if (!layers.cones || !(contact > 0) || !(foot.friction > 0)) return;
      const cop = valueAt(shown.frames, 'cop' + SIDES[s], frame);
      const point = contact === 1 ? foot.heel : contact === 3 ? foot.toe : null;
      const tip = place(point ? inWorld(pose(motion, frame, foot.link), point) : onSole(motion, frame, foot, Number.isNaN(cop) ? 0 : cop));
      const tall = 0.34 * robot.leg_length * scale;
      const glow = pen.createLinearGradient(0, tip[1], 0, tip[1] - tall);
      const slips = (valueAt(shown.frames, 'flags', frame) & 1) !== 0;
      glow.addColorStop(0, colour(slips ? 'warning' : 'contact') + '55');
      glow.addColorStop(1, colour(slips ? 'warning' : 'contact') + '00');
      pen.fillStyle = glow;
      pen.beginPath();
      pen.moveTo(...tip);
      pen.lineTo(tip[0] - foot.friction * tall, tip[1] - tall);
      pen.lineTo(tip[0] + foot.friction * tall, tip[1] - tall);
      pen.fill();
    });

    const main = {left: colour('left'), right: colour('right'), null: colour('right')};
    drawLinks(pen, motion, frame, place, scale, side => main[side]);

    if (layers.torques) {
      const taken = [];
      for (const joint of robot.joints) {
        const torque = valueAt(shown.frames, 'tau_' + joint.name, frame);
        const at = place(jointPlace(motion, frame, joint));
        if (Number.isNaN(torque) || Number.isNaN(at[0])) continue;
        const share = torque / Math.max(shown.figures.peak, 1e-9);
        const radius = Math.max(5, 0.028 * robot.leg_length * scale);
        pen.fillStyle = colour('card');
        pen.strokeStyle = main[robot.links[joint.child].side];
        pen.lineWidth = 1.5;
        pen.beginPath();
        pen.arc(...at, radius, 0, 2 * Math.PI);
        pen.fill();
        pen.stroke();
        const ink = colour(torque > 0 ? 'positive' : 'negative');
        pen.globalAlpha = Math.min(1, Math.abs(share));
        pen.fillStyle = ink;
        pen.fill();
        pen.globalAlpha = 1;
        // an arc that is the longer the larger the torque is, turning as it turns
        const crowd = taken.filter(other => Math.hypot(other[0] - at[0], other[1] - at[1]) < radius).length;
        const ring = (1.9 + 0.9 * crowd) * radius, start = -Math.PI / 2, end = start - share * 1.6 * Math.PI;
        taken.push(at);
        if (Math.abs(share) < 0.03) continue;
        pen.strokeStyle = pen.fillStyle = ink;
        pen.lineWidth = 2.5;
        pen.beginPath();
        pen.arc(...at, ring, start, end, share > 0);
        pen.stroke();
        const turn = share > 0 ? 1 : -1, tip = end - turn * 0.32;
        pen.beginPath();
        pen.moveTo(at[0] + ring * Math.cos(tip), at[1] + ring * Math.sin(tip));
        pen.lineTo(at[0] + (ring + 4.5) * Math.cos(end), at[1] + (ring + 4.5) * Math.sin(end));
        pen.lineTo(at[0] + (ring - 4.5) * Math.cos(end), at[1] + (ring - 4.5) * Math.sin(end));
        pen.fill();
      }
    }

    const drawForce = (table, foot, ink, thick) => {
      const side = foot.side === 'left' ? 'L' : 'R';
      const [fx, fz, cop] = ['fx', 'fz', 'cop'].map(name => valueAt(table, name + side, frame));
      if (Number.isNaN(fx) || Number.isNaN(cop)) return;
      const from = place(onSole(motion, frame, foot, cop));
      pen.strokeStyle = pen.fillStyle = ink;
      pen.beginPath();
      pen.arc(...from, 1.5 * thick, 0, 2 * Math.PI);
      pen.fill();
      arrow(pen, from, [from[0] + newtons * fx, from[1] - newtons * fz], thick);
    };
    for (const foot of robot.feet) {
      if (layers.measured && motion.plates) drawForce(motion.plates.frames, foot, colour('measured'), 6);
      if (layers.forces) drawForce(shown.frames, foot, runColour(shown), 3);
    }
  };

  // ---- contacts and flags over time ----

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
    return [{name: 'no answer', found: set(Number.isNaN)}, ...FLAGS.map((name, bit) => ({name, found: set(v => v >> bit & 1)}))]
      .filter(row => row.found.length > 0);
  };
  const STRIP_LEFT = 92, STRIP_RIGHT = 8, ROW = 15;
  const stripX = (width, t) => STRIP_LEFT + (t - view[0]) / (view[1] - view[0]) * (width - STRIP_LEFT - STRIP_RIGHT);

  const drawStrip = () => {
    const motion = shown.motion;
    const rows = [
      ...robot.feet.map(foot => ({name: foot.side + ' foot', foot: foot.side === 'left' ? 0 : 1})),
      ...shown.flagRows,
    ];
    const {pen, width, height} = fitCanvas(byId('strip'), ROW * rows.length + 4);
    pen.font = '11px system-ui, sans-serif';
    pen.textBaseline = 'middle';
    rows.forEach((row, i) => {
      const y = i * ROW + 2;
      pen.textAlign = 'right';
      pen.fillStyle = colour('quiet');
      pen.fillText(row.foot === undefined ? row.name.toLowerCase().replace('_', ' ') : row.name, STRIP_LEFT - 8, y + ROW / 2, STRIP_LEFT - 8);
      pen.fillStyle = colour('grid');
      pen.fillRect(STRIP_LEFT, y + 2, width - STRIP_LEFT - STRIP_RIGHT, ROW - 4);
      const found = row.foot === undefined ? row.found : motion.stances[row.foot];
      for (const [from, to, value] of found) {
        if (row.foot !== undefined && !(value > 0)) continue;
        if (motion.time[from] > view[1] || endOf(motion, to) < view[0]) continue;
        const a = Math.max(stripX(width, motion.time[from]), STRIP_LEFT), b = Math.min(stripX(width, endOf(motion, to)), width - STRIP_RIGHT);
        pen.fillStyle = colour(row.foot === undefined ? 'warning' : 'contact');
        pen.globalAlpha = row.foot === undefined || value === 2 ? 0.85 : 0.45;
        pen.fillRect(a, y + 2, Math.max(b - a, 1), ROW - 4);
        pen.globalAlpha = 1;
        if (row.foot !== undefined && b - a > 34) {
          pen.textAlign = 'center';
          pen.fillStyle = value === 2 ? colour('card') : colour('text');
          pen.fillText(CONTACTS[value], (a + b) / 2, y + ROW / 2 + 0.5);
        }
      }
    });
    pen.fillStyle = colour('text');
    pen.fillRect(stripX(width, now) - 0.5, 0, 1.5, height);
  };

  // ---- curves ----

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
    ...runs.filter(isVisible).sort((a, b) => (a === shown) - (b === shown))
      .map(run => ({key: 'run ' + run.index, owner: run, motion: run.motion, ink: runColour(run), width: run === shown ? 2 : 1.4})),
  ].map(series => ({...series, curve: curveOf(series.owner, series.motion, panel.name)})).filter(series => series.curve);

  const panels = [];
  const addSection = title => {
    const id = 'section-' + panels.length;
    const grid = make('div', {class: 'panels'});
    byId('plots').append(make('section', {class: 'card', 'aria-labelledby': id}, make('h2', {id, text: title}), grid));
    return grid;
  };
  // group: panels that share their range; side: whose contacts are shaded; bounds: lines at numbers that matter
  const addPanel = (grid, {name, title, unit, side = null, group = name, bounds = [], wide = false}) => {
    if (!runs.some(run => run.frames[name] !== undefined)) return;
    const chart = make('div', {class: 'chart'});
    const cursor = make('div', {class: 'cursor'});
    const plot = make('div', {class: 'plot', role: 'img', 'aria-label': `${title} over time, ${unit}`}, chart, cursor);
    const values = make('span', {class: 'values'});
    grid.append(make('figure', wide ? {class: 'wide'} : {},
      make('figcaption', {}, make('span', {class: 'title', text: `${title}, ${unit}`}), values), plot));
    const panel = {name, title, unit, side, group, bounds, chart, cursor, plot, values, dygraph: null};
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

  const paired = name => /^(left|right)_(.+)$/.exec(name);
  const buildPanels = () => {
    const torques = addSection('Joint torques');
    const kinds = [...new Set(robot.joints.map(joint => (paired(joint.name) || [])[2]).filter(Boolean))];
    // as they lie in the picture: hip, knee, ankle
    const order = ['hip', 'knee', 'ankle'];
    kinds.sort((a, b) => (order.indexOf(a) + 4) % 4 - (order.indexOf(b) + 4) % 4);
    const bounds = joint => joint.limit === null ? [] : [joint.limit, -joint.limit];
    for (const kind of kinds)
      for (const side of ['left', 'right']) {
        const joint = robot.joints.find(candidate => candidate.name === `${side}_${kind}`);
        if (joint) addPanel(torques, {name: 'tau_' + joint.name, title: `${side} ${kind}`, unit: joint.unit, side, group: kind, bounds: bounds(joint)});
      }
    for (const joint of robot.joints)
      if (!paired(joint.name)) addPanel(torques, {name: 'tau_' + joint.name, title: joint.name, unit: joint.unit, bounds: bounds(joint)});

    const forces = addSection('Ground reactions');
    for (const [quantity, title, unit] of [['fz', 'upward force', 'N'], ['fx', 'forward force', 'N'], ['cop', 'centre of pressure', 'm']])
      for (const foot of robot.feet) {
        const sole = quantity === 'cop' ? [foot.heel[0] - foot.ankle[0], foot.toe[0] - foot.ankle[0]] : [];
        addPanel(forces, {name: quantity + (foot.side === 'left' ? 'L' : 'R'), title: `${foot.side} foot: ${title}`, unit, side: foot.side, group: quantity, bounds: sole, wide: robot.feet.length === 1});
      }

    const checks = addSection('How well it fits');
    addPanel(checks, {name: 'contact_speed', title: 'speed of resting contacts', unit: 'm/s or rad/s'});
    addPanel(checks, {name: 'contact_residual', title: 'acceleration of resting contacts', unit: 'm/s² or rad/s²'});
    addPanel(checks, {name: 'dynamics_residual', title: 'residual of the equation of motion', unit: 'N or N m'});
    addPanel(checks, {name: 'compute_us', title: 'time to compute the answer', unit: 'µs'});
    addPanel(checks, {name: 'delay_us', title: 'from desired state to answer, at the logger', unit: 'µs'});
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
      for (const [from, to, value] of motion.stances[panel.side === 'left' ? 0 : 1]) {
        if (!(value > 0)) continue;
        const a = Math.max(dygraph.toDomXCoord(motion.time[from]), area.x);
        const b = Math.min(dygraph.toDomXCoord(endOf(motion, to)), area.x + area.w);
        if (b <= a) continue;
        pen.globalAlpha = value === 2 ? 0.13 : 0.07;
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

  // ---- one cursor ----

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
        span.style.color = key === 'plates' || key === 'published' ? colour('quiet') : ink;
        span.textContent = ` ${key === 'plates' ? 'plates ' : key === 'published' ? 'published ' : ''}${text(value, 4)} `;
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

  // ---- live: what is shown is the last seconds, a little late so that it runs smoothly ----

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

  // ---- figures ----

  const percent = (part, whole) => whole === 0 ? '–' : `${text(100 * part / whole, 3)} %`;
  const words = name => name.toLowerCase().replace('_', ' ');
  const fillFigures = () => {
    const table = byId('figures');
    table.replaceChildren();
    const group = (title, rows) => {
      if (rows.length === 0) return;
      const body = make('tbody', {}, make('tr', {class: 'group'}, make('th', {scope: 'rowgroup', colspan: runs.length + 1, text: title})));
      for (const [name, cell] of rows)
        body.append(make('tr', {}, make('th', {scope: 'row', text: name}), ...runs.map(run => make('td', {text: cell(run)}))));
      table.append(body);
    };
    table.append(make('thead', {}, make('tr', {}, make('td'), ...runs.map(run =>
      make('th', {scope: 'col'}, make('span', {class: 'swatch', mark: `var(--run-${run.index % 10})`}), ` ${run.name}`)))));
    group('Torques', [
      ['largest, N m', run => text(run.figures.peak)],
      ['root mean square of all, N m', run => text(run.figures.rms)],
      ['Σ∫τ²dt, N² m² s', run => text(run.figures.effort)],
      ['work Σ∫|τθ̇|dt, J', run => text(run.figures.work)],
      ['work per metre, J/m', run => Math.abs(run.figures.distance) > 0.01 * robot.leg_length ? text(run.figures.work === null ? null : run.figures.work / Math.abs(run.figures.distance)) : '–'],
    ]);
    const kinds = [...new Set(runs.flatMap(run => Object.keys(run.figures.jumps)))];
    group('Largest jump of a torque where contacts change, N m', kinds.map(kind =>
      [kind, run => run.figures.jumps[kind] === undefined ? '–' : run.figures.jumps[kind] < 1e-6 ? '0' : text(run.figures.jumps[kind], 3)]));
    const reasons = [...new Set(runs.flatMap(run => Object.keys(run.figures.unanswered)))];
    const flags = FLAGS.filter(name => runs.some(run => run.figures.flags[name]));
    group('Samples', [
      ['answered', run => `${run.figures.answered} of ${run.motion.samples}`],
      ...reasons.map(name => [words(name), run => String(run.figures.unanswered[name] || 0)]),
      ['double support: no foot slips, lifts or tips', run => percent(run.figures.held, run.figures.double_support)],
      ...flags.map(name => [words(name), run => String(run.figures.flags[name] || 0)]),
    ]);
    for (const published of [false, true]) {
      const channels = new Map(); // of both feet, by name
      for (const run of runs)
        for (const channel of run.figures.measured) {
          if (channel.published !== published || channel.rms === null) continue;
          const joint = channel.channel.startsWith('tau_') ? channel.channel.slice(4) : null;
          const name = joint ? `${(paired(joint) || [])[2] || joint}, ${channel.unit}` : {fx: 'forward force, N', fz: 'upward force, N'}[channel.channel.slice(0, 2)];
          if (!channels.has(name)) channels.set(name, new Map());
          channels.get(name).set(run, [...(channels.get(name).get(run) || []), channel]);
        }
      const mean = (all, name) => all.reduce((sum, channel) => sum + channel[name], 0) / all.length;
      group(published ? 'Difference from published joint moments, rms' : 'Difference from the force plates, rms', [...channels].map(([name, byRun]) =>
        [name, run => byRun.has(run) ? `${text(mean(byRun.get(run), 'rms'), 3)} (${text(100 * mean(byRun.get(run), 'of_range'), 3)} %)` : '–']));
    }
    const apart = Math.max(...motions.map(motion => motion.longest_change)) / 1000;
    byId('figures-note').textContent = 'Figures are those of all samples.'
      + (kinds.length > 0 ? ` A jump is the change between two samples, up to ${text(apart)} ms apart.` : '')
      + (runs.some(run => run.figures.measured.length > 0) ? ' Differences: mean of both feet, and their share of the measured range; joint moments from the plates'
        + ' are inverse dynamics of this robot, bottom-up from the measured forces.' : '');
  };
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

  // ---- light and dark ----

  const setTheme = theme => {
    document.documentElement.dataset.theme = theme;
    byId('theme').textContent = theme === 'dark' ? 'Light' : 'Dark';
  };

  // ---- start ----

  setTheme(window.matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light');
  const summary = () => [robot.name, ...motions.map(motion =>
    `${motion.source}: ${motion.samples} samples in ${motion.seconds.toFixed(3)} s${motion.curveTime && !report.live ? ', thinned for drawing' : ''}`)].join(' · ');
  // the first motion is here
  const begun = () => {
    fillRuns();
    fillLayers();
    buildPanels();
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
})();
