#include "torque/least_torque.h"

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
  SumOfSquares sum = torque_squares(robot, reaction_torques(robot, equations, support, all), settings.weights);

  // and λᵀ V λ, λ of w0 + Z y, by the root of V; it has 2 to 4 components
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  std::array<int, 4> of_w{};
  Eigen::Vector4d root = Eigen::Vector4d::Zero();
  int count = 0;
  for (const Side side : kSides)
    if (const bool fixed = side == support.leading ? leading_sole && !trailing_sole : trailing_sole; !fixed)
      for (int i = 0; i < wrench_components(support.of(side)); ++i)
      {
        of_w[static_cast<std::size_t>(count)] = support.row(side) + i;
        root(count++) = std::sqrt(settings.reaction_weights(i));
      }
  const auto lambda = [&](const auto& w) -> Eigen::Vector4d
  {
    return root.cwiseProduct(Eigen::Vector4d(w(of_w[0]), w(of_w[1]), w(of_w[2]), w(of_w[3])));
  };
  sum.b.segment<4>(sum.rows) = lambda(all.w0);
  for (int k = 0; k < sum.variables; ++k)
    sum.A.col(k).segment<4>(sum.rows) = lambda(all.Z.col(k));
  sum.rows += 4;

  const auto y = least_squares(sum, 0.0);
  if (!y)
    return Refusal(Reason::numerical, "the measure of torques and reactions does not tell some reactions apart");
  return Reactions{all.at(*y)};
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

  // moments in N × leg length, so that the columns compare
  const double unit = all.redundancy() == 3 ? robot.leg_length : 1.0;
  SumOfSquares sum = torque_squares(robot, reaction_torques(robot, equations, support, all), weights);
  sum.A.col(sum.variables - 1).head(sum.rows) *= unit;
  const double size = weights.size() == 0 ? 1.0 : std::sqrt(weights.trace() / static_cast<double>(weights.rows()));
  auto y = least_squares(sum, kIndependent * robot.leg_length * size);
  if (!y)
    return Refusal(Reason::numerical,
                   "an internal wrench between the feet needs no torque here, as when both legs are straight, parallel "
                   "and at one place, so that the least torque does not determine the ground reactions");
  (*y)(all.redundancy() - 1) *= unit;
  return Reactions{all.at(*y)};
}

} // namespace torqued
