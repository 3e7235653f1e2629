#include "motion/samples.h"

#include "motion/frozen.h"
#include "motion/median.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued
{

namespace
{

// rows nearer to each other than this share of a step are not two samples
constexpr double kNear = 0.05;
// what the rounding of a sample's time may move an acceleration by, as a share of the velocity per second
constexpr double kTolerableTimeError = 0.01;
// rows that are further apart are postures, of which none is missing and any may be held
constexpr double kLongestFrame = 0.05; // s

// whether a step that is much longer than the others is a gap
bool is_recording(const Samples& samples)
{
  if (samples.step > kLongestFrame)
    return false;
  if (samples.frames)
    return true;
  std::size_t usual = 0;
  for (std::size_t row = 1; row < samples.times.size(); ++row)
    usual += std::abs(samples.times[row] - samples.times[row - 1] - samples.step) < 0.5 * samples.step ? 1 : 0;
  return 10 * usual >= 9 * (samples.times.size() - 1);
}

bool is_frame(const Samples& samples, std::size_t row)
{
  return samples.frames && samples.frames->number[row] != FrameRate::kNone;
}

// rows that show one instant get one time; all but one of them are no samples
void merge_instants(Samples& samples, const Eigen::MatrixXd& motion, const std::vector<std::size_t>& lines)
{
  std::size_t repeated = 0, first_line = 0;
  double longest = 0.0;
  for (std::size_t begin = 0, end = 1; begin < samples.times.size(); begin = end++)
  {
    std::size_t sample = begin;
    while (end < samples.times.size() && samples.times[end] - samples.times[begin] < kNear * samples.step &&
           motion.row(static_cast<Eigen::Index>(end)) == motion.row(static_cast<Eigen::Index>(begin)))
    {
      if (is_frame(samples, end))
        sample = end;
      ++end;
    }
    if (end == begin + 1)
      continue;
    longest = std::max(longest, samples.times[end - 1] - samples.times[begin]);
    if (repeated == 0)
      first_line = lines[end - 1];
    repeated += end - begin - 1;
    for (std::size_t row = begin; row < end; ++row)
    {
      samples.times[row] = samples.times[sample];
      samples.is_sample[row] = row == sample;
    }
  }
  if (repeated > 0)
    samples.notes.push_back(fmt::format("{} row{} the instant of the row before once more, up to {:.2g} s later, first "
                                        "in line {}: each such pair is one sample",
                                        repeated, repeated == 1 ? " shows" : "s show", longest, first_line));
}

// Rows too near to others for two samples, and rows between frames whose times are not known well enough.
void leave_out_near_rows(Samples& samples, const std::vector<double>& errors, const std::vector<std::size_t>& lines)
{
  std::optional<std::size_t> before; // the sample before
  std::vector<std::size_t> left_out;
  for (std::size_t row = 0; row < samples.times.size(); ++row)
  {
    if (!samples.is_sample[row])
      continue;
    if (samples.frames && !is_frame(samples, row))
    {
      double distance = before ? samples.times[row] - samples.times[*before] : INFINITY;
      std::size_t after = row + 1;
      while (after < samples.times.size() && !is_frame(samples, after))
        ++after;
      if (after < samples.times.size())
        distance = std::min(distance, samples.times[after] - samples.times[row]);
      if (distance < kNear * samples.step || errors[row] > kTolerableTimeError * distance * samples.step)
        samples.is_sample[row] = false;
    }
    else if (!samples.frames && before && samples.times[row] - samples.times[*before] < kNear * samples.step)
    {
      samples.is_sample[row] = false;
    }
    if (samples.is_sample[row])
      before = row;
    else
      left_out.push_back(row);
  }
  if (!left_out.empty())
    samples.notes.push_back(fmt::format("{} row{} between frames or too near to others for a sample, first in line {}: "
                                        "derivatives there are those of the spline through the others",
                                        left_out.size(), left_out.size() == 1 ? " is" : "s are",
                                        lines[left_out.front()]));
}

void leave_out_frozen_rows(Samples& samples, const Eigen::MatrixXd& motion, const std::vector<std::size_t>& lines)
{
  if (!samples.is_recording)
    return;
  std::vector<Eigen::Index> rows;
  for (std::size_t row = 0; row < samples.times.size(); ++row)
    if (samples.is_sample[row] && motion.row(static_cast<Eigen::Index>(row)).array().isFinite().all())
      rows.push_back(static_cast<Eigen::Index>(row));
  const Eigen::Map<const Eigen::VectorXd> all(samples.times.data(), motion.rows());
  const Eigen::VectorXd times = all(rows);
  const Eigen::MatrixXd positions = motion(rows, Eigen::all);
  constexpr std::size_t shown = 3;
  std::vector<std::string> places;
  std::size_t frozen = 0;
  for (const FrozenRows& run : find_frozen_rows(times, samples.step, positions))
  {
    for (Eigen::Index i = run.first; i <= run.last; ++i, ++frozen)
    {
      const auto row = static_cast<std::size_t>(rows[static_cast<std::size_t>(i)]);
      samples.is_sample[row] = false;
      samples.is_frozen[row] = true;
    }
    const auto line = [&](Eigen::Index i)
    {
      return lines[static_cast<std::size_t>(rows[static_cast<std::size_t>(i)])];
    };
    places.push_back(run.first == run.last ? fmt::format("{}", line(run.first))
                                           : fmt::format("{} to {}", line(run.first), line(run.last)));
  }
  if (places.empty())
    return;
  const std::size_t more = places.size() > shown ? places.size() - shown : 0;
  places.resize(places.size() - more);
  samples.notes.push_back(fmt::format(
      "{} frozen frame{}, all coordinates as in the row before while the motion goes on, bridged: line{} {}{}", frozen,
      frozen == 1 ? "" : "s", places.size() + frozen > 2 ? "s" : "", fmt::join(places, ", "),
      more > 0 ? fmt::format(", and {} more", more) : ""));
}

} // namespace

Samples find_samples(const std::vector<double>& times, const Eigen::MatrixXd& motion,
                     const std::vector<std::size_t>& lines)
{
  Samples samples;
  const std::vector<double> errors = rounding_errors(times);
  samples.frames = find_frame_rate(times, errors);
  samples.is_sample.assign(times.size(), true);
  samples.is_frozen.assign(times.size(), false);
  for (std::size_t row = 0; row < times.size(); ++row)
    samples.times.push_back(is_frame(samples, row) ? samples.frames->time(samples.frames->number[row])
                                                   : times[row] - times.front());
  samples.step = samples.frames ? samples.frames->step() : median_step(samples.times);
  samples.is_recording = is_recording(samples);
  // smaller moves are the rounding of this computation
  if (samples.frames && samples.frames->largest_move > 1e-9 * samples.step)
    samples.notes.push_back(fmt::format("times are rounded to {:.1g} s: put back on {:.6g} Hz (largest move {:.2g} s)",
                                        samples.frames->rounding, samples.frames->rate, samples.frames->largest_move));
  merge_instants(samples, motion, lines);
  leave_out_near_rows(samples, errors, lines);
  leave_out_frozen_rows(samples, motion, lines);
  return samples;
}

} // namespace torqued
