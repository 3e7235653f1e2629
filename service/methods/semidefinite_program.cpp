#include "methods/quadratic_program.h"

#include <algorithm>
#include <limits>

namespace torqued
{

QuadraticProgramSolution solve_semidefinite(const QuadraticProgram& program, const BoundedVector<kMaxVariables>& from,
                                            const std::bitset<kMaxRows>& start)
{
  using enum QuadraticProgramStatus;
  constexpr int kMaxRounds = 30;
  const Eigen::Index n = program.g.size();
  double weight = 1e-6;                                    // of the distance, beside the objective
  double before = std::numeric_limits<double>::infinity(); // the last distance
  // less would leave H, where it is flat, with nothing but rounding
  const double least_weight = n == 0 ? 1e-12 : std::max(1e-12, 1e-10 * program.H.diagonal().maxCoeff());

  QuadraticProgram step = program;
  BoundedVector<kMaxVariables> y = from;
  QuadraticProgramSolution found;
  found.active = start;
  int steps = 0;
  for (int round = 0; round < kMaxRounds; ++round)
  {
    // from where it stands, so that its rounding shrinks with the step
    step.H = program.H;
    step.H.diagonal().array() += weight;
    step.g.noalias() = program.H.lazyProduct(y);
    step.g += program.g;
    step.rows.b.noalias() = -program.rows.A.lazyProduct(y);
    step.rows.b += program.rows.b;
    found = solve(step, found.active);
    found.steps = steps += found.steps;
    if (found.status != optimal)
      return found;
    y += found.y;

    // weight × distance is what is left of the objective's gradient
    const double distance = found.y.norm();
    if (weight * distance <= 1e-14)
      break;
    if (distance > 0.1 * before)
      weight = std::max(0.1 * weight, least_weight);
    before = distance;
  }
  found.y = y;
  if (!(kkt_residuals(program, y, found.lambda).largest() <= kKktTolerance))
    found.status = not_solved;
  return found;
}

QuadraticProgramSolution least_violation(const Rows& rows, const BoundedVector<kMaxVariables>& from,
                                         const std::bitset<kMaxRows>& start)
{
  const Eigen::Index n = from.size();
  return solve_semidefinite(
      {Bounded<kMaxVariables, kMaxVariables>::Zero(n, n), BoundedVector<kMaxVariables>::Zero(n), rows}, from, start);
}

} // namespace torqued
