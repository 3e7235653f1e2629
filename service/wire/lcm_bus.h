/// An opened LCM bus, as a program with one thread uses it: messages come in while it waits.
#pragma once

#include "wire/messages.h"

#include <lcm/lcm-cpp.hpp>

#include <chrono>
#include <exception>
#include <functional>
#include <list>
#include <signal.h>
#include <stdexcept>
#include <string>

namespace torqued
{

/// Why a bus cannot be used, with its URL, who set it, and what it needs.
struct BusError : std::runtime_error
{
  using std::runtime_error::runtime_error;
};

class LcmBus
{
public:
  using Clock = std::chrono::steady_clock; ///< CLOCK_MONOTONIC
  using Handler = std::function<void(Bytes)>;

  /// Messages that a subscription keeps: more than LCM's thirty, so that a program that was busy for a while loses
  /// none.
  static constexpr int kQueue = 10'000;

  /// url, given_by: as for choose_bus(). Throws BusError if the bus cannot be opened or does not carry messages: at
  /// once if its URL says so already, else after the ten seconds for which LCM looks for its own message.
  LcmBus(const std::string& url, const std::string& given_by);
  LcmBus(const LcmBus&) = delete;
  LcmBus& operator=(const LcmBus&) = delete;

  /// Calls a handler with the bytes of each message on a channel, during wait(). The bytes live until it returns; what
  /// it throws comes out of wait().
  void subscribe(const std::string& channel, Handler handler);
  /// The same for all channels whose names end so: those of any prefix. The handler gets the channel's name, too.
  void subscribe_ending(const std::string& ending, std::function<void(const std::string&, Bytes)> handler);
  /// Throws BusError.
  void publish(const std::string& channel, Bytes message);

  /// Waits for one message and handles it; false if none came until the deadline, or a signal came first. mask: of the
  /// signals that are held back meanwhile; null: those that are held back otherwise. Throws BusError.
  bool wait(Clock::time_point deadline, const sigset_t* mask = nullptr);
  /// Readable when wait() has a message to handle.
  int file_descriptor() { return lcm_.getFileno(); }
  /// Which bus this is, who set it, and what it needs; for the end of a complaint.
  const std::string& trouble() const { return trouble_; }

private:
  struct Subscription
  {
    LcmBus& bus;
    std::function<bool(const std::string&)> is_meant;
    std::function<void(const std::string&, Bytes)> handler;
    static void receive(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                        Subscription* subscription) noexcept;
  };
  void subscribe(const std::string& pattern, Subscription subscription);

  std::string trouble_;
  lcm::LCM lcm_;
  std::list<Subscription> subscriptions_; // LCM keeps their addresses
  std::exception_ptr thrown_;
};

} // namespace torqued
