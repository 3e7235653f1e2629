/// What force plates and others' inverse dynamics say about a motion, beside what torqued makes of it.
///
/// Columns of a trajectory CSV, one number per sample, nothing or nan where there is none:
///
///   FxL FzL ML FxR FzR MR   force (N) of the ground on the left and right foot, and its moment about that ankle (N m):
///                           all six
///   pub_ankleL, …           joint moments that others published (N m), of the proximal on the distal segment, which is
///                           the opposite of the torques here: pub_JOINTL for an actuator left_JOINT, pub_JOINTR for a
///                           right_JOINT; each may be missing
#pragma once

#include "answer/answer.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// "left_ankle": left, "ankle"; what is on neither side: as it is.
struct SidedName
{
  std::optional<Side> side;
  std::string kind;
};
SidedName sided(const std::string& actuator);

/// One measured quantity along a motion.
struct Channel
{
  std::string name;           ///< "FxL"; an actuator's name
  std::string kind;           ///< the same for both feet: "Fx", "ankle"
  bool published;             ///< others' joint moment; else from the plates
  std::string unit;           ///< "N", "N m"
  Side side;                  ///< of a force
  int component;              ///< of a force: 0 f_x, 1 f_z; −1 for a moment
  int joint;                  ///< of a moment: the actuator's place
  std::vector<double> values; ///< by sample, ground on robot and torques with the signs of an answer; NaN: none

  /// The same quantity of an answer.
  double of(const Answer& answer) const;
  /// Largest value less smallest one; NaN without values.
  double range() const;
};

/// The same quantity of a motion's answers, by sample; NaN where there is none.
std::vector<double> values_of(const Channel& channel, const std::vector<std::optional<Answer>>& answers);

/// What was measured along a motion.
struct Measured
{
  /// Forces from the plates; torques that follow from them bottom-up, by the recursion of Newton and Euler in the same
  /// robot and motion; published moments.
  std::vector<Channel> channels;
  /// The plates' wrenches by sample, in the order of their columns; all empty if there are none. N, N m; NaN: none.
  std::array<std::vector<double>, 6> plates;
};

/// Reads what a file has of it: nothing of an LCM log, nor of a CSV with none of the columns.
///
/// bytes: the file, which parse_trajectory() has read as these states. Throws Failure, bad_data.
Measured read_measured(std::string_view bytes, const std::string& file, const Robot& robot,
                       const std::vector<DesiredState>& states);

/// How far something is from what was measured, over the samples that have both.
struct Agreement
{
  int samples = 0;
  double rms = 0.0;         ///< of the difference, in the channel's unit
  double of_range = 0.0;    ///< rms / Channel::range()
  double correlation = 0.0; ///< Pearson's r; NaN where one of them is constant
};

/// computed: by sample, NaN where there is nothing. chosen: which samples count.
Agreement agreement(const Channel& channel, const std::vector<double>& computed, const std::vector<bool>& chosen);

} // namespace torqued
