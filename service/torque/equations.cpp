#include "torque/equations.h"

#include "planar/dynamics.h"
#include "torque/joint_friction.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

Result<SupportEquations> support_equations(const Robot& robot, const DesiredState& desired)
{
  const Result<Motion> completed = complete_motion(robot, desired);
  if (const Refusal* refusal = std::get_if<Refusal>(&completed))
    return *refusal;
  const Support& support = desired.support;
  const int size = robot.mechanism.num_theta();

  SupportEquations equations;
  equations.motion = std::get<Motion>(completed);
  const auto& [now, v, a] = equations.motion;
  equations.r = inverse_dynamics(robot.mechanism, now, a);
  equations.d.head<2>() = equations.r.tail<2>();
  equations.d(2) = robot.A_inverse.col(size - 1).dot(equations.r.head(size));
  equations.r.head(size) += joint_forces(robot, joint_friction(robot, v, a));

  // what should be at rest
  const auto [J, Jdot_v] = contact_rows(robot, now, support);
  equations.J = J;
  const bool contact = J.rows() > 0;
  equations.contact_speed = contact ? (J * v).cwiseAbs().maxCoeff() : 0.0;
  equations.contact_residual = contact ? (J * a + Jdot_v).cwiseAbs().maxCoeff() : 0.0;
  equations.sole_tilt = 0.0;

  // columns of G: the force itself, and its moment about the base point
  equations.G.resize(3, support.wrench_components());
  int row = 0;
  for (const Side side : kSides)
  {
    const Foot& foot = robot.foot(side);
    FootPose& pose = equations.feet[static_cast<std::size_t>(side)];
    pose = {now.base, now.base, now.base, {1.0, 0.0}};
    if (foot.exists())
      pose = {position(now, foot.ankle), position(now, foot.heel), position(now, foot.toe),
              heading(robot.link(foot.link), now)};
    const Contact contact_of_foot = support.of(side);
    if (contact_of_foot == Contact::none)
      continue;
    const Eigen::Vector2d lever = pose.point(contact_of_foot) - now.base;
    equations.G.col(row) << 1.0, 0.0, -lever.y();
    equations.G.col(row + 1) << 0.0, 1.0, lever.x();
    if (contact_of_foot == Contact::sole)
    {
      equations.G.col(row + 2) << 0.0, 0.0, 1.0;
      equations.sole_tilt = std::max(equations.sole_tilt, std::abs(std::atan2(pose.e.y(), pose.e.x())));
    }
    row += wrench_components(contact_of_foot);
  }
  return equations;
}

} // namespace torqued
