#include "motion/frozen.h"

#include "motion/frame_rate.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

// the longest that a planned motion may not stop for
constexpr double kShortestHold = 0.1; // s

// Rows with one posture.
struct Posture
{
  Eigen::Index first, last;
};

// the smallest change of a coordinate if all others are whole multiples of it, as of converted numbers; else 0
double smallest_change(const Eigen::VectorXd& numbers)
{
  const Eigen::VectorXd changes = (numbers.tail(numbers.size() - 1) - numbers.head(numbers.size() - 1)).cwiseAbs();
  const double smallest = (changes.array() > 0.0).select(changes, INFINITY).minCoeff();
  const bool are_multiples = std::ranges::all_of(
      changes, [&](double change) { return std::abs(std::remainder(change, smallest)) < 0.01 * smallest; });
  return std::isfinite(smallest) && are_multiples ? smallest : 0.0;
}

// of each coordinate, the unit of its last digit
Eigen::RowVectorXd resolution(const Eigen::MatrixXd& motion)
{
  Eigen::RowVectorXd units(motion.cols());
  for (Eigen::Index j = 0; j < motion.cols(); ++j)
  {
    const std::vector<double> errors = rounding_errors({motion.col(j).begin(), motion.col(j).end()});
    units(j) = std::max(2.0 * *std::ranges::max_element(errors), smallest_change(motion.col(j)));
  }
  return units;
}

} // namespace

std::vector<FrozenRows> find_frozen_rows(const Eigen::VectorXd& times, double step, const Eigen::MatrixXd& motion)
{
  std::vector<Posture> postures;
  for (Eigen::Index i = 0; i < motion.rows(); ++i)
    if (i > 0 && motion.row(i) == motion.row(i - 1))
      postures.back().last = i;
    else
      postures.push_back({i, i});
  if (postures.size() < 4 || static_cast<Eigen::Index>(postures.size()) == motion.rows())
    return {};

  const Eigen::RowVectorXd units = resolution(motion);
  const auto velocity = [&](std::size_t k) -> Eigen::RowVectorXd // from the k-th posture to the next
  {
    return (motion.row(postures[k + 1].first) - motion.row(postures[k].first)) /
           (times(postures[k + 1].first) - times(postures[k].first));
  };
  double usual = 0.0; // rms speed while it moves
  for (std::size_t k = 0; k + 1 < postures.size(); ++k)
    usual += velocity(k).squaredNorm();
  usual = std::sqrt(usual / static_cast<double>(postures.size() - 1));

  std::vector<FrozenRows> frozen;
  for (std::size_t k = 0; k + 1 < postures.size(); ++k)
  {
    const bool inside = k > 0 && k + 2 < postures.size();
    const auto [first, last] = postures[k];
    if (first == last)
      continue;
    const Eigen::RowVectorXd before = velocity(k > 0 ? k - 1 : k + 1),
                             after = velocity(k + 2 < postures.size() ? k + 1 : k - 1);
    const Eigen::RowVectorXd arrived = motion.row(last + 1) - motion.row(first);
    const Eigen::RowVectorXd expected = 0.5 * (times(last + 1) - times(first)) * (before + after);
    const auto above_resolution = [&](const Eigen::RowVectorXd& velocity_then)
    {
      return velocity_then.array().abs() * step > 3.0 * units.array();
    };
    if (!(above_resolution(before) && above_resolution(after)).any())
      continue;
    const bool caught_up = arrived.dot(expected) > 0.6 * expected.squaredNorm();
    const bool moving = inside && before.norm() > 0.25 * usual && after.norm() > 0.25 * usual;
    const bool leaps = arrived.norm() > 2.5 * step * std::max(before.norm(), after.norm());
    const bool held = times(last) - times(first) > kShortestHold + 0.5 * step;
    if (caught_up || (moving && (leaps || !held)))
      frozen.push_back({first + 1, last});
  }
  // a recording that repeats every frame ends with a repetition
  if (const auto [first, last] = postures.back(); !frozen.empty() && last > first)
    if (const auto& before = frozen.back(); before.last == postures[postures.size() - 2].last)
      frozen.push_back({first + 1, last});

  // at the ends nothing follows, or nothing went before: what moves there as fast as usual does not stop in one frame
  const auto stops_at_once = [&](const Posture& posture, Eigen::Index beside)
  {
    const auto [from, to] = std::minmax({beside, beside > posture.last ? posture.last : posture.first});
    const Eigen::RowVectorXd rate = (motion.row(to) - motion.row(from)) / (times(to) - times(from));
    return posture.last > posture.first && times(posture.last) - times(posture.first) <= kShortestHold + 0.5 * step &&
           rate.norm() > 0.25 * usual && (rate.array().abs() * step > 3.0 * units.array()).any();
  };
  if (const Posture& start = postures.front(); stops_at_once(start, start.last + 1))
    if (frozen.empty() || frozen.front().first > start.last)
      frozen.insert(frozen.begin(), {start.first, start.last - 1});
  if (const Posture& end = postures.back(); stops_at_once(end, end.first - 1))
    if (frozen.empty() || frozen.back().last < end.first)
      frozen.push_back({end.first + 1, end.last});
  return frozen;
}

} // namespace torqued
