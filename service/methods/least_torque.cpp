#include "methods/least_torque.h"

#include <cmath>

namespace torqued
{

namespace
{

// Internal wrenches that need less torque than this, over the size of their forces × leg length, need none.
constexpr double kIndependent = 1e-9;

} // namespace

Result<Reactions> least_torque(const Robot& robot, const SupportEquations& equations, const Support& support,
                               const AdmissibleReactions& all, const JointWeights& weights)
{
  const double apart = (equations.foot(Side::left).point(support.of(Side::left)) -
                        equations.foot(Side::right).point(support.of(Side::right)))
                           .norm();
  if (support.redundancy() == 1 && apart < kCoincident * robot.leg_length)
    return Refusal(Reason::numerical,
                   "the contact points of both feet are {:.3g} m apart; with less than {:.3g} m the moments about them "
                   "are one condition, not two",
                   apart, kCoincident * robot.leg_length);

  const ReactionTorques torques = reaction_torques(robot, equations, support, all);
  const double size = weights.size() == 0 ? 1.0 : std::sqrt(weights.trace() / static_cast<double>(weights.rows()));
  const double independent = kIndependent * robot.leg_length * size;
  if (weights.size() == 0)
    if (const auto y = least_torque_equations(robot, torques).solution(independent))
      return Result<Reactions>(std::in_place_type<Reactions>, all, *y);

  // moments in N × leg length, so that the columns compare
  const double unit = all.redundancy == 3 ? robot.leg_length : 1.0;
  SumOfSquares sum = torque_squares(robot, torques, weights);
  sum.A.col(sum.variables - 1).head(sum.rows) *= unit;
  auto y = least_squares(sum, independent);
  if (!y)
    return Refusal(Reason::numerical,
                   "an internal wrench between the feet needs no torque here, as when both legs are straight, parallel "
                   "and at one place, so that the least torque does not determine the ground reactions");
  (*y)(all.redundancy - 1) *= unit;
  return Result<Reactions>(std::in_place_type<Reactions>, all, *y);
}

} // namespace torqued
