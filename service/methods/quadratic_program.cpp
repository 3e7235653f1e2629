#include "methods/quadratic_program.h"

#include "planar/processors.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace torqued
{

namespace
{

using RowSet = std::bitset<kMaxRows>;
using PerRow = std::array<double, kMaxRows>;

// Relative to the terms that it is the difference of, what is less than this is rounding.
constexpr double kRounding = 1e-12;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double square(double x)
{
  return x * x;
}

// The numbers of the rows in a set: for (const int i : Each(rows)).
class Each
{
public:
  explicit Each(const RowSet& rows) : left_(rows.to_ullong()) {}
  Each begin() const { return *this; }
  std::nullptr_t end() const { return nullptr; }
  bool operator!=(std::nullptr_t) const { return left_ != 0; }
  int operator*() const { return std::countr_zero(left_); }
  void operator++() { left_ &= left_ - 1; }

private:
  std::uint64_t left_;
};

// The dual active-set method. y and λ solve the program with the rows of the working set as equalities: a_i·y = b_i of
// a hard row, = b_i + λ_i of a soft one, which adds a_i a_iᵀ to H and −b_i a_i to g.
//
// Jᵀ H J = 1 and, N being the normals of the hard rows, Jᵀ N = [R; 0] with R upper triangular, by reflections of an
// inverse root of H. Of y = J [u; w] the rows determine u = R⁻ᵀ b, the minimum w = −J₂ᵀ g, and both
// λ = −R⁻¹ (J₁ᵀ g + u).
template <int N> class DualMethod
{
public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  RowSet active; // the working set
  Vector y;
  PerRow lambda;
  int steps = 0;
  bool relaxed = false; // rows contradicted one another by no more than rounding, and were granted as much

  DualMethod(const QuadraticProgram& program, const RowSet& start)
      : active(start), size_(program.rows.size()), soft_(program.rows.soft), H_norm_(program.H.norm()),
        squares_(square(H_norm_) + program.g.squaredNorm() + program.rows.A.squaredNorm() +
                 program.rows.b.squaredNorm())
  {
    const int n = static_cast<int>(program.g.size());
    H_.topLeftCorner(n, n) = program.H;
    g_.head(n) = program.g;
    for (int i = 0; i < size_; ++i)
    {
      b_[i] = program.rows.b(i);
      for (int k = 0; k < N; ++k)
        a_[i](k) = k < n ? program.rows.A(i, k) : 0.0;
    }
  }

  QuadraticProgramStatus run()
  {
    using enum QuadraticProgramStatus;
    if (!std::isfinite(squares_) || !(inverse_root(H_, inverse_root_) > kRounding))
      return not_solved;
    settle();
    for (int p; (p = most_violated()) >= 0;)
      if (const QuadraticProgramStatus status = meet(p); status != optimal)
        return status;
    for (int times = 0; times < 3 && residual() > kRounding; ++times)
      correct(y, lambda);
    // the rows beyond the working set are met, or one of them would be the most violated; if no square overflowed
    return std::isfinite(squares_ * y.squaredNorm()) && residual() <= kKktTolerance ? optimal : not_solved;
  }

private:
  // of row i, as if it were hard
  double violation(int i, const Vector& at) const { return a_[i].dot(at) - b_[i]; }
  // what a violation is measured against
  double scale(int i) const { return std::max({a_[i].norm() * y.norm(), std::abs(b_[i]), 1.0}); }
  // |λ_i a_i|, of row i's term in the gradient of the Lagrangian
  double term(int i, const PerRow& multipliers) const { return std::abs(multipliers[i]) * a_[i].norm(); }

  // the row outside the working set that is violated most; -1 if none is
  int most_violated() const
  {
    int worst = -1;
    double most = kRowTolerance;
    for (int i = 0; i < size_; ++i)
      if (const double lacks = violation(i, y); lacks > 0.0 && !active[i])
        if (const double share = lacks / scale(i); share > most)
        {
          worst = i;
          most = share;
        }
    return worst;
  }

  // of the conditions of the minimum, the largest; each over what it is the difference of, or 1
  double residual() const
  {
    Vector gradient = H_ * y + g_;
    double largest = std::max({H_norm_ * y.norm(), g_.norm(), 1.0}), worst = 0.0;
    for (const int i : Each(active))
    {
      gradient += lambda[i] * a_[i];
      largest = std::max(largest, term(i, lambda));
      const double lacks = violation(i, y) - (soft_[i] ? lambda[i] : 0.0);
      worst = std::max(worst, std::abs(lacks) / scale(i));
    }
    return std::max(gradient.norm() / largest, worst);
  }

  // Solves with the working set, and drops from it, one by one, the rows whose multipliers are negative.
  void settle()
  {
    for (int worst = 0; worst >= 0;)
    {
      factorize();
      lambda.fill(0.0);
      minimum(y, lambda);
      worst = -1;
      double most = kRounding * std::max({H_norm_ * y.norm(), g_.norm(), 1.0});
      for (const int i : Each(active))
        if (lambda[i] < 0.0 && term(i, lambda) > most)
        {
          most = term(i, lambda);
          worst = i;
        }
      if (worst >= 0)
        active.reset(worst);
    }
    for (const int i : Each(active))
      lambda[i] = std::max(lambda[i], 0.0);
  }

  // Lets λ_p grow until row p is met, and drops each row whose multiplier comes to zero before.
  QuadraticProgramStatus meet(int p)
  {
    using enum QuadraticProgramStatus;
    while (++steps <= kMaxSteps)
    {
      // up to the solution with p in the working set; or, where p's normal depends on the hard rows', without end
      const bool independent = factorize(p);
      RowSet moving = active;
      moving.set(p);
      Vector to = y;
      PerRow change;
      if (independent)
        minimum(to, change);
      for (const int i : Each(moving))
        change[i] = independent ? change[i] - lambda[i] : i == p ? 1.0 : 0.0;
      if (!independent)
        take_over(J_.transpose() * a_[p], change);

      double t = independent ? 1.0 : kInfinity;
      const int blocking = first_to_fall(moving, change, t);
      if (!independent && blocking < 0)
        // the row's normal is −Σ change_i a_i, change ≥ 0: no y meets them all
        return relax(moving, p, change) ? settle(), optimal : infeasible;
      y = t == 1.0 ? to : y + t * (to - y);
      for (const int i : Each(moving))
        lambda[i] = std::max(0.0, lambda[i] + t * change[i]);
      if (blocking < 0)
      {
        active.set(p);
        return optimal;
      }
      active.reset(blocking);
      lambda[blocking] = 0.0;
    }
    return not_solved;
  }

  // The row whose multiplier comes to zero first, within t times the change; -1 if none does.
  int first_to_fall(const RowSet& moving, const PerRow& change, double& t) const
  {
    double largest = 0.0;
    for (const int i : Each(moving))
      largest = std::max(largest, term(i, change));
    int first = -1;
    for (const int i : Each(active))
      if (change[i] < 0.0 && lambda[i] < -t * change[i] && term(i, change) > kRounding * largest)
      {
        t = lambda[i] / -change[i];
        first = i;
      }
    return first;
  }

  // If each of the rows that add up to what row p lacks accounts for it with no more than rounding: grants them twice
  // that, or what shows at all.
  bool relax(const RowSet& moving, int p, const PerRow& change)
  {
    double total = 0.0;
    for (const int i : Each(moving))
      total += std::max(change[i], 0.0) * scale(i);
    const double share = std::max(0.0, violation(p, y)) / total;
    if (share > kRowTolerance)
      return false;
    relaxed = true;
    for (const int i : Each(moving))
      if (change[i] > 0.0)
        b_[i] += std::max(2.0 * share, 1e-15) * scale(i);
    return true;
  }

  void minimum(Vector& at, PerRow& multipliers) const
  {
    at.setZero();
    for (int k = 0; k < hard_; ++k)
      multipliers[rows_[k]] = 0.0;
    correct(at, multipliers);
    // a_i a_iᵀ in H squares the condition of the soft rows
    for (int times = 0; times < 2 && soft_in_J_.any(); ++times)
      correct(at, multipliers);
  }
  // takes away what these lack to the minimum of ½ yᵀ H y + gᵀ y + ½ Σ λ_i² of the soft rows
  void correct(Vector& at, PerRow& multipliers) const
  {
    Vector gradient = H_ * at + g_;
    for (int k = 0; k < hard_; ++k)
      gradient += multipliers[rows_[k]] * a_[rows_[k]];
    for (const int i : Each(soft_in_J_))
      gradient += violation(i, at) * a_[i];
    const Vector along = J_.transpose() * gradient;
    Vector move = -along;
    for (int k = 0; k < hard_; ++k)
    {
      move(k) = -violation(rows_[k], at);
      for (int j = 0; j < k; ++j)
        move(k) -= R_(j, k) * move(j);
      move(k) /= R_(k, k);
    }
    take_over(along + move, multipliers);
    at += J_ * move;
    for (const int i : Each(soft_in_J_))
      multipliers[i] = violation(i, at);
  }
  // lets the hard rows' multipliers take over a gradient g: adds −R⁻¹ J₁ᵀ g, `along` being Jᵀ g
  void take_over(const Vector& along, PerRow& multipliers) const
  {
    Vector more = -along;
    for (int k = hard_ - 1; k >= 0; --k)
    {
      for (int j = k + 1; j < hard_; ++j)
        more(k) -= R_(k, j) * more(j);
      more(k) /= R_(k, k);
      multipliers[rows_[k]] += more(k);
    }
  }

  // J and R of the working set, and of row p after it; false if p is hard and depends on the other hard rows. Hard rows
  // that depend on those before them are taken out of the working set.
  bool factorize(int p = -1)
  {
    const bool is_soft = p >= 0 && soft_[p];
    if (p < 0 || is_soft || factorized_ != active)
    {
      soft_in_J_ = active & soft_;
      if (is_soft)
        soft_in_J_.set(p);
      J_ = inverse_root_;
      if (soft_in_J_.any())
      {
        Matrix H = H_;
        for (const int i : Each(soft_in_J_))
          H += a_[i] * a_[i].transpose();
        inverse_root(H, J_);
      }
      hard_ = 0;
      for (const int i : Each(active & ~soft_))
        if (!add(i))
        {
          active.reset(i);
          lambda[i] = 0.0;
        }
      factorized_ = active;
    }
    if (p < 0 || !(is_soft || add(p)))
      return false;
    factorized_.set(p);
    return true;
  }
  // one hard row more, the first column of J₂ turned into what is new in its normal; false if nothing is but rounding
  bool add(int row)
  {
    const Vector along = J_.transpose() * a_[row];
    Vector rest = along;
    for (int k = 0; k < hard_; ++k)
      rest(k) = 0.0;
    const double squared = rest.squaredNorm();
    if (squared <= square(kRounding) * along.squaredNorm())
      return false;
    R_.col(hard_) = along - rest;
    R_(hard_, hard_) = std::copysign(std::sqrt(squared), -rest(hard_));
    rest(hard_) -= R_(hard_, hard_);
    const Vector turned = J_ * rest * (2.0 / rest.squaredNorm());
    J_ -= turned * rest.transpose();
    rows_[hard_++] = row;
    return true;
  }
  // J, upper triangular, with Jᵀ H J = 1; returns the least pivot over its entry of H's diagonal, 0 if not positive
  static double inverse_root(const Matrix& H, Matrix& J)
  {
    J.setIdentity();
    double least = 1.0;
    for (int k = 0; k < N; ++k)
    {
      double pivot = H(k, k);
      for (int j = 0; j < k; ++j)
      {
        const double share = J.col(j).dot(H.col(k));
        J.col(k) -= share * J.col(j);
        pivot -= square(share);
      }
      if (!(pivot > 0.0))
        return 0.0;
      least = std::min(least, pivot / H(k, k));
      J.col(k) /= std::sqrt(pivot);
    }
    return least;
  }

  // the program; the variables that it lacks have H = 1, g = 0 and no part in any row, and stay 0
  int size_; // rows
  Matrix H_ = Matrix::Identity();
  Vector g_ = Vector::Zero();
  std::array<Vector, kMaxRows> a_;
  PerRow b_;
  RowSet soft_;
  double H_norm_;  // |H|, without what was added
  double squares_; // of all numbers, the sum

  Matrix inverse_root_; // of H
  Matrix J_, R_;
  std::array<int, N> rows_; // the hard rows, in the order of R's columns
  int hard_ = 0;
  RowSet soft_in_J_, factorized_; // the soft rows in J, and all that are in J and R
};

template <int N> QuadraticProgramSolution solve_in(const QuadraticProgram& program, const RowSet& start)
{
  using enum QuadraticProgramStatus;
  DualMethod<N> method(program, start);
  QuadraticProgramSolution found{method.run(), {}, {}, method.steps, method.active};
  if (found.status != optimal)
    return found;
  found.y = method.y.head(program.g.size());
  found.lambda = Eigen::Map<const BoundedVector<kMaxRows>>(method.lambda.data(), program.rows.size());
  // against what was asked, if that is not what was solved
  if (method.relaxed && kkt_residuals(program, found.y, found.lambda).largest() > kKktTolerance)
    found.status = not_solved;
  return found;
}

} // namespace

TORQUED_FOR_PROCESSORS
QuadraticProgramSolution solve(const QuadraticProgram& program, const RowSet& start)
{
  const Eigen::Index variables = program.g.size();
  return variables <= 3   ? solve_in<3>(program, start)
         : variables <= 8 ? solve_in<8>(program, start)
                          : solve_in<kMaxVariables>(program, start);
}

} // namespace torqued
