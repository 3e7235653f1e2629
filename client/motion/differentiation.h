/// Velocities and accelerations of a motion of which a file gives only positions.
#pragma once

#include "motion/spline.h"
#include "motion/unit_doubts.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace torqued
{

/// How derivatives are found.
struct Differentiation
{
  bool wanted = false;
  std::optional<double> lowpass; ///< cut-off of a low-pass before it, Hz; see lowpass()

  Differentiation() = default;
  /// Without a low-pass.
  Differentiation(bool differentiate) : wanted(differentiate) {} // NOLINT(google-explicit-constructor)
};

/// A motion with its derivatives, one row per row of the file.
struct Differentiated
{
  SampledMotion motion;
  std::vector<double> times;      ///< s, put back on the frame rate where there is one
  std::vector<std::string> notes; ///< on everything that was not taken as the file says; a sentence each
};

/// Derivatives of the quintic spline through the samples of a motion, after
///
/// - whole turns are taken off angles that jump by them (unwrap());
/// - times within their rounding of a frame rate are put back on it (find_frame_rate());
/// - rows that show one instant twice, within a twentieth of a step, became one sample; and rows between frames none,
/// where
///   the rounding of their time would move the acceleration by more than 0.01/s times the velocity;
/// - frozen frames (find_frozen_rows()) and cells without a number became none;
/// - with `lowpass`, samples are smoothed (lowpass()), which needs a frame rate.
///
/// Every row gets positions and derivatives, those of the spline where it is no sample; positions that are samples stay
/// as they are without `lowpass`. Gaps of up to 0.1 s, in frames that are no more than 0.05 s apart or in a column, are
/// bridged by the spline.
///
/// written: the file's positions. file, lines: for complaints, each row's line.
/// Throws Failure, bad_data: fewer than kFewestSplineSamples samples; longer gaps; steps that no motion makes; a
/// low-pass without a frame rate, or not below half of it.
Differentiated differentiate(const WrittenMotion& written, const Differentiation& how, const std::string& file,
                             const std::vector<std::size_t>& lines);

} // namespace torqued
