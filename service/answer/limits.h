/// The limits of motors: of torques, and of how fast they may change from one answer to the next.
#pragma once

#include "answer/settings.h"
#include "robot/robot.h"
#include "stance/refusal.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace torqued
{

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

/// The time since the answer before, in which torques may have changed.
struct Elapsed
{
  bool follows;       ///< whether there is an answer before
  std::int64_t time;  ///< µs, positive; of no consequence if there is none
  std::int64_t ahead; ///< StreamMemory::ahead after this answer

  double seconds() const { return 1e-6 * static_cast<double>(time); } ///< not 0, which times an infinite limit is NaN
};
Elapsed elapsed_since(const StreamMemory& memory, const DesiredState& desired, const std::optional<OwnClock>& clock);

/// Whether check_magnitude() and apply_limits() would find nothing, so that they need not be called: for the rows
/// "single support" of tools/bench. torque: N m (N of a slide), in actuator order; a number that is NaN keeps none.
inline bool keeps_limits(const Robot& robot, const Elapsed& elapsed, const StreamMemory& memory, const VectorJ& torque)
{
  const double most = kMostTorque * robot.weight() * std::min(robot.leg_length, 1.0);
  const double dt = elapsed.seconds();
  bool keeps = true;
  const double* now = torque.data();
  const double* before = elapsed.follows ? memory.torque.data() : now; // of no change, if it follows none
  for (const Actuator& actuator : robot.actuators)
  {
    keeps &= std::abs(*now) <= std::min(most, actuator.torque_limit);
    keeps &= std::abs(*now++ - *before++) <= actuator.rate_limit * dt;
  }
  return keeps;
}

/// Refuses, as numerical, a torque that no robot of this size could ever need.
std::optional<Refusal> check_magnitude(const Robot& robot, const VectorJ& torque);

/// Keeps torques within their limits as the settings want it, and raises the flags. The last change of any torque.
/// Refuses: over_limit.
std::optional<Refusal> apply_limits(const Robot& robot, const AnswerSettings& settings, const Elapsed& elapsed,
                                    const StreamMemory& memory, VectorJ& torque, std::int32_t& flags);

} // namespace torqued
