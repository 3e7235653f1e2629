/// The ground reactions that equations (2) leave to choose from. A method of double support is a rule that chooses.
#pragma once

#include "torque/equations.h"

namespace torqued
{

/// Ground reactions as a method chooses them.
struct Reactions
{
  WrenchVector w;
  bool clamped = false; ///< a share was outside 0 to 1, or undefined, and was set
  bool relaxed = false; ///< conditions that could not all be met are violated, as little as can be
};

/// All ground reactions that (2) allows:
///
///   w = w0 + Z y,   G w0 = d,   G Z = 0
///
/// Where a foot is on its sole, y is the wrench of the other foot, so that w0 leaves that one unloaded: the heel's or
/// toe's force, or, on two soles, the leading foot's force and moment. With two heels or toes y is the internal force
/// along the line from the trailing to the leading point; where both are one point, the leading foot's force. With one
/// foot down, or none, y is empty.
struct AdmissibleReactions
{
  WrenchVector w0;
  Bounded<6, 3> Z;       ///< wrench_components() × redundancy
  Eigen::Vector3d unmet; ///< what of (2) no reaction meets: in flight d; on one heel or toe, or on two at one point,
                         ///< (0, 0, moment about it); else 0
  Eigen::Index redundancy() const { return Z.cols(); }
  /// Rank of G: 3; 2 on a single heel or toe, or two at one point; 0 in flight.
  Eigen::Index rank() const { return w0.size() - Z.cols(); }
};

AdmissibleReactions admissible_reactions(const Robot& robot, const SupportEquations& equations, const Support& support);

/// The torques that go with them, τ = τ0 + T y.
struct ReactionTorques
{
  VectorJ tau0;             ///< B⁺ (r − Jᵀ w0), N m
  Bounded<kMaxJoints, 3> T; ///< −B⁺ Jᵀ Z, joints × redundancy; of full column rank where J has full row rank
};

ReactionTorques reaction_torques(const Robot& robot, const SupportEquations& equations, const Support& support,
                                 const AdmissibleReactions& all);

/// W of ½ τᵀ W τ, joints × joints, symmetric and positive definite; empty: the unit matrix.
using JointWeights = Bounded<kMaxJoints, kMaxJoints>;

} // namespace torqued
