/// Times of samples that were taken at a fixed rate, and rounded when they were written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace torqued
{

/// Frame k is at start + k / rate.
struct FrameRate
{
  static constexpr std::int64_t kNone = -1; ///< number of a row that is no frame

  double rate = 0.0;                ///< Hz
  double start = 0.0;               ///< s, relative to the first row's time
  std::vector<std::int64_t> number; ///< of each row: its frame, from 0, strictly increasing; or kNone
  double largest_move = 0.0;        ///< between a frame's written time and its own, s
  double rounding = 0.0;            ///< the decimal place whose rounding explains that, s

  double step() const { return 1.0 / rate; }
  double time(std::int64_t frame) const { return start + static_cast<double>(frame) / rate; }
};

/// What each number may have lost by being written: in decimals or significant digits (as many as all of them need), in
/// float if all of them are floats, in double. At most; of the numbers' own unit.
std::vector<double> rounding_errors(const std::vector<double>& numbers);

/// The frame rate of samples, if their times are those of frames within their rounding errors: at least half of the
/// rows are frames, most of them one after another, and the rest lie between two neighbouring frames or within a step
/// of the ends.
///
/// The rate is a whole number of Hz, or 1000/1001 of one (29.97, 59.94), if such a rate explains all times, the
/// roundest first; else that of the least squares' line through the times.
///
/// times: s, as written, strictly increasing. errors: of each, s.
std::optional<FrameRate> find_frame_rate(const std::vector<double>& times, const std::vector<double>& errors);

} // namespace torqued
