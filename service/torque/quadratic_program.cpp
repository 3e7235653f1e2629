#include "torque/quadratic_program.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace torqued
{

namespace
{

using Variables = BoundedVector<kMaxVariables>;
using Square = Bounded<kMaxVariables, kMaxVariables>;
using Multipliers = BoundedVector<kMaxRows>;
using RowSet = std::bitset<kMaxRows>;

// Relative to the terms that it is the difference of, what is less than this is rounding.
constexpr double kRounding = 1e-12;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What the violation of a row is measured against.
double size_of(const Rows& rows, int i, const Variables& y)
{
  return std::max({rows.A.row(i).norm() * y.norm(), std::abs(rows.b(i)), 1.0});
}

double violation(const Rows& rows, int i, const Variables& y, double lambda)
{
  return rows.A.row(i).dot(y) - rows.b(i) - (rows.soft[i] ? lambda : 0.0);
}

// What the terms of H y + g + Σ λ_i a_i are, at the largest.
double size_of_forces(const QuadraticProgram& program, const Variables& y, const Multipliers& lambda)
{
  double size = std::max({program.H.norm() * y.norm(), program.g.norm(), 1.0});
  for (int i = 0; i < program.rows.size(); ++i)
    size = std::max(size, std::abs(lambda(i)) * program.rows.A.row(i).norm());
  return size;
}

struct Iterate
{
  Variables y;
  Multipliers lambda;
};

// A step of Iterate as λ_p of another row grows by 1.
struct Direction
{
  Iterate change;
  double closing; // how fast the row's violation shrinks
};

// The program with the rows of a working set as equalities: a_i·y = b_i of a hard row, = b_i + λ_i of a soft one.
//
// With H = L Lᵀ it is the least squares of C y − c, the rows of C being Lᵀ and a_iᵀ of the soft rows, c = (−L⁻¹ g,
// b_i). The hard normals are N = Y R, with Z what is orthogonal to them: y = Y R⁻ᵀ b + Z z meets the hard rows to
// rounding, however badly H may be conditioned; with n of them H does not matter to y.
class Equalities
{
public:
  Equalities(const QuadraticProgram& program, const Eigen::LLT<Square>& llt, const RowSet& active)
      : program_(program), llt_(llt)
  {
    const Rows& rows = program.rows;
    const Eigen::Index n = program.g.size();
    for (int i = 0; i < rows.size(); ++i)
      if (active[i])
      {
        if (rows.soft[i])
          soft_[num_soft_++] = i;
        else
          hard_[num_hard_++] = i;
      }

    Square N(n, num_hard_);
    for (Eigen::Index k = 0; k < num_hard_; ++k)
      N.col(k) = rows.A.row(hard_[k]).transpose();
    const Eigen::HouseholderQR<Square> qr(N);
    const Square Q = qr.householderQ() * Square::Identity(n, n);
    Y_ = Q.leftCols(num_hard_);
    Z_ = Q.rightCols(n - num_hard_);
    R_ = qr.matrixQR().topRows(num_hard_);

    C_.resize(n + num_soft_, n);
    C_.topRows(n) = llt.matrixL().transpose();
    for (Eigen::Index k = 0; k < num_soft_; ++k)
      C_.row(n + k) = rows.A.row(soft_[k]);
    qr_of_CZ_.compute(C_ * Z_);
  }

  // minimises ½ yᵀ H y + gᵀ y + ½ Σ λ_i² of the soft rows
  Iterate minimum(const Variables& g, const Multipliers& b) const
  {
    const Rows& rows = program_.rows;
    const Eigen::Index n = g.size();
    Variables b_hard(num_hard_);
    for (Eigen::Index k = 0; k < num_hard_; ++k)
      b_hard(k) = b(hard_[k]);
    Tall c(n + num_soft_);
    c.head(n) = -llt_.matrixL().solve(g);
    for (Eigen::Index k = 0; k < num_soft_; ++k)
      c(n + k) = b(soft_[k]);

    Iterate iterate{Y_ * R_.triangularView<Eigen::Upper>().transpose().solve(b_hard), Multipliers::Zero(rows.size())};
    iterate.y += Z_ * qr_of_CZ_.solve(c - C_ * iterate.y);
    Variables gradient = program_.H * iterate.y + g;
    for (Eigen::Index k = 0; k < num_soft_; ++k)
    {
      const int i = soft_[k];
      iterate.lambda(i) = rows.A.row(i).dot(iterate.y) - b(i);
      gradient += iterate.lambda(i) * rows.A.row(i).transpose();
    }
    set_hard(iterate.lambda, gradient);
    return iterate;
  }

  Direction towards(int p) const
  {
    const Rows& rows = program_.rows;
    const Variables a = rows.A.row(p).transpose();
    const Variables free = Z_.transpose() * a;

    // what the hard rows can take over of the normal; what is left of it beyond rounding is independent of them
    Direction direction{{Variables::Zero(a.size()), Multipliers::Zero(rows.size())}, 0.0};
    set_hard(direction.change.lambda, a);
    double size = a.norm();
    for (Eigen::Index k = 0; k < num_hard_; ++k)
      size += std::abs(direction.change.lambda(hard_[k])) * rows.A.row(hard_[k]).norm();
    if (free.norm() > kRounding * size)
    {
      direction.change = minimum(a, Multipliers::Zero(rows.size()));
      const auto R = qr_of_CZ_.matrixQR().topRows(free.size()).triangularView<Eigen::Upper>();
      direction.closing = R.transpose().solve(free).squaredNorm();
    }
    if (rows.soft[p])
      direction.closing += 1.0;
    return direction;
  }

private:
  using Tall = BoundedVector<kMaxVariables + kMaxRows>;

  void set_hard(Multipliers& lambda, const Variables& gradient) const
  {
    const Variables of_hard = -R_.triangularView<Eigen::Upper>().solve(Y_.transpose() * gradient);
    for (Eigen::Index k = 0; k < num_hard_; ++k)
      lambda(hard_[k]) = of_hard(k);
  }

  const QuadraticProgram& program_;
  const Eigen::LLT<Square>& llt_;
  Eigen::Matrix<int, kMaxVariables, 1> hard_;
  Eigen::Matrix<int, kMaxRows, 1> soft_;
  Eigen::Index num_hard_ = 0, num_soft_ = 0;
  Square Y_, Z_, R_;
  Bounded<kMaxVariables + kMaxRows, kMaxVariables> C_;
  Eigen::HouseholderQR<Bounded<kMaxVariables + kMaxRows, kMaxVariables>> qr_of_CZ_;
};

// The dual active-set method: the working set, and the y and λ that solve the program with its rows as equalities.
class DualMethod
{
public:
  explicit DualMethod(const QuadraticProgram& program) : program_(program), llt_(program.H) {}

  QuadraticProgramStatus run()
  {
    if (!well_posed())
      return QuadraticProgramStatus::not_solved;
    settle();
    for (int p; (p = most_violated()) >= 0;)
      if (const QuadraticProgramStatus status = meet(p); status != QuadraticProgramStatus::optimal)
        return status;
    return QuadraticProgramStatus::optimal;
  }

  const Iterate& at() const { return at_; }
  int steps() const { return steps_; }

private:
  // How far to go until the first multiplier is zero, and whose it is.
  struct Block
  {
    int row = -1;
    double t = kInfinity;
  };

  bool well_posed() const
  {
    const Rows& rows = program_.rows;
    if (!std::isfinite(program_.H.squaredNorm() + program_.g.squaredNorm() + rows.A.squaredNorm() +
                       rows.b.squaredNorm()))
      return false;
    const Variables pivots = llt_.matrixLLT().diagonal().array().square();
    return llt_.info() == Eigen::Success && (pivots.array() > kRounding * program_.H.diagonal().array()).all();
  }

  // Lets λ_p grow until row p is met, and drops each row whose multiplier comes to zero before.
  QuadraticProgramStatus meet(int p)
  {
    using enum QuadraticProgramStatus;
    const Rows& rows = program_.rows;
    for (double lambda_p = 0.0;;)
    {
      if (++steps_ > kMaxSteps)
        return not_solved;
      const Direction direction = Equalities(program_, llt_, active_).towards(p);
      const double lacks = std::max(0.0, violation(rows, p, at_.y, lambda_p));
      const double to_row = direction.closing > 0.0 ? lacks / direction.closing : kInfinity;
      const Block block = first_block(direction.change.lambda, rows.A.row(p).norm());

      if (to_row == kInfinity)
      {
        // the row's normal is −Σ change_i a_i of the hard rows. Where nothing blocks, change ≥ 0: no y meets them all.
        // But what rounding accounts for is not lacking
        const double tolerance = block.row < 0 ? kRowTolerance : 16.0 * kEpsilon;
        if (relax(p, lacks, direction.change.lambda, tolerance))
          break;
        if (block.row < 0)
          return infeasible;
      }
      if (to_row <= block.t)
      {
        active_.set(p);
        break;
      }
      lambda_p += block.t;
      active_.reset(block.row);
      solve_equalities(program_.g + lambda_p * rows.A.row(p).transpose());
      at_.lambda = at_.lambda.cwiseMax(0.0);
    }
    settle();
    return optimal;
  }

  // The inactive row that is violated most, if any is.
  int most_violated() const
  {
    int worst = -1;
    double largest = kRowTolerance;
    for (int i = 0; i < program_.rows.size(); ++i)
    {
      const double relative =
          active_[i] ? 0.0 : violation(program_.rows, i, at_.y, 0.0) / size_of(program_.rows, i, at_.y);
      if (relative > largest)
      {
        worst = i;
        largest = relative;
      }
    }
    return worst;
  }

  // Of several rows the one that falls fastest, so that what stays in the working set is as independent as can be.
  Block first_block(const Multipliers& change, double size_p) const
  {
    const Rows& rows = program_.rows;
    Multipliers falls(rows.size());
    double least = size_p;
    for (int i = 0; i < rows.size(); ++i)
    {
      falls(i) = -change(i) * rows.A.row(i).norm();
      least = std::max(least, std::abs(falls(i)));
    }
    least *= kRounding;
    double t = kInfinity;
    for (int i = 0; i < rows.size(); ++i)
      if (falls(i) > least)
        t = std::min(t, -at_.lambda(i) / change(i));
    Block block;
    for (int i = 0; i < rows.size(); ++i)
      if (falls(i) > least && at_.lambda(i) + change(i) * t <= kRounding * at_.lambda.maxCoeff() &&
          (block.row < 0 || falls(i) > falls(block.row)))
        block = {i, -at_.lambda(i) / change(i)};
    return block;
  }

  // If each of the rows that add up to what row p lacks accounts for it with no more than a tolerance of its size:
  // gives them twice that, or what shows at all.
  bool relax(int p, double lacks, const Multipliers& change, double tolerance)
  {
    Rows& rows = program_.rows;
    Multipliers size = Multipliers::Zero(rows.size());
    for (int i = 0; i < rows.size(); ++i)
      if (i == p || change(i) > 0.0)
        size(i) = size_of(rows, i, at_.y);
    const double share = lacks / (size(p) + size.dot(change));
    if (share > tolerance)
      return false;
    rows.b += std::max(2.0 * share, 4.0 * kEpsilon) * size;
    return true;
  }

  // Solves with the working set, and drops from it what would pull.
  void settle()
  {
    const Rows& rows = program_.rows;
    for (;;)
    {
      solve_equalities(program_.g);
      int worst = -1;
      double most = kRounding * size_of_forces(program_, at_.y, at_.lambda);
      for (int i = 0; i < rows.size(); ++i)
        if (const double pull = -at_.lambda(i) * rows.A.row(i).norm(); pull > most)
        {
          worst = i;
          most = pull;
        }
      if (worst < 0)
        break;
      active_.reset(worst);
    }
    at_.lambda = at_.lambda.cwiseMax(0.0);
  }

  void solve_equalities(const Variables& g) { at_ = Equalities(program_, llt_, active_).minimum(g, program_.rows.b); }

  QuadraticProgram program_; // b relaxed by rounding
  Eigen::LLT<Square> llt_;   // of H
  RowSet active_;
  Iterate at_;
  int steps_ = 0;
};

} // namespace

double KktResiduals::largest() const
{
  return std::max({stationarity, violation, sign, complementarity});
}

KktResiduals kkt_residuals(const QuadraticProgram& program, const BoundedVector<kMaxVariables>& y,
                           const BoundedVector<kMaxRows>& lambda)
{
  if (!y.allFinite() || !lambda.allFinite())
    return {kInfinity, kInfinity, kInfinity, kInfinity};
  const Rows& rows = program.rows;
  const Variables forces = program.H * y + program.g + rows.A.transpose() * lambda;
  KktResiduals worst{forces.norm() / size_of_forces(program, y, lambda), 0.0, 0.0, 0.0};
  const double size = std::max(1.0, lambda.size() ? lambda.cwiseAbs().maxCoeff() : 0.0);
  for (int i = 0; i < rows.size(); ++i)
  {
    const double relative = torqued::violation(rows, i, y, lambda(i)) / size_of(rows, i, y);
    worst.violation = std::max(worst.violation, relative);
    worst.sign = std::max(worst.sign, -lambda(i) / size);
    worst.complementarity = std::max(worst.complementarity, lambda(i) / size * std::abs(relative));
  }
  return worst;
}

QuadraticProgramSolution solve(const QuadraticProgram& program)
{
  using enum QuadraticProgramStatus;
  DualMethod method(program);
  const QuadraticProgramStatus status = method.run();
  if (status != optimal)
    return {status, {}, {}, method.steps()};
  if (!(kkt_residuals(program, method.at().y, method.at().lambda).largest() <= kKktTolerance))
    return {not_solved, {}, {}, method.steps()};
  return {optimal, method.at().y, method.at().lambda, method.steps()};
}

QuadraticProgramSolution least_violation(const Rows& rows, const BoundedVector<kMaxVariables>& from)
{
  using enum QuadraticProgramStatus;
  constexpr int kMaxRounds = 30;
  const Eigen::Index n = from.size();
  QuadraticProgramSolution solution{optimal, from, {}, 0};
  QuadraticProgram step{Square::Zero(n, n), Variables::Zero(n), rows};
  double delta = 1e-6;
  double before = kInfinity;
  for (int round = 0; round < kMaxRounds; ++round)
  {
    // from where it stands, so that its rounding shrinks with the step
    step.H.diagonal().setConstant(delta);
    step.rows.b = rows.b - rows.A * solution.y;
    const QuadraticProgramSolution next = solve(step);
    solution.steps += next.steps;
    if (next.status != optimal)
      return {next.status, {}, {}, solution.steps};
    solution.y += next.y;
    solution.lambda = next.lambda;

    // δ |y − y_before| is what is left of the gradient of ½ Σ v_i²
    const double moved = next.y.norm();
    if (delta * moved <= 1e-14)
      break;
    if (moved > 0.1 * before)
      delta = std::max(0.1 * delta, 1e-12);
    before = moved;
  }
  step.H.setZero();
  step.rows.b = rows.b;
  if (!(kkt_residuals(step, solution.y, solution.lambda).largest() <= kKktTolerance))
    return {not_solved, {}, {}, solution.steps};
  return solution;
}

} // namespace torqued
