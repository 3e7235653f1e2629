/// Decompositions of matrices of any size, compiled once: Eigen compiles longer at each of them than at all that is
/// around it in a test.
#pragma once

#include <Eigen/Core>

namespace torqued::oracle
{

/// The shortest of all x that make |A x − b| least.
Eigen::VectorXd solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// A⁻¹ b; not finite where A is singular.
Eigen::VectorXd solve_square(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Moore and Penrose's inverse.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& A);

/// A basis of all x with A x = 0, as columns; one column of zeros if there is no other.
Eigen::MatrixXd kernel(const Eigen::MatrixXd& A);

/// How many columns are independent by more than this share of the largest pivot.
Eigen::Index rank(const Eigen::MatrixXd& A, double threshold = 1e-9);

/// Largest first.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& A);

/// Of a symmetric matrix, smallest first.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& A);

/// Of a symmetric positive definite matrix: A^(-1/2).
Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& A);

/// Of a symmetric positive definite matrix: U, upper triangular, with A = Uᵀ U.
Eigen::MatrixXd upper_root(const Eigen::MatrixXd& A);

/// Orthogonal columns that span what those of A span.
Eigen::MatrixXd orthogonal(const Eigen::MatrixXd& A);

} // namespace torqued::oracle
