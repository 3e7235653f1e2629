/// Accelerations under constraints without a matrix F and without multipliers.
#pragma once

#include "torque/equation_of_motion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace torqued
{

/// a + M^(-1/2) (J M^(-1/2))⁺ (b − J a), with a = M⁻¹(B τ − C v − g) and b = −J̇ v [Udwadia and Kalaba].
inline VectorQ udwadia_kalaba(const EquationOfMotion& equation, const VectorJ& torque)
{
  const Eigen::SelfAdjointEigenSolver<MatrixQ> M(equation.M);
  const MatrixQ root = M.operatorInverseSqrt();
  const VectorQ a = root * (root * (equation.B * torque - equation.h - equation.g));
  const Jacobian Jroot = equation.J * root;
  const WrenchVector missing = -equation.Jdot_v - equation.J * a;
  return a + root * Jroot.completeOrthogonalDecomposition().solve(missing);
}

} // namespace torqued
