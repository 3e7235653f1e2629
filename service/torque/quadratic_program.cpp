#include "torque/quadratic_program.h"

#include "torque/least_squares.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace torqued
{

namespace
{

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;
using RowSet = std::bitset<kMaxRows>;
// One number per row.
using PerRow = std::array<double, kMaxRows>;

// Relative to the terms that it is the difference of, what is less than this is rounding.
constexpr double kRounding = 1e-12;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <typename Function> void for_each(const RowSet& rows, const Function& function)
{
  for (std::uint64_t left = rows.to_ullong(); left != 0; left &= left - 1)
    function(std::countr_zero(left));
}

// A program of three variables: those that it lacks have H = 1, g = 0 and no part in any row, and stay 0. A and b by
// columns, so that the compiler does several rows at once.
struct Program
{
  int size; // rows
  Matrix H = Matrix::Identity();
  Vector g = Vector::Zero();
  double H_squared = 0.0;                     // |H|², without what was added
  std::array<const double*, kMaxVariables> A; // columns, of the rows that were given
  PerRow b, squared;                          // squared: |a_i|²
  RowSet soft;

  explicit Program(const Rows& rows) : size(rows.size()), soft(rows.soft)
  {
    static constexpr PerRow zeros{};
    for (int k = 0; k < kMaxVariables; ++k)
      A[k] = k < rows.A.cols() ? rows.A.col(k).data() : zeros.data();
    all(b) = rows.b.array();
    all(squared) = all(A[0]).square() + all(A[1]).square() + all(A[2]).square();
  }
  explicit Program(const QuadraticProgram& program) : Program(program.rows)
  {
    const Eigen::Index n = program.g.size();
    for (Eigen::Index j = 0; j < n; ++j)
    {
      g(j) = program.g(j);
      for (Eigen::Index i = 0; i < n; ++i)
        H(i, j) = program.H(i, j);
    }
    H_squared = program.H.squaredNorm();
  }

  // one number of each row, as an array
  Eigen::Map<Eigen::ArrayXd> all(PerRow& x) const { return {x.data(), size}; }
  Eigen::Map<const Eigen::ArrayXd> all(const PerRow& x) const { return all(x.data()); }
  Eigen::Map<const Eigen::ArrayXd> all(const double* x) const { return {x, size}; }
  Vector a(int i) const { return {A[0][i], A[1][i], A[2][i]}; }
  // a_i·y
  double along(int i, const Vector& y) const { return A[0][i] * y(0) + A[1][i] * y(1) + A[2][i] * y(2); }
  // of row i, as if it were hard
  double violation(int i, const Vector& y) const { return along(i, y) - b[i]; }
  // what a violation is measured against; y_squared: |y|²
  double scale_squared(int i, double y_squared) const
  {
    return std::max(squared[i] * y_squared, std::max(b[i] * b[i], 1.0));
  }
  double scale(int i, double y_squared) const { return std::sqrt(scale_squared(i, y_squared)); }
};

// The program with the rows of a working set as equalities: a_i·y = b_i of a hard row, = b_i + λ_i of a soft one.
//
// With H = L D Lᵀ it is the least squares of C y − c, weighted by D and 1, the rows of C being Lᵀ and a_iᵀ of the soft
// rows, c = (−D⁻¹ L⁻¹ g, b_i). The hard normals are N = Y R, Y's columns orthogonal and R unit upper triangular, with Z
// what is orthogonal to them, of any length: y = Y |Y|⁻² R⁻ᵀ b + Z z meets the hard rows to rounding, however badly H
// may be conditioned; with three of them H does not matter to y. C Z = Q U, with Q's columns orthogonal and U unit
// upper triangular, by modified Gram-Schmidt.
class Equalities
{
public:
  Equalities(const Program& program, const Ldlt3& factors) : program_(program), factors_(factors) {}

  void set(const RowSet& active)
  {
    rows_ = hard_ = 0;
    const auto add = [this](int row)
    {
      row_[rows_++] = row;
    };
    for_each(active & ~program_.soft, add);
    hard_ = rows_;
    for_each(active & program_.soft, add);

    // twice where the first time cancels more than half of the length, because it leaves what that amounts to
    for (int k = 0; k < hard_; ++k)
    {
      Vector rest = program_.a(row_[k]);
      double squared = program_.squared[row_[k]];
      R_.col(k).setZero();
      for (int times = 0; times < 2 && k > 0; ++times)
      {
        for (int j = 0; j < k; ++j)
        {
          const double share = Y_.col(j).dot(rest) * per_Y_squared_[j];
          R_(j, k) += share;
          rest -= share * Y_.col(j);
        }
        const double before = std::exchange(squared, rest.squaredNorm());
        if (squared > 0.25 * before)
          break;
      }
      Y_.col(k) = rest;
      per_Y_squared_[k] = 1.0 / squared;
    }
    free_ = 3 - hard_;
    if (rows_ == 0)
      return;
    if (hard_ == 0)
    {
      Z_.setIdentity();
      per_Z_squared_.fill(1.0);
    }
    else if (hard_ == 1)
    {
      int least;
      const Vector y = Y_.col(0);
      y.cwiseAbs().minCoeff(&least);
      Z_.col(0) = y.cross(Vector::Unit(least));
      Z_.col(1) = y.cross(Z_.col(0));
      per_Z_squared_[0] = 1.0 / Z_.col(0).squaredNorm();
      per_Z_squared_[1] = per_Y_squared_[0] * per_Z_squared_[0];
    }
    else if (hard_ == 2)
    {
      Z_.col(0) = Y_.col(0).cross(Y_.col(1));
      per_Z_squared_[0] = per_Y_squared_[0] * per_Y_squared_[1];
    }

    for (int k = 0; k < free_; ++k)
    {
      Column& q = Q_[k];
      const Vector z = Z_.col(k);
      to_left(z, q);
      for (int i = hard_; i < rows_; ++i)
        q[3 + i - hard_] = program_.along(row_[i], z);
      for (int j = 0; j < k; ++j)
        U_(j, k) = take(j, q);
      per_squared_[k] = 1.0 / dot(q, q);
    }
  }

  int size() const { return rows_; }
  int row(int place) const { return row_[place]; }

  // minimises ½ yᵀ H y + gᵀ y + ½ Σ λ_i² of the soft rows. b: of the rows; zeros if there is none; lambda: by the rows'
  // places in the set
  void minimum(const Vector& g, const PerRow* b, Vector& y, PerRow& lambda) const
  {
    const auto bound = [&](int place)
    {
      return b ? (*b)[row_[place]] : 0.0;
    };
    if (rows_ == 0)
    {
      y = factors_.solve(-g);
      return;
    }

    // Y |Y|⁻² R⁻ᵀ b, and c − C y of that
    y.setZero();
    std::array<double, 3> along;
    for (int k = 0; k < hard_; ++k)
    {
      along[k] = bound(k);
      for (int j = 0; j < k; ++j)
        along[k] -= R_(j, k) * along[j];
      y += along[k] * per_Y_squared_[k] * Y_.col(k);
    }
    if (free_ > 0)
    {
      Column c;
      const auto of_g = factors_.from_left(g);
      to_left(y, c);
      for (std::size_t i = 0; i < 3; ++i)
        c[i] = -of_g[i] * factors_.per_D[i] - c[i];
      for (int i = hard_; i < rows_; ++i)
        c[3 + i - hard_] = bound(i) - program_.along(row_[i], y);

      std::array<double, 3> z;
      for (int k = 0; k < free_; ++k)
        z[k] = take(k, c);
      for (int k = free_ - 1; k >= 0; --k)
      {
        for (int j = k + 1; j < free_; ++j)
          z[k] -= U_(k, j) * z[j];
        y += z[k] * Z_.col(k);
      }
    }

    Vector gradient = program_.H * y + g;
    for (int i = hard_; i < rows_; ++i)
    {
      lambda[i] = program_.along(row_[i], y) - bound(i);
      gradient += lambda[i] * program_.a(row_[i]);
    }
    take_over(gradient, lambda);
  }

  // how the multipliers change as that of another row p grows by 1; returns how fast p's violation shrinks
  double towards(int p, PerRow& change) const
  {
    const Vector a = program_.a(p);
    double closing = program_.soft[p] ? 1.0 : 0.0;
    if (rows_ == 0)
    {
      const auto z = factors_.from_left(a);
      for (std::size_t i = 0; i < 3; ++i)
        closing += z[i] * z[i] * factors_.per_D[i];
      return closing;
    }

    std::array<double, 3> free;
    double free_squared = 0.0;
    for (int k = 0; k < free_; ++k)
    {
      free[k] = program_.along(p, Z_.col(k));
      free_squared += free[k] * free[k] * per_Z_squared_[k];
    }

    // what the hard rows can take over of the normal; what is left of it beyond rounding is independent of them
    take_over(a, change);
    std::fill(change.begin() + hard_, change.begin() + rows_, 0.0);
    double scale_squared = program_.squared[p];
    for (int k = 0; k < hard_; ++k)
      scale_squared += change[k] * change[k] * program_.squared[row_[k]];
    if (free_squared > kRounding * kRounding * scale_squared)
    {
      Vector y;
      minimum(a, nullptr, y, change);
      // freeᵀ ((C Z)ᵀ C Z)⁻¹ free
      for (int k = 0; k < free_; ++k)
      {
        for (int j = 0; j < k; ++j)
          free[k] -= U_(j, k) * free[j];
        closing += free[k] * free[k] * per_squared_[k];
      }
    }
    return closing;
  }

private:
  using Column = std::array<double, 3 + kMaxRows>;

  // Lᵀ x
  void to_left(const Vector& x, Column& z) const
  {
    z[0] = x(0) + factors_.L10 * x(1) + factors_.L20 * x(2);
    z[1] = x(1) + factors_.L21 * x(2);
    z[2] = x(2);
  }
  // weighted by D and 1
  double dot(const Column& x, const Column& y) const
  {
    const auto& D = factors_.D;
    double sum = D[0] * x[0] * y[0] + D[1] * x[1] * y[1] + D[2] * x[2] * y[2];
    for (int i = 3; i < 3 + rows_ - hard_; ++i)
      sum += x[i] * y[i];
    return sum;
  }
  // takes out of x what it shares with Q's column k, and returns how often that is in it
  double take(int k, Column& x) const
  {
    const double share = dot(Q_[k], x) * per_squared_[k];
    for (int i = 0; i < 3; ++i)
      x[i] -= share * Q_[k][i];
    for (int i = 3; i < 3 + rows_ - hard_; ++i)
      x[i] -= share * Q_[k][i];
    return share;
  }
  // λ of the hard rows by which Σ λ_i a_i takes over −gradient, as far as they can
  void take_over(const Vector& gradient, PerRow& lambda) const
  {
    for (int k = hard_ - 1; k >= 0; --k)
    {
      lambda[k] = -Y_.col(k).dot(gradient) * per_Y_squared_[k];
      for (int j = k + 1; j < hard_; ++j)
        lambda[k] -= R_(k, j) * lambda[j];
    }
  }

  const Program& program_;
  const Ldlt3& factors_;
  std::array<int, kMaxRows> row_; // hard ones first
  int rows_ = 0, hard_ = 0, free_ = 3;
  Matrix Y_, R_, Z_, U_;
  std::array<Column, 3> Q_;
  std::array<double, 3> per_Y_squared_, per_Z_squared_; // 1 / |y|² of Y's columns, and of Z's
  std::array<double, 3> per_squared_;                   // 1 / |q|² of Q's columns
};

// The KKT residuals of these rows, the only ones with multipliers, as squares: see(residual, numerator, denominator),
// because roots and quotients take longer than all else here. Each residual is the largest of those that are seen.
template <typename See>
void residuals(const Program& program, const Vector& y, const PerRow& lambda, const RowSet& rows, const See& see)
{
  const auto square = [](double x)
  {
    return x * x;
  };
  const double y_squared = y.squaredNorm();
  Vector forces = program.H * y + program.g;
  double force_squared = std::max({program.H_squared * y_squared, program.g.squaredNorm(), 1.0});
  double largest = 1.0;
  for_each(rows,
           [&](int i)
           {
             largest = std::max(largest, square(lambda[i]));
             forces += lambda[i] * program.a(i);
             force_squared = std::max(force_squared, square(lambda[i]) * program.squared[i]);
           });
  see(&KktResiduals::stationarity, forces.squaredNorm(), force_squared);
  for_each(rows,
           [&](int i)
           {
             const double lacks = program.violation(i, y) - (program.soft[i] ? lambda[i] : 0.0);
             const double scale = program.scale_squared(i, y_squared);
             see(&KktResiduals::violation, square(std::max(lacks, 0.0)), scale);
             see(&KktResiduals::sign, square(std::min(lambda[i], 0.0)), largest);
             see(&KktResiduals::complementarity, square(std::max(lambda[i], 0.0)) * square(lacks), largest * scale);
           });
}

RowSet all_rows(const Program& program)
{
  return program.size == 0 ? RowSet() : RowSet(~std::uint64_t{0} >> (kMaxRows - program.size));
}

bool is_optimal(const Program& program, const Vector& y, const PerRow& lambda, const RowSet& rows)
{
  bool within = true;
  residuals(program, y, lambda, rows,
            [&](double KktResiduals::*, double numerator, double denominator)
            { within &= numerator <= kKktTolerance * kKktTolerance * denominator && std::isfinite(denominator); });
  return within && std::isfinite(y.sum());
}

// The dual active-set method: the working set, and the y and λ that solve the program with its rows as equalities.
class DualMethod
{
public:
  /// Rows of the program that contradict one another by no more than rounding are relaxed by as much.
  /// active: a working set to begin with, as another run has left it.
  explicit DualMethod(Program& program, const RowSet& active = {})
      : program_(program), active_(active), equalities_(program, factors_)
  {
  }

  QuadraticProgramStatus run()
  {
    using enum QuadraticProgramStatus;
    if (!is_finite() || !factors_.factorize(program_.H, kRounding))
      return not_solved;
    std::fill_n(lambda_.begin(), program_.size, 0.0);
    equalities_.set(active_);
    settle();
    for (int p; (p = most_violated()) >= 0;)
      if (const QuadraticProgramStatus status = meet(p); status != optimal)
        return status;
    // the rows beyond the working set are met, or one of them would be the most violated; if no square overflowed
    return std::isfinite(size_ * y_.squaredNorm()) && is_optimal(program_, y_, lambda_, active_) ? optimal : not_solved;
  }

  const Vector& y() const { return y_; }
  const PerRow& lambda() const { return lambda_; }
  int steps() const { return steps_; }
  const RowSet& active() const { return active_; }
  /// Whether rows were relaxed by what rounding accounts for.
  bool relaxed() const { return relaxed_; }

private:
  // How far to go until the first multiplier is zero, and whose it is.
  struct Block
  {
    int row = -1;
    double t = kInfinity;
  };

  bool is_finite()
  {
    size_ = program_.H.squaredNorm() + program_.g.squaredNorm();
    size_ += (program_.all(program_.squared) + program_.all(program_.b).square()).sum();
    return std::isfinite(size_);
  }

  // Lets λ_p grow until row p is met, and drops each row whose multiplier comes to zero before.
  QuadraticProgramStatus meet(int p)
  {
    using enum QuadraticProgramStatus;
    const double soft = program_.soft[p] ? 1.0 : 0.0;
    for (double lambda_p = 0.0;;)
    {
      if (++steps_ > kMaxSteps)
        return not_solved;
      PerRow change;
      const double closing = equalities_.towards(p, change);
      const double lacks = std::max(0.0, program_.violation(p, y_) - soft * lambda_p);
      const double to_row = closing > 0.0 ? lacks / closing : kInfinity;
      const Block block = first_block(change, p);

      if (to_row == kInfinity)
      {
        // the row's normal is −Σ change_i a_i of the hard rows. Where nothing blocks, change ≥ 0: no y meets them all.
        // But what rounding accounts for is not lacking
        const double tolerance = block.row < 0 ? kRowTolerance : 16.0 * kEpsilon;
        if (relax(p, lacks, change, tolerance))
          break;
        if (block.row < 0)
          return infeasible;
      }
      if (to_row <= block.t)
      {
        active_.set(p);
        equalities_.set(active_);
        break;
      }
      lambda_p += block.t;
      active_.reset(block.row);
      equalities_.set(active_);
      lambda_[block.row] = 0.0;
      solve_equalities(program_.g + lambda_p * program_.a(p));
      keep_from_pulling();
    }
    settle();
    return optimal;
  }

  // The inactive row that is violated most, if any is.
  int most_violated() const
  {
    // by squares, because roots and quotients take longer than all else here
    const double y_squared = y_.squaredNorm();
    PerRow lacks;
    const auto& [A0, A1, A2] = program_.A;
    program_.all(lacks) =
        program_.all(A0) * y_(0) + program_.all(A1) * y_(1) + program_.all(A2) * y_(2) - program_.all(program_.b);
    int worst = -1;
    double most = kRowTolerance * kRowTolerance;
    for (int i = 0; i < program_.size; ++i)
      if (lacks[i] > 0.0)
        if (const double scale = program_.scale_squared(i, y_squared);
            lacks[i] * lacks[i] > most * scale && !active_[i])
        {
          worst = i;
          most = lacks[i] * lacks[i] / scale;
        }
    return worst;
  }

  // Of several rows the one that falls fastest, so that what stays in the working set is as independent as can be.
  // p: whose multiplier grows meanwhile.
  Block first_block(const PerRow& change, int p) const
  {
    // by squares, as in residuals()
    const auto moves = [&](int place)
    {
      return change[place] * change[place] * program_.squared[equalities_.row(place)];
    };
    double least = program_.squared[p], largest = 0.0;
    for (int k = 0; k < equalities_.size(); ++k)
    {
      least = std::max(least, moves(k));
      largest = std::max(largest, lambda_[equalities_.row(k)]);
    }
    least *= kRounding * kRounding;
    const auto falls = [&](int place)
    {
      return change[place] < 0.0 && moves(place) > least;
    };
    double t = kInfinity;
    for (int k = 0; k < equalities_.size(); ++k)
      if (falls(k))
        t = std::min(t, -lambda_[equalities_.row(k)] / change[k]);
    Block block;
    double fastest = 0.0;
    for (int k = 0; k < equalities_.size(); ++k)
    {
      const int i = equalities_.row(k);
      if (falls(k) && lambda_[i] + change[k] * t <= kRounding * largest && (block.row < 0 || moves(k) > fastest))
      {
        block = {i, -lambda_[i] / change[k]};
        fastest = moves(k);
      }
    }
    return block;
  }

  // If each of the rows that add up to what row p lacks accounts for it with no more than a tolerance of its size:
  // gives them twice that, or what shows at all.
  bool relax(int p, double lacks, const PerRow& change, double tolerance)
  {
    const double y_squared = y_.squaredNorm();
    double scale = program_.scale(p, y_squared);
    for (int k = 0; k < equalities_.size(); ++k)
      if (change[k] > 0.0)
        scale += change[k] * program_.scale(equalities_.row(k), y_squared);
    const double share = lacks / scale;
    if (share > tolerance)
      return false;
    relaxed_ = true;
    const double grant = std::max(2.0 * share, 4.0 * kEpsilon);
    program_.b[p] += grant * program_.scale(p, y_squared);
    for (int k = 0; k < equalities_.size(); ++k)
      if (const int i = equalities_.row(k); change[k] > 0.0)
        program_.b[i] += grant * program_.scale(i, y_squared);
    return true;
  }

  // Solves with the working set, and drops from it what would pull.
  void settle()
  {
    for (;;)
    {
      solve_equalities(program_.g);
      // by squares, as in residuals()
      const auto pull = [&](int i)
      {
        return lambda_[i] * lambda_[i] * program_.squared[i];
      };
      double largest = std::max({program_.H_squared * y_.squaredNorm(), program_.g.squaredNorm(), 1.0});
      for (int k = 0; k < equalities_.size(); ++k)
        largest = std::max(largest, pull(equalities_.row(k)));
      int worst = -1;
      double most = kRounding * kRounding * largest;
      for (int k = 0; k < equalities_.size(); ++k)
        if (const int i = equalities_.row(k); lambda_[i] < 0.0 && pull(i) > most)
        {
          worst = i;
          most = pull(i);
        }
      if (worst < 0)
        break;
      active_.reset(worst);
      lambda_[worst] = 0.0;
      equalities_.set(active_);
    }
    keep_from_pulling();
  }

  void solve_equalities(const Vector& g)
  {
    PerRow lambda;
    equalities_.minimum(g, &program_.b, y_, lambda);
    for (int k = 0; k < equalities_.size(); ++k)
      lambda_[equalities_.row(k)] = lambda[k];
  }
  void keep_from_pulling()
  {
    for (int k = 0; k < equalities_.size(); ++k)
      lambda_[equalities_.row(k)] = std::max(lambda_[equalities_.row(k)], 0.0);
  }

  Program& program_;
  Ldlt3 factors_;
  RowSet active_;
  Equalities equalities_; // of the working set
  Vector y_;
  PerRow lambda_;
  double size_ = 0.0; // of all numbers, squared
  int steps_ = 0;
  bool relaxed_ = false;
};

// y and λ in the form of the interface
QuadraticProgramSolution optimum(Eigen::Index n, int rows, const Vector& y, const PerRow& lambda, int steps,
                                 const RowSet& active)
{
  QuadraticProgramSolution found{QuadraticProgramStatus::optimal, y.head(n), BoundedVector<kMaxRows>(rows), steps,
                                 active};
  std::copy_n(lambda.begin(), rows, found.lambda.data());
  return found;
}

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
  Vector all = Vector::Zero();
  all.head(y.size()) = y;
  PerRow multipliers;
  std::copy_n(lambda.data(), lambda.size(), multipliers.begin());
  const Program padded(program);
  KktResiduals worst{};
  residuals(padded, all, multipliers, all_rows(padded),
            [&](double KktResiduals::*residual, double numerator, double denominator)
            { worst.*residual = std::max(worst.*residual, std::sqrt(numerator / denominator)); });
  return worst;
}

QuadraticProgramSolution solve(const QuadraticProgram& asked, const RowSet& start)
{
  Program program(asked);
  DualMethod method(program, start);
  const QuadraticProgramStatus status = method.run();
  const Eigen::Index n = asked.g.size();
  if (status != QuadraticProgramStatus::optimal)
    return {status, {}, {}, method.steps(), method.active()};
  // against what was asked, if that is not what was solved
  if (method.relaxed())
    if (const Program before(asked); !is_optimal(before, method.y(), method.lambda(), all_rows(before)))
      return {QuadraticProgramStatus::not_solved, {}, {}, method.steps(), method.active()};
  return optimum(n, program.size, method.y(), method.lambda(), method.steps(), method.active());
}

QuadraticProgramSolution least_violation(const Rows& rows, const BoundedVector<kMaxVariables>& from)
{
  using enum QuadraticProgramStatus;
  constexpr int kMaxRounds = 30;
  const Eigen::Index n = from.size();
  const Program asked(rows);
  Program step = asked;
  Vector y = Vector::Zero();
  y.head(n) = from;
  PerRow lambda;
  int steps = 0;
  double delta = 1e-6;
  double before = kInfinity;
  RowSet active;
  for (int round = 0; round < kMaxRounds; ++round)
  {
    // from where it stands, so that its rounding shrinks with the step
    step.H.diagonal().head(n).setConstant(delta);
    step.H_squared = delta * delta * static_cast<double>(n);
    for (int i = 0; i < step.size; ++i)
      step.b[i] = -asked.violation(i, y);
    DualMethod method(step, active);
    const QuadraticProgramStatus status = method.run();
    steps += method.steps();
    if (status != optimal)
      return {status, {}, {}, steps, method.active()};
    active = method.active();
    y += method.y();
    lambda = method.lambda();

    // δ |y − y_before| is what is left of the gradient of ½ Σ v_i²
    const double moved = method.y().norm();
    if (delta * moved <= 1e-14)
      break;
    if (moved > 0.1 * before)
      delta = std::max(0.1 * delta, 1e-12);
    before = moved;
  }
  Program violations = asked;
  violations.H.diagonal().head(n).setZero();
  if (!is_optimal(violations, y, lambda, all_rows(violations)))
    return {not_solved, {}, {}, steps, active};
  return optimum(n, asked.size, y, lambda, steps, active);
}

} // namespace torqued
