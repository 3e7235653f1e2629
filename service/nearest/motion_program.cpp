#include "nearest/motion_program.h"

#include "methods/torque_solution.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace torqued
{

MotionProgram::MotionProgram(const Robot& robot, const SupportEquations& equations, const Support& support,
                             const AdmissibleReactions& all0, const MotionSpace& space, const Eigen::Matrix3d& D,
                             const ContactConditions& contacts, const std::optional<TorqueRange>& range)
{
  zeta = range ? space.size() : std::min(3, space.size());
  const int n = zeta + all0.redundancy, joints = robot.num_joints();
  Rows& rows = program.rows;
  rows.A.setZero(contacts.size() + (range ? 2 * joints : 0), n);
  rows.b.setOnes(rows.A.rows());

  // w as a function of d, and d of ζ
  std::array<AdmissibleReactions, 3> of_d;
  for (int k = 0; k < 3; ++k)
    of_d[static_cast<std::size_t>(k)] = admissible_reactions(robot, equations, support, Eigen::Vector3d::Unit(k));
  Eigen::Matrix<double, AdmissibleReactions::kMaxComponents, 3> w_d; // columns: of each of d
  for (int c = 0; c < all0.components; ++c)
    for (int k = 0; k < 3; ++k)
      w_d(c, k) = of_d[static_cast<std::size_t>(k)].rows(c, 0);

  int row = 0;
  for (const ContactCondition& condition : contacts)
  {
    double of_w0 = 0.0;
    Eigen::Vector3d by_d = Eigen::Vector3d::Zero();
    for (int i = 0; i < wrench_components(support.of(condition.side)); ++i)
    {
      const int c = support.row(condition.side) + i;
      const double factor = condition.factor * condition.c(i);
      of_w0 += factor * all0.rows(c, 0);
      by_d += factor * w_d.row(c).transpose();
      for (int k = 0; k < all0.redundancy; ++k)
        rows.A(row, zeta + k) += factor * all0.rows(c, 1 + k);
    }
    const Eigen::Vector3d by_zeta = D * by_d;
    for (int k = 0; k < std::min(3, zeta); ++k)
      rows.A(row, k) = by_zeta(k);
    rows.b(row++) = condition.factor * condition.bound - of_w0;
  }

  if (range)
  {
    // τ = B⁺ (r − Jᵀ w), and of each ζ what it changes of it
    const ReactionTorques torques = reaction_torques(robot, equations, support, all0);
    const MatrixQ F = space.basis();
    SupportEquations change = equations;
    for (int k = 0; k < n; ++k)
    {
      VectorJ torque;
      if (k < zeta)
      {
        change.r.noalias() = space.mass().lazyProduct(F.col(k));
        WrenchVector w = WrenchVector::Zero(all0.components);
        if (k < 3)
          for (int c = 0; c < all0.components; ++c)
            w(c) = w_d.row(c).dot(D.row(k));
        torque = TorqueSolution(robot, change, support, Method::none, w).torque;
      }
      else
        torque = torques.T.col(k - zeta).head(joints);
      for (int j = 0; j < joints; ++j)
      {
        const double factor = torque_factor(robot, j);
        rows.A(row + j, k) = factor * torque(j);
        rows.A(row + joints + j, k) = -factor * torque(j);
      }
    }
    for (int j = 0; j < joints; ++j)
    {
      const double factor = torque_factor(robot, j);
      rows.b(row + j) = factor * (range->most(j) - torques.tau0(j));
      rows.b(row + joints + j) = factor * (torques.tau0(j) - range->least(j));
    }
    // what is not bounded
    for (int i = row; i < row + 2 * joints; ++i)
      if (!std::isfinite(rows.b(i)))
      {
        rows.A.row(i).setZero();
        rows.b(i) = 1.0;
      }
  }

  // units in which entries are of order 1
  unit = VectorQ::Constant(n, robot.weight());
  if (all0.redundancy == 3)
    unit(n - 1) *= robot.leg_length;
  const double most = rows.A.leftCols(zeta).size() > 0 ? rows.A.leftCols(zeta).cwiseAbs().maxCoeff() : 0.0;
  unit.head(zeta).setConstant(most > 0.0 ? 1.0 / most : 1.0);
  for (int k = 0; k < n; ++k)
    rows.A.col(k) *= unit(k);
  program.H.setZero(n, n);
  program.H.diagonal().head(zeta).setOnes();
  program.g.setZero(n);
}

std::optional<VectorQ> MotionProgram::relax(ContactConditions& contacts, double room)
{
  Rows& rows = program.rows;
  Rows soft = rows;
  for (int i = 0; i < contacts.size(); ++i)
    soft.soft.set(static_cast<std::size_t>(i));
  // ζ has no part in what is sought: each may have units of its own, in which its entries are of order 1
  VectorQ own_unit = VectorQ::Ones(program.g.size());
  for (int k = 0; k < zeta; ++k)
    if (const double most = rows.A.col(k).cwiseAbs().maxCoeff(); most > 0.0)
    {
      own_unit(k) = 1.0 / most;
      soft.A.col(k) *= own_unit(k);
    }
  const QuadraticProgramSolution least = least_violation(soft, BoundedVector<kMaxVariables>::Zero(program.g.size()));
  if (least.status != QuadraticProgramStatus::optimal)
    return {};
  const VectorQ at_least = own_unit.cwiseProduct(least.y);
  ContactCondition* condition = contacts.begin();
  for (int i = 0; i < contacts.size(); ++i, ++condition)
  {
    const double lacks = std::max(0.0, rows.A.row(i).dot(at_least) - rows.b(i)) + room;
    rows.b(i) += lacks;
    condition->bound += lacks / condition->factor;
  }
  return at_least;
}

} // namespace torqued
