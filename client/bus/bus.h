/// The LCM bus, as a client with one thread uses it: messages come in while it waits, and a signal ends the wait.
#pragma once

#include "wire/codec.h"

#include <lcm/lcm-cpp.hpp>

#include <chrono>
#include <exception>
#include <functional>
#include <list>
#include <optional>
#include <signal.h>
#include <string>

namespace torqued
{

/// An opened bus. From its construction on SIGINT and SIGTERM do not end the process, but a wait; at most one per
/// process.
class Bus
{
public:
  using Clock = std::chrono::steady_clock; ///< CLOCK_MONOTONIC
  using Handler = std::function<void(Bytes)>;

  /// url: empty for LCM's default. Throws Failure, no_bus.
  explicit Bus(const std::string& url);
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// Calls a handler with the bytes of each message on a channel, during wait(). The bytes live until it returns; what
  /// it throws comes out of wait().
  void subscribe(const std::string& channel, Handler handler);
  /// The same for all channels whose names end so: those of any prefix. The handler gets the channel's name, too.
  void subscribe_ending(const std::string& ending, std::function<void(const std::string&, Bytes)> handler);
  /// Throws Failure, no_bus.
  void publish(const std::string& channel, Bytes message);

  /// Waits for one message and handles it; at the latest until the deadline, or until a signal.
  void wait(Clock::time_point deadline);
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
  struct Subscription
  {
    Bus& bus;
    std::function<bool(const std::string&)> is_meant;
    std::function<void(const std::string&, Bytes)> handler;
    static void receive(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                        Subscription* subscription) noexcept;
  };
  void subscribe(const std::string& pattern, Subscription subscription);
  void hear_model(const std::string& channel, Bytes bytes);

  sigset_t mask_while_waiting_;
  std::string trouble_;
  lcm::LCM lcm_;
  std::list<Subscription> subscriptions_; // LCM keeps their addresses
  std::exception_ptr thrown_;
  std::optional<model_info_t> model_;
  bool flaw_told_ = false;
};

} // namespace torqued
