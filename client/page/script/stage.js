// The stage: the robot at one instant, with its torques and its ground reactions.
//
// A scene is one picture: the pen, the motion and its frame; `scale`, in px per m; `middle`, the x that is in the middle,
// and how far the picture reaches from there, in m; `ground`, its height in px; and `place`, from the world to the canvas.

const sceneOf = (canvas, motion, frame) => {
  const {pen, width, height} = fitCanvas(canvas);
  const ground = height - 34;
  const scale = (ground - 12) / (1.04 * motion.top);
  const middle = motion.path[frame];
  const place = ([x, z]) => [width / 2 + (x - middle) * scale, ground - z * scale];
  return {pen, motion, frame, scale, middle, reach: width / 2 / scale, width, ground, place};
};

// a mark every half metre
const drawGround = ({pen, middle, reach, width, ground, place}) => {
  pen.fillStyle = colour('ground');
  pen.fillRect(0, ground, width, 1.5);
  pen.font = '11px system-ui, sans-serif';
  pen.textAlign = 'center';
  for (let mark = Math.ceil(2 * (middle - reach)); mark <= 2 * (middle + reach); ++mark) {
    const [x] = place([mark / 2, 0]);
    pen.fillStyle = colour('ground');
    pen.fillRect(x, ground, 1, 5);
    pen.fillStyle = colour('quiet');
    pen.fillText(mark / 2 + (mark === Math.ceil(2 * (middle - reach)) + 1 ? ' m' : ''), x, ground + 18);
  }
};

// frame: of the scene, or another one; strokeOf: a colour by side, null for the trunk
const drawLinks = ({pen, motion, place, scale}, frame, strokeOf) => {
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

// the same walk at other instants
const drawStrobes = scene => {
  const {pen, motion, middle, reach} = scene;
  pen.globalAlpha = 0.13;
  for (const strobe of motion.strobes)
    if (Math.abs(motion.path[strobe] - middle) < reach + robot.leg_length) drawLinks(scene, strobe, () => colour('quiet'));
  pen.globalAlpha = 1;
};

// where forces must point so that a foot does not slip
const drawCone = ({pen, motion, frame, scale, place}, foot) => {
  const contact = contactAt(motion, foot.side, frame);
  if (contact === 'none' || !(foot.friction > 0)) return;
  const cop = valueAt(shown.frames, 'cop' + LETTER[foot.side], frame);
  const point = contact === 'sole' ? null : foot[contact];
  const tip = place(point ? inWorld(pose(motion, frame, foot.link), point) : onSole(motion, frame, foot, Number.isNaN(cop) ? 0 : cop));
  const tall = 0.34 * robot.leg_length * scale;
  const glow = pen.createLinearGradient(0, tip[1], 0, tip[1] - tall);
  const ink = colour(isFlagged(shown, 'SLIPS', frame) ? 'warning' : 'contact');
  glow.addColorStop(0, ink + '55');
  glow.addColorStop(1, ink + '00');
  pen.fillStyle = glow;
  pen.beginPath();
  pen.moveTo(...tip);
  pen.lineTo(tip[0] - foot.friction * tall, tip[1] - tall);
  pen.lineTo(tip[0] + foot.friction * tall, tip[1] - tall);
  pen.fill();
};

// an arc that is the longer the larger the torque is, turning as it turns; share: of the largest torque
const drawArc = (pen, at, radius, share, ink) => {
  const begin = -Math.PI / 2, end = begin - share * 1.6 * Math.PI;
  pen.strokeStyle = pen.fillStyle = ink;
  pen.lineWidth = 2.5;
  pen.beginPath();
  pen.arc(...at, radius, begin, end, share > 0);
  pen.stroke();
  const turn = share > 0 ? 1 : -1, tip = end - turn * 0.32;
  pen.beginPath();
  pen.moveTo(at[0] + radius * Math.cos(tip), at[1] + radius * Math.sin(tip));
  pen.lineTo(at[0] + (radius + 4.5) * Math.cos(end), at[1] + (radius + 4.5) * Math.sin(end));
  pen.lineTo(at[0] + (radius - 4.5) * Math.cos(end), at[1] + (radius - 4.5) * Math.sin(end));
  pen.fill();
};

const drawTorques = ({pen, motion, frame, scale, place}, strokeOf) => {
  const radius = Math.max(5, 0.028 * robot.leg_length * scale);
  const taken = []; // places of the joints so far: where two coincide, the second arc is the wider one
  for (const joint of robot.joints) {
    const torque = valueAt(shown.frames, 'tau_' + joint.name, frame);
    const at = place(jointPlace(motion, frame, joint));
    if (Number.isNaN(torque) || Number.isNaN(at[0])) continue;
    const share = torque / Math.max(shown.figures.peak, 1e-9);
    const ink = colour(torque > 0 ? 'positive' : 'negative');
    pen.fillStyle = colour('card');
    pen.strokeStyle = strokeOf(robot.links[joint.child].side);
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.arc(...at, radius, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
    pen.globalAlpha = Math.min(1, Math.abs(share));
    pen.fillStyle = ink;
    pen.fill();
    pen.globalAlpha = 1;
    const crowd = taken.filter(other => Math.hypot(other[0] - at[0], other[1] - at[1]) < radius).length;
    taken.push(at);
    if (Math.abs(share) >= 0.03) drawArc(pen, at, (1.9 + 0.9 * crowd) * radius, share, ink);
  }
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

// the force on a foot, from its centre of pressure; the robot's weight is as long as three quarters of a leg
const drawForce = ({pen, motion, frame, scale, place}, table, foot, ink, width) => {
  const [fx, fz, cop] = ['fx', 'fz', 'cop'].map(name => valueAt(table, name + LETTER[foot.side], frame));
  if (Number.isNaN(fx) || Number.isNaN(cop)) return;
  const newton = 0.75 * robot.leg_length / robot.weight * scale; // px
  const from = place(onSole(motion, frame, foot, cop));
  pen.strokeStyle = pen.fillStyle = ink;
  pen.beginPath();
  pen.arc(...from, 1.5 * width, 0, 2 * Math.PI);
  pen.fill();
  arrow(pen, from, [from[0] + newton * fx, from[1] - newton * fz], width);
};

const drawStage = () => {
  const motion = shown.motion;
  const scene = sceneOf(byId('stage'), motion, frameAt(motion, now));
  const ink = {left: colour('left'), right: colour('right')};
  const strokeOf = side => ink[side || 'right'];
  drawGround(scene);
  if (layers.poses) drawStrobes(scene);
  if (layers.cones) for (const foot of robot.feet) drawCone(scene, foot);
  drawLinks(scene, scene.frame, strokeOf);
  if (layers.torques) drawTorques(scene, strokeOf);
  for (const foot of robot.feet) {
    if (layers.measured && motion.plates) drawForce(scene, motion.plates.frames, foot, colour('measured'), 6);
    if (layers.forces) drawForce(scene, shown.frames, foot, runColour(shown), 3);
  }
};
