#include "bench/full_form.h"

#include "methods/contact_conditions.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace torqued::bench
{

namespace
{

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Conditions of contacts and motors on (τ, w), in N and N m; rows in units in which what is much of them is 1.
struct Conditions
{
  MatrixXd A;
  VectorXd b;
};

Conditions conditions(const Robot& robot, const SupportEquations& equations, const Support& support,
                      const Constrained& settings)
{
  const int motors = robot.num_joints();
  ContactConditions contacts;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  for_each_condition(
      robot, equations, support, {settings.windows, settings.f_min},
      [&](Side side, double bound, double factor, bool is_window, const auto& form) {
        contacts.push_back({side, form(unit.col(0), unit.col(1), unit.col(2)), bound, factor, is_window});
      });
  Conditions all{MatrixXd::Zero(contacts.size() + 2 * motors, motors + support.wrench_components()),
                 VectorXd::Zero(contacts.size() + 2 * motors)};
  int row = 0;
  for (const ContactCondition& contact : contacts)
  {
    const int components = wrench_components(support.of(contact.side));
    all.A.row(row).segment(motors + support.row(contact.side), components) =
        contact.factor * contact.c.head(components).transpose();
    all.b(row++) = contact.factor * contact.bound;
  }
  for (int j = 0; j < motors; ++j)
    if (const double limit = robot.actuators[static_cast<std::size_t>(j)].torque_limit; std::isfinite(limit))
      for (const double sign : {1.0, -1.0})
      {
        all.A(row, j) = sign / limit;
        all.b(row++) = 1.0;
      }
  all.A.conservativeResize(row, Eigen::NoChange);
  all.b.conservativeResize(row);
  return all;
}

} // namespace

VectorXd solve_dense(const DenseProgram& program)
{
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Eigen::LLT<MatrixXd> llt(program.H);
  const auto whitened = [&](const MatrixXd& normals) -> MatrixXd
  {
    return llt.matrixL().solve(normals);
  };

  // with H = L Lᵀ and v = Lᵀ x it is the v nearest to −L⁻¹ g
  const Eigen::Index equalities = program.e.size();
  MatrixXd N = whitened(program.E.transpose());
  VectorXd v = -whitened(program.g);
  if (equalities > 0)
    v += MatrixXd(N.transpose()).completeOrthogonalDecomposition().solve(program.e - N.transpose() * v);
  VectorXd x = llt.matrixU().solve(v);

  std::vector<Eigen::Index> active;
  std::vector<double> lambda;
  for (int steps = 0;;)
  {
    Eigen::Index p = 0;
    if (program.b.size() == 0 || (program.A * x - program.b).maxCoeff(&p) <= 1e-10)
      return x;
    const VectorXd a = whitened(program.A.row(p).transpose());
    for (double lambda_p = 0.0;;)
    {
      if (++steps > 500)
        throw std::runtime_error("the dense solver does not end");
      // z: what of the normal the working set cannot take over; r: how it takes over the rest
      VectorXd z = a, r(N.cols());
      if (N.cols() > 0)
      {
        r = N.householderQr().solve(a);
        z -= N * r;
      }
      const double closing = z.squaredNorm();
      const double full =
          closing > 1e-20 * a.squaredNorm() ? (program.A.row(p) * x - program.b(p)) / closing : kInfinity;
      double part = kInfinity;
      std::size_t blocking = 0;
      for (std::size_t j = 0; j < active.size(); ++j)
        if (const double falls = r(equalities + static_cast<Eigen::Index>(j));
            falls > 1e-12 && lambda[j] / falls < part)
        {
          part = lambda[j] / falls;
          blocking = j;
        }
      const double t = std::min(full, part);
      if (t == kInfinity)
        throw std::runtime_error("the dense solver finds no solution");
      if (closing > 1e-20 * a.squaredNorm())
        x -= t * llt.matrixU().solve(z);
      for (std::size_t j = 0; j < active.size(); ++j)
        lambda[j] -= t * r(equalities + static_cast<Eigen::Index>(j));
      lambda_p += t;
      if (full <= part)
      {
        active.push_back(p);
        lambda.push_back(lambda_p);
        N.conservativeResize(Eigen::NoChange, N.cols() + 1);
        N.rightCols<1>() = a;
        break;
      }
      active.erase(active.begin() + static_cast<std::ptrdiff_t>(blocking));
      lambda.erase(lambda.begin() + static_cast<std::ptrdiff_t>(blocking));
      const Eigen::Index dropped = equalities + static_cast<Eigen::Index>(blocking);
      const MatrixXd after = N.rightCols(N.cols() - dropped - 1);
      N.conservativeResize(Eigen::NoChange, N.cols() - 1);
      N.rightCols(after.cols()) = after;
    }
  }
}

DenseProgram full_form(const Robot& robot, const DesiredState& desired, const SupportEquations& equations,
                       const Constrained& settings)
{
  const int motors = robot.num_joints();
  const int components = desired.support.wrench_components();
  const Conditions all = conditions(robot, equations, desired.support, settings);
  DenseProgram program;
  program.H = MatrixXd::Identity(motors + components, motors + components);
  program.H.bottomRightCorner(components, components) *= 1e-9;
  program.g = VectorXd::Zero(motors + components);
  program.E.resize(robot.mechanism.num_q(), motors + components);
  program.E << MatrixXd(input_matrix(robot)), contact_rows(robot, equations.now, desired.support).J.transpose();
  program.e = equations.r;
  program.A = all.A;
  program.b = all.b;
  return program;
}

DenseProgram null_space_form(const Robot& robot, const DesiredState& desired, const SupportEquations& equations,
                             const Constrained& settings)
{
  const int motors = robot.num_joints();
  const AdmissibleReactions reactions = admissible_reactions(robot, equations, desired.support);
  const ReactionTorques torques = reaction_torques(robot, equations, desired.support, reactions);
  const Conditions all = conditions(robot, equations, desired.support, settings);
  // (τ, w) = base + along y
  MatrixXd along(motors + reactions.w0().size(), reactions.redundancy);
  along << torques.T.topRows(motors), reactions.Z();
  VectorXd base(motors + reactions.w0().size());
  base << torques.tau0.head(motors), reactions.w0();
  const MatrixXd T = along.topRows(motors);
  DenseProgram program;
  program.H = T.transpose() * T;
  program.g = T.transpose() * base.head(motors);
  program.E.resize(0, reactions.redundancy);
  program.e.resize(0);
  program.A = all.A * along;
  program.b = all.b - all.A * base;
  return program;
}

} // namespace torqued::bench
