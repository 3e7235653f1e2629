/// What the rules that hand the load over have in common: from the force on the leading foot to all ground reactions.
#pragma once

#include "stance/reactions.h"
#include "stance/refusal.h"

namespace torqued
{

/// A stretch of a sole, from one point in the world to another, m.
struct Stretch
{
  Eigen::Vector2d from, to;
};

/// How two feet share the total ground force F.
struct LoadSharing
{
  Eigen::Vector2d leading_force; ///< N; the trailing foot's is F less this. Between two points: its x only
  double s;                      ///< 0..1, the leading foot's share of a moment that no sole can hold
  Stretch leading, trailing;     ///< of a sole: where its centre of pressure is to be
  bool trailing_takes_rest;      ///< two soles: the moment that is left over, be its sole long enough or not
};

/// The ground reactions that go with it, by the contact pair:
///
/// - sole and point: the sole's moment follows from (2).
/// - point and point: (2) determines the normal forces; refused as numerical when the points stand above one another.
/// - sole and sole: the trailing foot presses where the line of F meets its sole, as near as `trailing` lets it (in its
///   middle where F is without load), the leading foot takes what is left of the moment within `leading`, and the
///   trailing foot the rest as far as its whole sole allows. What no sole can hold is shared by s.
///
/// All levers are between points of the robot, so that nothing depends on where the world's zero is.
Result<Reactions> share_load(const Robot& robot, const SupportEquations& equations, const Support& support,
                             const LoadSharing& sharing);

/// The leading foot takes s of the total force, and each sole's pressure may be anywhere in it.
LoadSharing in_proportion(const SupportEquations& equations, const Support& support, double s);

/// A part of a whole, from 0 to 1.
struct Share
{
  double s;
  bool clamped; ///< it was outside 0 to 1, or undefined: |whole| < nothing; then s is 0.5
};
Share share_of(double part, double whole, double nothing);

} // namespace torqued
