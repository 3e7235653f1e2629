#include "torque/equations.h"

#include "planar/dynamics.h"
#include "torque/joint_friction.h"

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
  Result<SupportEquations> result(std::in_place_type<SupportEquations>);
  SupportEquations& equations = std::get<SupportEquations>(result);
  Kinematics& now = equations.now;
  now = kinematics(robot.mechanism, desired.q, desired.v);
  equations.turn = robot.mechanism.of_directions(desired.a);
  const Result<BaseMotion> completed = base_motion(robot, desired, equations.turn, now);
  if (const Refusal* refusal = std::get_if<Refusal>(&completed))
  {
    result = *refusal;
    return result;
  }
  const auto& [base_velocity, base_acceleration] = std::get<BaseMotion>(completed);
  equations.base_acceleration = base_acceleration;
  const Support& support = desired.support;
  const int size = robot.mechanism.num_theta();

  equations.r = inverse_dynamics(robot.mechanism, now, equations.turn, base_acceleration);
  equations.d.head<2>() = equations.r.tail<2>();
  equations.d(2) = robot.turning.dot(equations.r);
  if (robot.joint_friction)
    equations.r.head(size) += joint_forces(robot, joint_friction(robot, desired.v, desired.a));

  equations.contact_speed = 0.0;
  equations.contact_residual = 0.0;
  equations.sole_tilt = 0.0;
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    const Foot& foot = robot.foot(side);
    equations.feet[static_cast<std::size_t>(side)] = foot_pose(robot, now, foot);

    // what should be at rest
    const Point& point = contact_point(foot, contact);
    Eigen::Vector2d speed = velocity(now, point, base_velocity).cwiseAbs();
    Eigen::Vector2d residual = acceleration(now, point, equations.turn, base_acceleration).cwiseAbs();
    if (contact == Contact::sole)
    {
      const double tilt = wrapped(desired.q(foot.direction) + robot.link(foot.link).direction_angle);
      equations.sole_tilt = std::max(equations.sole_tilt, std::abs(tilt));
      speed.x() = std::max(speed.x(), std::abs(now.rate(foot.direction)));
      residual.x() = std::max(residual.x(), std::abs(equations.turn(foot.direction)));
    }
    equations.contact_speed = std::max(equations.contact_speed, speed.maxCoeff());
    equations.contact_residual = std::max(equations.contact_residual, residual.maxCoeff());
  }
  return result;
}

VectorQ left_for_motors(const Robot& robot, const SupportEquations& equations, const Support& support,
                        const WrenchVector& w)
{
  VectorQ rest = equations.r;
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    const Foot& foot = robot.foot(side);
    const int row = support.row(side);
    const Eigen::Vector2d force = w.segment<2>(row);
    for (const Arm& arm : contact_point(foot, contact))
      robot.mechanism.add_from_direction(arm.direction,
                                         -cross(rotate(equations.now.e.col(arm.direction), arm.r), force), rest);
    if (contact == Contact::sole)
      robot.mechanism.add_from_direction(foot.direction, -w(row + 2), rest);
    rest.tail<2>() -= force;
  }
  return rest;
}

} // namespace torqued
