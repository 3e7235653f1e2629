/// The daemon's loop: carries bytes from the bus to the line of answer.h, and its answers back.
#pragma once

#include "daemon/answer_dynamics.h"
#include "daemon/config.h"
#include "daemon/latency.h"
#include "daemon/stream_gate.h"

#include <lcm/lcm-cpp.hpp>

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
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
/// make it throw or stop.
class LcmLoop
{
public:
  /// dropped_logs: how many log lines have been dropped so far. The bus, the robot and the logger must outlive the
  /// loop.
  LcmLoop(lcm::LCM& bus, const Robot& robot, const Config& config, spdlog::logger& log,
          std::function<std::int64_t()> dropped_logs);
  ~LcmLoop();
  LcmLoop(const LcmLoop&) = delete;
  LcmLoop& operator=(const LcmLoop&) = delete;

  /// Publishes the first status and hears it come back. false: the bus does not carry messages, not even to ourselves.
  bool prove_bus();

  /// Begins to hear desired states. What came before is not heard.
  void listen();

  /// Waits for messages, for at most timeout (s) or until stop_fd can be read, and deals with all that have come.
  /// Returns whether stop_fd can be read. stop_fd: −1 for none.
  bool cycle(double timeout, int stop_fd = -1);

  /// Runs until stop_fd can be read, then publishes the last status, STOPPING.
  void run(int stop_fd);

private:
  // what LCM calls; they let nothing be thrown into it
  static void hear_desired(const lcm::ReceiveBuffer* buffer, const std::string& channel, LcmLoop* loop) noexcept;
  static void hear_status(const lcm::ReceiveBuffer* buffer, const std::string& channel, LcmLoop* loop) noexcept;

  static void hear_request(const lcm::ReceiveBuffer* buffer, const std::string& channel, LcmLoop* loop) noexcept;

  void on_desired(Bytes message);
  void on_request(Bytes message);
  void on_status(Bytes message);

  void answer_sample(const DesiredState& desired, std::int64_t arrival);
  void answer_pending();
  void answer_oldest_request();
  void reject(const Sender& sender, const Refusal& refusal);
  void publish_status(std::int8_t state);
  void publish_status_and_model_when_due();
  std::int8_t state(std::int64_t now) const;
  bool notice_own_stall(std::int64_t now, std::int64_t asleep = 0);

  template <typename Message> void publish(const std::string& channel, const Message& message);

  lcm::LCM& bus_;
  const Robot& robot_;
  const Config config_;
  spdlog::logger& log_;
  const std::function<std::int64_t()> dropped_logs_;
  const Channels channels_;
  const std::vector<BaseParameter> parameters_;
  std::vector<lcm::Subscription*> subscriptions_;

  StreamGate gate_;
  StreamMemory memory_;
  std::optional<DesiredState> pending_; // newest wins: the newest checked sample that waits for its answer
  std::int64_t pending_arrival_ = 0;
  std::deque<std::vector<std::byte>> requests_; // for the equation of motion, the oldest first

  torque_command_t command_;
  rejection_t rejection_;
  status_t status_;
  model_info_t model_;
  dynamics_t dynamics_;
  std::vector<std::byte> buffer_;

  Latencies latencies_;
  std::int64_t start_, last_arrival_ = -1, last_awake_, next_status_ = 0, next_model_ = 0;
  std::array<std::int64_t, 16> next_log_{}; // by reason: a repeated refusal is logged once a second, and counted
  bool heard_own_status_ = false;
};

} // namespace torqued
