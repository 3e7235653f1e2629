/// The ground reactions that equations (2) leave to choose from. A method of double support is a rule that chooses.
#pragma once

#include "stance/least_squares.h"
#include "stance/support_equations.h"

namespace torqued
{

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
  /// (w0, Z), a row for each component of w; columns beyond the redundancy are 0. An odd number of rows is followed by
  /// one of zeros; what follows that is not set.
  static constexpr int kMaxComponents = 6;
  Eigen::Matrix<double, kMaxComponents, 4, Eigen::RowMajor> rows;
  int components, redundancy;
  Eigen::Vector3d unmet; ///< what of (2) no reaction meets: in flight d; on one heel or toe, or on two at one point,
                         ///< (0, 0, moment about it); else 0

  /// A row, entry by entry, because that is how it was written just before.
  Eigen::Vector4d row(int c) const { return {rows(c, 0), rows(c, 1), rows(c, 2), rows(c, 3)}; }
  WrenchVector w0() const
  {
    return by_rows([](const auto& row) { return row(0); });
  }
  /// components × redundancy.
  auto Z() const { return rows.block(0, 1, components, redundancy); }
  /// w0 + Z y; y may go on.
  WrenchVector at(const Eigen::Vector3d& y) const
  {
    return by_rows([by = Eigen::RowVector4d(1.0, y(0), y(1), y(2))](const auto& row) { return row.dot(by); });
  }
  /// Rank of G: 3; 2 on a single heel or toe, or two at one point; 0 in flight.
  int rank() const { return components - redundancy; }

private:
  template <typename OfRow> WrenchVector by_rows(const OfRow& of_row) const
  {
    WrenchVector w(kMaxComponents);
    for (int i = 0; i < components; i += 2)
      w.segment<2>(i) = Eigen::Vector2d(of_row(rows.row(i)), of_row(rows.row(i + 1)));
    w.conservativeResize(components);
    return w;
  }
};

/// Ground reactions as a method chooses them.
struct Reactions
{
  explicit Reactions(const WrenchVector& chosen) : w(chosen) {}
  Reactions(const AdmissibleReactions& all, const Eigen::Vector3d& y, bool was_relaxed = false)
      : w(all.at(y)), relaxed(was_relaxed)
  {
  }

  WrenchVector w;
  bool clamped = false; ///< a share was outside 0 to 1, or undefined, and was set
  bool relaxed = false; ///< conditions that could not all be met are violated, as little as can be
};

/// d: what the ground must supply; by default what the motion needs. w0 and unmet are linear in it, Z does not depend
/// on it.
AdmissibleReactions admissible_reactions(const Robot& robot, const SupportEquations& equations, const Support& support,
                                         const Eigen::Vector3d& d);
inline AdmissibleReactions admissible_reactions(const Robot& robot, const SupportEquations& equations,
                                                const Support& support)
{
  return admissible_reactions(robot, equations, support, equations.d);
}

/// The torques that go with them, τ = τ0 + T y. One row for each joint; zeros follow.
struct ReactionTorques
{
  PaddedJoints tau0; ///< B⁺ (r − Jᵀ w0), N m
  /// −B⁺ Jᵀ Z, one column for each y; of full column rank where J has full row rank.
  Eigen::Matrix<double, kMaxJoints, Eigen::Dynamic, 0, kMaxJoints, 3> T;
};

ReactionTorques reaction_torques(const Robot& robot, const SupportEquations& equations, const Support& support,
                                 const AdmissibleReactions& all);

/// τᵀ W τ of τ = τ0 + T y: with W = Uᵀ U it is |U T y + U τ0|².
SumOfSquares torque_squares(const Robot& robot, const ReactionTorques& torques, const JointWeights& weights);

/// The normal equations of the least τᵀ τ.
NormalEquations least_torque_equations(const Robot& robot, const ReactionTorques& torques);

} // namespace torqued
