#include "trunk_wrench.h"
#include "oracles.h"

#include <Eigen/Geometry>
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

// What gives a link its rate of momentum and carries its weight, about a point: its momentum along the motion
// φ = φ(0) + φ̇ t + ½ φ̈ t², seen from where the base point's velocity is 0, differentiated.
Eigen::Vector3d wrench_on(const Robot& robot, const SupportEquations& equations, const Link& link,
                          const Eigen::Vector2d& point)
{
  const Kinematics& now = equations.now;
  Eigen::Vector2d centre;
  const auto momentum = [&](double t) -> Eigen::Vector3d
  {
    const auto rate = [&](int direction)
    {
      return now.rate(direction) + equations.direction_acceleration(direction) * t;
    };
    centre = now.base + 0.5 * t * t * equations.base_acceleration;
    Eigen::Vector2d velocity = t * equations.base_acceleration;
    const auto add = [&](int direction, const Eigen::Vector2d& from)
    {
      const Eigen::Vector2d r = Eigen::Rotation2Dd(0.5 * (now.rate(direction) + rate(direction)) * t) * from;
      centre += r;
      velocity += rate(direction) * perp(r);
    };
    for (const Arm& arm : link.origin)
      add(arm.direction, rotate(now.e.col(arm.direction), arm.r));
    add(link.direction, rotate(heading(link, now), link.com));
    const Eigen::Vector2d linear = link.mass * velocity;
    return {linear.x(), linear.y(), link.inertia * rate(link.direction) + cross(centre - point, linear)};
  };
  // at rates of 10 rad/s the stencil's error and rounding are both some 1e-14 of the momentum's rate
  const Eigen::Vector3d rate = slope(momentum, 3e-3);
  momentum(0.0);
  const Eigen::Vector2d weight(0.0, link.mass * robot.mechanism.gravity());
  return rate + Eigen::Vector3d(0.0, weight.y(), cross(centre - point, weight));
}

Legs legs_of(const Robot& robot, const SupportEquations& equations)
{
  Legs legs{position(equations.now, robot.link(robot.trunk).origin),
            Eigen::Vector3d::Zero(),
            {{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}}};
  for (std::size_t i = 0; i < robot.links.size(); ++i)
  {
    Eigen::Vector3d& sum = robot.leg[i] ? legs.rate[static_cast<std::size_t>(*robot.leg[i])] : legs.trunk;
    sum += wrench_on(robot, equations, robot.links[i], legs.origin);
  }
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
