/// Double support by the least torque, or the least torque and reactions, whatever the ground would have to do.
#pragma once

#include "stance/reactions.h"
#include "stance/refusal.h"

namespace torqued
{

/// The least torques and ground reactions, taken as one vector:
///
///   [τ; λ] = [A Jᵀ]^# (M q̈ + C q̇ + g + A τ_f)                                                               (27)
///
/// that is, the least τᵀ W τ + λᵀ V λ, W and V unit matrices in the paper. λ is the wrench of the foot that is not
/// fixed, J its rows: the fixed foot is the one on its sole, and of two soles the trailing one. Where neither is on its
/// sole, λ is the reaction of both.
///
/// Its measure adds N m to N: it is not the least torque, depends on the units and on which foot is fixed, and
/// respects no condition of a contact. Source: [Al-Shuka 2014, (27)]; weights added.
struct PseudoInverse
{
  JointWeights weights;                                       ///< W, 1/(N m)²
  Eigen::Vector3d reaction_weights = Eigen::Vector3d::Ones(); ///< of f_x, f_z (1/N²) and moment (1/(N m)²); positive
};

/// Refuses: numerical, where neither torques nor weighted reactions tell the reactions apart, as with weights of next
/// to nothing.
Result<Reactions> pseudo_inverse(const Robot& robot, const SupportEquations& equations, const Support& support,
                                 const AdmissibleReactions& all, const PseudoInverse& settings);

/// Procedures 1 and 2: the least ½ τᵀ W τ, (65), that the equations allow; no condition of a contact or a motor is
/// respected.
///
///   η = −P B1ᵀ W b1 − P a1 θ,   θ = (a1ᵀ P a1)⁻¹ (a2 − a1ᵀ P B1ᵀ W b1),   P = (B1ᵀ W B1)⁻¹               (67), (68)
///
/// The internal wrenches η that keep the moments about heels and toes at 0 are in one-to-one relation with y of the
/// admissible reactions, so that the least is sought there, without P, which need not exist. carried_trunk() has η.
/// Procedure 2, (70), is σ = 0: f_T1 itself is sought. σ shows in η, not in torques or reactions: η + σ f* is the same
/// for all. In the paper's (70) b1 and a2 keep a shift by σ f*.
struct InternalWrench
{
  double sigma = 0.5; ///< the trailing leg's share of f* before η, of carried_trunk(); no torque or reaction has it
  JointWeights weights;
};

/// weights: W. Refuses: numerical where an internal wrench needs no torque (both legs straight, parallel, and feet at
/// one place), or where two contact points are one.
Result<Reactions> least_torque(const Robot& robot, const SupportEquations& equations, const Support& support,
                               const AdmissibleReactions& all, const JointWeights& weights);

} // namespace torqued
