#include "torque/linear_transition.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

struct Interval
{
  double from, to;
  Interval times(double factor) const
  {
    return factor < 0.0 ? Interval{factor * to, factor * from} : Interval{factor * from, factor * to};
  }
  double clamp(double x) const { return std::clamp(x, from, to); }
  double middle() const { return 0.5 * (from + to); }
};

Interval sole(const FootPose& foot)
{
  return {std::min(foot.heel.x(), foot.toe.x()), std::max(foot.heel.x(), foot.toe.x())};
}

// What the leading and the trailing foot take of the total moment about the world's origin, both on their soles.
//
// On level soles a foot's moment about the origin is x_c f_z, with x_c its centre of pressure: a moment within
// sole × f_z keeps the pressure inside the sole.
struct Moments
{
  double leading, trailing;
};

Moments moments_of_soles(const SupportEquations& equations, const Support& support, double s,
                         const LinearTransition& settings, double no_load)
{
  const double F_z = equations.force().y();
  const double m = equations.moment_about_origin();
  const Interval leading = sole(equations.foot(support.leading));
  const Interval trailing = sole(equations.foot(support.trailing()));

  if (settings.leading_cop)
  {
    const FootPose& foot = equations.foot(support.leading);
    const double x = foot.heel.x() + *settings.leading_cop * (foot.toe.x() - foot.heel.x());
    return {s * F_z * x, m - s * F_z * x};
  }

  // the trailing foot presses as near to the total zero-moment point as its sole goes, the leading foot takes what is
  // left of the moment as far as its sole allows, then the trailing foot again; what no sole can hold is shared by load
  const double p = std::abs(F_z) < no_load ? trailing.middle() : trailing.clamp(m / F_z);
  const double m_f = leading.times(s * F_z).clamp(m - (1.0 - s) * p * F_z);
  const double m_r = trailing.times((1.0 - s) * F_z).clamp(m - m_f);
  const double R = m - m_f - m_r;
  return {m_f + s * R, m_r + (1.0 - s) * R};
}

// both feet's wrenches where the leading one takes s of the total force; between two points, of the horizontal one
Result<Reactions> share_load(const Robot& robot, const SupportEquations& equations, const Support& support, double s,
                             const LinearTransition& settings)
{
  const Eigen::Vector2d F = equations.force();
  const Side leading = support.leading;
  const Side trailing = support.trailing();
  WrenchVector w(support.wrench_components());
  const auto force = [&](Side side)
  {
    return w.segment<2>(support.row(side));
  };
  const auto moment = [&](Side side) -> double&
  {
    return w(support.row(side) + 2);
  };

  force(leading) = s * F;
  force(trailing) = F - s * F;

  const bool leading_sole = support.of(leading) == Contact::sole;
  const bool trailing_sole = support.of(trailing) == Contact::sole;
  if (leading_sole && trailing_sole)
  {
    const Moments about_origin = moments_of_soles(equations, support, s, settings, kNoLoad * robot.weight());
    moment(leading) = about_origin.leading - cross(equations.foot(leading).ankle, force(leading));
    moment(trailing) = about_origin.trailing - cross(equations.foot(trailing).ankle, force(trailing));
  }
  else if (leading_sole || trailing_sole)
  {
    const Side flat = leading_sole ? leading : trailing;
    const Side rolling = other(flat);
    moment(flat) = equations.d(2) - cross(equations.foot(flat).ankle - equations.base(), force(flat)) -
                   cross(equations.foot(rolling).point(support.of(rolling)) - equations.base(), force(rolling));
  }
  else
  {
    // both normal forces from the moments about the trailing point
    const Eigen::Vector2d p = equations.foot(trailing).point(support.of(trailing));
    const Eigen::Vector2d lever = equations.foot(leading).point(support.of(leading)) - p;
    if (std::abs(lever.x()) < kCoincident * robot.leg_length)
      return Refusal(
          Reason::numerical,
          "the contact points of both feet stand {:.3g} m apart along the ground; with less than {:.3g} m the normal "
          "forces are not determined",
          std::abs(lever.x()), kCoincident * robot.leg_length);
    const double moment_about_p = equations.moment_about_origin() - cross(p, F);
    force(leading).y() = (moment_about_p + lever.y() * force(leading).x()) / lever.x();
    force(trailing).y() = F.y() - force(leading).y();
  }
  return Reactions{w};
}

// a share of the load, and whether it was outside 0 to 1 or undefined
struct Share
{
  double s;
  bool clamped;
};

// a moment as a share of another; 0.5 where that one is nothing
Share share_of(double part, double whole, double nothing)
{
  if (std::abs(whole) < nothing)
    return {0.5, true};
  const double s = part / whole;
  return {std::clamp(s, 0.0, 1.0), s < 0.0 || s > 1.0};
}

} // namespace

Result<Reactions> linear_transition(const Robot& robot, const SupportEquations& equations, const Support& support,
                                    const LinearTransition& settings)
{
  return share_load(robot, equations, support, support.load_transfer, settings);
}

Result<Reactions> zmp_transition(const Robot& robot, const SupportEquations& equations, const Support& support)
{
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  const FootPose& leading = equations.foot(support.leading);
  const FootPose& trailing = equations.foot(support.trailing());
  const double p = support.phase;
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

  Result<Reactions> result = share_load(robot, equations, support, share.s, {});
  if (Reactions* reactions = std::get_if<Reactions>(&result))
    reactions->clamped = share.clamped;
  return result;
}

} // namespace torqued
