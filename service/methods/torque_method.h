/// From the equations of a support to torques and ground reactions.
#pragma once

#include "methods/constrained.h"
#include "methods/human_transition.h"
#include "methods/least_torque.h"
#include "methods/linear_transition.h"
#include "methods/trunk_wrench.h"

#include <optional>
#include <string>
#include <string_view>

namespace torqued
{

/// The methods that can be asked for, by number and name.
struct NamedMethod
{
  Method method;
  std::string_view name;
};
inline constexpr std::array<NamedMethod, 9> kMethods{{
    {Method::pseudo_inverse, "pseudo-inverse"},
    {Method::linear_transition, "linear-transition"},
    {Method::internal_wrench, "internal-wrench"},
    {Method::torso_wrench, "torso-wrench"},
    {Method::tracked_reaction, "tracked-reaction"},
    {Method::tracked_internal, "tracked-internal"},
    {Method::constrained, "constrained"},
    {Method::zmp_transition, "zmp-transition"},
    {Method::human_transition, "human-transition"},
}};
/// The same for a complaint about a desired state.
inline constexpr std::string_view kMethodChoices =
    "DEFAULT (0), PSEUDO_INVERSE (1), LINEAR_TRANSITION (2), INTERNAL_WRENCH (3), TORSO_WRENCH (4), TRACKED_REACTION "
    "(5), TRACKED_INTERNAL (6), CONSTRAINED (7), ZMP_TRANSITION (8) or HUMAN_TRANSITION (9)";
/// A method's name; "none" for Method::none and for any number that is no method.
std::string_view name_of(Method method);

/// The settings of each method; zmp_transition has none.
struct MethodSettings
{
  Method method = Method::constrained; ///< used when the desired state asks for none
  PseudoInverse pseudo_inverse;
  LinearTransition linear_transition; ///< of tracked_reaction and tracked_internal, too
  InternalWrench internal_wrench;
  InternalWrench torso_wrench{.sigma = 0.0, .weights = {}};
  Constrained constrained;
  HumanTransition human_transition;
  bool relax = true; ///< constrained: conditions that cannot be met are violated as little as can be; else refused
};

/// What is wrong with the settings for a robot with so many motors: one line, or nothing. Weights need a row and a
/// column for each motor.
std::optional<std::string> complaint(const MethodSettings& settings, int num_joints);

/// What makes the motion happen.
struct TorqueSolution
{
  /// All that follows from the ground reactions w, equation (3). w: wrench_components() long.
  TorqueSolution(const Robot& robot, const SupportEquations& equations, const Support& support, Method method,
                 const WrenchVector& w, bool clamped = false, bool relaxed = false);

  Method method;                ///< none when nothing had to be chosen
  bool clamped, relaxed;        ///< of the Reactions
  WrenchVector w;               ///< in the order of the rows of J, about the contact points
  std::array<Wrench, 2> ground; ///< the same about the ankles, indexed by Side
  VectorQ from_ground;          ///< Jᵀ w
  VectorJ torque;               ///< N m, in the actuators' order

  /// r − Jᵀ w, as a function of the row. equations: those that were solved.
  auto left_for_motors(const SupportEquations& equations) const
  {
    return [&r = equations.r, &supplied = from_ground](int row)
    {
      return r(row) - supplied(row);
    };
  }
};

/// Chooses w by the method that the support calls for, and computes the torques, equation (3).
///
/// residual_tolerance: an under-actuated motion (flight; one heel or toe) is answered only if its equations (2) hold
/// within this share of the weight (forces), or of weight × leg length (moment about the contact point); so is one on
/// two heels or toes at one place. The torques are then exact in every row but the root's, which keeps the residual.
/// Refuses: under_actuated; infeasible; numerical when a method's equations are singular.
Result<TorqueSolution> solve_torques(const Robot& robot, const SupportEquations& equations, const Support& support,
                                     Method method, const MethodSettings& settings, double residual_tolerance);

/// Largest component of r − B τ − Jᵀ w, N or N m: rounding, unless the motion is under-actuated or τ was clamped.
/// solution: of the equations; its Jᵀ w and τ are taken.
inline double dynamics_residual(const Robot& robot, const SupportEquations& equations, const TorqueSolution& solution)
{
  return largest_left(robot, solution.left_for_motors(equations), solution.torque);
}

} // namespace torqued
