/// The last seconds of a motion as it comes over the bus, with its answers.
#pragma once

#include "page/report_page.h"
#include "study/world_path.h"
#include "wire/codec.h"

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

namespace torqued
{

/// Hears what clients and daemon say, and keeps a window of it.
///
/// Shown is one stream at a time: another one when the present one has been silent for half a second, or when its clock
/// has been set back. What the daemon superseded has no answer.
class LiveMotion
{
public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMostSamples = 40'000;

  /// seconds: how much is kept, by the sender's clock; of very fast streams less, the last kMostSamples.
  LiveMotion(Robot robot, double seconds);
  // the path refers to the robot
  LiveMotion(const LiveMotion&) = delete;
  LiveMotion& operator=(const LiveMotion&) = delete;

  const Robot& robot() const { return robot_; }

  /// Samples that make no sense for the robot, and commands for another one, are passed over.
  void hear(const desired_state_t& desired, Clock::time_point now);
  void hear(const torque_command_t& command, Clock::time_point now);
  void hear(const rejection_t& rejection);

  /// What has been heard, as a report shows it: one motion, with one run; none before the first sample.
  ///
  /// The newest samples are left out while their answers may still come.
  std::vector<ReportMotion> window(Clock::time_point now) const;

  /// s since the last answer to a sample was heard; nothing as long as none was.
  std::optional<double> answer_age(Clock::time_point now) const;

private:
  struct Sample
  {
    DesiredState state; ///< its base placed, unless the root is fixed
    Clock::time_point heard;
    std::optional<Answer> answer;
    AnswerTime time;
    std::string rejected; ///< the reason's name; empty if it was not
  };
  Sample* find(std::int64_t stream_id, std::int64_t utime);

  Robot robot_;
  std::uint64_t length_; // µs
  std::deque<Sample> samples_;
  std::optional<std::int64_t> begin_; // utime of the stream's first sample
  std::optional<Clock::time_point> last_answer_;
  WorldPath path_;
};

} // namespace torqued
