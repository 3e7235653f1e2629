#include "methods/quadratic_program.h"

#include "planar/processors.h"
#include "stance/least_squares.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
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
// What an inverse may lose, as a factor on rounding: of each entry of the diagonal, how many times it is what the
// others leave of it.
constexpr double kMostInflation = 1e3;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <typename Function> void for_each(const RowSet& rows, const Function& function)
{
  for (std::uint64_t left = rows.to_ullong(); left != 0; left &= left - 1)
    function(std::countr_zero(left));
}

// A program of three variables: those that it lacks have H = 1, g = 0 and no part in any row, and stay 0. A by columns,
// so that the compiler does several rows at once. A and b are those that were given, where they are.
struct Program
{
  int size;      // rows
  int variables; // that it has
  Matrix H = Matrix::Identity();
  Vector g = Vector::Zero();
  double H_squared = 0.0; // |H|², without what was added
  std::array<const double*, kMaxVariables> A;
  const double* b;
  RowSet soft;

  explicit Program(const Rows& rows)
      : size(rows.size()), variables(static_cast<int>(rows.A.cols())), b(rows.b.data()), soft(rows.soft)
  {
    static constexpr PerRow zeros{};
    for (int k = 0; k < kMaxVariables; ++k)
      A[k] = k < rows.A.cols() ? rows.A.col(k).data() : zeros.data();
  }
  explicit Program(const QuadraticProgram& program) : Program(program.rows)
  {
    variables = static_cast<int>(program.g.size()); // also where there are no rows
    // entry by entry, of numbers that the compiler knows: what calls copy, later loads wait for
    for (int j = 0; j < kMaxVariables; ++j)
      for (int i = 0; i < kMaxVariables; ++i)
        if (i < variables && j < variables)
        {
          H(i, j) = program.H(i, j);
          H_squared += H(i, j) * H(i, j);
        }
    for (int i = 0; i < kMaxVariables; ++i)
      if (i < variables)
        g(i) = program.g(i);
  }

  // one number of each row, as an array
  Eigen::Map<Eigen::ArrayXd> all(double* x) const { return {x, size}; }
  Eigen::Map<const Eigen::ArrayXd> all(const double* x) const { return {x, size}; }
  Vector a(int i) const { return {A[0][i], A[1][i], A[2][i]}; }
  // |a_i|²
  double squared(int i) const { return A[0][i] * A[0][i] + A[1][i] * A[1][i] + A[2][i] * A[2][i]; }
  // a_i·y
  double along(int i, const Vector& y) const { return A[0][i] * y(0) + A[1][i] * y(1) + A[2][i] * y(2); }
  // of row i, as if it were hard
  double violation(int i, const Vector& y) const { return along(i, y) - b[i]; }
  // what a violation is measured against; y_squared: |y|²
  double scale_squared(int i, double y_squared) const
  {
    return std::max(squared(i) * y_squared, std::max(b[i] * b[i], 1.0));
  }
  double scale(int i, double y_squared) const { return std::sqrt(scale_squared(i, y_squared)); }

