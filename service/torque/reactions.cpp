#include "torque/reactions.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace torqued
{

namespace
{

// The wrench by which a sole supplies a force and a moment about the base point. lever: from there to its ankle.
Eigen::Vector3d at_sole(const Eigen::Vector2d& lever, const Eigen::Vector3d& d)
{
  return {d(0), d(1), d(2) - cross(lever, d.head<2>())};
}

} // namespace

AdmissibleReactions admissible_reactions(const Robot& robot, const SupportEquations& equations, const Support& support)
{
  const Eigen::Vector3d& d = equations.d;
  const int components = support.wrench_components();
  // all of the storage, because a number that the compiler knows is cleared in no time
  AdmissibleReactions all;
  all.w0.resize(components);
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(all.w0.data()).setZero();
  Eigen::Map<Eigen::Matrix<double, 6, 3>>(all.Z.data()).setZero();
  all.Z.resize(components, 0);
  all.unmet.setZero();

  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  if (components == 0)
  {
    all.unmet = d;
  }
  else if (leading_sole || trailing_sole)
  {
    // one foot is free, and the sole takes the rest
    const Side sole = trailing_sole ? support.trailing() : support.leading;
    const int sole_row = support.row(sole);
    const int free_row = support.row(other(sole));
    const int free = wrench_components(support.of(other(sole)));
    const StandingFoot& standing = equations.standing[static_cast<std::size_t>(sole)];
    const StandingFoot& free_foot = equations.standing[static_cast<std::size_t>(other(sole))];
    all.w0.segment<3>(sole_row) = at_sole(standing.ankle, d);
    if (free == 0)
      return all;

    // a force at the other foot, then a moment, and what takes them back
    all.Z.resize(components, free);
    for (int i = 0; i < free; ++i)
      all.Z(free_row + i, i) = 1.0;
    const Eigen::Vector2d between = free_foot.point - standing.ankle;
    all.Z.block<3, 2>(sole_row, 0) << -1.0, 0.0, 0.0, -1.0, between.y(), -between.x();
    if (free == 3)
      all.Z(sole_row + 2, 2) = -1.0;
  }
  else
  {
    // points only: moments about that of the trailing foot, or of the only one
    const bool two = components == 4;
    const Side at = two ? support.trailing() : support.of(Side::left) != Contact::none ? Side::left : Side::right;
    const Eigen::Vector2d p = equations.foot(at).point(support.of(at));
    const double moment = d(2) - cross(p - equations.base(), d.head<2>());
    const Eigen::Vector2d lever =
        two ? Eigen::Vector2d(equations.foot(support.leading).point(support.of(support.leading)) - p)
            : Eigen::Vector2d::Zero();
    const int row = support.row(at);
    const int leading_row = support.row(support.leading);
    all.w0.segment<2>(row) = d.head<2>();
    if (lever.norm() < kCoincident * robot.leg_length)
    {
      all.unmet(2) = moment;
      if (two)
      {
        all.Z = Bounded<6, 3>::Zero(4, 2);
        all.Z.middleRows<2>(leading_row).setIdentity();
        all.Z.middleRows<2>(row) = -Eigen::Matrix2d::Identity();
      }
    }
    else
    {
      all.w0.segment<2>(leading_row) = moment / lever.squaredNorm() * perp(lever);
      all.w0.segment<2>(row) -= all.w0.segment<2>(leading_row);
      all.Z.resize(4, 1);
      all.Z.middleRows<2>(leading_row) = lever.normalized();
      all.Z.middleRows<2>(row) = -lever.normalized();
    }
  }

  return all;
}

ReactionTorques reaction_torques(const Robot& robot, const SupportEquations& equations, const Support& support,
                                 const AdmissibleReactions& all)
{
  // what w0, and each y, gives each motor: −B⁺ Wᵀ of the moments of the feet's wrenches about the directions of their
  // legs
  using Columns = Eigen::Vector4d;
  const int rows = (robot.num_joints() + kJointBlock - 1) / kJointBlock * kJointBlock;
  std::array<Columns, kMaxJoints> given;
  std::fill_n(given.begin(), rows, Columns::Zero());
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    const StandingFoot& standing = equations.standing[static_cast<std::size_t>(side)];
    const auto component = [&](int c)
    {
      const auto of_y = [&](int k)
      {
        return k < all.redundancy() ? all.Z(c, k) : 0.0;
      };
      return Columns(all.w0(c), of_y(0), of_y(1), of_y(2));
    };
    const int row = support.row(side);
    const Columns fx = component(row), fz = component(row + 1);
    const auto moment_at = [&](const Eigen::Vector2d& r) -> Columns
    {
      return r.x() * fz - r.y() * fx;
    };
    std::array<Columns, kMaxDirections + 1> moments;
    const auto arms = static_cast<std::size_t>(standing.arms.cols());
    for (std::size_t i = 0; i < arms; ++i)
      moments[i] = moment_at(standing.arms.col(static_cast<int>(i)));
    moments[arms] = contact == Contact::sole ? component(row + 2) : moment_at(standing.point - standing.ankle);
    for (const Foot::TorqueShare& share : robot.foot(side).torque_shares)
      given[static_cast<std::size_t>(share.joint)] -= share.size * moments[static_cast<std::size_t>(share.moment)];
  }

  // τ0 and T, two joints at a time, and three columns, whatever their number: the storage goes on
  const VectorJ without = joint_torques(robot, equations.r);
  ReactionTorques found;
  found.T.resize(kMaxJoints, all.redundancy());
  Eigen::Map<Eigen::Matrix<double, kMaxJoints, 3>> T(found.T.data());
  for (int j = 0; j < rows; j += 2)
  {
    const Columns& one = given[static_cast<std::size_t>(j)];
    const Columns& next = given[static_cast<std::size_t>(j + 1)];
    found.tau0.segment<2>(j) = Eigen::Map<const Eigen::Vector2d>(without.data() + j) + Eigen::Vector2d(one(0), next(0));
    T.block<2, 1>(j, 0) = Eigen::Vector2d(one(1), next(1));
    T.block<2, 1>(j, 1) = Eigen::Vector2d(one(2), next(2));
    T.block<2, 1>(j, 2) = Eigen::Vector2d(one(3), next(3));
  }
  return found;
}

