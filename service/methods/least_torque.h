/// Double support by the least torque, whatever the ground would have to do: procedures 1 and 2 of [Al-Shuka 2014], in
/// which two legs carry the trunk.
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
/// Both procedures seek the least ½ τᵀ W τ, (65); no condition of a contact or a motor is respected.
///
///   η = −P B1ᵀ W b1 − P a1 θ,   θ = (a1ᵀ P a1)⁻¹ (a2 − a1ᵀ P B1ᵀ W b1),   P = (B1ᵀ W B1)⁻¹               (67), (68)
///
/// The internal wrenches η that keep the moments about heels and toes at 0 are in one-to-one relation with y of the
/// admissible reactions, so that the least is sought there, without P, which need not exist. Procedure 2, (70), is
/// σ = 0: f_T1 itself is sought. σ shows in η, not in torques or reactions: η + σ f* is the same for all, so that both
/// procedures give the same. In the paper's (70) b1 and a2 keep a shift by σ f*.
#pragma once

#include "methods/method.h"

namespace torqued
{

/// Procedure 1.
struct InternalWrench
{
  static constexpr Method kMethod = Method::internal_wrench;
  JointWeights weights; ///< W
};

/// Procedure 2.
struct TorsoWrench
{
  static constexpr Method kMethod = Method::torso_wrench;
  JointWeights weights; ///< W
};

/// weights: W. Refuses: numerical where an internal wrench needs no torque (both legs straight, parallel, and feet at
/// one place), or where two contact points are one.
Result<Reactions> least_torque(const Robot& robot, const SupportEquations& equations, const Support& support,
                               const AdmissibleReactions& all, const JointWeights& weights);

} // namespace torqued
