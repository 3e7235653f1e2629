// Where the robot's parts are in the world, frame by frame.

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
