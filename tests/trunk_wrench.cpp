#include "trunk_wrench.h"
#include "methods/linear_transition.h"

#include <algorithm>

namespace torqued::oracle
{

namespace
{

// the same wrench about the point at r
Eigen::Vector3d about(const Eigen::Vector2d& r, const Eigen::Vector3d& f)
{
  return {f(0), f(1), f(2) - cross(r, f.head<2>())};
}

// The trunk, the legs and the feet; wrenches about the trunk's origin.
struct Legs
{
  Eigen::Vector2d origin;        // of the trunk's frame, m
  Eigen::Vector3d trunk;         // f*
  PerSide<Eigen::Vector3d> rate; // n of each leg, indexed by Side

  const Eigen::Vector3d& leg(Side side) const { return rate[static_cast<std::size_t>(side)]; }
};

Legs legs_of(const Robot& robot, const SupportEquations& equations)
{
  const Kinematics& now = equations.now;
  const VectorD& turning = equations.direction_acceleration;
  const Eigen::Vector2d base_up(equations.base_acceleration.x(),
                                equations.base_acceleration.y() + robot.mechanism.gravity());
  Legs legs{position(now, robot.link(robot.trunk).origin),
            Eigen::Vector3d::Zero(),
            {{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}}};
  Eigen::Vector3d &left = legs.rate[0], &right = legs.rate[1];
  for (std::size_t i = 0; i < robot.links.size(); ++i)
  {
    if (robot.leg[i] == Side::right) // what the others leave of the whole
      continue;
    // rate of momentum, about the trunk's origin: the force at the link's frame, and about that frame
    const Link& link = robot.links[i];
    Eigen::Vector2d place = now.base - legs.origin;
    Eigen::Vector2d up = base_up;
    const auto add = [&](int direction, const Eigen::Vector2d& r)
    {
      const double rate = now.rate(direction);
      up += turning(direction) * perp(r) - rate * rate * r;
    };
    for (const Arm& arm : link.origin)
    {
      const Eigen::Vector2d r = rotate(now.e.col(arm.direction), arm.r);
      place += r;
      add(arm.direction, r);
    }
    const Eigen::Vector2d c = rotate(heading(link, now), link.com);
    double moment = (link.inertia + link.mass * c.squaredNorm()) * turning(link.direction) + link.mass * cross(c, up);
    add(link.direction, c);
    const Eigen::Vector2d force = link.mass * up;
    moment += cross(place, force);
    Eigen::Vector3d& rate = robot.leg[i] ? left : legs.trunk;
    rate += Eigen::Vector3d(force.x(), force.y(), moment);
  }
  right = about(legs.origin - equations.base(), equations.d) - legs.trunk - left;
  return legs;
}

// what the leg of a foot carries: the foot's wrench about the trunk's origin, less n
Eigen::Vector3d carried_by(const SupportEquations& equations, const Support& support, const Legs& legs, Side side,
                           const WrenchVector& w)
{
  const Contact contact = support.of(side);
  const int row = support.row(side);
  const Eigen::Vector3d of_foot(w(row), w(row + 1), contact == Contact::sole ? w(row + 2) : 0.0);
  return about(legs.origin - equations.foot(side).point(contact), of_foot) - legs.leg(side);
}

} // namespace

CarriedTrunk carried_trunk(const Robot& robot, const SupportEquations& equations, const Support& support,
                           const Reactions& chosen, double sigma)
{
  const Legs legs = legs_of(robot, equations);
  const Eigen::Vector3d f_T1 = carried_by(equations, support, legs, support.trailing(), chosen.w);
  return {legs.trunk, f_T1 - sigma * legs.trunk, sigma, chosen};
}

WrenchVector reactions_below(const Robot& robot, const SupportEquations& equations, const Support& support,
                             const Eigen::Vector3d& f_T1)
{
  const Legs legs = legs_of(robot, equations);
  WrenchVector w(support.wrench_components());
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    const Eigen::Vector3d carried = side == support.leading ? Eigen::Vector3d(legs.trunk - f_T1) : f_T1;
    const Eigen::Vector2d r = equations.foot(side).point(contact) - legs.origin;
    const int components = wrench_components(contact);
    w.segment(support.row(side), components) = about(r, carried + legs.leg(side)).head(components);
  }
  return w;
}

Result<CarriedTrunk> tracked_internal(const Robot& robot, const SupportEquations& equations, const Support& support,
                                      const LinearTransition& settings)
{
  const Result<Reactions> shared = linear_transition(robot, equations, support, settings);
  if (const Refusal* refusal = std::get_if<Refusal>(&shared))
    return *refusal;
  const Reactions& reactions = std::get<Reactions>(shared);
  const Legs legs = legs_of(robot, equations);
  const Eigen::Vector3d x = carried_by(equations, support, legs, support.trailing(), reactions.w);

  // B2 cancels: η + σ f* = x with the least |η|² + σ²
  const Eigen::Vector3d& f = legs.trunk;
  const double unclamped = f.dot(x) / (1.0 + f.squaredNorm());
  const double sigma = std::clamp(unclamped, 0.0, 1.0);
  CarriedTrunk carried{f, x - sigma * f, sigma, reactions};
  carried.reactions.clamped = sigma != unclamped;
  return carried;
}

} // namespace torqued::oracle
