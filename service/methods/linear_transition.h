/// Double support by handing the load over: in proportion to time, or as the motion's zero-moment point allows it.
#pragma once

#include "stance/reactions.h"
#include "stance/refusal.h"

#include <optional>

namespace torqued
{

/// Hands the load from the trailing to the leading foot in proportion to load_transfer, s.
///
/// Each foot takes its share of the total ground force F, horizontal part too: leading s F, trailing (1 − s) F.
/// Source: [Al-Shuka 2014, (28), (29)], with t_s and t_d the instants at which double support begins and ends. They
/// give forces and no moments, which leaves to each contact pair:
///
/// - sole and point: the point's share acts at the point; the sole's wrench follows from (2).
/// - point and point: s splits the horizontal force; (2) determines the normal forces. Refused as numerical when the
///   points stand above one another.
/// - sole and sole: one moment is free. By default each foot's centre of pressure follows the total zero-moment point
///   as far as its sole allows; or the leading foot's stays at `leading_cop`, a fraction of its sole (0 = heel, 1 =
///   toe).
struct LinearTransition
{
  std::optional<double> leading_cop; ///< empty: follow the zero-moment point
};

/// Refuses: numerical.
Result<Reactions> linear_transition(const Robot& robot, const SupportEquations& equations, const Support& support,
                                    const LinearTransition& settings);

/// Hands the load over so that no torque jumps where the contacts change, whatever the motion.
///
/// From a trailing sole and a leading heel to a trailing toe and a leading sole the reactions can only be continuous
/// where the trailing foot presses at its toe and the leading one at its heel; there the leading foot's share is
///
///   s* = M_toe / (r × F)          M_toe: moment of the total force F about the trailing foot's toe; r: from there to
///                                 the leading foot's heel
///
/// (x_zmp − x_toe) / (x_heel − x_toe) where both are at the height z = 0; so the share is led through it, p = phase,
/// each instant with its own s*:
///
/// - trailing sole, leading point: s = p s*
/// - trailing point, leading sole: s = s* + p (1 − s*)
/// - two soles: s = load_transfer
/// - two points: normal forces by (2); s, the leading foot's share of them, splits the horizontal force, too
///
/// and the rest is as in linear_transition(), the pressure on two soles following the zero-moment point. s* is clamped
/// to 0 to 1; where it is undefined (no load; the two points above one another) it is 0.5; both with clamped set.
///
/// Refuses: numerical.
Result<Reactions> zmp_transition(const Robot& robot, const SupportEquations& equations, const Support& support);

} // namespace torqued
