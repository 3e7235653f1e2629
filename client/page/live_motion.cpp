#include "page/live_motion.h"

#include "study/recorded.h"
#include "study/tally.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace torqued
{

namespace
{

using namespace std::chrono_literals;

// an answer that has not come by then does not come
constexpr auto kDisplayPatience = 200ms;
// a stream that has been silent for so long gives way to another one
constexpr auto kSilence = 500ms;

// µs; defined whatever times a stranger makes up
std::uint64_t elapsed(std::int64_t from, std::int64_t to)
{
  return static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from);
}

} // namespace

LiveMotion::LiveMotion(Robot robot, double seconds)
    : robot_(std::move(robot)), length_(static_cast<std::uint64_t>(std::llround(1e6 * seconds))), path_(robot_)
{
}

void LiveMotion::hear(const desired_state_t& desired, Clock::time_point now)
{
  std::vector<std::byte> buffer;
  const Result<DesiredState> decoded = decode_desired_state(encode(desired, buffer), robot_);
  if (std::holds_alternative<Refusal>(decoded))
    return;
  DesiredState state = std::get<DesiredState>(decoded);
  if (!samples_.empty())
  {
    const Sample& last = samples_.back();
    const bool follows = state.stream_id == last.state.stream_id && state.utime > last.state.utime;
    if (!follows && now - last.heard < kSilence)
      return;
    if (!follows)
    {
      samples_.clear();
      begin_.reset();
      path_ = WorldPath(robot_);
    }
  }
  begin_ = begin_.value_or(state.utime);
  const std::optional<Kinematics> placed = path_.next(state);
  if (placed && !robot_.fixed_root())
  {
    state.q.tail<2>() = placed->base;
    if (!state.base_given)
      state.a.tail<2>().setConstant(NAN); // nobody asked for any
    state.base_given = true;
  }
  samples_.push_back({std::move(state), now, std::nullopt, {NAN, NAN}, ""});
  while (elapsed(samples_.front().state.utime, samples_.back().state.utime) > length_ || samples_.size() > kMostSamples)
    samples_.pop_front();
}

LiveMotion::Sample* LiveMotion::find(std::int64_t stream_id, std::int64_t utime)
{
  const auto found = std::ranges::lower_bound(samples_, utime, {}, [](const Sample& one) { return one.state.utime; });
  const bool is_meant = found != samples_.end() && found->state.utime == utime && found->state.stream_id == stream_id;
  return is_meant ? &*found : nullptr;
}

void LiveMotion::hear(const torque_command_t& command, Clock::time_point now)
{
  Sample* sample = find(command.stream_id, command.utime);
  if (!sample || command.model_id != robot_.model_id || command.num_joints != robot_.num_joints() ||
      command.num_coordinates != robot_.num_coordinates())
    return;
  last_answer_ = now;
  sample->answer = to_answer(command);
  sample->time = {1e-3 * command.compute_ns, std::chrono::duration<double, std::micro>(now - sample->heard).count()};
}

void LiveMotion::hear(const rejection_t& rejection)
{
  if (Sample* sample = find(rejection.stream_id, rejection.utime))
    sample->rejected = reason_name(rejection.reason);
}

std::vector<ReportMotion> LiveMotion::window(Clock::time_point now) const
{
  auto end = samples_.end();
  while (end != samples_.begin())
  {
    const Sample& last = *std::prev(end);
    if (last.answer || !last.rejected.empty() || now - last.heard > kDisplayPatience)
      break;
    --end;
  }
  if (end == samples_.begin())
    return {};
  ReportMotion motion;
  motion.source = "live";
  motion.start = 1e-6 * static_cast<double>(elapsed(*begin_, samples_.front().state.utime));
  ReportRun& run = motion.runs.emplace_back();
  run.name = "torqued";
  for (auto sample = samples_.begin(); sample != end; ++sample)
  {
    motion.states.push_back(sample->state);
    run.answers.push_back(sample->answer);
    run.times.push_back(sample->time);
    if (!sample->answer)
      ++run.unanswered[sample->rejected.empty() ? "NO_ANSWER" : sample->rejected];
  }
  return {motion};
}

std::optional<double> LiveMotion::answer_age(Clock::time_point now) const
{
  return last_answer_ ? std::optional(std::chrono::duration<double>(now - *last_answer_).count()) : std::nullopt;
}

} // namespace torqued
