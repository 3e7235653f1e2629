/// The nearest motion that can be had, where the one that is asked for cannot.
///
///   1. minimise   ½ (a − a_d)ᵀ W (a − a_d)                over a, τ, w
///      subject to M a + h + g + B τ_f = B τ + Jᵀ w         (1)
///                 J a + J̇ v = −c J v                       loaded contacts rest; or J a = J a_d (NearestContacts)
///                 contact conditions                       each loaded foot, contact_conditions.h, without windows
///                 τ within its range                       each motor
///   2. and, among its minimisers (a is unique), choose τ, w by the method that is asked for.
///
/// The method chooses as for any motion, now for a: constrained the least torque within its windows; of every other
/// method the nearest reactions to its choice that keep the conditions, forces per weight, moments per weight × sole
/// length, so that its answer passes into this one without a jump. Where a method refuses, constrained chooses.
///
/// W is M, rotors in it, so that 1 is Gauss's principle of least constraint; without inequalities its answer is that of
/// Udwadia and Kalaba. Or W weighs angles, NearestMetric.
///
/// What gives way where not all can be kept, lowest priority first: the method's criterion; a; contact conditions, by
/// the least sum of squares, forces over weight, moments over weight × sole length; contacts that contradict one
/// another, in least squares. (1) and the torques' range never do.
///
/// A fixed root rests, and has no conditions. On one heel or toe, and in flight, the nearest motion is one in which the
/// rows without motors hold: in flight the centre of mass is ballistic and angular momentum constant.
/// Source: C. F. Gauss, "Über ein neues allgemeines Grundgesetz der Mechanik", J. reine angew. Math. 4, 1829, with the
/// contacts' inequalities as Moreau takes them; the two levels are ours.
#pragma once

#include "methods/conditions.h"
#include "methods/torque_solution.h"
#include "nearest/nearest_settings.h"

#include <optional>

namespace torqued
{

/// What is answered.
struct NearestMotion
{
  NearestMotion(const TorqueSolution& found, const std::optional<VectorQ>& moved) : solution(found), change(moved) {}

  TorqueSolution solution; ///< relaxed: conditions, windows or contacts gave way
  /// a − a_d, length num_q(); empty where the usual answer keeps all, which is then answered as it is.
  std::optional<VectorQ> change;
};

/// Answers the nearest motion. The usual answer comes first: where it keeps all that is asked to 1e-9 of what is much
/// of it, it is the answer, bit for bit.
///
/// equations: of the desired motion; then of the answered one. method: none for the settings' one. range: of torques.
/// Refuses: numerical.
Result<NearestMotion> nearest_motion(const Robot& robot, const Support& support, Method method,
                                     const MethodSettings& methods, const NearestSettings& settings,
                                     const TorqueRange& range, SupportEquations& equations);

} // namespace torqued
