#include "udwadia_kalaba.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace torqued
{

VectorQ udwadia_kalaba(const EquationOfMotion& equation, const VectorJ& torque)
{
  const Eigen::SelfAdjointEigenSolver<MatrixQ> M(equation.M);
  const MatrixQ root = M.operatorInverseSqrt();
  const VectorQ a = root * (root * (equation.B * torque - equation.h - equation.g));
  const Jacobian Jroot = equation.J * root;
  const WrenchVector missing = -equation.Jdot_v - equation.J * a;
  return a + root * Jroot.completeOrthogonalDecomposition().solve(missing);
}

} // namespace torqued
