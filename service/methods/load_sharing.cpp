#include "methods/load_sharing.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

// What the leading and the trailing foot take of the total moment about the world's origin, both on their soles.
struct Moments
{
  double leading, trailing;
};

// The moment nearest to m by which a force presses on a stretch of a sole; moments about the world's origin.
double within(double m, const Stretch& stretch, const Eigen::Vector2d& force)
{
  const auto [least, most] = std::minmax({cross(stretch.from, force), cross(stretch.to, force)});
  return std::clamp(m, least, most);
}

Moments moments_of_soles(const SupportEquations& equations, const Support& support, const LoadSharing& sharing,
                         double no_load)
{
  const Eigen::Vector2d F = equations.force();
  const double m = equations.moment_about_origin();
  const Eigen::Vector2d trailing_force = F - sharing.leading_force;

  // where the line of F meets the trailing foot's stretch, or the end nearest to that
  const Eigen::Vector2d along = sharing.trailing.to - sharing.trailing.from;
  const double share = share_of(m - cross(sharing.trailing.from, F), cross(along, F), no_load * along.norm()).s;
  const Eigen::Vector2d p = sharing.trailing.from + share * along;
  const double m_f = within(m - cross(p, trailing_force), sharing.leading, sharing.leading_force);
  if (sharing.trailing_takes_rest)
    return {m_f, m - m_f};
  const FootPose& trailing = equations.foot(support.trailing());
  const double m_r = within(m - m_f, {trailing.heel, trailing.toe}, trailing_force);
  const double R = m - m_f - m_r;
  return {m_f + sharing.s * R, m_r + (1.0 - sharing.s) * R};
}

} // namespace

Result<Reactions> share_load(const Robot& robot, const SupportEquations& equations, const Support& support,
                             const LoadSharing& sharing)
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

  force(leading) = sharing.leading_force;
  force(trailing) = F - sharing.leading_force;

  const bool leading_sole = support.of(leading) == Contact::sole;
  const bool trailing_sole = support.of(trailing) == Contact::sole;
  if (leading_sole && trailing_sole)
  {
    const Moments about_origin = moments_of_soles(equations, support, sharing, kNoLoad * robot.weight());
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
  return Result<Reactions>(std::in_place_type<Reactions>, w);
}

LoadSharing in_proportion(const SupportEquations& equations, const Support& support, double s)
{
  const FootPose& leading = equations.foot(support.leading);
  const FootPose& trailing = equations.foot(support.trailing());
  return {.leading_force = s * equations.force(),
          .s = s,
          .leading = {leading.heel, leading.toe},
          .trailing = {trailing.heel, trailing.toe},
          .trailing_takes_rest = false};
}

Share share_of(double part, double whole, double nothing)
{
  if (std::abs(whole) < nothing)
    return {0.5, true};
  const double s = part / whole;
  return {std::clamp(s, 0.0, 1.0), s < 0.0 || s > 1.0};
}

} // namespace torqued
