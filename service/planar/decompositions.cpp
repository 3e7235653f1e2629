#include "planar/decompositions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace torqued
{

using Eigen::MatrixXd;

PivotedQr pivoted_qr(const MatrixXd& A)
{
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(A);
  return {qr.householderQ(), qr.matrixQR().triangularView<Eigen::Upper>(), qr.colsPermutation().indices()};
}

Qr qr(const MatrixXd& A)
{
  const Eigen::HouseholderQR<MatrixXd> qr(A);
  return {qr.householderQ(), qr.matrixQR().triangularView<Eigen::Upper>()};
}

Svd svd(const MatrixXd& A)
{
  const Eigen::JacobiSVD<MatrixXd> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.matrixV(), svd.singularValues()};
}

SymmetricEigen symmetric_eigen(const MatrixXd& A)
{
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

RealSchur real_schur(const MatrixXd& A)
{
  const Eigen::RealSchur<MatrixXd> schur(A);
  return {schur.matrixU(), schur.matrixT()};
}

MatrixXd product(const MatrixXd& A, const MatrixXd& B)
{
  return A * B;
}

MatrixXd solve_upper(const MatrixXd& T, const MatrixXd& B)
{
  return T.triangularView<Eigen::Upper>().solve(B);
}

} // namespace torqued
