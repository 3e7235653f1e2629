#include "questions/elimination.h"

#include "planar/decompositions.h"

#include <Eigen/Householder>
#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

using Eigen::MatrixXd;
using Eigen::VectorXd;

// J P = Q [R1 R2], P an order of columns: the first of them depend on the others
Elimination by_partitioning(const MatrixXd& J)
{
  const Eigen::Index rows = J.rows(), n = J.cols();
  const PivotedQr qr = pivoted_qr(J);
  Elimination result{MatrixQ::Zero(n, n - rows), {}, MatrixXd::Zero(n, rows), qr.order.tail(n - rows)};
  std::ranges::sort(result.independent);

  const MatrixXd dependent_bar = solve_upper(qr.R.leftCols(rows), qr.Q.transpose());
  const MatrixXd dependent = product(dependent_bar, J(Eigen::all, result.independent));
  for (Eigen::Index i = 0; i < rows; ++i)
  {
    result.F.row(qr.order(i)) = -dependent.row(i);
    result.F_bar.row(qr.order(i)) = dependent_bar.row(i);
  }
  for (Eigen::Index i = 0; i < n - rows; ++i)
    result.F(result.independent(i), i) = 1.0;
  return result;
}

// Jᵀ = Q [U 0]ᵀ, Q orthogonal, U upper triangular: J⁺ = Q1 U⁻ᵀ
Elimination orthonormal(const MatrixXd& Q, const MatrixXd& U)
{
  const Eigen::Index rows = U.rows();
  return {Q.rightCols(Q.cols() - rows), {}, solve_upper(U, Q.leftCols(rows).transpose()).transpose(), {}};
}

Elimination by_qr(const MatrixXd& J)
{
  const Qr of_Jt = qr(J.transpose());
  return orthonormal(of_Jt.Q, of_Jt.R.topRows(J.rows()));
}

Elimination by_putd(const MatrixXd& J)
{
  const Eigen::Index rows = J.rows(), n = J.cols();
  MatrixXd A = J;
  MatrixXd P = MatrixXd::Identity(n, n);
  VectorXd work(n);
  for (Eigen::Index k = 0; k < rows; ++k)
  {
    // the reflection that leaves of the row's tail one entry
    const Eigen::Index rest = n - k;
    VectorXd tail(rest - 1);
    double tau, entry;
    A.row(k).tail(rest).transpose().makeHouseholder(tail, tau, entry);
    A.rightCols(rest).applyHouseholderOnTheRight(tail, tau, work.data());
    P.rightCols(rest).applyHouseholderOnTheRight(tail, tau, work.data());
  }
  return orthonormal(P, A.leftCols(rows).transpose());
}

Elimination by_svd(const MatrixXd& J)
{
  const Eigen::Index rows = J.rows();
  const Svd of_J = svd(J);
  const MatrixXd scaled = of_J.V.leftCols(rows) * of_J.values.cwiseInverse().asDiagonal();
  return {of_J.V.rightCols(J.cols() - rows), {}, product(scaled, of_J.U.transpose()), {}};
}

// F of JᵀJ, whose condition is the square of that of J: what it has of the rows of J is taken off, and its columns are
// made orthonormal again, to which they are near
Elimination polished(const MatrixXd& J, const MatrixXd& F)
{
  const auto F_bar = by_qr(J).F_bar;
  const MatrixXd projected = F - product(F_bar, product(J, F));
  const MatrixXd squares = product(projected.transpose(), projected);
  return {1.5 * projected - 0.5 * product(projected, squares), {}, F_bar, {}};
}

Elimination by_zero_eigenvalue(const MatrixXd& J)
{
  return polished(J, symmetric_eigen(product(J.transpose(), J)).vectors.leftCols(J.cols() - J.rows()));
}

Elimination by_schur(const MatrixXd& J)
{
  const RealSchur schur = real_schur(product(J.transpose(), J));
  const VectorXd diagonal = schur.T.diagonal();
  Eigen::VectorXi order = Eigen::VectorXi::LinSpaced(J.cols(), 0, static_cast<int>(J.cols()) - 1);
  std::ranges::sort(order, {}, [&](int i) { return diagonal(i); });
  return polished(J, schur.U(Eigen::all, order.head(J.cols() - J.rows())));
}

Elimination with_F(const MatrixXd& J, EliminationMethod method)
{
  switch (method)
  {
  case EliminationMethod::partitioning: return by_partitioning(J);
  case EliminationMethod::qr: return by_qr(J);
  case EliminationMethod::svd: return by_svd(J);
  case EliminationMethod::zero_eigenvalue: return by_zero_eigenvalue(J);
  case EliminationMethod::schur: return by_schur(J);
  case EliminationMethod::putd: break;
  }
  return by_putd(J);
}

// smallest singular value of J over its largest; near the limit, from squares, to six digits
double independence(const MatrixXd& J)
{
  const VectorXd squares = symmetric_eigen(product(J, J.transpose())).values;
  return std::sqrt(std::max(0.0, squares(0)) / squares(squares.size() - 1));
}

} // namespace

Result<Elimination> eliminate(const Jacobian& J, const Jacobian& Jdot, EliminationMethod method)
{
  const Eigen::Index rows = J.rows(), n = J.cols();
  if (rows == 0)
  {
    Elimination all{MatrixQ::Identity(n, n), MatrixQ::Zero(n, n), MatrixXd(n, 0), {}};
    if (method == EliminationMethod::partitioning)
      all.independent.setLinSpaced(n, 0, static_cast<int>(n) - 1);
    return all;
  }
  if (rows > n)
    return Refusal(Reason::numerical,
                   "the contacts have {} rows in J, the robot has {} coordinates: they cannot all rest", rows, n);
  if (const double found = independence(J); !(found >= kIndependentContacts))
    return Refusal(Reason::numerical,
                   "the contacts are not independent: the smallest singular value of J is {:.3g} of the largest; it "
                   "must be at least {:.3g}",
                   found, kIndependentContacts);
  Elimination result = with_F(J, method);
  result.Fdot = -product(result.F_bar, product(Jdot, result.F));
  return result;
}

ReducedForm reduced_form(const EquationOfMotion& equation, const Elimination& elimination)
{
  const MatrixXd F = elimination.F, Ft = F.transpose();
  return {product(Ft, product(equation.M, F)),
          product(Ft, product(equation.M, elimination.Fdot) + product(equation.C, F)), product(Ft, equation.g),
          product(Ft, equation.B)};
}

WrenchVector multipliers(const EquationOfMotion& equation, const Elimination& elimination, const VectorJ& torque)
{
  return elimination.F_bar.transpose() * (equation.generalized_force - equation.B * torque);
}

} // namespace torqued
