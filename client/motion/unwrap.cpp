#include "motion/unwrap.h"

#include "motion/median.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace torqued
{

namespace
{

constexpr double kTurn = 2.0 * std::numbers::pi;

using Rows = std::vector<std::size_t>;

// The median speed of up to three steps on either side.
double usual_speed(const std::vector<double>& speeds, std::size_t at)
{
  constexpr std::size_t sides = 3;
  std::vector<double> around;
  for (std::size_t i = at > sides ? at - sides : 0; i < std::min(at + sides + 1, speeds.size()); ++i)
    if (i != at)
      around.push_back(speeds[i]);
  return around.empty() ? 0.0 : median(std::move(around));
}

// The steps of a coordinate between rows, and as large as the others make expect; whole turns do not count.
struct Steps
{
  std::vector<double> size, usual;
};

double without_turns(double step)
{
  return step - kTurn * std::round(step / kTurn);
}

Steps steps_between(const std::vector<double>& times, const Eigen::MatrixXd& motion, Eigen::Index column, bool angle,
                    const Rows& rows)
{
  Steps steps;
  std::vector<double> speeds;
  for (std::size_t i = 1; i < rows.size(); ++i)
  {
    const auto row = static_cast<Eigen::Index>(rows[i]), before = static_cast<Eigen::Index>(rows[i - 1]);
    const double size = motion(row, column) - motion(before, column);
    steps.size.push_back(size);
    speeds.push_back(std::abs(angle ? without_turns(size) : size) / (times[rows[i]] - times[rows[i - 1]]));
  }
  for (std::size_t i = 0; i < speeds.size(); ++i)
    steps.usual.push_back(usual_speed(speeds, i) * (times[rows[i + 1]] - times[rows[i]]));
  return steps;
}

} // namespace

std::vector<CoordinateStep> unwrap(const std::vector<double>& times, Eigen::MatrixXd& motion,
                                   const std::vector<bool>& is_angle)
{
  constexpr double most_left = 0.5;
  std::vector<CoordinateStep> unwrapped;
  for (Eigen::Index j = 0; j < motion.cols(); ++j)
  {
    if (!is_angle[static_cast<std::size_t>(j)])
      continue;
    Rows rows;
    for (std::size_t row = 0; row < times.size(); ++row)
      if (std::isfinite(motion(static_cast<Eigen::Index>(row), j)))
        rows.push_back(row);
    const Steps steps = steps_between(times, motion, j, true, rows);
    double offset = 0.0;
    for (std::size_t i = 0; i < steps.size.size(); ++i)
    {
      const auto row = static_cast<Eigen::Index>(rows[i + 1]);
      const double left = without_turns(steps.size[i]), turns = std::abs(steps.size[i]) / kTurn;
      if (turns > 0.5 && turns < 1.5 && std::abs(left) <= std::max(most_left, 3.0 * steps.usual[i]))
      {
        offset += left - steps.size[i];
        unwrapped.push_back({row, j, steps.size[i], steps.usual[i]});
      }
      motion(row, j) += offset;
    }
  }
  return unwrapped;
}

std::optional<CoordinateStep> find_jump(const std::vector<double>& times, const Eigen::MatrixXd& motion, bool angle,
                                        Eigen::Index column, const Rows& rows)
{
  const double smallest = angle ? kTurn / 4.0 : 0.25;
  const Steps steps = steps_between(times, motion, column, angle, rows);
  for (std::size_t i = 0; i < steps.size.size(); ++i)
    if (std::abs(steps.size[i]) > std::max(smallest, 10.0 * steps.usual[i]))
      return CoordinateStep{static_cast<Eigen::Index>(rows[i + 1]), column, steps.size[i], steps.usual[i]};
  return {};
}

} // namespace torqued
