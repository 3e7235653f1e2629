#include "methods/pseudo_inverse.h"

#include <cmath>

namespace torqued
{

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

static void list(PseudoInverse& settings, SettingList& with)
{
  with.weights("weights", settings.weights);
  with.three("reaction_weights", settings.reaction_weights, "three positive numbers: of f_x, of f_z and of the moment",
             "of f_x, f_z and moment");
}

MethodRow pseudo_inverse_row()
{
  return method_row<PseudoInverse>(
      "pseudo-inverse", [](const DoubleSupport& now)
      { return pseudo_inverse(now.robot, now.equations, now.support, now.all, now.settings.of<PseudoInverse>()); });
}

} // namespace torqued
