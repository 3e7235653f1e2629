#include "stance/joint_friction.h"

#include <cmath>

namespace torqued
{

namespace
{

// sgn_s
double sign_of(double rate, double stick_velocity)
{
  if (std::abs(rate) < stick_velocity)
    return rate / stick_velocity;
  return rate > 0.0 ? 1.0 : rate < 0.0 ? -1.0 : 0.0;
}

} // namespace

double joint_friction(const Actuator& actuator, double rate, double acceleration)
{
  const double sign = sign_of(rate, actuator.stick_velocity);
  const double slow = rate / actuator.stribeck_velocity;
  return actuator.rotor_inertia * acceleration + actuator.coulomb * sign + actuator.viscous * rate +
         actuator.stribeck * sign * std::exp(-slow * slow) + actuator.friction_offset;
}

VectorJ joint_friction(const Robot& robot, const VectorQ& v, const VectorQ& a)
{
  const int size = robot.mechanism.num_theta();
  const VectorJ rate = joint_rates(robot, v.head(size));
  const VectorJ acceleration = joint_rates(robot, a.head(size));
  VectorJ torque(robot.num_joints());
  for (int j = 0; j < robot.num_joints(); ++j)
    torque(j) = joint_friction(robot.actuators[static_cast<std::size_t>(j)], rate(j), acceleration(j));
  return torque;
}

} // namespace torqued
