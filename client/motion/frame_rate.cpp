#include "motion/frame_rate.h"

#include "text/number.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <string>

namespace torqued
{

namespace
{

double ulp(double x)
{
  return std::nextafter(std::abs(x), INFINITY) - std::abs(x);
}
double float_ulp(double x)
{
  const float rounded = std::abs(static_cast<float>(x));
  return static_cast<double>(std::nextafter(rounded, INFINITY)) - static_cast<double>(rounded);
}

// whether a float was written, with its shortest digits or all of them
bool is_float(double time)
{
  const auto rounded = static_cast<float>(time);
  return static_cast<double>(rounded) == time || number_in<double>(fmt::format("{}", rounded)) == time;
}

// Rows that are frames: their place among the rows, time since the first row, error and frame.
struct Frame
{
  std::size_t row;
  double time, error;
  std::int64_t number;
};
using Line = std::vector<Frame>;

struct Fit
{
  double start, step;
};

Fit least_squares(const Line& frames)
{
  const auto n = static_cast<double>(frames.size());
  double mean_number = 0.0, mean_time = 0.0;
  for (const Frame& frame : frames)
  {
    mean_number += static_cast<double>(frame.number) / n;
    mean_time += frame.time / n;
  }
  double covariance = 0.0, variance = 0.0;
  for (const Frame& frame : frames)
  {
    const double number = static_cast<double>(frame.number) - mean_number;
    covariance += number * (frame.time - mean_time);
    variance += number * number;
  }
  const double step = covariance / variance;
  return {mean_time - step * mean_number, step};
}

// The starts that put every frame within its error, with a step: an interval, of negative length if there is none.
struct Starts
{
  double from, to;
  double length() const { return to - from; }
};

Starts feasible_starts(const Line& frames, double step)
{
  Starts starts{-INFINITY, INFINITY};
  for (const Frame& frame : frames)
  {
    const double start = frame.time - static_cast<double>(frame.number) * step;
    starts.from = std::max(starts.from, start - frame.error);
    starts.to = std::min(starts.to, start + frame.error);
  }
  return starts;
}

// The step with the longest interval of starts, whose length is a concave function of the step.
double most_feasible_step(const Line& frames, double step, double radius)
{
  double from = step - radius, to = step + radius;
  for (int i = 0; i < 100 && to - from > 1e-15 * step; ++i)
  {
    const double left = from + 0.382 * (to - from), right = to - 0.382 * (to - from);
    if (feasible_starts(frames, left).length() < feasible_starts(frames, right).length())
      from = left;
    else
      to = right;
  }
  return 0.5 * (from + to);
}

// The last feasible step from a feasible one towards one that is none.
double limit_of_feasibility(const Line& frames, double feasible, double infeasible)
{
  for (int i = 0; i < 60; ++i)
  {
    const double middle = 0.5 * (feasible + infeasible);
    (feasible_starts(frames, middle).length() >= 0.0 ? feasible : infeasible) = middle;
  }
  return feasible;
}

// The roundest rate between two, and among equally round ones the nearest to a third.
std::optional<double> nominal_rate(double low, double high, double nearest)
{
  const double margin = 1e-12 * nearest;
  low -= margin;
  high += margin;
  for (const double unit : {100.0, 50.0, 20.0, 10.0, 5.0, 1.0, 1000.0 / 1001.0})
    if (const double rate =
            unit * std::clamp(std::round(nearest / unit), std::ceil(low / unit), std::floor(high / unit));
        rate > 0.0 && low <= rate && rate <= high)
      return rate;
  return {};
}

// The step that most rows have, within their errors.
double most_common_step(const std::vector<double>& times, double width)
{
  std::vector<double> steps(times.size());
  std::adjacent_difference(times.begin(), times.end(), steps.begin());
  steps.erase(steps.begin());
  std::ranges::sort(steps);
  std::size_t first = 0, most = 0, best = 0;
  for (std::size_t last = 0; last < steps.size(); ++last)
  {
    while (steps[last] - steps[first] > width)
      ++first;
    if (last - first + 1 > most)
    {
      most = last - first + 1;
      best = first;
    }
  }
  const auto begin = steps.begin() + static_cast<std::ptrdiff_t>(best);
  return std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(most), 0.0) / static_cast<double>(most);
}

// The rows that follow one another by whole steps, beginning with the first two that are one step apart.
Line follow(const std::vector<double>& times, const std::vector<double>& errors, double step)
{
  const auto near = [&](std::size_t a, std::size_t b) -> std::optional<std::int64_t>
  {
    const double steps = (times[b] - times[a]) / step;
    // the step is not known exactly yet
    const double error = errors[a] + errors[b] + 1e-3 * std::abs(steps) * step;
    return std::abs(steps - std::round(steps)) * step <= error ? std::optional(std::llround(steps)) : std::nullopt;
  };
  std::size_t anchor = 0;
  while (anchor + 1 < times.size() && near(anchor, anchor + 1) != 1)
    ++anchor;
  if (anchor + 1 == times.size())
    return {};
  Line frames{{anchor, times[anchor], errors[anchor], 0}};
  for (std::size_t row = anchor; row-- > 0;)
    if (const auto number = near(row, frames.back().row); number && *number > 0)
      frames.push_back({row, times[row], errors[row], frames.back().number - *number});
  std::ranges::reverse(frames);
  for (std::size_t row = anchor + 1; row < times.size(); ++row)
    if (const auto number = near(frames.back().row, row); number && *number > 0)
      frames.push_back({row, times[row], errors[row], frames.back().number + *number});
  const std::int64_t first = frames.front().number;
  for (Frame& frame : frames)
    frame.number -= first;
  return frames;
}

// Of the rows near each frame the nearest, by the line through those that were followed.
Line nearest_rows(const Line& followed, const std::vector<double>& times, const std::vector<double>& errors)
{
  const Fit fit = least_squares(followed);
  Line nearest;
  double move_before = 0.0;
  for (std::size_t row = 0; row < times.size(); ++row)
  {
    const std::int64_t number = std::llround((times[row] - fit.start) / fit.step);
    const double move = std::abs(times[row] - fit.start - static_cast<double>(number) * fit.step);
    if (move > 2.0 * errors[row] + 1e-3 * fit.step)
      continue;
    if (nearest.empty() || number > nearest.back().number)
      nearest.push_back({row, times[row], errors[row], number});
    else if (move < move_before)
      nearest.back() = {row, times[row], errors[row], number};
    else
      continue;
    move_before = move;
  }
  return nearest;
}

// Leaves out rows that came near a frame by chance, so that the rest has a fit within its errors; none if it has not.
std::optional<double> feasible_step(Line& frames)
{
  constexpr int rounds = 5;
  for (int round = 0; round < rounds && frames.size() > 2; ++round)
  {
    const Fit fit = least_squares(frames);
    const double largest_error = std::ranges::max_element(frames, {}, &Frame::error)->error;
    const double radius = 4.0 * largest_error / static_cast<double>(frames.back().number - frames.front().number);
    const double step = most_feasible_step(frames, fit.step, radius);
    const Starts starts = feasible_starts(frames, step);
    if (starts.length() >= 0.0)
      return step;
    std::erase_if(
        frames, [&](const Frame& frame)
        { return std::abs(frame.time - fit.start - static_cast<double>(frame.number) * fit.step) > frame.error; });
  }
  return {};
}

bool is_convincing(const Line& frames, std::size_t rows)
{
  if (2 * frames.size() < rows || frames.size() < 4)
    return false;
  // as many frames missing as there are at most
  if (static_cast<std::size_t>(frames.back().number - frames.front().number) > 2 * frames.size())
    return false;
  std::size_t neighbours = 0;
  for (std::size_t i = 1; i < frames.size(); ++i)
  {
    const bool follows = frames[i].number == frames[i - 1].number + 1;
    neighbours += follows ? 1 : 0;
    // rows between frames that are not neighbours are of another rate
    if (!follows && frames[i].row != frames[i - 1].row + 1)
      return false;
  }
  return 5 * neighbours >= 3 * (frames.size() - 1);
}

} // namespace

