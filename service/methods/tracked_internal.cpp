/// Procedure 4 of [Al-Shuka 2014], of two legs that carry the trunk (least_torque.h): of all η and σ that give the feet
/// the reactions of procedure 3 (tracked_reaction.cpp), the least,
///
///   [η; σ̄] = [B2 b2]^# (y − b3),   b2 = B2 f*,   σ = clamp(σ̄, 0, 1),   η = B2⁻¹ (y − b3 − b2 σ)       (72) to (74)
///
/// In the paper η stays what it was before the clamp, and then (71) does not hold. So the reactions are those of
/// procedure 3, and what this one adds is whether σ̄ was clamped.
#include "methods/linear_transition.h"

namespace torqued
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
  PerSide<Eigen::Vector3d> rate; // n of each leg
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

// f_T of the leg of a foot: the foot's wrench about the trunk's origin, less n
Eigen::Vector3d carried_by(const SupportEquations& equations, const Support& support, const Legs& legs, Side side,
                           const WrenchVector& w)
{
  const Contact contact = support.of(side);
  const int row = support.row(side);
  const Eigen::Vector3d of_foot(w(row), w(row + 1), contact == Contact::sole ? w(row + 2) : 0.0);
  return about(legs.origin - equations.foot(side).point(contact), of_foot) - legs.rate[side];
}

Result<Reactions> tracked_internal(const DoubleSupport& now)
{
  Result<Reactions> result =
      linear_transition(now.robot, now.equations, now.support, now.settings.of<LinearTransition>());
  if (Reactions* reactions = std::get_if<Reactions>(&result))
  {
    // B2 cancels: η + σ f* = f_T1 with the least |η|² + σ²
    const Legs legs = legs_of(now.robot, now.equations);
    const Eigen::Vector3d f_T1 = carried_by(now.equations, now.support, legs, now.support.trailing(), reactions->w);
    const double sigma = legs.trunk.dot(f_T1) / (1.0 + legs.trunk.squaredNorm());
    reactions->clamped = sigma < 0.0 || sigma > 1.0;
  }
  return result;
}

} // namespace

MethodRow tracked_internal_row()
{
  return {Method::tracked_internal, "tracked-internal", tracked_internal};
}

} // namespace torqued
