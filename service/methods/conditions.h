/// Conditions of contacts and motors as rows of a quadratic program in y, for the methods that keep them.
#pragma once

#include "methods/contact_conditions.h"
#include "methods/quadratic_program.h"
#include "stance/reactions.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace torqued
{

/// What each motor's torque may be, N m; infinite where nothing bounds it.
struct TorqueRange
{
  VectorJ least, most;

  /// The motors' own limits.
  explicit TorqueRange(const Robot& robot) : least(robot.num_joints()), most(robot.num_joints())
  {
    for (int j = 0; j < robot.num_joints(); ++j)
    {
      most(j) = robot.actuators[static_cast<std::size_t>(j)].torque_limit;
      least(j) = -most(j);
    }
  }
};

/// What reactions must keep besides windows.
struct ReactionLimits
{
  ContactConditions contacts; ///< no windows
  TorqueRange torques;
};

/// The priorities of conditions, highest first.
enum class Rank
{
  contact,
  torque,
  window
};
inline constexpr std::array<Rank, 3> kRanks{Rank::contact, Rank::torque, Rank::window};

/// One over what is much of a motor's torque; a motor with next to no limit would otherwise outweigh all others.
inline double torque_factor(const Robot& robot, int joint)
{
  const double size = robot.weight() * robot.leg_length;
  const double limit = robot.actuators[static_cast<std::size_t>(joint)].torque_limit;
  return 1.0 / (std::isfinite(limit) ? std::max(limit, 1e-3 * size) : size);
}

/// Conditions as rows a·y ≤ b, in units in which their entries and those of y are of order 1: those of contacts, by
/// w = w0 + Z y, and, once they are asked for, those of motors.
class Conditions
{
public:
  /// rows: where they are kept
  explicit Conditions(Rows& rows) : rows_(rows), size_(0) {}

  /// Adds contacts' conditions and windows; or, of given limits, theirs, and windows. unit: of y, in N and N m.
  void add_contacts(const Robot& robot, const SupportEquations& equations, const Support& support,
                    const AdmissibleReactions& all, const ContactBounds& bounds, const ReactionLimits* limits,
                    const Eigen::Vector3d& unit)
  {
    size_ = ContactConditions::kMost;
    // the components of both feet's wrenches, for w0 and for y at once; no moment at a heel or toe
    using Columns = Eigen::Vector4d;
    const Columns units(-1.0, unit(0), unit(1), unit(2));
    std::array<std::array<Columns, 3>, 2> wrench;
    for (const Side side : kSides)
      for (int i = 0; i < 3; ++i)
      {
        auto& component = wrench[static_cast<std::size_t>(side)][static_cast<std::size_t>(i)];
        if (i < wrench_components(support.of(side)))
          component = all.row(support.row(side) + i).cwiseProduct(units);
        else
          component.setZero();
      }

    // always as many rows, of which the last may ask nothing: the compiler then knows where each entry is
    rows_.A.resize(size_, all.redundancy);
    rows_.b.resize(size_);
    int row = 0;
    const auto write = [&](const Columns& a, double bound, Rank rank)
    {
      for (int k = 0; k < all.redundancy; ++k)
        rows_.A(row, k) = a(1 + k);
      rows_.b(row) = bound + a(0);
      rank_[static_cast<std::size_t>(row++)] = rank;
    };
    if (limits)
      for (const ContactCondition& condition : limits->contacts)
      {
        const auto& [f_x, f_z, moment] = wrench[static_cast<std::size_t>(condition.side)];
        write(condition.factor * (condition.c(0) * f_x + condition.c(1) * f_z + condition.c(2) * moment),
              condition.factor * condition.bound, Rank::contact);
      }
    for_each_condition(robot, equations, support, bounds,
                       [&](Side side, double bound, double factor, bool is_window, const auto& form)
                       {
                         if (limits && !is_window)
                           return;
                         const auto& [f_x, f_z, moment] = wrench[static_cast<std::size_t>(side)];
                         write(factor * form(f_x, f_z, moment), factor * bound,
                               is_window ? Rank::window : Rank::contact);
                       });
    while (row < size_)
      write(Columns::Zero(), 1.0, Rank::contact);
  }

  /// Adds τ ≤ most and −τ ≤ −least of all motors, by τ = τ0 + T y, where what is not bounded has 0 ≤ 1; nothing where
  /// no motor is bounded.
  void add_motors(const Robot& robot, const ReactionTorques& torques, const TorqueRange& range,
                  const Eigen::Vector3d& unit)
  {
    const int motors = robot.num_joints();
    if (!(range.most.array().isFinite() || range.least.array().isFinite()).any())
      return;
    rows_.A.conservativeResize(size_ + 2 * motors, Eigen::NoChange);
    rows_.b.conservativeResize(size_ + 2 * motors);
    for (const double sign : {1.0, -1.0})
      for (int j = 0; j < motors; ++j)
      {
        const double most = sign > 0.0 ? range.most(j) : -range.least(j);
        const double factor = std::isfinite(most) ? torque_factor(robot, j) : 0.0;
        for (int k = 0; k < rows_.A.cols(); ++k)
          rows_.A(size_, k) = sign * unit(k) * (factor * torques.T(j, k));
        rows_.b(size_) = factor > 0.0 ? factor * most - sign * (factor * torques.tau0(j)) : 1.0;
        rank_[static_cast<std::size_t>(size_++)] = Rank::torque;
      }
  }

  /// Rows of this rank soft, those that give way to it left out.
  Rows up_to(Rank soft) const
  {
    Rows rows{Bounded<kMaxRows, kMaxVariables>(size_, rows_.A.cols()), BoundedVector<kMaxRows>(size_), {}};
    int n = 0;
    for (int i = 0; i < size_; ++i)
      if (rank(i) <= soft)
      {
        rows.A.row(n) = rows_.A.row(i);
        rows.b(n) = rows_.b(i);
        rows.soft[static_cast<std::size_t>(n++)] = rank(i) == soft;
      }
    rows.A.conservativeResize(n, Eigen::NoChange);
    rows.b.conservativeResize(n);
    return rows;
  }

  Eigen::Index variables() const { return rows_.A.cols(); }
  bool any(Rank of) const { return std::find(rank_.begin(), rank_.begin() + size_, of) != rank_.begin() + size_; }

  /// The most that a row of this rank lacks at y.
  double lacking(Rank of, const BoundedVector<kMaxVariables>& y) const
  {
    double most = 0.0;
    for (int i = 0; i < size_; ++i)
      if (rank(i) == of)
        most = std::max(most, rows_.A.row(i).dot(y) - rows_.b(i));
    return most;
  }

  /// Grants rows of this rank what they lack at y, and all of them room for rounding: of weight, of weight × sole
  /// length, of a torque limit. What gave way leaves a point that rounding could close, so lower ranks get more.
  void relax(Rank of, const BoundedVector<kMaxVariables>& y)
  {
    const double room = of == Rank::contact ? 1e-9 : 1e-8;
    for (int i = 0; i < size_; ++i)
      if (rank(i) == of)
        rows_.b(i) = std::max(rows_.b(i), rows_.A.row(i).dot(y)) + room;
  }

private:
  static_assert(ContactConditions::kMost + 2 * kMaxJoints <= kMaxRows);
  Rank rank(int i) const { return rank_[static_cast<std::size_t>(i)]; }

  Rows& rows_;
  int size_;
  std::array<Rank, kMaxRows> rank_;
};

/// Lets windows alone give way, as little as can be, if that is enough. active: the working set in which the program
/// turned out infeasible; then one to solve it from. Whether it is.
bool windows_give_way(Conditions& conditions, std::bitset<kMaxRows>& active);

} // namespace torqued
