#include "questions/newton_euler.h"

#include <cmath>
#include <utility>

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

namespace
{

// One run of the recursion over the links of a robot.
class Recursion
{
public:
  explicit Recursion(const Robot& robot)
      : robot_(robot), frames_(robot.links.size()), sideways_(robot.links.size(), 0.0),
        joints_(robot.links.size(), {{0.0, 0.0}, {0.0, 0.0}, 0.0, 0.0}),
        force_(VectorQ::Zero(robot.mechanism.num_theta()))
  {
  }

  // from the root outwards: how each frame moves
  void move(const VectorQ& q, const VectorQ& v, const VectorQ& a)
  {
    const int own = robot_.link(robot_.root()).coordinate;
    const Eigen::Vector2d back(std::cos(q(own)), -std::sin(q(own)));
    Frame& root = frame(robot_.root());
    root = {{0.0, 0.0}, q(own), v(own), a(own), rotate(back, v.tail<2>()), {0.0, 0.0}};
    root.vdot = rotate(back, a.tail<2>()) - v(own) * perp(root.v);
    for (const int i : robot_.order)
      if (i != robot_.root())
        move_link(i, q, v, a);
  }

  // what moves each link, its own motion (45) less what the ground does; so far about its origin
  void drive(const std::array<Eigen::Vector3d, 2>& ground)
  {
    for (int i = 0; i < static_cast<int>(robot_.links.size()); ++i)
    {
      const Link& link = robot_.link(i);
      const Frame& at = frame(i);
      const auto [M, C, g] = link_dynamics(link, at.heading(), at.rate, robot_.mechanism.gravity());
      const Eigen::Vector3d V(at.v.x(), at.v.y(), at.rate);
      const Eigen::Vector3d Vdot(at.vdot.x(), at.vdot.y(), at.acceleration);
      const Eigen::Vector3d f = M * Vdot + C * V + g;
      JointWrench& needed = joint(i);
      needed.force = at.in_world(f.head<2>());
      needed.moment = f(2);
      needed.sideways = link.mass * sideways(i);
      for (const Side side : kSides)
      {
        const Foot& foot = robot_.foot(side);
        if (foot.link != i)
          continue;
        const Eigen::Vector3d& w = ground[static_cast<std::size_t>(side)];
        needed.force -= w.head<2>();
        needed.moment -= w(2) + cross(at.in_world(foot.ankle_at), w.head<2>());
      }
    }
  }

  // from the leaves inwards (34): each link passes on what it needs, about its joint
  void pass_on()
  {
    for (auto i = robot_.order.rbegin(); i != robot_.order.rend(); ++i)
    {
      const Link& link = robot_.link(*i);
      JointWrench& needed = joint(*i);
      needed.moment += cross(frame(*i).p - needed.at, needed.force);
      if (link.type().slides())
        force_(link.coordinate) += needed.sideways;
      if (*i == robot_.root())
        continue;
      JointWrench& parent = joint(link.parent);
      parent.force += needed.force;
      parent.sideways += needed.sideways;
      parent.moment += cross(needed.at - frame(link.parent).p, needed.force);
      const JointType& type = link.type();
      if (type.coordinate == JointType::Coordinate::angle)
      {
        // between link and parent: the angle between them needs it
        parent.moment += needed.moment;
        add_moment(*i, needed.moment);
        add_moment(link.parent, -needed.moment);
      }
      else
      {
        // what holds the angle does no work: each gives it by its share
        parent.moment += type.angle.parent * needed.moment;
        joint(robot_.root()).moment += type.angle.world * needed.moment;
      }
    }
    add_moment(robot_.root(), joint(robot_.root()).moment);
  }

  NewtonEuler result() && { return {std::move(joints_), joint_torques(robot_, force_)}; }

private:
  Frame& frame(int link) { return frames_[static_cast<std::size_t>(link)]; }
  JointWrench& joint(int link) { return joints_[static_cast<std::size_t>(link)]; }
  double& sideways(int link) { return sideways_[static_cast<std::size_t>(link)]; }

  // (36): the frame at the joint, or at the far end of a bar, by the shares of its angle
  void move_link(int i, const VectorQ& q, const VectorQ& v, const VectorQ& a)
  {
    const Link& link = robot_.link(i);
    const JointType& type = link.type();
    const Frame& parent = frame(link.parent);
    const Frame& root = frame(robot_.root());
    const auto own = [&link](const VectorQ& of)
    {
      return link.coordinate < 0 ? 0.0 : of(link.coordinate);
    };
    const auto carried_at = [&](const Frame& by, const Eigen::Vector2d& r, const AngleShares& shares, double constant)
    {
      return carried(by, r, shares.of(own(q), parent.angle, root.angle) + constant,
                     shares.of(own(v), parent.rate, root.rate),
                     shares.of(own(a), parent.acceleration, root.acceleration));
    };
    if (type.bar)
    {
      const Frame bar = carried_at(parent, link.at, link.bar_shares(), link.angle);
      frame(i) = carried_at(bar, {0.0, -link.parent_radius - link.child_radius}, type.angle, 0.0);
      joint(i).at = bar.p + bar.in_world({0.0, -link.parent_radius}); // where the circles touch
    }
    else
    {
      frame(i) = carried_at(parent, link.at, type.angle, link.angle);
      joint(i).at = frame(i).p;
    }
    sideways(i) = sideways(link.parent) + (type.slides() ? own(a) : 0.0);
  }

  // a moment on a link, as a force on the coordinates that turn it
  void add_moment(int link, double moment)
  {
    const Link& on = robot_.link(link);
    const AngleShares& shares = on.type().angle;
    if (link == robot_.root())
    {
      force_(on.coordinate) += moment;
      return;
    }
    if (shares.own != 0.0)
      force_(on.coordinate) += shares.own * moment;
    if (shares.parent != 0.0)
      add_moment(on.parent, shares.parent * moment);
    if (shares.world != 0.0)
      add_moment(robot_.root(), shares.world * moment);
  }

  const Robot& robot_;
  std::vector<Frame> frames_;
  std::vector<double> sideways_; // accelerations, m/s²
  std::vector<JointWrench> joints_;
  VectorQ force_; // by the rows of θ
};

} // namespace

NewtonEuler newton_euler(const Robot& robot, const VectorQ& q, const VectorQ& v, const VectorQ& a,
                         const std::array<Eigen::Vector3d, 2>& ground)
{
  Recursion recursion(robot);
  recursion.move(q, v, a);
  recursion.drive(ground);
  recursion.pass_on();
  return std::move(recursion).result();
}

} // namespace torqued
