/// Double support as two legs that carry the trunk: the four procedures of [Al-Shuka 2014, (61) to (74)].
///
/// The trailing leg carries f_T1 of the trunk's net wrench f*, the leading leg f_T2:
///
///   f_T1 + f_T2 = f*,   f_T1 = σ f* + η,   f_T2 = (1 − σ) f* − η                                        (61), (62)
///
/// η: the internal wrench. All are (f_x, f_z, moment about the origin of the trunk's frame), world frame, N and N m; f*
/// is the rate of momentum of the trunk and of what hangs on it, weight included. What stands on the ground under a leg
/// follows from what it carries, as the leg's own rate of momentum is known:
///
///   ground wrench of a foot = f_T + n,   n: rate of momentum of its leg, weight included
///
/// so torques and the moments about heels or toes, which must vanish, are affine in η:
///
///   τ = B1 η + b1(σ),   a1ᵀ η + a2(σ) = 0: one row for each heel or toe                                  (63), (64)
///
/// Procedures 1 and 2 choose η by the least torque: least_torque.h. Procedure 3 has the wrench y of one foot from
/// linear_transition(): of the one on heel or toe, about that point; where both or none are on their soles, of the
/// leading one,
///
///   B2 f_T1 + b3 = y                                                                                         (71)
///
/// and B2 is rigid: the one solution is that the trailing leg carries what linear_transition() gives its foot, so that
/// the reactions are linear_transition()'s, and so are those of procedure 4.
#pragma once

#include "methods/linear_transition.h"

namespace torqued
{

/// An internal wrench and what follows from it.
struct CarriedTrunk
{
  Eigen::Vector3d trunk;    ///< f*
  Eigen::Vector3d internal; ///< η
  double sigma;             ///< σ, after a clamp
  Reactions reactions;
};

/// What the legs carry where the feet stand as `chosen`; sigma: σ.
CarriedTrunk carried_trunk(const Robot& robot, const SupportEquations& equations, const Support& support,
                           const Reactions& chosen, double sigma);

/// The other way: the ground reactions where the trailing leg carries f_T1. Moments about heels and toes are left out.
WrenchVector reactions_below(const Robot& robot, const SupportEquations& equations, const Support& support,
                             const Eigen::Vector3d& f_T1);

/// Procedure 4: of all η and σ that give the feet the reactions of procedure 3, the least,
///
///   [η; σ̄] = [B2 b2]^# (y − b3),   b2 = B2 f*,   σ = clamp(σ̄, 0, 1),   η = B2⁻¹ (y − b3 − b2 σ)       (72) to (74)
///
/// In the paper η stays what it was before the clamp, and then (71) does not hold. reactions.clamped: whether σ̄ was.
Result<CarriedTrunk> tracked_internal(const Robot& robot, const SupportEquations& equations, const Support& support,
                                      const LinearTransition& settings);

} // namespace torqued
