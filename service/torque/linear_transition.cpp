#include "torque/linear_transition.h"

#include "torque/load_sharing.h"

namespace torqued
{

namespace
{

// the leading foot takes s of the total force, and each sole's pressure may be anywhere in it
LoadSharing in_proportion(const SupportEquations& equations, const Support& support, double s)
{
  const FootPose& leading = equations.foot(support.leading);
  const FootPose& trailing = equations.foot(support.trailing());
  return {.leading_force = s * equations.force(),
          .s = s,
          .leading = between(leading.heel, leading.toe),
          .trailing = between(trailing.heel, trailing.toe),
          .trailing_takes_rest = false};
}

} // namespace

Result<Reactions> linear_transition(const Robot& robot, const SupportEquations& equations, const Support& support,
                                    const LinearTransition& settings)
{
  LoadSharing sharing = in_proportion(equations, support, support.load_transfer);
  if (settings.leading_cop)
  {
    const FootPose& foot = equations.foot(support.leading);
    const double x = foot.heel.x() + *settings.leading_cop * (foot.toe.x() - foot.heel.x());
    sharing.leading = {x, x};
    sharing.trailing_takes_rest = true;
  }
  return share_load(robot, equations, support, sharing);
}

Result<Reactions> zmp_transition(const Robot& robot, const SupportEquations& equations, const Support& support)
{
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  const FootPose& leading = equations.foot(support.leading);
  const FootPose& trailing = equations.foot(support.trailing());
  const double p = support.progress();
  const double nothing = kNoLoad * robot.weight() * robot.leg_length;
  const Eigen::Vector2d F = equations.force();
  const double m = equations.moment_about_origin();

  Share share{p, false};
  if (leading_sole != trailing_sole)
  {
    // s*, numerator and denominator times F_z
    share = share_of(m - trailing.toe.x() * F.y(), (leading.heel.x() - trailing.toe.x()) * F.y(), nothing);
    share.s = trailing_sole ? p * share.s : share.s + p * (1.0 - share.s);
  }
  else if (!leading_sole)
  {
    // the share of F that, at the leading point, balances the moments about the trailing one
    const Eigen::Vector2d at = trailing.point(support.of(support.trailing()));
    const Eigen::Vector2d lever = leading.point(support.of(support.leading)) - at;
    share = share_of(m - cross(at, F), cross(lever, F), nothing);
  }

  Result<Reactions> result = share_load(robot, equations, support, in_proportion(equations, support, share.s));
  if (Reactions* reactions = std::get_if<Reactions>(&result))
    reactions->clamped = share.clamped;
  return result;
}

} // namespace torqued