  static constexpr int kNone = -1, kNotFinite = -2;
  // The row outside the working set that is violated most; kNotFinite if the square of some violation is not.
  int most_violated(const Vector& y, const RowSet& active) const
  {
    // by squares, because roots and quotients take longer than all else here
    const double y_squared = y.squaredNorm();
    PerRow lacks;
    all(lacks.data()) = all(A[0]) * y(0) + all(A[1]) * y(1) + all(A[2]) * y(2) - all(b);
    double sum = all(lacks.data()).square().sum();
    int worst = kNone;
    double most = kRowTolerance * kRowTolerance;
    for (int i = 0; i < size; ++i)
      if (lacks[i] > 0.0)
      {
        const double scale = scale_squared(i, y_squared), squared = lacks[i] * lacks[i];
        sum += scale;
        if (squared > most * scale && !active[i])
        {
          worst = i;
          most = squared / scale;
        }
      }
    return std::isfinite(sum) ? worst : kNotFinite;
  }
  // finite if all numbers are and their squares, too
  double sum_of_squares() const
  {
    double sum = H.squaredNorm() + g.squaredNorm() + all(b).square().sum();
    for (const double* column : A)
      sum += all(column).square().sum();
    return sum;
  }
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
      double squared = program_.squared(row_[k]);
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
  void minimum(const Vector& g, const double* b, Vector& y, PerRow& lambda) const
  {
    const auto bound = [&](int place)
    {
      return b ? b[row_[place]] : 0.0;
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
    double scale_squared = program_.squared(p);
    for (int k = 0; k < hard_; ++k)
      scale_squared += change[k] * change[k] * program_.squared(row_[k]);
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
             force_squared = std::max(force_squared, square(lambda[i]) * program.squared(i));
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
  /// active: a working set to begin with, as another run has left it after so many steps.
  DualMethod(const Program& program, const RowSet& active, int steps)
      : program_(program), active_(active), equalities_(program_, factors_), steps_(steps)
  {
  }
  DualMethod(const DualMethod&) = delete; // parts of it point to others

  QuadraticProgramStatus run()
  {
    using enum QuadraticProgramStatus;
    const double squares = program_.sum_of_squares();
    if (!std::isfinite(squares) || !factors_.factorize(program_.H, kRounding))
      return not_solved;
    std::fill_n(lambda_.begin(), program_.size, 0.0);
    equalities_.set(active_);
    settle();
    for (int p; (p = program_.most_violated(y_, active_)) != Program::kNone;)
      if (const QuadraticProgramStatus status = p < 0 ? not_solved : meet(p); status != optimal)
        return status;
    // the rows beyond the working set are met, or one of them would be the most violated; if no square overflowed
    return std::isfinite(squares * y_.squaredNorm()) && is_optimal(program_, y_, lambda_, active_) ? optimal
                                                                                                   : not_solved;
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

  // Of several rows the one that falls fastest, so that what stays in the working set is as independent as can be.
  // p: whose multiplier grows meanwhile.
  Block first_block(const PerRow& change, int p) const
  {
    // by squares, as in residuals()
    const auto moves = [&](int place)
    {
      return change[place] * change[place] * program_.squared(equalities_.row(place));
    };
    double least = program_.squared(p), largest = 0.0;
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
    if (!std::exchange(relaxed_, true))
    {
      std::copy_n(program_.b, program_.size, granted_.begin());
      program_.b = granted_.data();
    }
    const double grant = std::max(2.0 * share, 4.0 * kEpsilon);
    granted_[p] += grant * program_.scale(p, y_squared);
    for (int k = 0; k < equalities_.size(); ++k)
      if (const int i = equalities_.row(k); change[k] > 0.0)
        granted_[i] += grant * program_.scale(i, y_squared);
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
        return lambda_[i] * lambda_[i] * program_.squared(i);
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
    equalities_.minimum(g, program_.b, y_, lambda);
    for (int k = 0; k < equalities_.size(); ++k)
      lambda_[equalities_.row(k)] = lambda[k];
  }
  void keep_from_pulling()
  {
    for (int k = 0; k < equalities_.size(); ++k)
      lambda_[equalities_.row(k)] = std::max(lambda_[equalities_.row(k)], 0.0);
  }

  Program program_;
  PerRow granted_; // b once rows are relaxed
  Ldlt3 factors_;
  RowSet active_;
  Equalities equalities_; // of the working set
  Vector y_;
  PerRow lambda_;
  int steps_;
  bool relaxed_ = false;
};

// The same method for hard rows by the inverses of H and of the Schur complement S = N H⁻¹ Nᵀ, N the rows of the
// working set: much shorter, and good enough where neither costs more than some three digits. It gives up where one
// does, and where it finds no way on; what it says it has checked in the rows and H themselves. S⁻¹ is bordered by what
// a row adds: with c = −S⁻¹ N H⁻¹ a_p and s what p's violation shrinks by, both per λ_p, it is S⁻¹ + c cᵀ / s, c / s,
// and 1 / s.
//
// The working set has three places; what stands for one that is empty is 0. A fourth makes pairs of all numbers, which
// are stored as they are read: a number alone that was just written makes the pair wait.
class SchurMethod
{
public:
  explicit SchurMethod(const Program& program) : program_(program) {}

  /// optimal, infeasible, or not_solved: then active() is a working set to go on from.
  QuadraticProgramStatus run()
  {
    using enum QuadraticProgramStatus;
    if (!invert())
      return not_solved;
    y_ = -(H_inverse_ * program_.g);
    for (int p; (p = program_.most_violated(y_, active_)) != Program::kNone;)
      if (const QuadraticProgramStatus status = p < 0 ? not_solved : meet(p); status != optimal)
        return status;
    std::fill_n(lambda_of_rows_.begin(), program_.size, 0.0);
    for (int k = 0; k < 3; ++k)
      if (row_[k] >= 0)
        lambda_of_rows_[row_[k]] = lambda_(k);
    return is_optimal(program_, y_, lambda_of_rows_, active_) ? optimal : not_solved;
  }

  const Vector& y() const { return y_; }
  const PerRow& lambda() const { return lambda_of_rows_; }
  int steps() const { return steps_; }
  const RowSet& active() const { return active_; }

private:
  // a number for each place
  using Places = Eigen::Vector4d;

  // whether H is positive definite, and its inverse good enough
  bool invert()
  {
    const Matrix& H = program_.H;
    bool invertible;
    double determinant;
    H.computeInverseAndDetWithCheck(H_inverse_, determinant, invertible, 0.0);
    return H(0, 0) > 0.0 && H(0, 0) * H(1, 1) > H(1, 0) * H(1, 0) && determinant > 0.0 &&
           (H.diagonal().cwiseProduct(H_inverse_.diagonal()).array() < kMostInflation).all();
  }

  // Lets λ_p grow until row p is met, and drops each row whose multiplier comes to zero before.
  QuadraticProgramStatus meet(int p)
  {
    using enum QuadraticProgramStatus;
    const Vector h = H_inverse_ * program_.a(p);
    const double own = program_.along(p, h);
    for (double lambda_p = 0.0;;)
    {
      if (++steps_ > kMaxSteps)
        return not_solved;
      // as λ_p grows by 1, how the multipliers change, how y moves, and how fast p's violation shrinks
      const Places shared = of_rows([&](int row) { return program_.along(row, h); });
      const Places change = -(S_inverse_ * shared);
      const double closing = own + shared.dot(change);
      const bool independent = size() < program_.variables;
      if (independent && !(kMostInflation * closing > own))
        return not_solved;
      const double per_closing = 1.0 / closing;
      double t = independent ? program_.violation(p, y_) * per_closing : kInfinity;
      int blocking = -1;
      for (int k = 0; k < 3; ++k)
        if (change(k) < 0.0 && lambda_(k) < -change(k) * t &&
            is_more_than_rounding(change(k), row_[k], program_.squared(p)))
        {
          t = -lambda_(k) / change(k);
          blocking = k;
        }
      if (t == kInfinity)
        return is_contradiction(p, change.cwiseMax(0.0)) ? infeasible : not_solved;

      lambda_ += t * change;
      lambda_p += t;
      if (independent)
        y_ -= t * (h + moved_by(change));
      if (blocking < 0)
      {
        add(p, h, lambda_p, change, per_closing);
        if (!(diagonal().cwiseProduct(S_inverse_.diagonal()).array() < kMostInflation).all())
          return not_solved;
        refine();
        for (int k = 0; k < 3; ++k)
          if (lambda_(k) < 0.0 && is_more_than_rounding(lambda_(k), row_[k], std::max(program_.g.squaredNorm(), 1.0)))
            return not_solved;
        lambda_ = lambda_.cwiseMax(0.0);
        return optimal;
      }
      drop(blocking);
    }
  }

  // of a row's multiplier, or its change; against: the square of what the forces are measured against
  bool is_more_than_rounding(double lambda, int row, double against) const
  {
    return lambda * lambda * program_.squared(row) > kRounding * kRounding * against;
  }

  // whether a_p = −Σ share_k a_k of the set, share ≥ 0, and row p lacks more than these rows account for with their
  // rounding, as in DualMethod::relax(): then no y meets them all
  bool is_contradiction(int p, const Places& share) const
  {
    const double y_squared = y_.squaredNorm();
    Vector sum = program_.a(p);
    double size = sum.norm(), scale = program_.scale(p, y_squared);
    for (int k = 0; k < 3; ++k)
      if (share(k) > 0.0)
      {
        const Vector a = program_.a(row_[k]);
        sum += share(k) * a;
        size += share(k) * a.norm();
        scale += share(k) * program_.scale(row_[k], y_squared);
      }
    return sum.norm() <= kRounding * size && program_.violation(p, y_) > kRowTolerance * scale;
  }

  // S⁻¹ with one row and column more
  void add(int p, const Vector& h, double lambda, const Places& change, double per_closing)
  {
    const int place = row_[0] < 0 ? 0 : row_[1] < 0 ? 1 : 2;
    const Places both = change + unit(place);
    S_inverse_ += per_closing * both * both.transpose();
    lambda_ += lambda * unit(place);
    row_[place] = p;
    h_[place] = h;
    active_.set(p);
  }
  // and with one less
  void drop(int place)
  {
    const Places column = S_inverse_.col(place), others = Places::Ones() - unit(place);
    S_inverse_ -= column * column.transpose() / S_inverse_(place, place);
    S_inverse_ = others.asDiagonal() * S_inverse_ * others.asDiagonal();
    lambda_ = lambda_.cwiseProduct(others);
    active_.reset(row_[place]);
    row_[place] = -1;
  }

  // takes away what rounding has left of the working set's violations
  void refine()
  {
    const Places more = S_inverse_ * of_rows([&](int row) { return program_.violation(row, y_); });
    lambda_ += more;
    y_ -= moved_by(more);
  }

  // of the working set
  int size() const { return (row_[0] >= 0) + (row_[1] >= 0) + (row_[2] >= 0); }

  template <typename Function> Places of_places(const Function& function) const
  {
    const auto at = [&](int place)
    {
      return row_[place] >= 0 ? function(place) : 0.0;
    };
    return {at(0), at(1), at(2), 0.0};
  }
  template <typename Function> Places of_rows(const Function& function) const
  {
    return of_places([&](int place) { return function(row_[place]); });
  }
  // of S
  Places diagonal() const
  {
    return of_places([&](int place) { return program_.along(row_[place], h_[place]); });
  }
  // H⁻¹ Nᵀ change
  Vector moved_by(const Places& change) const { return change(0) * h_[0] + change(1) * h_[1] + change(2) * h_[2]; }
  static Places unit(int place)
  {
    static constexpr std::array<std::array<double, 4>, 3> all{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    return Places(all[place].data());
  }

  const Program& program_;
  Matrix H_inverse_;
  Vector y_;
  RowSet active_;
  std::array<int, 3> row_{-1, -1, -1};
  std::array<Vector, 3> h_{Vector::Zero(), Vector::Zero(), Vector::Zero()}; // H⁻¹ a; of no consequence if empty
  Eigen::Matrix4d S_inverse_ = Eigen::Matrix4d::Zero();
  Places lambda_ = Places::Zero();
  PerRow lambda_of_rows_;
  int steps_ = 0;
};

// SchurMethod::run() for several processors
TORQUED_FOR_PROCESSORS
QuadraticProgramStatus run(SchurMethod& method)
{
  return method.run();
}

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
  using enum QuadraticProgramStatus;
  const Program program(asked);
  const Eigen::Index n = asked.g.size();
  RowSet from = start;
  int steps = 0;
  if (start.none() && program.soft.none())
  {
    SchurMethod method(program);
    const QuadraticProgramStatus status = run(method);
    if (status == optimal)
      return optimum(n, program.size, method.y(), method.lambda(), method.steps(), method.active());
    if (status == infeasible)
      return {infeasible, {}, {}, method.steps(), method.active()};
    from = method.active();
    steps = method.steps();
  }
  DualMethod method(program, from, steps);
  const QuadraticProgramStatus status = method.run();
  if (status != optimal)
    return {status, {}, {}, method.steps(), method.active()};
  // against what was asked, if that is not what was solved
  if (method.relaxed())
    if (const Program before(asked); !is_optimal(before, method.y(), method.lambda(), all_rows(before)))
      return {not_solved, {}, {}, method.steps(), method.active()};
  return optimum(n, program.size, method.y(), method.lambda(), method.steps(), method.active());
}

QuadraticProgramSolution least_violation(const Rows& rows, const BoundedVector<kMaxVariables>& from)
{
  using enum QuadraticProgramStatus;
  constexpr int kMaxRounds = 30;
  const Eigen::Index n = from.size();
  const Program asked(rows);
  PerRow lacking;
  Program step = asked;
  step.b = lacking.data();
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
      lacking[i] = -asked.violation(i, y);
    DualMethod method(step, active, 0);
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
