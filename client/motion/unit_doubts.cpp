#include "motion/unit_doubts.h"

#include "motion/median.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <optional>

namespace torqued
{

namespace
{

// How many times larger the velocities are than the positions' change over time: least squares over all angles; nothing
// for a motion that hardly moves.
std::optional<double> velocity_ratio(const WrittenMotion& motion)
{
  double change = 0.0, product = 0.0;
  for (Eigen::Index i = 0; i + 1 < motion.positions.rows(); ++i)
  {
    const auto row = static_cast<std::size_t>(i);
    const double step = motion.times[row + 1] - motion.times[row];
    for (Eigen::Index j = 0; j < motion.positions.cols(); ++j)
    {
      if (!motion.is_angle[static_cast<std::size_t>(j)])
        continue;
      const double slope = (motion.positions(i + 1, j) - motion.positions(i, j)) / step;
      const double velocity = 0.5 * (motion.velocities(i, j) + motion.velocities(i + 1, j));
      if (std::isfinite(slope) && std::isfinite(velocity) && std::abs(slope) * step < 1.0)
      {
        change += slope * slope * step;
        product += slope * velocity * step;
      }
    }
  }
  return change > 0.0 && product > 0.0 ? std::optional(product / change) : std::nullopt;
}

// the unit that a time column seems to have, from the step between rows as the column's own unit says, s
std::optional<std::string> unit_of_steps(bool utime, double step, double duration)
{
  if (utime && duration < 0.05 && step <= 1e-4)
    return "ms";
  if (step <= 0.5)
    return {};
  if (utime)
    return "ns";
  return step <= 100.0 ? "ms" : step <= 1e5 ? "µs" : "ns";
}

std::optional<std::string> time_doubt(const WrittenMotion& motion)
{
  if (motion.times.size() < 4)
    return {};
  const bool utime = motion.time_column == "utime";
  const std::string expected = utime ? "µs" : "s";
  if (motion.velocities.size() > 0)
  {
    const auto ratio = velocity_ratio(motion);
    if (!ratio)
      return {};
    const auto is = [&](double factor)
    {
      return std::abs(*ratio / factor - 1.0) < 0.2;
    };
    const std::optional<std::string> unit = is(1e3)             ? std::optional(utime ? "ns" : "ms")
                                            : is(1e6)           ? std::optional(utime ? "ps" : "µs")
                                            : is(1e9)           ? std::optional(utime ? "fs" : "ns")
                                            : is(1e-3) && utime ? std::optional("ms")
                                            : is(1e-6) && utime ? std::optional("s")
                                                                : std::nullopt;
    if (!unit)
      return {};
    return fmt::format("column {} seems to be in {}, not in {}: the velocities are {:.3g} times as large as the "
                       "angles' change over it",
                       motion.time_column, *unit, expected, *ratio);
  }
  bool moves = false;
  for (Eigen::Index j = 0; j < motion.positions.cols(); ++j)
    moves = moves || (motion.positions.col(j).array() != motion.positions(0, j)).any();
  const double step = median_step(motion.times);
  const auto unit = unit_of_steps(utime, step, motion.times.back() - motion.times.front());
  if (!moves || !unit)
    return {};
  return fmt::format("column {} seems to be in {}, not in {}: its rows are {:.4g} s apart; it was taken to be in {}",
                     motion.time_column, *unit, expected, step, expected);
}

// Whether the velocities are in degrees per second beside angles in rad.
std::optional<std::string> velocity_doubt(const WrittenMotion& motion)
{
  constexpr double degrees = 180.0 / std::numbers::pi;
  const auto ratio = motion.velocities.size() > 0 && motion.times.size() >= 4 ? velocity_ratio(motion) : std::nullopt;
  if (!ratio || std::abs(*ratio / degrees - 1.0) > 0.2)
    return {};
  return fmt::format("velocities seem to be in degrees per second, not in rad/s: they are {:.3g} times as large as the "
                     "angles' change over the time",
                     *ratio);
}

// The widest row: the largest difference between two angles at one time, and that row.
std::pair<double, Eigen::Index> widest_row(const WrittenMotion& motion)
{
  std::pair<double, Eigen::Index> widest{0.0, 0};
  for (Eigen::Index i = 0; i < motion.positions.rows(); ++i)
  {
    double low = INFINITY, high = -INFINITY;
    for (Eigen::Index j = 0; j < motion.positions.cols(); ++j)
      if (const double angle = motion.positions(i, j);
          motion.is_angle[static_cast<std::size_t>(j)] && std::isfinite(angle))
      {
        low = std::min(low, angle);
        high = std::max(high, angle);
      }
    if (high - low > widest.first)
      widest = {high - low, i};
  }
  return widest;
}

constexpr std::string_view kTakenForRadians =
    "were taken to be in rad: if they are degrees, multiply angles, rates and "
    "accelerations by pi / 180";

std::optional<std::string> angle_doubt(const WrittenMotion& motion)
{
  constexpr double turn = 2.0 * std::numbers::pi, widest = 3.5, largest_in_degrees = 720.0;
  std::optional<std::string> doubt;
  double largest = 0.0;
  for (Eigen::Index j = 0; j < motion.positions.cols(); ++j)
  {
    if (!motion.is_angle[static_cast<std::size_t>(j)])
      continue;
    double low = INFINITY, high = -INFINITY, before = NAN;
    bool leaps = false; // by turns, or from one link to another: no range of a joint
    for (const double angle : motion.positions.col(j))
    {
      if (!std::isfinite(angle))
        continue;
      low = std::min(low, angle);
      high = std::max(high, angle);
      leaps = leaps || std::abs(angle - before) > turn / 4.0;
      before = angle;
    }
    const double size = std::max(std::abs(low), std::abs(high));
    if (!(low <= high) || (size <= turn && (leaps || high - low <= widest)) || size <= largest)
      continue;
    largest = size;
    doubt = fmt::format("angles seem to be in degrees, not in radians: column {} goes from {:.4g} to {:.4g}; they {}",
                        motion.columns[static_cast<std::size_t>(j)], low, high, kTakenForRadians);
  }
  // two links at more than a turn from one another, and one link that was unwrapped apart
  if (const auto [width, row] = widest_row(motion); !doubt && width > 1.25 * turn)
    doubt = fmt::format("angles seem to be in degrees, not in radians: at time {:.6g} s two of them differ by {:.4g}; "
                        "they {}",
                        motion.times[static_cast<std::size_t>(row)], width, kTakenForRadians);
  return largest <= largest_in_degrees ? doubt : std::nullopt;
}

std::optional<std::string> height_doubt(const WrittenMotion& motion)
{
  constexpr double highest = 50.0;
  if (!motion.base_given)
    return {};
  const Eigen::Index z = motion.positions.cols() - 1;
  double height = 0.0;
  for (const double position : motion.positions.col(z))
    if (std::isfinite(position))
      height = std::max(height, std::abs(position));
  if (height <= highest)
    return {};
  return fmt::format("the base seems to be in mm, not in m: column {} reaches {:.4g}; it was taken to be in m",
                     motion.columns[static_cast<std::size_t>(z)], height);
}

} // namespace

UnitDoubts doubt_units(const WrittenMotion& motion)
{
  UnitDoubts doubts;
  for (const auto doubt : {time_doubt, velocity_doubt, angle_doubt, height_doubt})
    if (auto sentence = doubt(motion))
    {
      doubts.sentences.push_back(std::move(*sentence));
      doubts.degrees = doubts.degrees || doubt == angle_doubt;
    }
  return doubts;
}

} // namespace torqued
