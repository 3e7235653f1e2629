/// What two legs that carry the trunk carry, [Al-Shuka 2014, (61) to (74)]; methods/least_torque.h says what σ, η and
/// f* are.
#pragma once

#include "methods/linear_transition.h"

namespace torqued::oracle
{

/// An internal wrench and what follows from it.
struct CarriedTrunk
{
  Eigen::Vector3d trunk;    ///< f*
  Eigen::Vector3d internal; ///< η
  double sigma;             ///< σ, after a clamp
  Reactions reactions;
};

/// What the legs carry where the feet stand as `chosen`; sigma: σ.
CarriedTrunk carried_trunk(const Robot& robot, const SupportEquations& equations, const Support& support,
                           const Reactions& chosen, double sigma);

/// The other way: the ground reactions where the trailing leg carries f_T1. Moments about heels and toes are left out.
WrenchVector reactions_below(const Robot& robot, const SupportEquations& equations, const Support& support,
                             const Eigen::Vector3d& f_T1);

/// Procedure 4, (72) to (74), η recomputed after the clamp of σ. reactions.clamped: whether σ̄ was.
Result<CarriedTrunk> tracked_internal(const Robot& robot, const SupportEquations& equations, const Support& support,
                                      const LinearTransition& settings);

} // namespace torqued::oracle
