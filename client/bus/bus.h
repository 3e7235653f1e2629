/// The LCM bus of a program that SIGINT and SIGTERM end.
#pragma once

#include "wire/lcm_bus.h"

#include <chrono>
#include <functional>
#include <optional>
#include <signal.h>
#include <string>
#include <utility>

namespace torqued
{

/// An opened bus. From its construction on SIGINT and SIGTERM do not end the process, but a wait; at most one per
/// process.
class Bus
{
public:
  using Clock = LcmBus::Clock;

  /// url: empty for LCM's default. Throws BusError, also for a bus on which no other process is heard.
  explicit Bus(const std::string& url);

  /// As LcmBus does.
  void subscribe(const std::string& channel, LcmBus::Handler handler) { lcm_.subscribe(channel, std::move(handler)); }
  void subscribe_ending(const std::string& ending, std::function<void(const std::string&, Bytes)> handler)
  {
    lcm_.subscribe_ending(ending, std::move(handler));
  }
  void publish(const std::string& channel, Bytes message) { lcm_.publish(channel, message); }

  /// Waits for one message and handles it; at the latest until the deadline, or until a signal.
  void wait(Clock::time_point deadline) { lcm_.wait(deadline, &mask_while_waiting_); }
  /// Whether SIGINT or SIGTERM has come.
  bool stopped() const;

  static constexpr std::chrono::seconds kModelPatience{5};
  /// Waits up to kModelPatience until a daemon has said which robot it computes; false if a signal came first. To be
  /// called once. A message that can be no robot's is passed over; the first one is told to the user, whenever it
  /// comes. Throws Failure, no_bus, if none says so.
  bool wait_for_model(const Channels& channels);
  /// What was said about the robot last. Requires: wait_for_model() was true.
  const model_info_t& model() const { return *model_; }

private:
  void hear_model(const std::string& channel, Bytes bytes);

  sigset_t mask_while_waiting_;
  LcmBus lcm_;
  std::optional<model_info_t> model_;
  bool flaw_told_ = false;
};

} // namespace torqued
