/// The nearest motion's problem, written out densely and by itself, and what proves that an answer solves it.
///
/// Its unknowns are all of a, τ and w; nothing is eliminated as in service/nearest. Proofs are multipliers: an answer
/// is optimal where some, of the signs that they must have, balance the objective's gradient.
#pragma once

#include "answer/answer.h"
#include "methods/constrained.h"
#include "questions/equation_of_motion.h"

#include <Eigen/Core>

namespace torqued::oracle
{

/// The z ≥ 0 that makes |A z − b| least, by active sets. Source: [Lawson, Hanson 1974, NNLS].
Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Conditions G w ≥ h: forces over the robot's weight, moments over weight × sole length.
struct ReactionRows
{
  Eigen::MatrixXd G;
  Eigen::VectorXd h;
};

/// An answer, in the rows of the equation of motion.
struct Answered
{
  Eigen::VectorXd a, torque;
  Eigen::VectorXd w;      ///< about the contact points
  double moment_at_point; ///< of the ground about heels and toes, which must be none; over weight × leg length
};

/// minimise ½ (a − a_d)ᵀ W (a − a_d) subject to M a + f = B τ + Jᵀ w, J a = b, G w ≥ h, least ≤ τ ≤ most.
struct NearestProblem
{
  Eigen::MatrixXd M; ///< rotors in it
  Eigen::VectorXd f; ///< h + g + B τ_f, friction only
  Eigen::MatrixXd B, J, W;
  Eigen::VectorXd b;       ///< −J̇ v − c J v, or J a_d
  Eigen::VectorXd b_terms; ///< sizes of what is summed in b
  Eigen::VectorXd a_d;
  ReactionRows conditions;
  ReactionRows windows;                              ///< those of `constrained`, once set_windows() has set them
  Eigen::VectorXd least, most;                       ///< of torques, N m
  Eigen::VectorXd torque_unit, w_unit, contact_unit; ///< what is much: N m; N, N m; m, rad
  Eigen::Vector2d base, base_rate;                   ///< of the completed motion, m, m/s

  /// memory: as it was before the answer.
  NearestProblem(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired,
                 const StreamMemory& memory);

  /// Sets the windows that there are for a motion a.
  void set_windows(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired,
                   const Eigen::VectorXd& a);

  /// Of M a + f − B τ − Jᵀ w: the largest row over the largest term.
  double residual(const Answered& found) const;
  /// Of J a − b, likewise.
  double contact_error(const Answered& found) const;
  /// How far torques are out of their range, N m.
  double out_of_range(const Answered& found) const;
  /// max(0, h − G w), row by row.
  Eigen::VectorXd lacking(const Answered& found) const;
  /// Whether the contacts' rows are independent.
  bool full_rank() const;

  /// What is left of the gradient when the best multipliers have balanced all that they can of it, over the gradient:
  /// of level 1, where the conditions are lowered by what they lack, so that it holds for relaxed answers, too.
  double motion_gradient_left(const Answered& found) const;
  /// Of the least violation, ½ |lacking|²; over the gradient, or 1, which is a lack of all the weight.
  double violation_gradient_left(const Answered& found) const;
  /// Of the choice of τ and w for the motion that was answered; gradient: of the objective, by τ and by w. Over the
  /// gradient, × units, or `nothing` where that is more.
  double choice_gradient_left(const Answered& found, const Eigen::VectorXd& by_torque, const Eigen::VectorXd& by_w,
                              double nothing) const;

  /// All that the equation of motion and the contacts leave: a = a0 + a_y y, τ = torque0 + torque_y y, w = w0 + w_y y.
  /// The objective is ½ Σ (size_i y_i + at_i)²; the last of y, which change no acceleration, have size and `at` 0.
  struct Reduced
  {
    Eigen::VectorXd a0, torque0, w0, size, at;
    Eigen::MatrixXd a_y, torque_y, w_y;
  };
  Reduced reduced() const;

  /// Whether any torques and reactions keep all of it.
  enum class Feasible
  {
    yes,      ///< some were found that do, to 1e-9
    no,       ///< multipliers prove that there are none
    undecided ///< by rounding
  };
  Feasible feasible() const;
};

/// What was answered to an absolute desired state.
Answered answered(const Robot& robot, const DesiredState& desired, const Answer& answer);

} // namespace torqued::oracle
