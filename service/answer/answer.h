/// The line of the whole service: from a desired state to what is published for it.
#pragma once

#include "methods/torque_method.h"
#include "wire/codec.h"

#include <cstdint>
#include <optional>

namespace torqued
{

/// What happens when a limit or a tolerance is passed.
enum class OnExcess
{
  flag,   ///< the answer says so
  refuse, ///< the desired state is refused
  clamp   ///< limits only: the torque is cut to the limit, and the answer says so
};

/// The settings that change answers.
struct AnswerSettings
{
  MethodSettings methods;
  OnExcess consistency = OnExcess::flag;  ///< flag or refuse
  double contact_speed_tolerance = 0.01;  ///< m/s, rad/s
  double contact_tolerance = 0.1;         ///< m/s², rad/s²; beyond it the flag is contact_acceleration
  double sole_tilt_tolerance = 0.02;      ///< rad
  double contact_height_tolerance = 0.03; ///< m above or below the ground z = 0; no torque depends on that height
  double residual_tolerance = 1e-3;       ///< share of the weight, or of weight × leg length; see solve_torques
  bool project = false;                   ///< answer the nearest motion that keeps its contacts, projection.h
  OnExcess limits = OnExcess::flag;       ///< torque limits
  OnExcess rate_limits = OnExcess::flag;  ///< torque-rate limits
};

/// FNV-1a of the settings; never 0.
std::int64_t settings_id(const AnswerSettings& settings);

/// The motion that answer() answers: the desired one, or, with settings.project, its projection. Refuses what project()
/// refuses.
Result<DesiredState> answered_motion(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired);

/// What the next answer may depend on besides its own desired state: the torque it follows.
struct StreamMemory
{
  bool answered = false;
  std::int64_t stream_id = 0, utime = 0;
  VectorJ torque;
  std::int64_t now = 0;   ///< µs, OwnClock's at the last answer
  std::int64_t ahead = 0; ///< µs by which the sender's clock is ahead of ours, since the stream began
};

/// The clock of whoever answers, against which torque-rate limits hold whatever a sender's clock shows.
///
/// The sender's time counts, so that jitter costs nothing, as long as it is honest: since its stream began it is at
/// most max_age ahead of ours, and of what it was behind, it makes up 5 × max_age at most. To the first sample of
/// another stream our own time counts, at most 5 × max_age.
struct OwnClock
{
  std::int64_t now;     ///< µs, monotonic
  std::int64_t max_age; ///< µs
};

/// A torque above so many times weight × leg length, a slide's force above so many times the weight, is no robot's.
inline constexpr double kMostTorque = 10.0;

/// Answers a desired state: projection if wanted, equations, method, checks, limits.
///
/// No clock, no log, no transport, no allocation: the same robot, settings, memory and desired state give the same
/// bits (on a thread that has called flush_denormals()). Updates the memory when it answers.
/// Without a clock the sender's own time counts for torque-rate limits, within a stream.
/// Refuses: not_supported, inconsistent, under_actuated, infeasible, numerical (also a torque beyond kMostTorque),
/// over_limit.
/// Requires: the settings fit the robot, complaint().
Result<Answer> answer(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired,
                      StreamMemory& memory, const std::optional<OwnClock>& clock = {});

/// Makes the calling thread treat denormal numbers as zero, because they cost up to 70 times a normal one's time. To be
/// called before answer() by whatever calls it, so that all get the same bits.
void flush_denormals();

} // namespace torqued
