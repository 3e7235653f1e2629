#include "methods/least_torque.h"

#include <array>
#include <cmath>

namespace torqued
{

namespace
{

// Internal wrenches that need less torque than this, over the size of their forces × leg length, need none.
constexpr double kIndependent = 1e-9;

} // namespace

Result<Reactions> pseudo_inverse(const Robot& robot, const SupportEquations& equations, const Support& support,
                                 const AdmissibleReactions& all, const PseudoInverse& settings)
{
  const ReactionTorques torques = reaction_torques(robot, equations, support, all);

  // and λᵀ V λ, λ of w0 + Z y, by the root of V: the wrench of the foot that is not fixed, or the forces of both
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  const bool one = leading_sole || trailing_sole;
  const Side loose = trailing_sole ? support.leading : support.trailing();
  const int from = one ? support.row(loose) : 0;
  const bool moment = one && support.of(loose) == Contact::sole;
  const auto root_of = [&](int i)
  {
    const double weight = settings.reaction_weights(i);
    return weight == 1.0 ? 1.0 : std::sqrt(weight); // a root takes time
  };
  const double of_x = root_of(0), of_z = root_of(1);
  const Eigen::Vector4d root(of_x, of_z, one ? (moment ? root_of(2) : 0.0) : of_x, one ? 0.0 : of_z);
  const int third = one ? (moment ? from + 2 : from) : 2, fourth = one ? from : 3;
  const auto lambda = [&](const auto& w) -> Eigen::Vector4d
  {
    return root.cwiseProduct(Eigen::Vector4d(w(from), w(from + 1), w(third), w(fourth)));
  };
  const Eigen::Vector4d b = lambda(all.rows.col(0));
  Eigen::Matrix<double, 4, 3> A;
  for (int k = 0; k < 3; ++k)
    A.col(k) = lambda(all.rows.col(1 + k));

  if (settings.weights.size() == 0)
  {
    NormalEquations normal = least_torque_equations(robot, torques);
    normal.add<4>(A, b);
    if (const auto y = normal.solution(0.0))
      return Result<Reactions>(std::in_place_type<Reactions>, all, *y);
  }
  SumOfSquares sum = torque_squares(robot, torques, settings.weights);
  sum.b.segment<4>(sum.rows) = b;
  for (int k = 0; k < sum.variables; ++k)
    sum.A.col(k).segment<4>(sum.rows) = A.col(k);
  sum.rows += 4;
  const auto y = least_squares(sum, 0.0);
  if (!y)
    return Refusal(Reason::numerical, "the measure of torques and reactions does not tell some reactions apart");
  return Result<Reactions>(std::in_place_type<Reactions>, all, *y);
}

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
