/// What the rules that hand the load over have in common: from the force on the leading foot to all ground reactions.
#pragma once

#include "torque/reactions.h"
#include "torque/refusal.h"

namespace torqued
{

/// From one world x to another, m, or between two moments, N m; from <= to.
struct Interval
{
  double from, to;
};

/// Along x, whichever point is before the other.
Interval between(const Eigen::Vector2d& a, const Eigen::Vector2d& b);

/// How two feet share the total ground force F.
struct LoadSharing
{
  Eigen::Vector2d leading_force; ///< N; the trailing foot's is F less this. Between two points: its x only
  double s;                      ///< 0..1, the leading foot's share of a moment that no sole can hold
  Interval leading, trailing;    ///< world x between which a sole's centre of pressure is to be
  bool trailing_takes_rest;      ///< two soles: the moment that is left over, be its sole long enough or not
};

/// The ground reactions that go with it, by the contact pair:
///
/// - sole and point: the sole's moment follows from (2).
/// - point and point: (2) determines the normal forces; refused as numerical when the points stand above one another.
/// - sole and sole: the trailing foot presses as near to the total zero-moment point as `trailing` lets it, the leading
///   foot takes what is left of the moment within `leading`, and the trailing foot the rest as far as its whole sole
///   allows. What no sole can hold is shared by s.
Result<Reactions> share_load(const Robot& robot, const SupportEquations& equations, const Support& support,
                             const LoadSharing& sharing);

/// A part of a whole, from 0 to 1.
struct Share
{
  double s;
  bool clamped; ///< it was outside 0 to 1, or undefined: |whole| < nothing; then s is 0.5
};
Share share_of(double part, double whole, double nothing);

} // namespace torqued
