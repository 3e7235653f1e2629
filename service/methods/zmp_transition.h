/// Double support by handing the load over as the motion's zero-moment point allows it.
#pragma once

#include "methods/method.h"

namespace torqued
{

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