static_assert(kJointBlock == 8 && kMaxJoints == 16, "what SumOfSquares knows of");

SumOfSquares torque_squares(const Robot& robot, const ReactionTorques& torques, const JointWeights& weights)
{
  SumOfSquares sum;
  sum.variables = static_cast<int>(torques.T.cols());
  for (; sum.rows < robot.num_joints(); sum.rows += kJointBlock)
  {
    sum.b.segment<kJointBlock>(sum.rows) = torques.tau0.segment<kJointBlock>(sum.rows);
    for (int k = 0; k < sum.variables; ++k)
      sum.A.col(k).segment<kJointBlock>(sum.rows) = torques.T.col(k).segment<kJointBlock>(sum.rows);
  }
  if (weights.size() > 0)
  {
    const Eigen::LLT<JointWeights> W(weights);
    const VectorJ b = sum.b.head(weights.rows());
    sum.b.head(weights.rows()) = W.matrixU() * b;
    for (int k = 0; k < sum.variables; ++k)
    {
      const VectorJ column = sum.A.col(k).head(weights.rows());
      sum.A.col(k).head(weights.rows()) = W.matrixU() * column;
    }
  }
  return sum;
}

NormalEquations least_torque_equations(const Robot& robot, const ReactionTorques& torques)
{
  NormalEquations equations(static_cast<int>(torques.T.cols()));
  if (robot.num_joints() <= kJointBlock)
    equations.add<kJointBlock>(torques.T, torques.tau0);
  else
    equations.add<kMaxJoints>(torques.T, torques.tau0);
  return equations;
}

} // namespace torqued
