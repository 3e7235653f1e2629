/// From the equations of a support to torques and ground reactions.
#pragma once

#include "torque/equations.h"

#include <optional>
#include <string_view>
#include <vector>

namespace torqued
{

/// Hands the load from the trailing to the leading foot in proportion to load_transfer, s.
///
/// Each foot takes its share of the total ground force F, horizontal part too: leading s F, trailing (1 − s) F.
/// Source: H. F. N. Al-Shuka, B. J. Corves, W.-H. Zhu, "Dynamic Modeling of Biped Robot using Lagrangian and
/// Recursive Newton-Euler Formulations", 2014, equations (28) and (29), with t_s and t_d the instants at which double
/// support begins and ends. They give forces and no moments, which leaves to each contact pair:
///
/// - sole and point: the point's share acts at the point; the sole's wrench follows from (2).
/// - point and point: s splits the horizontal force; (2) determines the normal forces. Refused as numerical when the
///   points stand above one another.
/// - sole and sole: one moment is free. By default each foot's centre of pressure follows the total zero-moment point
///   as far as its sole allows; or the leading foot's stays at `leading_cop`, a fraction of its sole (0 = heel, 1 =
///   toe).
struct LinearTransition
{
  std::optional<double> leading_cop; ///< empty: follow the zero-moment point
};

/// The methods that can be asked for, by number and name ("linear-transition"), and the settings of each.
struct NamedMethod
{
  Method method;
  std::string_view name;
};
inline constexpr std::array<NamedMethod, 1> kMethods{{{Method::linear_transition, "linear-transition"}}};
/// The same for a complaint about a desired state.
inline constexpr std::string_view kMethodChoices = "DEFAULT (0) or LINEAR_TRANSITION (2)";
/// A method's name; "none" for Method::none and for any number that is no method.
std::string_view name_of(Method method);

struct MethodSettings
{
  Method method = Method::linear_transition; ///< used when the desired state asks for none
  LinearTransition linear_transition;
};

/// The wrench (N, N m) of the ground on one foot: force, and moment about the ankle.
struct Wrench
{
  double fx = 0.0, fz = 0.0, moment = 0.0;
};

/// What makes the motion happen.
struct TorqueSolution
{
  VectorJ torque;               ///< N m, in the actuators' order
  std::array<Wrench, 2> ground; ///< indexed by Side; about the ankle, whatever the contact
  WrenchVector w;               ///< the same, in the order of the rows of J, about the contact points
  Method method;                ///< none when nothing had to be chosen
};

/// Chooses w by the method that the support calls for, and computes the torques, equation (3).
///
/// residual_tolerance: an under-actuated motion (flight; one heel or toe) is answered only if its equations (2) hold
/// within this share of the weight (forces), or of weight × leg length (moment about the contact point). The torques
/// are then exact in every row but the root's, which keeps the residual.
/// Refuses: under_actuated; numerical when a method's equations are singular.
Result<TorqueSolution> solve_torques(const Robot& robot, const SupportEquations& equations, const Support& support,
                                     Method method, const MethodSettings& settings, double residual_tolerance);

/// Largest component of r − B τ − Jᵀ w, N or N m: rounding, unless the motion is under-actuated or τ was clamped.
double dynamics_residual(const Robot& robot, const SupportEquations& equations, const WrenchVector& w,
                         const VectorJ& torque);

/// The rule of LinearTransition, for any two contacts. Refuses: numerical.
Result<WrenchVector> linear_transition(const Robot& robot, const SupportEquations& equations, const Support& support,
                                       const LinearTransition& settings);

} // namespace torqued
