// Contacts and flags over time.

const STRIP_LEFT = 92, STRIP_RIGHT = 8, ROW = 15;
const stripX = (width, t) => STRIP_LEFT + (t - view[0]) / (view[1] - view[0]) * (width - STRIP_LEFT - STRIP_RIGHT);

const drawStrip = () => {
  const motion = shown.motion;
  const rows = [
    ...robot.feet.map(foot => ({name: foot.side + ' foot', contacts: true, found: motion.stances[foot.side]})),
    ...shown.flagRows,
  ];
  const {pen, width, height} = fitCanvas(byId('strip'), ROW * rows.length + 4);
  pen.font = '11px system-ui, sans-serif';
  pen.textBaseline = 'middle';
  rows.forEach(({name, contacts, found}, i) => {
    const y = i * ROW + 2;
    pen.textAlign = 'right';
    pen.fillStyle = colour('quiet');
    pen.fillText(words(name), STRIP_LEFT - 8, y + ROW / 2, STRIP_LEFT - 8);
    pen.fillStyle = colour('grid');
    pen.fillRect(STRIP_LEFT, y + 2, width - STRIP_LEFT - STRIP_RIGHT, ROW - 4);
    for (const [from, to, contact] of found) {
      if (motion.time[from] > view[1] || endOf(motion, to) < view[0]) continue;
      const a = Math.max(stripX(width, motion.time[from]), STRIP_LEFT), b = Math.min(stripX(width, endOf(motion, to)), width - STRIP_RIGHT);
      pen.fillStyle = colour(contacts ? 'contact' : 'warning');
      pen.globalAlpha = !contacts || contact === 'sole' ? 0.85 : 0.45;
      pen.fillRect(a, y + 2, Math.max(b - a, 1), ROW - 4);
      pen.globalAlpha = 1;
      if (contacts && b - a > 34) {
        pen.textAlign = 'center';
        pen.fillStyle = contact === 'sole' ? colour('card') : colour('text');
        pen.fillText(contact, (a + b) / 2, y + ROW / 2 + 0.5);
      }
    }
  });
  pen.fillStyle = colour('text');
  pen.fillRect(stripX(width, now) - 0.5, 0, 1.5, height);
};
