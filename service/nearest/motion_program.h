/// The nearest motion as a quadratic program, level 1 of nearest_motion.h.
#pragma once

#include "methods/conditions.h"
#include "nearest/motion_space.h"

#include <optional>

namespace torqued
{

/// ½ |ζ|², of the accelerations a = a_d + δ0 + F ζ (motion_space.h), over ζ and the y of the reactions w = w0 + Z y:
///
///   w0 = w0(d + Dᵀ ζ),   τ = B⁺ (r + M̂ F ζ − Jᵀ w)
///
///   subject to   contacts' conditions on w,   least ≤ τ ≤ most
///
/// Flat in y: solve_semidefinite().
struct MotionProgram
{
  /// equations: of the motion a_d + δ0; all0: their reactions. D: space.span(). contacts: without windows. range: of
  /// the torques; empty where they take no part, and three of ζ are enough then.
  MotionProgram(const Robot& robot, const SupportEquations& equations, const Support& support,
                const AdmissibleReactions& all0, const MotionSpace& space, const Eigen::Matrix3d& D,
                const ContactConditions& contacts, const std::optional<TorqueRange>& range);

  QuadraticProgram program; ///< the contacts' rows come first
  int zeta;                 ///< so many of the variables are ζ; y follows
  VectorQ unit;             ///< of the variables: ζ; N, and N m of a moment

  /// The variables, in their units, at which the contacts' conditions lack the least sum of squares while torques keep
  /// their range; grants program and contacts what they lack there, and room for rounding, over what is much of each.
  /// Nothing if it was not found. contacts: those of the program.
  std::optional<VectorQ> relax(ContactConditions& contacts, double room);
};

} // namespace torqued
