/// Which rows of a file are samples of its motion, and when they were taken.
#pragma once

#include "motion/frame_rate.h"
#include "motion/unit_doubts.h"

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace torqued
{

/// The rows of a file as samples.
struct Samples
{
  std::vector<double> times;       ///< of each row, s since the first row; one for all rows that show one instant
  std::optional<FrameRate> frames; ///< where the times are those of frames
  double step = 0.0;               ///< s, from frame to frame, or the median
  bool is_recording = false;       ///< whether frames can be missing or frozen: 0.05 s apart at most, and evenly
  std::vector<bool> is_sample;     ///< of each row
  std::vector<bool> is_frozen;     ///< of each row: it repeats the one before while the motion goes on
  std::vector<std::string> notes;  ///< on rows that are none, and on times that were moved; a sentence each
};

/// See differentiate(). motion: one row per row of the file, one column per coordinate; NaN where nothing is written.
/// times: s, as written, strictly increasing. lines: of each row, in the file.
Samples find_samples(const std::vector<double>& times, const Eigen::MatrixXd& motion,
                     const std::vector<std::size_t>& lines);

} // namespace torqued
