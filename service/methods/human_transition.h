/// Double support as people walk it.
#pragma once

#include "methods/method.h"

namespace torqued
{

/// Shape of human_transition(): of no particular subject, found on one measured walk and flat around these values.
struct HumanTransition
{
  static constexpr Method kMethod = Method::human_transition;
  double trailing_cop = 0.875; ///< 0 = heel, 1 = toe: where the trailing sole presses when it can, about the toes' ball
  double leading_cop = 0.125;  ///< likewise the leading sole
  double time_weight = 0.3;    ///< 0..1: weight of load_transfer, against the lever, in the vertical share
  double fade = 0.1;           ///< 0..0.5: share of the double support in which each end passes into single support; 0:
                               ///< at once, so that torques may jump there
};

/// Hands the load over as measured on people: pushed off with the trailing forefoot, taken up with the leading heel,
/// the trailing force through the centre of mass.
///
/// With r, f the pressure points of the trailing and the leading foot (a heel or toe itself; of a sole the settings'
/// point), s = load_transfer, p = phase, F the total force and M_f its moment about f, c the centre of mass as seen
/// from r:
///
///   n  = (c_x / c_z, 1)                                    along the trailing foot's force
///   σ* = 1 − M_f / ((r − f) × n F_z), from 0 to 1          lever rule, at any height of r and f
///   σ  = e(p_0) (1 − e(p_1) (1 − ((1 − ω) σ* + ω s)))      leading foot's share of F_z; ω: time_weight
///   f_x = e(p_0) (1 − σ) F_z n_x + (1 − e(p_0)) F_x        trailing foot
///   e(p) = u² (3 − 2u),  u = min(p / fade, 1)
///
/// n_x is held within the trailing foot's friction coefficient. Where r and f are equally high,
/// σ* = (x_zmp − x_r) / (x_f − x_r), the zero-moment point taken at their height.
///
/// - sole and sole: p_0 = s, p_1 = 1 − s, so that both ends are single support, whatever the motion. The pressures are
///   as in linear_transition(), but on the soles behind r and before f.
/// - trailing sole, leading point: p_0 = p, p_1 = 1; then trailing point, leading sole: p_0 = 1, p_1 = 1 − p. Towards
///   the change from one to the other r moves to the toe, f to the heel, and ω to 0, because there the reactions
///   can only be continuous as the lever rule has them (see zmp_transition()).
/// - two points: as zmp_transition(). Two soles side by side, so that f is behind r, as of a robot that stands: as
///   linear_transition().
///
/// σ* is undefined, and 0.5 with clamped set, without load or where r and f are one.
///
/// It needs no past and no future: the same desired state has the same answer. Sources: that trailing and leading foot
/// share the load smoothly, and horizontally otherwise than vertically [Ren, Jones, Howard 2008]; the rest follows
/// measured walking (torqued-accuracy(7)).
///
/// Refuses: numerical.
Result<Reactions> human_transition(const Robot& robot, const SupportEquations& equations, const Support& support,
                                   const HumanTransition& settings);

} // namespace torqued
