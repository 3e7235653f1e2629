/// Double support by optimisation under the conditions of contacts and motors.
#pragma once

#include "methods/method_settings.h"
#include "stance/support_equations.h"

#include <optional>

namespace torqued
{

struct AdmissibleReactions;
struct Reactions;
struct ReactionLimits;

/// The least torque by which feet neither lift, slip nor tip and motors stay within their limits:
///
///   minimise ½ τᵀ W τ + ½ k Σ_feet (L² |f − f_ref|² + (M − M_ref)²)   over the admissible reactions
///   subject to, at each foot,   the conditions and windows of contact_conditions.h
///   and at each motor           |τ| ≤ its limit
///
/// τ includes what rotors and friction take. f_ref, M_ref: reactions of zmp_transition(); L: the leg length; k:
/// `reference_weight`. Solved for the one to three numbers that (2) leaves free (quadratic_program.h). Where they need
/// no torque, so that W does not tell them apart (both legs straight, parallel, and feet at one place), the smaller
/// reactions are taken.
///
/// Where not all conditions can be met, windows give way first, then torque limits, then contacts: each by the least
/// sum of squares of what is missing, forces over weight, moments over weight × sole length, torques over their limits;
/// and of what then remains, the least torque is taken (relaxed is set). Beyond that least, contacts get room of 1e-9,
/// torque limits and windows 1e-8.
struct Constrained
{
  static constexpr Method kMethod = Method::constrained;
  JointWeights weights;
  bool windows = true;
  double reference_weight = 0.0; ///< k
  std::optional<double> f_min;   ///< N; empty: each foot's own
};

/// Chooses the reactions.
///
/// relax: whether conditions of contacts and motors may be violated when they cannot be met; windows always may.
/// Refuses: infeasible, if they cannot and may not; numerical.
Result<Reactions> constrained(const Robot& robot, const SupportEquations& equations, const Support& support,
                              const AdmissibleReactions& all, const Constrained& settings, bool relax);

/// The same choice, where contacts and motors can be kept, windows giving way where they must; nothing where they
/// cannot. limits: what they ask; null: their own conditions, as above. Refuses: numerical.
Result<std::optional<Reactions>> constrained_within(const Robot& robot, const SupportEquations& equations,
                                                    const Support& support, const AdmissibleReactions& all,
                                                    const Constrained& settings, const ReactionLimits* limits);

} // namespace torqued
