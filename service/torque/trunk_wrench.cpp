#include "torque/trunk_wrench.h"

#include <algorithm>

namespace torqued
{

namespace
{

// row (f_x, f_z, m) of a wrench's moment about the point at r from where m is taken
Eigen::RowVector3d moment_about(const Eigen::Vector2d& r)
{
  return {r.y(), -r.x(), 1.0};
}

// the same wrench about the point at r
Eigen::Matrix3d transport(const Eigen::Vector2d& r)
{
  Eigen::Matrix3d U = Eigen::Matrix3d::Identity();
  U.row(2) = moment_about(r);
  return U;
}

// The trunk, the legs and the feet; wrenches about the trunk's origin.
struct Legs
{
  Eigen::Vector2d origin;              // of the trunk's frame, m
  Eigen::Vector3d trunk;               // f*
  std::array<Eigen::Vector3d, 2> rate; // n of each leg, indexed by Side

  const Eigen::Vector3d& leg(Side side) const { return rate[static_cast<std::size_t>(side)]; }
};

Legs legs_of(const Robot& robot, const SupportEquations& equations)
{
  const Kinematics& now = equations.now;
  const VectorD& turning = equations.turn;
  const Eigen::Vector2d& base_acceleration = equations.base_acceleration;
  Legs legs{position(now, robot.link(robot.trunk).origin), {}, {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}};
  for (std::size_t i = 0; i < robot.links.size(); ++i)
  {
    if (!robot.leg[i])
      continue;
    // rate of momentum, about the trunk's origin: the force at the link's frame, and about that frame
    const Link& link = robot.links[i];
    Eigen::Vector2d place = now.base - legs.origin;
    Eigen::Vector2d up = base_acceleration + Eigen::Vector2d(0.0, robot.mechanism.gravity());
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
    legs.rate[static_cast<std::size_t>(*robot.leg[i])] += Eigen::Vector3d(force.x(), force.y(), moment);
  }
  legs.trunk << equations.force(), equations.d(2) - cross(legs.origin - equations.base(), equations.force());
  legs.trunk -= legs.rate[0] + legs.rate[1];
  return legs;
}

// w of what the trailing leg carries
WrenchVector on_the_ground(const SupportEquations& equations, const Support& support, const Legs& legs,
                           const Eigen::Vector3d& f_T1)
{
  WrenchVector w(support.wrench_components());
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    const Eigen::Vector3d carried = side == support.leading ? Eigen::Vector3d(legs.trunk - f_T1) : f_T1;
    const Eigen::Vector2d r = equations.foot(side).point(contact) - legs.origin;
    const int components = wrench_components(contact);
    w.segment(support.row(side), components) = (transport(r) * (carried + legs.leg(side))).head(components);
  }
  return w;
}

// the other way: what the leg of a foot carries
Eigen::Vector3d carried_by(const SupportEquations& equations, const Support& support, const Legs& legs, Side side,
                           const WrenchVector& w)
{
  // the foot's wrench about its point is f_T + n about the trunk's origin, transported; back by the opposite way
  const Contact contact = support.of(side);
  const int components = wrench_components(contact);
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  y.head(components) = w.segment(support.row(side), components);
  return transport(legs.origin - equations.foot(side).point(contact)) * y - legs.leg(side);
}

// x of procedure 3: f_T1 by which one foot stands as linear_transition() has it
Result<Eigen::Vector3d> tracked(const Robot& robot, const SupportEquations& equations, const Support& support,
                                const LinearTransition& settings, const Legs& legs)
{
  const Result<Reactions> shared = linear_transition(robot, equations, support, settings);
  if (const Refusal* refusal = std::get_if<Refusal>(&shared))
    return *refusal;

  const Side trailing = support.trailing();
  const bool rolls_off = support.of(trailing) != Contact::sole && support.of(support.leading) == Contact::sole;
  const Side passive = rolls_off ? trailing : support.leading;
  const Eigen::Vector3d f_T = carried_by(equations, support, legs, passive, std::get<Reactions>(shared).w);
  return passive == trailing ? f_T : Eigen::Vector3d(legs.trunk - f_T);
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
  return on_the_ground(equations, support, legs_of(robot, equations), f_T1);
}

Result<CarriedTrunk> tracked_reaction(const Robot& robot, const SupportEquations& equations, const Support& support,
                                      const LinearTransition& settings)
{
  const Legs legs = legs_of(robot, equations);
  const Result<Eigen::Vector3d> x = tracked(robot, equations, support, settings, legs);
  if (const Refusal* refusal = std::get_if<Refusal>(&x))
    return *refusal;
  const Eigen::Vector3d& f_T1 = std::get<Eigen::Vector3d>(x);
  return CarriedTrunk{legs.trunk, f_T1, 0.0, {on_the_ground(equations, support, legs, f_T1)}};
}

Result<CarriedTrunk> tracked_internal(const Robot& robot, const SupportEquations& equations, const Support& support,
                                      const LinearTransition& settings)
{
  const Legs legs = legs_of(robot, equations);
  const Result<Eigen::Vector3d> x = tracked(robot, equations, support, settings, legs);
  if (const Refusal* refusal = std::get_if<Refusal>(&x))
    return *refusal;

  // B2 cancels: η + σ f* = x with the least |η|² + σ²
  const Eigen::Vector3d& f = legs.trunk;
  const double unclamped = f.dot(std::get<Eigen::Vector3d>(x)) / (1.0 + f.squaredNorm());
  const double sigma = std::clamp(unclamped, 0.0, 1.0);
  const Eigen::Vector3d eta = std::get<Eigen::Vector3d>(x) - sigma * f;
  CarriedTrunk carried{f, eta, sigma, {on_the_ground(equations, support, legs, eta + sigma * f)}};
  carried.reactions.clamped = sigma != unclamped;
  return carried;
}

} // namespace torqued
