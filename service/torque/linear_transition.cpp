#include "torque/checks.h"
#include "torque/torque_method.h"

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

Moments moments_of_soles(const SupportEquations& equations, const Support& support, const LinearTransition& settings,
                         double no_load)
{
  const double s = support.load_transfer;
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

} // namespace

Result<WrenchVector> linear_transition(const Robot& robot, const SupportEquations& equations, const Support& support,
                                       const LinearTransition& settings)
{
  const double s = support.load_transfer;
  const Eigen::Vector2d F = equations.force();
  const Side leading = support.leading;
  const Side trailing = support.trailing();
  const std::array<int, 2> row{0, wrench_components(support.of(Side::left))};
  WrenchVector w(support.wrench_components());
  const auto force = [&](Side side)
  {
    return w.segment<2>(row[static_cast<std::size_t>(side)]);
  };
  const auto moment = [&](Side side) -> double&
  {
    return w(row[static_cast<std::size_t>(side)] + 2);
  };

  force(leading) = s * F;
  force(trailing) = F - s * F;

  const bool leading_sole = support.of(leading) == Contact::sole;
  const bool trailing_sole = support.of(trailing) == Contact::sole;
  if (leading_sole && trailing_sole)
  {
    const Moments about_origin = moments_of_soles(equations, support, settings, kNoLoad * robot.weight());
    moment(leading) = about_origin.leading - cross(equations.foot(leading).ankle, force(leading));
    moment(trailing) = about_origin.trailing - cross(equations.foot(trailing).ankle, force(trailing));
  }
  else if (leading_sole || trailing_sole)
  {
    const Side flat = leading_sole ? leading : trailing;
    const Side rolling = other(flat);
    moment(flat) = equations.d(2) - cross(equations.foot(flat).ankle - equations.base, force(flat)) -
                   cross(equations.foot(rolling).point(support.of(rolling)) - equations.base, force(rolling));
  }
  else
  {
    // both normal forces from the moments about the trailing point
    const Eigen::Vector2d p = equations.foot(trailing).point(support.of(trailing));
    const Eigen::Vector2d lever = equations.foot(leading).point(support.of(leading)) - p;
    if (std::abs(lever.x()) < 1e-6 * robot.leg_length)
      return Refusal(
          Reason::numerical,
          "the contact points of both feet stand {:.3g} m apart along the ground; with less than {:.3g} m the normal "
          "forces are not determined",
          std::abs(lever.x()), 1e-6 * robot.leg_length);
    const double moment_about_p = equations.moment_about_origin() - cross(p, F);
    force(leading).y() = (moment_about_p + lever.y() * force(leading).x()) / lever.x();
    force(trailing).y() = F.y() - force(leading).y();
  }
  return w;
}

} // namespace torqued
