// The table of figures.

const percent = (part, whole) => whole === 0 ? '–' : `${text(100 * part / whole, 3)} %`;
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
  const flags = report.flags.filter(name => runs.some(run => run.figures.flags[name]));
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
        const name = `${channel.title}, ${channel.unit}`;
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
