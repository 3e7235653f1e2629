/// From the equations of a support to torques and ground reactions.
#pragma once

#include "methods/method.h"

namespace torqued
{

/// What makes the motion happen.
struct TorqueSolution
{
  /// All that follows from the ground reactions w, equation (3). w: wrench_components() long.
  TorqueSolution(const Robot& robot, const SupportEquations& equations, const Support& support, Method method,
                 const WrenchVector& w, bool clamped = false, bool relaxed = false);

  Method method;          ///< none when nothing had to be chosen
  bool clamped, relaxed;  ///< of the Reactions
  WrenchVector w;         ///< in the order of the rows of J, about the contact points
  PerSide<Wrench> ground; ///< the same about the ankles
  VectorQ from_ground;    ///< Jᵀ w
  VectorJ torque;         ///< N m, in the actuators' order

  /// r − Jᵀ w, as a function of the row. equations: those that were solved.
  auto motor_forces(const SupportEquations& equations) const
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
  return largest_left(robot, solution.motor_forces(equations), solution.torque);
}

} // namespace torqued
