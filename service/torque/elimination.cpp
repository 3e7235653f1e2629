#include "torque/elimination.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace torqued
{

namespace
{

using RightInverse = Bounded<kMaxCoordinates, 6>;

// J P = Q [R1 R2], P an order of columns: the first of them depend on the others
Elimination partitioning(const Jacobian& J)
{
  const Eigen::Index rows = J.rows(), n = J.cols();
  const Eigen::ColPivHouseholderQR<Jacobian> qr(J);
  const auto R1 = qr.matrixQR().leftCols(rows).triangularView<Eigen::Upper>();
  const auto& order = qr.colsPermutation().indices();
  Elimination result{MatrixQ::Zero(n, n - rows), {}, RightInverse::Zero(n, rows), order.tail(n - rows)};
  std::sort(result.independent.begin(), result.independent.end());

  const Bounded<6, 6> Qt = qr.householderQ().transpose() * Bounded<6, 6>::Identity(rows, rows);
  const Bounded<6, 6> dependent_bar = R1.solve(Qt);
  const Jacobian free = J(Eigen::all, result.independent);
  const Jacobian dependent = -dependent_bar * free;
  for (Eigen::Index i = 0; i < rows; ++i)
  {
    result.F.row(order(i)) = dependent.row(i);
    result.F_bar.row(order(i)) = dependent_bar.row(i);
  }
  for (Eigen::Index i = 0; i < n - rows; ++i)
    result.F(result.independent(i), i) = 1.0;
  return result;
}

// J Q = [L 0], Q orthogonal: J⁺ = Q1 L⁻¹
template <typename Triangular> Elimination orthonormal(const MatrixQ& Q, const Triangular& L)
{
  const Eigen::Index rows = L.rows();
  RightInverse F_bar = Q.leftCols(rows);
  L.template solveInPlace<Eigen::OnTheRight>(F_bar);
  return {Q.rightCols(Q.cols() - rows), {}, F_bar, {}};
}

Elimination qr(const Jacobian& J)
{
  const Eigen::HouseholderQR<RightInverse> qr(J.transpose());
  const MatrixQ Q = qr.householderQ() * MatrixQ::Identity(J.cols(), J.cols());
  const Bounded<6, 6> L = qr.matrixQR().topRows(J.rows()).transpose();
  return orthonormal(Q, L.triangularView<Eigen::Lower>());
}

Elimination putd(const Jacobian& J)
{
  const Eigen::Index rows = J.rows(), n = J.cols();
  Jacobian A = J;
  MatrixQ P = MatrixQ::Identity(n, n);
  VectorQ work(n);
  for (Eigen::Index k = 0; k < rows; ++k)
  {
    // the reflection that leaves of the row's tail one entry
    const Eigen::Index rest = n - k;
    VectorQ tail(rest - 1);
    double tau, entry;
    A.row(k).tail(rest).transpose().makeHouseholder(tail, tau, entry);
    A.bottomRightCorner(rows - k, rest).applyHouseholderOnTheRight(tail, tau, work.data());
    P.rightCols(rest).applyHouseholderOnTheRight(tail, tau, work.data());
  }
  return orthonormal(P, A.leftCols(rows).triangularView<Eigen::Lower>());
}

Elimination svd(const Jacobian& J)
{
  const Eigen::Index rows = J.rows();
  const Eigen::JacobiSVD<Jacobian> svd(J, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const RightInverse scaled = svd.matrixV().leftCols(rows) * svd.singularValues().cwiseInverse().asDiagonal();
  return {svd.matrixV().rightCols(J.cols() - rows), {}, scaled * svd.matrixU().transpose(), {}};
}

// F of JᵀJ, whose condition is the square of that of J: what it has of the rows of J is taken off, and its columns are
// made orthonormal again, to which they are near
Elimination polished(const Jacobian& J, const MatrixQ& F)
{
  RightInverse F_bar = qr(J).F_bar;
  const MatrixQ projected = F - F_bar * (J * F);
  const Eigen::Index size = F.cols();
  return {projected * (1.5 * MatrixQ::Identity(size, size) - 0.5 * projected.transpose() * projected), {}, F_bar, {}};
}

Elimination zero_eigenvalue(const Jacobian& J)
{
  const Eigen::SelfAdjointEigenSolver<MatrixQ> solver(MatrixQ(J.transpose() * J));
  return polished(J, solver.eigenvectors().leftCols(J.cols() - J.rows()));
}

Elimination schur(const Jacobian& J)
{
  const Eigen::RealSchur<MatrixQ> schur(MatrixQ(J.transpose() * J));
  const VectorQ diagonal = schur.matrixT().diagonal();
  Eigen::Matrix<int, Eigen::Dynamic, 1, 0, kMaxCoordinates, 1> order(J.cols());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) { return diagonal(i) < diagonal(j); });
  return polished(J, schur.matrixU()(Eigen::all, order.head(J.cols() - J.rows())));
}

Elimination with_F(const Jacobian& J, EliminationMethod method)
{
  switch (method)
  {
  case EliminationMethod::partitioning: return partitioning(J);
  case EliminationMethod::qr: return qr(J);
  case EliminationMethod::svd: return svd(J);
  case EliminationMethod::zero_eigenvalue: return zero_eigenvalue(J);
  case EliminationMethod::schur: return schur(J);
  case EliminationMethod::putd: break;
  }
  return putd(J);
}

// smallest singular value of J over its largest; near the limit, from squares, to six digits
double independence(const Jacobian& J)
{
  const MatrixQ JJt = J * J.transpose();
  const VectorQ squares = Eigen::SelfAdjointEigenSolver<MatrixQ>(JJt, Eigen::EigenvaluesOnly).eigenvalues();
  return std::sqrt(std::max(0.0, squares(0)) / squares(squares.size() - 1));
}

} // namespace

Result<Elimination> eliminate(const Jacobian& J, const Jacobian& Jdot, EliminationMethod method)
{
  const Eigen::Index rows = J.rows(), n = J.cols();
  if (rows == 0)
  {
    Elimination all{MatrixQ::Identity(n, n), MatrixQ::Zero(n, n), RightInverse(n, 0), {}};
    if (method == EliminationMethod::partitioning)
      all.independent.setLinSpaced(n, 0, static_cast<int>(n) - 1);
    return all;
  }
  if (rows > n)
    return Refusal(Reason::numerical,
                   "the contacts have {} rows in J, the robot has {} coordinates: they cannot all rest", rows, n);
  if (const double found = independence(J); !(found >= kIndependentContacts))
    return Refusal(
        Reason::numerical,
        "the contacts are not independent: the smallest singular value of J is {:.3g} of the largest; it must "
        "be at least {:.3g}",
        found, kIndependentContacts);
  Elimination result = with_F(J, method);
  result.Fdot = -result.F_bar * (Jdot * result.F);
  return result;
}

ReducedForm reduced_form(const EquationOfMotion& equation, const Elimination& elimination)
{
  const auto Ft = elimination.F.transpose();
  return {Ft * equation.M * elimination.F, Ft * (equation.M * elimination.Fdot + equation.C * elimination.F),
          Ft * equation.g, Ft * equation.B};
}

WrenchVector multipliers(const EquationOfMotion& equation, const Elimination& elimination, const VectorJ& torque)
{
  return elimination.F_bar.transpose() * (equation.generalized_force - equation.B * torque);
}

} // namespace torqued
