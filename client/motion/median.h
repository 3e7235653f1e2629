/// The middle of many numbers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace torqued
{

/// The median; of an even count the larger of the two in the middle. Requires: one number or more.
inline double median(std::vector<double> numbers)
{
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

/// The median step from one time to the next. Requires: two times or more.
inline double median_step(const std::vector<double>& times)
{
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i)
    steps.push_back(times[i] - times[i - 1]);
  return median(std::move(steps));
}

} // namespace torqued
