/// A small strictly convex quadratic program, dense, without allocation.
///
///   minimise    ½ yᵀ H y + gᵀ y + ½ Σ v_i²     over y, and over v_i of the soft rows
///   subject to  a_i·y ≤ b_i                    of a hard row
///               a_i·y ≤ b_i + v_i, v_i ≥ 0     of a soft row
///
/// Optimal where, with multipliers λ ≥ 0,
///
///   H y + g + Σ λ_i a_i = 0,   a_i·y − b_i ≤ 0 (hard), ≤ λ_i (soft), with equality where λ_i > 0
///
/// because v_i = λ_i there.
#pragma once

#include "planar/mechanism.h"

#include <bitset>

namespace torqued
{

inline constexpr int kMaxVariables = 16;
inline constexpr int kMaxRows = 64;

/// The rows a_i·y ≤ b_i.
struct Rows
{
  Bounded<kMaxRows, kMaxVariables> A;
  BoundedVector<kMaxRows> b;
  std::bitset<kMaxRows> soft; ///< may be violated, by v_i, which costs ½ v_i²

  int size() const { return static_cast<int>(b.size()); }
};

/// Sizes: 0 to 16 variables, 0 to 64 rows. Of use if well scaled: entries of H and A of order 1 in the units of y.
struct QuadraticProgram
{
  Bounded<kMaxVariables, kMaxVariables> H; ///< symmetric, positive definite
  BoundedVector<kMaxVariables> g;
  Rows rows;
};

/// How far a point is from optimal, each in the worst entry.
struct KktResiduals
{
  double stationarity; ///< |H y + g + Σ λ_i a_i|, over the largest of |H|·|y|, |g|, |λ_i|·|a_i| and 1
  double violation; ///< a_i·y − b_i, of a soft row a_i·y − b_i − λ_i; over the largest of |a_i|·|y|, |b_i| and 1
  double sign;      ///< −λ_i, over the largest of |λ| and 1
  double complementarity; ///< λ_i > 0 times what its row lacks to equality; scaled as both

  double largest() const;
};

/// Requires: lambda has as many entries as there are rows.
KktResiduals kkt_residuals(const QuadraticProgram& program, const BoundedVector<kMaxVariables>& y,
                           const BoundedVector<kMaxRows>& lambda);

/// A row counts as met when it lacks no more than this, over the largest of |a_i|·|y|, |b_i| and 1.
inline constexpr double kRowTolerance = 1e-11;

/// What is answered as optimal has KKT residuals no larger than this.
inline constexpr double kKktTolerance = 1e-9;

enum class QuadraticProgramStatus
{
  optimal,
  infeasible, ///< no y meets all hard rows
  not_solved  ///< H is not positive definite, a number is not finite, or kKktTolerance or kMaxSteps were passed
};

struct QuadraticProgramSolution
{
  QuadraticProgramStatus status;
  BoundedVector<kMaxVariables> y; ///< optimal: the solution; else not set
  BoundedVector<kMaxRows> lambda; ///< multipliers, N m² and the like per unit of each row; 0 where a row is not active
  int steps = 0;
  std::bitset<kMaxRows> active; ///< the working set in the end, whatever the status
};

/// The most rows that are added and dropped; random programs need fewer than twenty.
inline constexpr int kMaxSteps = 500;

/// Solves by the dual active-set method: from the minimum without rows it meets one violated row after another, and
/// keeps the multipliers of those met before non-negative. The working set never holds more independent hard rows than
/// there are variables. The solution is computed afresh from each working set and corrected until what remains is
/// rounding, so that no error builds up; what is answered as optimal is so by its KKT residuals.
/// start: to begin with, the working set in which another program ended whose rows had the same directions. Rows of it
/// that would pull, and hard rows that depend on others, are dropped.
/// Source: D. Goldfarb, A. Idnani, "A numerically stable dual method for solving strictly convex quadratic programs",
/// Mathematical Programming 27, 1983; soft rows, and solving afresh, are ours.
QuadraticProgramSolution solve(const QuadraticProgram& program, const std::bitset<kMaxRows>& start = {});

/// The same for H that need not be definite, by proximal steps from `from` on:
///
///   y ← argmin ½ yᵀ H y + gᵀ y + ½ Σ v_i² + ½ δ |y − y_before|²    over the rows
///
/// each a strictly convex program. Of several minima, one near to `from`. As the objective is piecewise quadratic, few
/// steps leave nothing of its gradient but rounding, 1e-14 in the units of H y. start: as of solve(). The objective
/// must be bounded below.
QuadraticProgramSolution solve_semidefinite(const QuadraticProgram& program, const BoundedVector<kMaxVariables>& from,
                                            const std::bitset<kMaxRows>& start = {});

/// The y that violates the soft rows least, ½ Σ v_i², and meets the hard ones; of several, one that is near to `from`.
/// Status: optimal; infeasible if no y meets the hard rows; not_solved. lambda of a soft row is its violation.
QuadraticProgramSolution least_violation(const Rows& rows, const BoundedVector<kMaxVariables>& from,
                                         const std::bitset<kMaxRows>& start = {});

} // namespace torqued
