#include "stance/reactions.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace torqued
{

namespace
{

// a row of (w0, Z)
void set_row(AdmissibleReactions& all, int component, double w0, double of_y0, double of_y1, double of_y2)
{
  all.rows(component, 0) = w0;
  all.rows(component, 1) = of_y0;
  all.rows(component, 2) = of_y1;
  all.rows(component, 3) = of_y2;
}

// the sole supplies the force and the moment about the base point, and takes back what the other foot has
void on_sole(const SupportEquations& equations, const Support& support, Side sole, const Eigen::Vector3d& d,
             AdmissibleReactions& all)
{
  const Side free = other(sole);
  const int at_sole = support.row(sole), at_free = support.row(free);
  const Eigen::Vector2d& ankle = equations.standing[sole].ankle;
  all.redundancy = wrench_components(support.of(free));
  const bool force = all.redundancy > 0, moment = all.redundancy == 3;
  const Eigen::Vector2d between =
      force ? Eigen::Vector2d(equations.standing[free].point - ankle) : Eigen::Vector2d::Zero();
  set_row(all, at_sole, d(0), force ? -1.0 : 0.0, 0.0, 0.0);
  set_row(all, at_sole + 1, d(1), 0.0, force ? -1.0 : 0.0, 0.0);
  set_row(all, at_sole + 2, d(2) - cross(ankle, d.head<2>()), between.y(), -between.x(), moment ? -1.0 : 0.0);
  if (force)
  {
    set_row(all, at_free, 0.0, 1.0, 0.0, 0.0);
    set_row(all, at_free + 1, 0.0, 0.0, 1.0, 0.0);
  }
  if (moment)
    set_row(all, at_free + 2, 0.0, 0.0, 0.0, 1.0);
}

// points only: moments about that of the trailing foot, or of the only one
void on_points(const Robot& robot, const SupportEquations& equations, const Support& support, const Eigen::Vector3d& d,
               AdmissibleReactions& all)
{
  const bool two = all.components == 4;
  const Side side = two ? support.trailing() : support.of(Side::left) != Contact::none ? Side::left : Side::right;
  const Eigen::Vector2d p = equations.foot(side).point(support.of(side));
  const double moment = d(2) - cross(p - equations.base(), d.head<2>());
  const Eigen::Vector2d lever =
      two ? Eigen::Vector2d(equations.foot(support.leading).point(support.of(support.leading)) - p)
          : Eigen::Vector2d::Zero();
  const int at = support.row(side), at_leading = support.row(support.leading);
  if (lever.norm() < kCoincident * robot.leg_length)
  {
    all.unmet(2) = moment;
    const double force = two ? 1.0 : 0.0;
    all.redundancy = two ? 2 : 0;
    set_row(all, at, d(0), -force, 0.0, 0.0);
    set_row(all, at + 1, d(1), 0.0, -force, 0.0);
    if (two)
    {
      set_row(all, at_leading, 0.0, 1.0, 0.0, 0.0);
      set_row(all, at_leading + 1, 0.0, 0.0, 1.0, 0.0);
    }
  }
  else
  {
    // the leading force across the lever balances the moment; the internal force along it is free
    const Eigen::Vector2d force = moment / lever.squaredNorm() * perp(lever);
    const Eigen::Vector2d along = lever.normalized();
    all.redundancy = 1;
    set_row(all, at_leading, force.x(), along.x(), 0.0, 0.0);
    set_row(all, at_leading + 1, force.y(), along.y(), 0.0, 0.0);
    set_row(all, at, d(0) - force.x(), -along.x(), 0.0, 0.0);
    set_row(all, at + 1, d(1) - force.y(), -along.y(), 0.0, 0.0);
  }
}

} // namespace

AdmissibleReactions admissible_reactions(const Robot& robot, const SupportEquations& equations, const Support& support,
                                         const Eigen::Vector3d& d)
{
  AdmissibleReactions all;
  all.components = support.wrench_components();
  all.redundancy = 0;
  all.unmet.setZero();
  if (all.components % 2 == 1)
    set_row(all, all.components, 0.0, 0.0, 0.0, 0.0);
  if (all.components == 0)
    all.unmet = d;
  else if (support.of(support.trailing()) == Contact::sole)
    on_sole(equations, support, support.trailing(), d, all);
  else if (support.of(support.leading) == Contact::sole)
    on_sole(equations, support, support.leading, d, all);
  else
    on_points(robot, equations, support, d, all);
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
    const StandingFoot& standing = equations.standing[side];
    const int row = support.row(side);
    const Columns fx = all.row(row), fz = all.row(row + 1);
    const auto moment_at = [&](const Eigen::Vector2d& r) -> Columns
    {
      return r.x() * fz - r.y() * fx;
    };
    std::array<Columns, kMaxDirections + 1> moments;
    const auto arms = static_cast<std::size_t>(standing.arms.cols());
    for (std::size_t i = 0; i < arms; ++i)
      moments[i] = moment_at(standing.arms.col(static_cast<int>(i)));
    moments[arms] = contact == Contact::sole ? all.row(row + 2) : moment_at(standing.point - standing.ankle);
    // a joint's sum in registers: memory would wait for each of its parts
    const std::vector<Foot::TorqueShare>& shares = robot.foot(side).torque_shares;
    for (auto share = shares.begin(); share != shares.end();)
    {
      const int joint = share->joint;
      Columns sum = given[static_cast<std::size_t>(joint)];
      for (; share != shares.end() && share->joint == joint; ++share)
        sum -= share->size * moments[static_cast<std::size_t>(share->moment)];
      given[static_cast<std::size_t>(joint)] = sum;
    }
  }

  // τ0 and T, two joints at a time, and three columns, whatever their number
  ReactionTorques found;
  found.T.resize(kMaxJoints, 3);
  auto T = found.T.leftCols<3>();
  for (int j = 0; j < kMaxJoints; j += kJointBlock)
    if (j >= rows)
    {
      found.tau0.segment<kJointBlock>(j).setZero();
      T.middleRows<kJointBlock>(j).setZero();
    }
  write_joint_torques(robot, equations.r, found.tau0);
  for (int j = 0; j < rows; j += 2)
  {
    const Columns& one = given[static_cast<std::size_t>(j)];
    const Columns& next = given[static_cast<std::size_t>(j + 1)];
    found.tau0.segment<2>(j) += Eigen::Vector2d(one(0), next(0));
    for (int k = 0; k < 3; ++k)
      T.col(k).segment<2>(j) = Eigen::Vector2d(one(1 + k), next(1 + k));
  }
  found.T.conservativeResize(Eigen::NoChange, all.redundancy);
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
