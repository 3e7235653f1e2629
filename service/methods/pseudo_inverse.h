/// Double support by the least torque and reactions, whatever the ground would have to do.
#pragma once

#include "methods/method.h"

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
  static constexpr Method kMethod = Method::pseudo_inverse;
  JointWeights weights;                                       ///< W, 1/(N m)²
  Eigen::Vector3d reaction_weights = Eigen::Vector3d::Ones(); ///< of f_x, f_z (1/N²) and moment (1/(N m)²); positive
};

/// Refuses: numerical, where neither torques nor weighted reactions tell the reactions apart, as with weights of next
/// to nothing.
Result<Reactions> pseudo_inverse(const Robot& robot, const SupportEquations& equations, const Support& support,
                                 const AdmissibleReactions& all, const PseudoInverse& settings);

} // namespace torqued
