#include "udwadia_kalaba.h"

#include "decompositions.h"

namespace torqued
{

VectorQ udwadia_kalaba(const EquationOfMotion& equation, const VectorJ& torque)
{
  const Eigen::MatrixXd root = oracle::inverse_root(equation.M);
  const Eigen::VectorXd force = equation.B * torque - equation.h - equation.g;
  const Eigen::VectorXd a = root * (root * force).eval();
  const Eigen::MatrixXd Jroot = equation.J * root;
  const Eigen::VectorXd missing = -equation.Jdot_v - equation.J * a;
  return a + root * oracle::solve(Jroot, missing);
}

} // namespace torqued
