#include "stance/support_equations.h"

#include "planar/dynamics.h"
#include "stance/joint_friction.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

// an angle in -π to π
double wrapped(double angle)
{
  return std::abs(angle) <= M_PI ? angle : std::remainder(angle, 2.0 * M_PI);
}

} // namespace

Result<SupportEquations> support_equations(const Robot& robot, const DesiredState& desired)
{
  const Mechanism& mechanism = robot.mechanism;
  const Support& support = desired.support;
  Result<SupportEquations> result(std::in_place_type<SupportEquations>, mechanism, desired);
  SupportEquations& equations = std::get<SupportEquations>(result);
  Kinematics& now = equations.now;
  const Result<BaseMotion> completed =
      base_motion(robot, desired, equations.direction_acceleration, now, equations.standing);
  if (const Refusal* refusal = std::get_if<Refusal>(&completed))
  {
    result = *refusal;
    return result;
  }
  const BaseMotion& base = std::get<BaseMotion>(completed);
  equations.base_velocity = base.velocity;
  equations.base_acceleration = base.acceleration;

  equations.d = inverse_dynamics(mechanism, now, equations.direction_acceleration, base.acceleration, equations.r);
  if (robot.joint_friction)
    equations.r.head(mechanism.num_theta()) += joint_forces(robot, joint_friction(robot, desired.v, desired.a));

  double speed = 0.0, residual = 0.0, tilt = 0.0, height = 0.0;
  Side farthest = Side::left;
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    const Foot& foot = robot.foot(side);
    const StandingFoot& standing = equations.standing[side];
    equations.feet[side] = foot_pose(robot, now, foot, now.base + standing.ankle);
    if (const double own = equations.foot(side).height(contact); std::abs(own) > std::abs(height))
    {
      height = own;
      farthest = side;
    }

    // what should be at rest
    const auto raise = [](double& largest, double x)
    {
      largest = std::max(largest, std::abs(x));
    };
    raise(speed, base.velocity.x() + standing.velocity.x());
    raise(speed, base.velocity.y() + standing.velocity.y());
    raise(residual, base.acceleration.x() + standing.acceleration.x());
    raise(residual, base.acceleration.y() + standing.acceleration.y());
    if (contact == Contact::sole)
    {
      raise(tilt, wrapped(desired.q(foot.direction) + robot.link(foot.link).direction_angle));
      raise(speed, now.rate(foot.direction));
      raise(residual, equations.direction_acceleration(foot.direction));
    }
  }
  equations.contact_speed = speed;
  equations.contact_residual = residual;
  equations.sole_tilt = tilt;
  equations.contact_height = height;
  equations.farthest = farthest;
  return result;
}

VectorQ supported(const Robot& robot, const SupportEquations& equations, const Support& support,
                  const PerSide<Wrench>& ground)
{
  VectorQ force(kMaxCoordinates);
  force.head<kMaxCoordinates>().setZero(); // a number that the compiler knows
  force.conservativeResize(equations.r.size());
  Eigen::Vector2d total = Eigen::Vector2d::Zero();
  for (const Side side : kSides)
  {
    if (support.of(side) == Contact::none)
      continue;
    const Foot& foot = robot.foot(side);
    const Wrench& wrench = ground[side];
    const Eigen::Vector2d f(wrench.fx, wrench.fz);
    int i = 0;
    for (const Arm& arm : foot.ankle)
      robot.mechanism.add_from_direction(arm.direction, cross(equations.standing[side].arms.col(i++), f), force);
    robot.mechanism.add_from_direction(foot.direction, wrench.moment, force);
    total += f;
  }
  force.tail<2>() = total;
  return force;
}

} // namespace torqued
