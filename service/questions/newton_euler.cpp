#include "questions/newton_euler.h"

#include <cmath>

namespace torqued
{

namespace
{

// A frame that moves: v and its rate of change in components of the frame itself.
struct Frame
{
  Eigen::Vector2d p; // origin, from the base point, world frame
  double angle, rate, acceleration;
  Eigen::Vector2d v, vdot;

  Eigen::Vector2d heading() const { return {std::cos(angle), std::sin(angle)}; }
  Eigen::Vector2d in_world(const Eigen::Vector2d& r) const { return rotate(heading(), r); }
};

// (36) and its derivative: the frame at r of a frame, turned by an angle of its own
Frame carried(const Frame& by, const Eigen::Vector2d& r, double angle, double rate, double acceleration)
{
  const double turned = angle - by.angle;
  const double turning = rate - by.rate;
  const Eigen::Vector2d back(std::cos(turned), -std::sin(turned));
  Frame frame{by.p + by.in_world(r), angle, rate, acceleration, {0.0, 0.0}, {0.0, 0.0}};
  frame.v = rotate(back, by.v + by.rate * perp(r));
  frame.vdot = rotate(back, by.vdot + by.acceleration * perp(r)) - turning * perp(frame.v);
  return frame;
}

// the link whose own angle turns this one
int turned_by(const Robot& robot, int link)
{
  while (link != robot.root() && robot.link(link).joint != JointKind::revolute &&
         robot.link(link).joint != JointKind::rolling)
    link = robot.link(link).joint == JointKind::parallel ? robot.root() : robot.link(link).parent;
  return link;
}

} // namespace

LinkDynamics link_dynamics(const Link& link, const Eigen::Vector2d& heading, double rate, double gravity)
{
  const double m = link.mass;
  const Eigen::Vector2d& c = link.com;
  LinkDynamics dynamics;
  dynamics.M << m, 0.0, -m * c.y(), //
      0.0, m, m * c.x(),            //
      -m * c.y(), m * c.x(), link.inertia + m * c.squaredNorm();
  dynamics.C << 0.0, -m, -m * c.x(), //
      m, 0.0, -m * c.y(),            //
      m * c.x(), m * c.y(), 0.0;
  dynamics.C *= rate;
  const Eigen::Vector2d up(heading.y(), heading.x());
  dynamics.g << m * gravity * up, m * gravity * cross(c, up);
  return dynamics;
}

NewtonEuler newton_euler(const Robot& robot, const VectorQ& q, const VectorQ& v, const VectorQ& a,
                         const std::array<Eigen::Vector3d, 2>& ground)
{
  const std::size_t links = robot.links.size();
  std::vector<Frame> frames(links);
  std::vector<double> slid(links, 0.0); // acceleration sideways
  NewtonEuler result{std::vector<JointWrench>(links, {{0.0, 0.0}, {0.0, 0.0}, 0.0, 0.0}), {}};

  // from the root outwards: how each frame moves
  for (const int i : robot.order)
  {
    const Link& link = robot.link(i);
    const auto at = static_cast<std::size_t>(i);
    const int own = link.coordinate;
    if (i == robot.root())
    {
      const double angle = q(own);
      const Eigen::Vector2d back(std::cos(angle), -std::sin(angle));
      frames[at] = {{0.0, 0.0}, angle, v(own), a(own), rotate(back, v.tail<2>()), {0.0, 0.0}};
      frames[at].vdot = rotate(back, a.tail<2>()) - v(own) * perp(frames[at].v);
      continue;
    }
    const Frame& parent = frames[static_cast<std::size_t>(link.parent)];
    const Frame& root = frames[static_cast<std::size_t>(robot.root())];
    Frame& frame = frames[at];
    JointWrench& joint = result.joints[at];
    slid[at] = slid[static_cast<std::size_t>(link.parent)];
    switch (link.joint)
    {
    case JointKind::floating: break;
    case JointKind::revolute: frame = carried(parent, link.at, q(own), v(own), a(own)); break;
    case JointKind::rolling:
    {
      // both circles have the same velocity where they touch: (r_p + r_c) γ̇ = r_p φ̇_parent + r_c φ̇
      const auto mixed = [&link](double of_parent, double of_child)
      {
        return link.parent_share() * of_parent + link.child_share() * of_child;
      };
      const Frame bar = carried(parent, link.at, mixed(parent.angle, q(own)) + link.angle, mixed(parent.rate, v(own)),
                                mixed(parent.acceleration, a(own)));
      frame = carried(bar, {0.0, -link.parent_radius - link.child_radius}, q(own), v(own), a(own));
      joint.at = bar.p + bar.in_world({0.0, -link.parent_radius});
      break;
    }
    case JointKind::parallel:
      frame = carried(parent, link.at, root.angle + link.angle, root.rate, root.acceleration);
      break;
    case JointKind::slide:
      frame = carried(parent, link.at, parent.angle, parent.rate, parent.acceleration);
      slid[at] += a(own);
      break;
    case JointKind::fixed:
      frame = carried(parent, link.at, parent.angle + link.angle, parent.rate, parent.acceleration);
      break;
    }
    if (link.joint != JointKind::rolling)
      joint.at = frame.p;
  }

  // what moves each link, its own motion (45) less what the ground does; so far about its origin
  for (std::size_t i = 0; i < links; ++i)
  {
    const Link& link = robot.links[i];
    const Frame& frame = frames[i];
    const auto [M, C, g] = link_dynamics(link, frame.heading(), frame.rate, robot.mechanism.gravity());
    const Eigen::Vector3d V(frame.v.x(), frame.v.y(), frame.rate);
    const Eigen::Vector3d Vdot(frame.vdot.x(), frame.vdot.y(), frame.acceleration);
    const Eigen::Vector3d f = M * Vdot + C * V + g;
    JointWrench& joint = result.joints[i];
    joint.force = frame.in_world(f.head<2>());
    joint.moment = f(2);
    joint.sideways = link.mass * slid[i];
    for (const Side side : kSides)
    {
      const Foot& foot = robot.foot(side);
      if (foot.link != static_cast<int>(i))
        continue;
      const Eigen::Vector3d& w = ground[static_cast<std::size_t>(side)];
      joint.force -= w.head<2>();
      joint.moment -= w(2) + cross(frame.in_world(foot.ankle_at), w.head<2>());
    }
  }

  // from the leaves inwards (34): each link passes on what it needs, about its joint; the moment between two links is
  // what the angle between them needs
  VectorQ force = VectorQ::Zero(robot.mechanism.num_theta());
  for (auto it = robot.order.rbegin(); it != robot.order.rend(); ++it)
  {
    const Link& link = robot.link(*it);
    const auto i = static_cast<std::size_t>(*it);
    JointWrench& joint = result.joints[i];
    joint.moment += cross(frames[i].p - joint.at, joint.force);
    if (link.joint == JointKind::slide)
      force(link.coordinate) += joint.sideways;
    if (*it == robot.root())
      continue;
    JointWrench& parent = result.joints[static_cast<std::size_t>(link.parent)];
    parent.force += joint.force;
    parent.sideways += joint.sideways;
    parent.moment += cross(joint.at - frames[static_cast<std::size_t>(link.parent)].p, joint.force);
    JointWrench& holder =
        link.joint == JointKind::parallel ? result.joints[static_cast<std::size_t>(robot.root())] : parent;
    holder.moment += joint.moment;
    if (link.joint == JointKind::revolute || link.joint == JointKind::rolling)
    {
      force(link.coordinate) += joint.moment;
      force(robot.link(turned_by(robot, link.parent)).coordinate) -= joint.moment;
    }
  }
  const Link& root = robot.link(robot.root());
  force(root.coordinate) += result.joints[static_cast<std::size_t>(robot.root())].moment;
  result.torque = joint_torques(robot, force);
  return result;
}

} // namespace torqued
