#include "torque/quadratic_program.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace torqued
{

namespace
{

using Vector = BoundedVector<kMaxVariables>;
using Matrix = Bounded<kMaxVariables, kMaxVariables>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// what a row's violation is measured by
double row_size(const Rows& rows, int i, const Vector& y)
{
  return std::max({rows.A.row(i).cwiseAbs().dot(y.cwiseAbs()), std::abs(rows.b(i)), 1.0});
}

// The rows that are met with equality, and y and λ that follow from them.
class WorkingSet
{
  auto R() { return R_.topLeftCorner(num_hard_, num_hard_).triangularView<Eigen::Upper>(); }

public:
  explicit WorkingSet(const QuadraticProgram& program)
      : program_(program), lambda_(BoundedVector<kMaxRows>::Zero(program.rows.size()))
  {
  }

  // Factorises the working set: with x = Lᵀ y, H and the soft rows in it become the unit matrix, and the hard rows
  // ã·x = b, ã = L⁻¹ a, columns of Q R. False if H is not positive definite.
  bool factorise()
  {
    const Rows& rows = program_.rows;
    Matrix H = program_.H;
    for (int i = 0; i < rows.size(); ++i)
      if (active_[static_cast<std::size_t>(i)] && is_soft(i))
        H += rows.A.row(i).transpose() * rows.A.row(i);
    L_ = Eigen::LLT<Matrix>(H);
    Q_.resize(H.rows(), 0);
    R_.setZero();
    for (int k = 0; k < num_hard_; ++k)
    {
      // Gram and Schmidt, twice
      const Vector a = direction(hard_[static_cast<std::size_t>(k)]);
      const Vector once = Q_.transpose() * a;
      Vector off = a - Q_ * once;
      const Vector twice = Q_.transpose() * off;
      off -= Q_ * twice;
      R_.col(k).head(k) = once + twice;
      R_(k, k) = off.norm();
      Q_.conservativeResize(Eigen::NoChange, k + 1);
      Q_.col(k) = off.normalized();
    }
    return L_.info() == Eigen::Success;
  }

  // y and λ afresh: the minimum on the working set is the projection of the free one
  void minimise()
  {
    const Rows& rows = program_.rows;
    y_ = Vector::Zero(program_.g.size());
    lambda_.setZero();
    // the second time corrects what the first lost to a badly conditioned H
    for (int times = 0; times < 2; ++times)
    {
      Vector x = -L_.matrixL().solve(gradient());
      Vector lacking(num_hard_);
      for (int k = 0; k < num_hard_; ++k)
      {
        const int row = hard_[static_cast<std::size_t>(k)];
        lacking(k) = rows.A.row(row).dot(y_) + direction(row).dot(x) - rows.b(row);
      }
      const Vector along = R().transpose().solve(lacking);
      x -= Q_ * along;
      y_ += L_.matrixU().solve(x);
      const Vector multipliers = R().solve(along);
      for (int k = 0; k < num_hard_; ++k)
        lambda_(hard_[static_cast<std::size_t>(k)]) += multipliers(k);
      for (int i = 0; i < rows.size(); ++i)
        if (active_[static_cast<std::size_t>(i)] && is_soft(i))
          lambda_(i) = rows.A.row(i).dot(y_) - rows.b(i);
    }
    lambda_ = lambda_.cwiseMax(0.0); // what rounding made negative
  }

  // the row that is violated most, −1 if all are met
  int most_violated() const
  {
    int worst = -1;
    double most = kRowTolerance;
    for (int i = 0; i < program_.rows.size(); ++i)
    {
      if (active_[static_cast<std::size_t>(i)])
        continue;
      const double lacking = (program_.rows.A.row(i).dot(y_) - program_.rows.b(i)) / row_size(program_.rows, i, y_);
      if (lacking > most)
      {
        most = lacking;
        worst = i;
      }
    }
    return worst;
  }

  enum class Raised
  {
    met,       // the row is in the set now
    not_yet,   // another row has left the set
    impossible // no y meets the row beside those in the set
  };

  // Raises λ of a violated row until it is met, or until another one's λ comes down to 0.
  Raised raise(int row)
  {
    const Rows& rows = program_.rows;
    const Vector a = direction(row);
    Vector off = a - Q_ * (Q_.transpose() * a);
    off -= Q_ * (Q_.transpose() * off);
    if (off.norm() <= kDependent * a.norm())
      off.setZero();
    const Vector dy = -L_.matrixU().solve(off);
    const Vector multipliers = R().solve(-(Q_.transpose() * a));
    BoundedVector<kMaxRows> slopes = BoundedVector<kMaxRows>::Zero(rows.size()); // of λ
    for (int k = 0; k < num_hard_; ++k)
      slopes(hard_[static_cast<std::size_t>(k)]) = multipliers(k);

    double until_blocked = kInfinity;
    int blocking = -1;
    for (int i = 0; i < rows.size(); ++i)
    {
      if (!active_[static_cast<std::size_t>(i)])
        continue;
      if (is_soft(i))
        slopes(i) = rows.A.row(i).dot(dy);
      if (slopes(i) < 0.0 && -lambda_(i) / slopes(i) < until_blocked)
      {
        until_blocked = -lambda_(i) / slopes(i);
        blocking = i;
      }
    }
    const double softness = is_soft(row) ? 1.0 : 0.0;
    const double slope = off.squaredNorm() + softness;
    const double lacking = rows.A.row(row).dot(y_) - rows.b(row) - softness * lambda_(row);
    const double until_met = slope > 0.0 ? std::max(0.0, lacking / slope) : kInfinity;
    const double step = std::min(until_blocked, until_met);
    if (step == kInfinity)
      return Raised::impossible;

    y_ += step * dy;
    lambda_ += step * slopes;
    lambda_(row) += step;
    if (until_met <= until_blocked)
    {
      active_[static_cast<std::size_t>(row)] = true;
      if (!is_soft(row))
        hard_[static_cast<std::size_t>(num_hard_++)] = row;
      return Raised::met;
    }
    active_[static_cast<std::size_t>(blocking)] = false;
    lambda_(blocking) = 0.0;
    num_hard_ = static_cast<int>(std::remove(hard_.begin(), hard_.begin() + num_hard_, blocking) - hard_.begin());
    return Raised::not_yet;
  }

  const Vector& y() const { return y_; }
  const BoundedVector<kMaxRows>& lambda() const { return lambda_; }

private:
  // a hard row whose normal leaves those of the set by less than this sine depends on them
  static constexpr double kDependent = 1e-10;

  bool is_soft(int row) const { return program_.rows.soft[static_cast<std::size_t>(row)]; }
  // H y + g + Σ λ_i a_i, soft rows of the set with λ_i = a_i·y − b_i
  Vector gradient() const
  {
    const Rows& rows = program_.rows;
    Vector sum = program_.H * y_ + program_.g;
    for (int i = 0; i < rows.size(); ++i)
      if (active_[static_cast<std::size_t>(i)])
        sum += (is_soft(i) ? rows.A.row(i).dot(y_) - rows.b(i) : lambda_(i)) * rows.A.row(i).transpose();
    return sum;
  }
  Vector direction(int row) const { return L_.matrixL().solve(program_.rows.A.row(row).transpose()); }

  const QuadraticProgram& program_;
  std::bitset<kMaxRows> active_;
  std::array<int, kMaxVariables + 1> hard_{}; // those of active_ that are hard, in the order of Q's columns
  int num_hard_ = 0;
  Vector y_;
  BoundedVector<kMaxRows> lambda_;

  Eigen::LLT<Matrix> L_;
  Matrix Q_;
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Zero();
};

} // namespace

double KktResiduals::largest() const
{
  return std::max({stationarity, violation, sign, complementarity});
}

KktResiduals kkt_residuals(const QuadraticProgram& program, const BoundedVector<kMaxVariables>& y,
                           const BoundedVector<kMaxRows>& lambda)
{
  const auto& [H, g, rows] = program;
  KktResiduals residuals{0.0, 0.0, 0.0, 0.0};
  const double largest = std::max(1.0, lambda.size() > 0 ? lambda.cwiseAbs().maxCoeff() : 0.0);
  Vector gradient = H * y + g;
  double size = std::max({1.0, g.lpNorm<Eigen::Infinity>(), (H.cwiseAbs() * y.cwiseAbs()).lpNorm<Eigen::Infinity>()});
  for (int i = 0; i < rows.size(); ++i)
  {
    const Vector part = lambda(i) * rows.A.row(i).transpose();
    gradient += part;
    size = std::max(size, part.lpNorm<Eigen::Infinity>());
    const double softness = rows.soft[static_cast<std::size_t>(i)] ? 1.0 : 0.0;
    const double lacking = (rows.A.row(i).dot(y) - rows.b(i) - softness * lambda(i)) / row_size(rows, i, y);
    residuals.violation = std::max(residuals.violation, lacking);
    residuals.sign = std::max(residuals.sign, -lambda(i) / largest);
    residuals.complementarity = std::max(residuals.complementarity, lambda(i) / largest * std::abs(lacking));
  }
  residuals.stationarity = gradient.lpNorm<Eigen::Infinity>() / size;
  return residuals;
}

QuadraticProgramSolution solve(const QuadraticProgram& program)
{
  QuadraticProgramSolution solution{QuadraticProgramStatus::not_solved, {}, {}, 0};
  const bool finite =
      program.H.allFinite() && program.g.allFinite() && program.rows.A.allFinite() && program.rows.b.allFinite();
  WorkingSet working(program);
  if (!finite || !working.factorise())
    return solution;
  working.minimise();
  for (;;)
  {
    const int row = working.most_violated();
    if (row < 0)
    {
      if (kkt_residuals(program, working.y(), working.lambda()).largest() <= kKktTolerance)
        solution = {QuadraticProgramStatus::optimal, working.y(), working.lambda(), solution.steps};
      return solution;
    }
    for (auto raised = WorkingSet::Raised::not_yet; raised != WorkingSet::Raised::met;)
    {
      if (++solution.steps > kMaxSteps)
        return solution;
      raised = working.raise(row);
      if (raised == WorkingSet::Raised::impossible)
      {
        solution.status = QuadraticProgramStatus::infeasible;
        return solution;
      }
      if (!working.factorise())
        return solution;
    }
    working.minimise();
  }
}

QuadraticProgramSolution least_violation(const Rows& rows, const BoundedVector<kMaxVariables>& from)
{
  constexpr double delta = 1e-6;
  constexpr int rounds = 50;
  const Eigen::Index n = from.size();
  QuadraticProgram program{delta * Matrix::Identity(n, n), -delta * from, rows};
  QuadraticProgramSolution solution;
  int steps = 0;
  for (int round = 0; round < rounds; ++round)
  {
    solution = solve(program);
    steps += solution.steps;
    if (solution.status != QuadraticProgramStatus::optimal)
      break;
    const Vector next = -delta * solution.y;
    const double moved = (next - program.g).lpNorm<Eigen::Infinity>() / delta;
    program.g = next;
    if (moved <= 1e-12 * std::max(1.0, solution.y.lpNorm<Eigen::Infinity>()))
      break;
  }
  solution.steps = steps;
  return solution;
}

} // namespace torqued