std::vector<double> rounding_errors(const std::vector<double>& numbers)
{
  const bool floats = std::ranges::all_of(numbers, is_float);
  double largest = 0.0;
  for (const double number : numbers)
    largest = std::max(largest, std::abs(number));
  // half an ulp from a number to its float, and as much from the float to its shortest digits
  const auto representation = [&](double number)
  {
    return (floats ? float_ulp(number) : 0.0) + 2.0 * ulp(largest);
  };
  constexpr int most = 17;
  int decimals = 0, digits = 1;
  for (const double number : numbers)
  {
    const auto lost = [&](const std::string& text)
    {
      return std::abs(*number_in<double>(text) - number) > representation(number);
    };
    while (decimals < most && lost(fmt::format("{:.{}f}", number, decimals)))
      ++decimals;
    while (digits < most && lost(fmt::format("{:.{}e}", number, digits - 1)))
      ++digits;
  }
  std::vector<double> errors;
  for (const double number : numbers)
  {
    const double last_digit =
        number == 0.0 ? 0.0 : std::pow(10.0, std::floor(std::log10(std::abs(number))) + 1.0 - digits);
    errors.push_back(0.5 * std::max(std::pow(10.0, -decimals), last_digit) + representation(number));
  }
  return errors;
}

std::optional<FrameRate> find_frame_rate(const std::vector<double>& times, const std::vector<double>& errors)
{
  std::vector<double> since_first;
  for (const double time : times)
    since_first.push_back(time - times.front());
  const double largest_error = *std::ranges::max_element(errors);
  const double common = most_common_step(since_first, 4.0 * largest_error);
  Line frames = follow(since_first, errors, common);
  if (!is_convincing(frames, times.size()))
    return {};
  frames = nearest_rows(frames, since_first, errors);
  const auto feasible = feasible_step(frames);
  if (!feasible || !is_convincing(frames, times.size()))
    return {};

  const double radius = 4.0 * largest_error / static_cast<double>(frames.back().number - frames.front().number);
  const double shortest = limit_of_feasibility(frames, *feasible, *feasible - radius);
  const double longest = limit_of_feasibility(frames, *feasible, *feasible + radius);
  Fit fit = least_squares(frames);
  if (const auto rate = nominal_rate(1.0 / longest, 1.0 / shortest, 1.0 / fit.step))
    fit.step = 1.0 / *rate;
  else
    fit.step = std::clamp(fit.step, shortest, longest);
  const Starts starts = feasible_starts(frames, fit.step);
  double mean = 0.0;
  for (const Frame& frame : frames)
    mean += (frame.time - static_cast<double>(frame.number) * fit.step) / static_cast<double>(frames.size());
  fit.start = std::clamp(mean, starts.from, std::max(starts.from, starts.to));

  // rows that were left out on the way may be frames all the same
  FrameRate found;
  found.rate = 1.0 / fit.step;
  found.number.assign(times.size(), FrameRate::kNone);
  std::optional<std::int64_t> first, last;
  for (std::size_t row = 0; row < times.size(); ++row)
  {
    const std::int64_t number = std::llround((since_first[row] - fit.start) / fit.step);
    const double move = std::abs(since_first[row] - fit.start - static_cast<double>(number) * fit.step);
    if (move > errors[row] + 1e-12 * fit.step || (last && number <= *last))
      continue;
    if (!first)
      first = number;
    last = number;
    found.number[row] = number - *first;
    found.largest_move = std::max(found.largest_move, move);
  }
  found.start = fit.start + static_cast<double>(*first) * fit.step;
  if (found.largest_move > 0.0)
    found.rounding = std::pow(10.0, std::ceil(std::log10(2.0 * found.largest_move) - 0.02));
  const bool reaches_ends = found.start - since_first.front() <= 1.01 * fit.step &&
                            since_first.back() - found.time(*last - *first) <= 1.01 * fit.step;
  return reaches_ends ? std::optional(found) : std::nullopt;
}

} // namespace torqued
