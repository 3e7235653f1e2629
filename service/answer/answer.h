/// From a desired state to what is published for it.
#pragma once

#include "answer/limits.h"
#include "stance/flags.h"
#include "stance/ground_reaction.h"

#include <cstdint>
#include <optional>

namespace torqued
{

/// What is published for a desired state that was answered.
struct Answer
{
  Answer() {} // or a variant would zero all of its bytes first; rows "single support" of tools/bench

  std::int64_t utime = 0, stream_id = 0;
  Method method = Method::none;
  std::int32_t flags = 0;
  std::array<GroundReaction, 2> ground;             ///< indexed by Side
  double zmp = 0.0;                                 ///< m
  double dynamics_residual = 0.0;                   ///< N, N m
  double contact_speed = 0.0;                       ///< m/s, rad/s
  double contact_residual = 0.0;                    ///< m/s², rad/s²
  Eigen::Vector2d base_a = Eigen::Vector2d::Zero(); ///< of the base point, m/s²; 0 for a fixed root
  double adjustment = 0.0;                          ///< largest |a − a desired| among the coordinates, rad/s²
  VectorQ a;      ///< without the base point, in the coordinates that were sent, rad/s²
  VectorJ torque; ///< N m
};

/// The motion that answer() answers: the desired one, or, with settings.project, its projection. Refuses what project()
/// refuses.
Result<DesiredState> answered_motion(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired);

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
