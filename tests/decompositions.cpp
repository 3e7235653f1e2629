#include "decompositions.h"

#include <Eigen/Dense>

namespace torqued::oracle
{

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd solve(const MatrixXd& A, const VectorXd& b)
{
  return A.completeOrthogonalDecomposition().solve(b);
}

VectorXd solve_square(const MatrixXd& A, const VectorXd& b)
{
  return A.partialPivLu().solve(b);
}

MatrixXd pseudo_inverse(const MatrixXd& A)
{
  return A.completeOrthogonalDecomposition().pseudoInverse();
}

MatrixXd kernel(const MatrixXd& A)
{
  return A.fullPivLu().kernel();
}

Eigen::Index rank(const MatrixXd& A, double threshold)
{
  if (A.size() == 0)
    return 0;
  Eigen::FullPivLU<MatrixXd> decomposition(A);
  decomposition.setThreshold(threshold);
  return decomposition.rank();
}

VectorXd singular_values(const MatrixXd& A)
{
  return A.jacobiSvd().singularValues();
}

VectorXd eigenvalues(const MatrixXd& A)
{
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

MatrixXd inverse_root(const MatrixXd& A)
{
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A).operatorInverseSqrt();
}

MatrixXd upper_root(const MatrixXd& A)
{
  return A.llt().matrixU();
}

MatrixXd orthogonal(const MatrixXd& A)
{
  return Eigen::HouseholderQR<MatrixXd>(A).householderQ();
}

} // namespace torqued::oracle
