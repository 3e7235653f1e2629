#include "answer/limits.h"

#include "stance/flags.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace torqued
{

Elapsed elapsed_since(const StreamMemory& memory, const DesiredState& desired, const std::optional<OwnClock>& clock)
{
  const bool same_stream = memory.answered && memory.stream_id == desired.stream_id && memory.utime < desired.utime;
  std::int64_t sent = 1;
  if (same_stream && __builtin_sub_overflow(desired.utime, memory.utime, &sent))
    sent = std::numeric_limits<std::int64_t>::max();
  if (!clock || !memory.answered)
    return {same_stream, sent, 0};

  const std::int64_t own = std::max<std::int64_t>(clock->now - memory.now, 0);
  const std::int64_t most = 5 * clock->max_age;
  if (!same_stream)
    return {true, std::clamp<std::int64_t>(own, 1, most), 0};
  const std::int64_t time =
      std::clamp<std::int64_t>(sent, 1, std::max<std::int64_t>(own + clock->max_age - memory.ahead, 1));
  return {true, time, std::max(memory.ahead + time - own, -most)};
}

std::optional<Refusal> check_magnitude(const Robot& robot, const VectorJ& torque)
{
  const double weight = robot.weight();
  for (int j = 0; j < robot.num_joints(); ++j)
  {
    const Actuator& actuator = robot.actuators[static_cast<std::size_t>(j)];
    const bool slide = is_force(robot, actuator);
    const double limit = kMostTorque * weight * (slide ? 1.0 : robot.leg_length);
    if (!(std::abs(torque(j)) <= limit))
      return Refusal(Reason::numerical,
                     "{} would need {:.4g} {}; expected at most {:.4g}, {} times {}: the motion's numbers are no "
                     "motion of this robot",
                     actuator.name, torque(j), slide ? "N" : "N m", limit, kMostTorque,
                     slide ? "the weight" : "weight times leg length");
  }
  return {};
}

std::optional<Refusal> apply_limits(const Robot& robot, const AnswerSettings& settings, const Elapsed& elapsed,
                                    const StreamMemory& memory, VectorJ& torque, std::int32_t& flags)
{
  constexpr double rounding = 1.0 + 1e-9, torque_rounding = 1.0 + 2e-8; // motors that gave way have room of 1e-8
  const bool follows = elapsed.follows;
  const double dt = elapsed.seconds();
  for (int j = 0; j < robot.num_joints(); ++j)
  {
    const Actuator& actuator = robot.actuators[static_cast<std::size_t>(j)];
    const bool is_over = std::abs(torque(j)) > actuator.torque_limit * torque_rounding;
    if (is_over)
    {
      flags |= flag::over_torque;
      if (settings.limits == OnExcess::refuse)
        return Refusal(Reason::over_limit, "{} would need {:.4g} N m; its torque limit is {:.4g} N m", actuator.name,
                       torque(j), actuator.torque_limit);
    }
    if (settings.limits == OnExcess::clamp)
    {
      // also what is over by no more than rounding: a clamped torque keeps its limit to the last bit
      flags |= is_over ? flag::clamped : 0;
      torque(j) = std::clamp(torque(j), -actuator.torque_limit, actuator.torque_limit);
    }

    const double step = actuator.rate_limit * dt;
    if (follows && std::abs(torque(j) - memory.torque(j)) > step * rounding)
    {
      flags |= flag::over_rate;
      if (settings.rate_limits == OnExcess::refuse)
        return Refusal(Reason::over_limit, "{} would change by {:.4g} N m in {:.4g} s; its rate limit is {:.4g} N m/s",
                       actuator.name, torque(j) - memory.torque(j), dt, actuator.rate_limit);
      if (settings.rate_limits == OnExcess::clamp)
      {
        flags |= flag::clamped;
        torque(j) = std::clamp(torque(j), memory.torque(j) - step, memory.torque(j) + step);
      }
    }
  }
  return {};
}

} // namespace torqued
