/// The daemon's loop: carries bytes from the bus to the line of answer.h, and its answers back.
#pragma once

#include "answer/answer.h"
#include "answer/answer_dynamics.h"
#include "answer/config.h"
#include "daemon/latency.h"
#include "daemon/receiver.h"
#include "daemon/stream_gate.h"

#include <lcm/lcm-cpp.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace spdlog
{
class logger;
}

namespace torqued
{

/// Hears desired states and publishes a command or a rejection for each, answers requests for the equation of motion,
/// and publishes a status ten times a second and the model every two seconds. One thread; nothing a message holds can
/// make it throw, stop or, once it listens, allocate.
///
/// It hears its own statuses, too: as long as they come back, the bus carries messages and the loop turns. When they
/// stay away, and when another daemon publishes on the same channel, the log says so.
class LcmLoop
{
public:
  /// What the loop asks of, and tells, the process that it runs in.
  struct Surroundings
  {
    /// How many log lines have been dropped so far.
    std::function<std::int64_t()> dropped_logs = []
    {
      return std::int64_t{0};
    };
    /// Called once for each status of our own that came back over the bus, or was lost there among others: the loop
    /// turns, sends and hears.
    std::function<void()> on_healthy = [] {
    };
  };

  /// Publishes on the bus and hears what the receiver brings from it. Both, the robot and the logger must outlive the
  /// loop.
  LcmLoop(lcm::LCM& bus, Receiver& receiver, const Robot& robot, const Config& config, spdlog::logger& log,
          Surroundings surroundings);
  LcmLoop(const LcmLoop&) = delete;
  LcmLoop& operator=(const LcmLoop&) = delete;

  /// Publishes the first status and hears it come back. false: the bus does not carry messages, not even to ourselves,
  /// or stop_fd can be read.
  bool prove_bus(int stop_fd = -1);

  /// Begins to hear desired states. What came before is not heard. false: the bus takes no subscription.
  bool listen();

  /// Waits for messages, for at most timeout (s) or until stop_fd can be read, and deals with all that have come.
  /// Returns whether stop_fd can be read. stop_fd: −1 for none.
  bool cycle(double timeout, int stop_fd = -1);

  /// Runs until stop_fd can be read, then publishes the last status, STOPPING.
  void run(int stop_fd);

private:
  void on_desired(Bytes message) noexcept;
  void dispose_of(Bytes message);
  void on_request(Bytes message);
  void on_status(Bytes message);

  void answer_sample(const DesiredState& desired, std::int64_t arrival);
  void answer_pending();
  void answer_oldest_request();
  void reject(const Sender& sender, const Refusal& refusal);
  void publish_status(std::int8_t state);
  void publish_status_and_model_when_due();
  void note_healthy();
  void note_deafness();
  void note_losses(std::int64_t now);
  std::int8_t state(std::int64_t now) const;
  void notice_own_stall(std::int64_t now, std::int64_t asleep = 0);
  bool may_publish_rejection();
  bool may_log(std::size_t what, std::int64_t period);

  template <typename Message> void publish(const std::string& channel, const Message& message);
  void send(const std::string& channel, Bytes bytes);

  lcm::LCM& bus_;
  Receiver& receiver_;
  const Robot& robot_;
  const Config config_;
  spdlog::logger& log_;
  const Surroundings surroundings_;
  const Channels channels_;
  const std::vector<BaseParameter> parameters_;

  // Requests for the equation of motion that wait: one is answered per cycle, after the desired states.
  struct Requests
  {
    // of a longer one, which no robot's is, so much that it is refused
    static constexpr std::size_t kLongest = 4096;
    struct Request
    {
      std::size_t size = 0;
      std::array<std::byte, kLongest> bytes;
    };
    std::array<Request, 16> ring;
    std::size_t oldest = 0, count = 0;
  };

  StreamGate gate_;
  StreamMemory memory_;
  std::optional<DesiredState> pending_; // newest wins: the newest checked sample that waits for its answer
  std::int64_t pending_arrival_ = 0;
  Requests requests_;

  torque_command_t command_;
  rejection_t rejection_;
  status_t status_;
  model_info_t model_;
  dynamics_t dynamics_;
  std::vector<std::byte> buffer_;

  Latencies latencies_;
  // The most rejections published in a second; those beyond are counted alone.
  static constexpr std::size_t kMostRejections = 1000;
  std::array<std::int64_t, kMostRejections> rejected_at_; // when the last ones were published, in a ring
  std::size_t next_rejection_ = 0;
  std::int64_t start_, last_arrival_ = -1, last_awake_, next_status_ = 0, next_model_ = 0;
  std::int64_t drained_at_; // when messages last began to come after none had waited
  bool drained_ = true;     // whether none waits
  std::int64_t resumed_;    // when this process last went on after it had stood still
  int statuses_away_ = 0;   // published since one of our own came back
  bool deaf_ = false;
  std::array<std::int64_t, 17> next_log_{}; // by reason or event: when it may be logged again
};

} // namespace torqued
