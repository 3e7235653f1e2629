/// The ground reactions that equations (2) leave to choose from. A method of double support is a rule that chooses.
#pragma once

#include "torque/equations.h"
#include "torque/least_squares.h"

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
  /// w0 + Z y; y may go on.
  WrenchVector at(const Eigen::Vector3d& y) const
  {
    // six components, whatever their number: the storage goes on
    using Six = Eigen::Matrix<double, 6, 1>;
    WrenchVector w(w0.size());
    Six sum = Eigen::Map<const Six>(w0.data());
    for (int k = 0; k < Z.cols(); ++k)
      sum += y(k) * Eigen::Map<const Six>(Z.data() + k * Z.rows());
    Eigen::Map<Six>(w.data()) = sum;
    return w;
  }
  /// Rank of G: 3; 2 on a single heel or toe, or two at one point; 0 in flight.
  Eigen::Index rank() const { return w0.size() - Z.cols(); }
};

AdmissibleReactions admissible_reactions(const Robot& robot, const SupportEquations& equations, const Support& support);

/// The torques that go with them, τ = τ0 + T y. One row for each joint; in whole blocks of joints, zeros and then
/// nothing follow.
struct ReactionTorques
{
  Eigen::Matrix<double, kMaxJoints, 1> tau0; ///< B⁺ (r − Jᵀ w0), N m
  /// −B⁺ Jᵀ Z, one column for each y; of full column rank where J has full row rank.
  Eigen::Matrix<double, kMaxJoints, Eigen::Dynamic, 0, kMaxJoints, 3> T;
};

ReactionTorques reaction_torques(const Robot& robot, const SupportEquations& equations, const Support& support,
                                 const AdmissibleReactions& all);

/// W of ½ τᵀ W τ, joints × joints, symmetric and positive definite; empty: the unit matrix.
using JointWeights = Bounded<kMaxJoints, kMaxJoints>;

/// τᵀ W τ of τ = τ0 + T y: with W = Uᵀ U it is |U T y + U τ0|².
SumOfSquares torque_squares(const Robot& robot, const ReactionTorques& torques, const JointWeights& weights);

/// The normal equations of the least τᵀ τ.
NormalEquations least_torque_equations(const Robot& robot, const ReactionTorques& torques);

} // namespace torqued
