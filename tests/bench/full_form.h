/// The quadratic program of `constrained`, unit weights and no reference, in two forms, for a solver that is told
/// nothing of how it is made.
#pragma once

#include "methods/constrained.h"
#include <Eigen/Core>

namespace torqued::bench
{

/// minimise ½ xᵀ H x + gᵀ x subject to E x = e and A x ≤ b; H positive definite.
struct DenseProgram
{
  Eigen::MatrixXd H, E, A;
  Eigen::VectorXd g, e, b;
};

/// Its x, by the dual active-set method as a textbook has it: any size, every step solved afresh by QR. Source:
/// D. Goldfarb, A. Idnani, "A numerically stable dual method for solving strictly convex quadratic programs",
/// Mathematical Programming 27, 1983. Throws std::runtime_error if there is none.
Eigen::VectorXd solve_dense(const DenseProgram& program);

/// Over (τ, w): the equation of motion as equalities, w held by a weight of next to nothing.
DenseProgram full_form(const Robot& robot, const DesiredState& desired, const SupportEquations& equations,
                       const Constrained& settings);
/// Over y, w = w0 + Z y: no equalities.
DenseProgram null_space_form(const Robot& robot, const DesiredState& desired, const SupportEquations& equations,
                             const Constrained& settings);

} // namespace torqued::bench
