#include "methods/linear_transition.h"

#include "methods/load_sharing.h"

namespace torqued
{

Result<Reactions> linear_transition(const Robot& robot, const SupportEquations& equations, const Support& support,
                                    const LinearTransition& settings)
{
  LoadSharing sharing = in_proportion(equations, support, support.load_transfer);
  if (settings.leading_cop)
  {
    const FootPose& foot = equations.foot(support.leading);
    const Eigen::Vector2d cop = foot.heel + *settings.leading_cop * (foot.toe - foot.heel);
    sharing.leading = {cop, cop};
    sharing.trailing_takes_rest = true;
  }
  return share_load(robot, equations, support, sharing);
}

static void list(LinearTransition& settings, SettingList& with)
{
  const Range sole{0.0, 1.0, "\"zmp\", or 0 (heel) to 1 (toe)"};
  with.number_or("cop", settings.leading_cop, "zmp", sole,
                 "both feet on their soles: 'zmp', or the leading foot's pressure point from 0 (heel) to 1 (toe)");
}

MethodRow linear_transition_row()
{
  return method_row<LinearTransition>(
      "linear-transition", [](const DoubleSupport& now)
      { return linear_transition(now.robot, now.equations, now.support, now.settings.of<LinearTransition>()); });
}

} // namespace torqued
