#include "methods/human_transition.h"

#include "methods/linear_transition.h"
#include "methods/load_sharing.h"
#include "methods/zmp_transition.h"
#include "planar/dynamics.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

// from 0 to 1 with level ends
double ease(double p, double fade)
{
  if (p >= fade)
    return 1.0;
  const double u = p / fade;
  return u * u * (3.0 - 2.0 * u);
}

// 0 = heel, 1 = toe
Eigen::Vector2d along_sole(const FootPose& foot, double fraction)
{
  return foot.heel + fraction * (foot.toe - foot.heel);
}

} // namespace

Result<Reactions> human_transition(const Robot& robot, const SupportEquations& equations, const Support& support,
                                   const HumanTransition& settings)
{
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  if (!leading_sole && !trailing_sole)
    return zmp_transition(robot, equations, support);

  const FootPose& leading = equations.foot(support.leading);
  const FootPose& trailing = equations.foot(support.trailing());
  const bool both = leading_sole && trailing_sole;
  const double s = support.load_transfer;
  const double p = support.phase;
  const double begun = both ? ease(s, settings.fade) : trailing_sole ? ease(p, settings.fade) : 1.0;
  const double unfinished = both ? ease(1.0 - s, settings.fade) : trailing_sole ? 1.0 : ease(1.0 - p, settings.fade);
  // from the one instant at which a change from sole and point to point and sole is continuous
  const double away = both ? 1.0 : trailing_sole ? 1.0 - p : p;

  const Eigen::Vector2d x_r = trailing_sole ? along_sole(trailing, 1.0 - away * (1.0 - settings.trailing_cop))
                                            : trailing.point(support.of(support.trailing()));
  const Eigen::Vector2d x_f =
      leading_sole ? along_sole(leading, away * settings.leading_cop) : leading.point(support.of(support.leading));

  // feet side by side: no step that a force could be handed over
  if (both && x_f.x() < x_r.x())
    return linear_transition(robot, equations, support, {});

  // the line from the trailing foot to the centre of mass; of a robot that lies on the ground there is none
  const Eigen::Vector2d line = centre_of_mass(robot.mechanism, equations.now) - x_r;
  const double friction = robot.foot(support.trailing()).friction;
  const double slope =
      line.y() > kCoincident * robot.leg_length ? std::clamp(line.x() / line.y(), -friction, friction) : 0.0;

  // the trailing foot's share balances, along that line, the moments about the leading foot's point
  const Eigen::Vector2d F = equations.force();
  const double load_on_lever = cross(Eigen::Vector2d(x_r - x_f), Eigen::Vector2d(slope, 1.0)) * F.y();
  const double nothing = kNoLoad * robot.weight() * robot.leg_length;
  const double by_lever = 1.0 - share_of(equations.moment_about_origin() - cross(x_f, F), load_on_lever, nothing).s;
  const double time_weight = away * settings.time_weight;
  const double by_both = (1.0 - time_weight) * by_lever + time_weight * s;
  const double sigma = begun * (1.0 - unfinished * (1.0 - by_both));

  const double trailing_fz = (1.0 - sigma) * F.y();
  const double trailing_fx = begun * trailing_fz * slope + (1.0 - begun) * F.x();

  Result<Reactions> result = share_load(robot, equations, support,
                                        {.leading_force = F - Eigen::Vector2d(trailing_fx, trailing_fz),
                                         .s = sigma,
                                         .leading = {x_f, leading.toe},
                                         .trailing = {trailing.heel, x_r},
                                         .trailing_takes_rest = false});
  if (Reactions* reactions = std::get_if<Reactions>(&result))
    reactions->clamped = std::abs(load_on_lever) < nothing;
  return result;
}

static void list(HumanTransition& settings, SettingList& with)
{
  with.number("trailing_cop", settings.trailing_cop, from_0_to(1.0),
              "where the trailing sole presses, 0 (heel) to 1 (toe)");
  with.number("leading_cop", settings.leading_cop, from_0_to(1.0), "and the leading one");
  with.number("time_weight", settings.time_weight, from_0_to(1.0),
              "0 to 1: weight of load_transfer, against the lever rule, in the vertical share");
  with.number("fade", settings.fade, from_0_to(0.5),
              "0 to 0.5: share of the double support in which each end passes into single support; 0: at once");
}

MethodRow human_transition_row()
{
  return method_row<HumanTransition>(
      "human-transition", [](const DoubleSupport& now)
      { return human_transition(now.robot, now.equations, now.support, now.settings.of<HumanTransition>()); });
}

} // namespace torqued
