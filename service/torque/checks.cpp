#include "torque/checks.h"

#include <cmath>

namespace torqued
{

GroundReaction ground_reaction(const Robot& robot, const Foot& foot, const FootPose& pose, const Wrench& wrench)
{
  GroundReaction reaction{wrench, 0.0, 0.0};
  const double no_load = kNoLoad * robot.weight();
  if (std::abs(wrench.fz) < no_load)
    return reaction;
  reaction.friction_ratio = std::abs(wrench.fx) / wrench.fz;

  // the force in the foot's frame
  const double f_x = pose.e.x() * wrench.fx + pose.e.y() * wrench.fz;
  const double f_z = pose.e.x() * wrench.fz - pose.e.y() * wrench.fx;
  if (std::abs(f_z) >= no_load)
    reaction.cop = (wrench.moment - foot.ankle_height() * f_x) / f_z;
  return reaction;
}

std::int32_t contact_flags(const Robot& robot, const Foot& foot, Contact contact, const GroundReaction& reaction)
{
  if (contact == Contact::none)
    return 0;
  const double no_load = kNoLoad * robot.weight();
  const Wrench& wrench = reaction.wrench;
  std::int32_t flags = 0;
  if (wrench.fz < -no_load)
    flags |= flag::lifts;
  if (std::abs(wrench.fx) > foot.friction * std::max(wrench.fz, 0.0) + no_load)
    flags |= flag::slips;
  const double slack = 1e-6 * (foot.toe_x() - foot.heel_x());
  if (contact == Contact::sole && (reaction.cop < foot.heel_x() - slack || reaction.cop > foot.toe_x() + slack))
    flags |= flag::tips;
  return flags;
}

double zero_moment_point(const Robot& robot, const SupportEquations& equations)
{
  const double F_z = equations.force().y();
  return std::abs(F_z) < kNoLoad * robot.weight() ? 0.0 : equations.moment_about_origin() / F_z;
}

} // namespace torqued
