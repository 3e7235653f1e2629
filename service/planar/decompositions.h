/// Decompositions of matrices of any size, compiled once: Eigen's are the longest templates to compile here.
#pragma once

#include <Eigen/Core>

namespace torqued
{

/// A P = Q R: the columns of A in the order in which pivoting takes them.
struct PivotedQr
{
  Eigen::MatrixXd Q; ///< orthogonal
  Eigen::MatrixXd R; ///< upper triangular, of the shape of A
  Eigen::VectorXi order;
};
PivotedQr pivoted_qr(const Eigen::MatrixXd& A);

/// A = Q R.
struct Qr
{
  Eigen::MatrixXd Q; ///< orthogonal
  Eigen::MatrixXd R; ///< upper triangular, of the shape of A
};
Qr qr(const Eigen::MatrixXd& A);

/// A = U S Vᵀ, U and V orthogonal.
struct Svd
{
  Eigen::MatrixXd U, V;
  Eigen::VectorXd values; ///< largest first
};
Svd svd(const Eigen::MatrixXd& A);

/// A symmetric matrix A = V Λ Vᵀ, V orthogonal.
struct SymmetricEigen
{
  Eigen::VectorXd values; ///< smallest first
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);

/// A = U T Uᵀ, U orthogonal, T triangular but for blocks of two rows where eigenvalues are complex.
struct RealSchur
{
  Eigen::MatrixXd U, T;
};
RealSchur real_schur(const Eigen::MatrixXd& A);

/// A B
Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// T⁻¹ B, T upper triangular.
Eigen::MatrixXd solve_upper(const Eigen::MatrixXd& T, const Eigen::MatrixXd& B);

} // namespace torqued
