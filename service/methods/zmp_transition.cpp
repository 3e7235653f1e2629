#include "methods/zmp_transition.h"

#include "methods/load_sharing.h"

namespace torqued
{

namespace
{

// A point of a foot, as high as its contact: on the ground where a heel or toe alone touches it.
Eigen::Vector2d on_ground(const FootPose& foot, Contact contact, const Eigen::Vector2d& point)
{
  return {point.x(), contact == Contact::sole ? point.y() : foot.point(contact).y()};
}

} // namespace

Result<Reactions> zmp_transition(const Robot& robot, const SupportEquations& equations, const Support& support)
{
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  const FootPose& leading = equations.foot(support.leading);
  const FootPose& trailing = equations.foot(support.trailing());
  const double p = support.progress();
  const double nothing = kNoLoad * robot.weight() * robot.leg_length;
  const Eigen::Vector2d F = equations.force();
  // the share of F that, at one point, balances the moments about another
  const auto balancing = [&](const Eigen::Vector2d& at, const Eigen::Vector2d& about)
  {
    return share_of(equations.moment_about_origin() - cross(about, F), cross(Eigen::Vector2d(at - about), F), nothing);
  };

  const Contact leading_contact = support.of(support.leading), trailing_contact = support.of(support.trailing());
  Share share{p, false};
  if (leading_sole != trailing_sole)
  {
    share = balancing(on_ground(leading, leading_contact, leading.heel),
                      on_ground(trailing, trailing_contact, trailing.toe)); // s*
    share.s = trailing_sole ? p * share.s : share.s + p * (1.0 - share.s);
  }
  else if (!leading_sole)
  {
    share = balancing(leading.point(leading_contact), trailing.point(trailing_contact));
  }

  Result<Reactions> result = share_load(robot, equations, support, in_proportion(equations, support, share.s));
  if (Reactions* reactions = std::get_if<Reactions>(&result))
    reactions->clamped = share.clamped;
  return result;
}

MethodRow zmp_transition_row()
{
  return {Method::zmp_transition, "zmp-transition",
          [](const DoubleSupport& now)
          {
            return zmp_transition(now.robot, now.equations, now.support);
          }};
}

} // namespace torqued
