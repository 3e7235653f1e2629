#include "methods/quadratic_program.h"

#include <algorithm>
#include <limits>

namespace torqued
{

QuadraticProgramSolution least_violation(const Rows& rows, const BoundedVector<kMaxVariables>& from,
                                         const std::bitset<kMaxRows>& start)
{
  using enum QuadraticProgramStatus;
  constexpr int kMaxRounds = 30;
  const Eigen::Index n = from.size();
  double weight = 1e-6;                                    // of the distance, beside the violations
  double before = std::numeric_limits<double>::infinity(); // the last distance

  QuadraticProgram step{{}, BoundedVector<kMaxVariables>::Zero(n), rows};
  BoundedVector<kMaxVariables> y = from;
  QuadraticProgramSolution found;
  found.active = start;
  int steps = 0;
  for (int round = 0; round < kMaxRounds; ++round)
  {
    // from where it stands, so that its rounding shrinks with the step
    step.H = weight * Bounded<kMaxVariables, kMaxVariables>::Identity(n, n);
    step.rows.b = rows.b - rows.A * y;
    found = solve(step, found.active);
    found.steps = steps += found.steps;
    if (found.status != optimal)
      return found;
    y += found.y;

    // weight × distance is what is left of the gradient of ½ Σ v_i²
    const double distance = found.y.norm();
    if (weight * distance <= 1e-14)
      break;
    if (distance > 0.1 * before)
      weight = std::max(0.1 * weight, 1e-12);
    before = distance;
  }
  found.y = y;
  step.H.setZero();
  step.rows.b = rows.b;
  if (!(kkt_residuals(step, y, found.lambda).largest() <= kKktTolerance))
    found.status = not_solved;
  return found;
}

} // namespace torqued
