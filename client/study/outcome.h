/// Figures of the answers to a whole motion.
#pragma once

#include "answer/answer.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// By sample of a motion; nothing where it was not answered.
using Answers = std::vector<std::optional<Answer>>;

/// What torqued would answer to a motion.
struct Answered
{
  Answers answers;
  std::map<std::string, std::int64_t> refused; ///< samples by the reason's name
};
/// Answers a motion. by: the method, whatever its samples ask for; nothing: as they ask, or else by the settings'.
Answered answer_motion(const Robot& robot, AnswerSettings settings, const std::vector<DesiredState>& states,
                       const std::optional<Method>& by);

/// The changes of contacts in a motion, by kind: "SSP→DSP1". From one stream to another nothing changes: they are two
/// motions.
struct Changes
{
  std::vector<std::string> kinds; ///< in the order in which they come first
  std::vector<int> at;            ///< of each sample: the kind of change that it begins; −1 for none
  std::int64_t longest = 0;       ///< µs between the samples before and after a change
};
Changes find_changes(const std::vector<DesiredState>& states);

/// Counts of samples, and figures of their torques. Integrals are sums of trapezia between neighbours of one stream
/// that are both answered.
struct Outcome
{
  std::vector<double> jumps;           ///< by kind of change: the largest change of a torque across it, N m
  double peak = 0.0;                   ///< largest torque, N m
  double effort = 0.0;                 ///< ∫ Σ τ² dt, N² m² s
  double seconds = 0.0;                ///< over which the integrals run
  double work = 0.0;                   ///< ∫ Σ |τ θ̇| dt, θ̇ the motors' rates, J
  int answered = 0;                    ///< samples
  int double_support = 0;              ///< answered samples in which something had to be chosen
  int held = 0, relaxed = 0;           ///< of those: no foot slips, lifts or tips; RELAXED
  std::map<std::int32_t, int> flagged; ///< answered samples by flag bit

  /// √(effort / seconds): root mean square over time of the torques' vector, N m; 0 without time.
  double rms() const;
};
Outcome outcome_of(const Robot& robot, const std::vector<DesiredState>& states, const Answers& answers,
                   const Changes& changes);

} // namespace torqued
