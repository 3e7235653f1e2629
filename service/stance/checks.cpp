#include "stance/checks.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

std::int32_t contact_flags(const Robot& robot, const Foot& foot, const FootPose& pose, Contact contact,
                           const Wrench& wrench)
{
  if (contact == Contact::none)
    return 0;
  const double no_load = kNoLoad * robot.weight();
  std::int32_t flags = 0;
  if (wrench.fz < -no_load)
    flags |= flag::lifts;
  if (std::abs(wrench.fx) > foot.friction * std::max(wrench.fz, 0.0) + no_load)
    flags |= flag::slips;
  if (contact == Contact::sole && foot.has_extent())
  {
    const Eigen::Vector2d f = in_foot(pose, wrench);
    const double moment = wrench.moment - foot.ankle_height() * f.x();
    const double slack = no_load * (foot.toe_x() - foot.heel_x());
    const auto [least, most] = std::minmax({foot.heel_x() * f.y(), foot.toe_x() * f.y()});
    if (moment < least - slack || moment > most + slack)
      flags |= flag::tips;
  }
  return flags;
}

double zero_moment_point(const Robot& robot, const SupportEquations& equations)
{
  const double F_z = equations.force().y();
  return std::abs(F_z) < kNoLoad * robot.weight() ? 0.0 : equations.moment_about_origin() / F_z;
}

} // namespace torqued
