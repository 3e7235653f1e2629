/// The daemons on a bus, as they are heard.
#pragma once

#include "bus/bus.h"

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace torqued
{

/// A daemon as it said it is.
struct Daemon
{
  /// Desired states per second, over the last second that it told about.
  struct Rates
  {
    double received, answered, rejected, superseded;
  };

  std::string prefix; ///< of its channels
  status_t status;    ///< its last one
  double silent;      ///< s since that was heard
  std::optional<Rates> rates;
  std::optional<model_info_t> model;

  /// Whether it publishes: neither its last status nor silence says that it ended.
  bool present() const;
};

/// A state's name; the number itself for any other.
std::string state_name(std::int8_t state);

/// Keeps what daemons say of themselves, told apart by instance_id.
class DaemonsHeard
{
public:
  using Clock = Bus::Clock;

  /// Of an older daemon, too, old_messages.h.
  void hear_status(const std::string& prefix, Bytes message, Clock::time_point now);
  /// Of a daemon whose status was heard before; others' are dropped.
  void hear_model(Bytes message);

  /// All that publish, and of each prefix without one the one that fell silent last; by prefix and instance_id.
  std::vector<Daemon> at(Clock::time_point now) const;

private:
  struct Heard
  {
    std::string prefix;
    std::deque<status_t> statuses; // of the last second, the newest at the end
    Clock::time_point last;
    std::optional<model_info_t> model;
  };
  std::map<std::int64_t, Heard> heard_;
};

/// The daemons on one page, for the eye: what each computes, its counts in all and per second, its latencies, and what
/// is wrong with them. Ends its lines.
std::string status_page(const std::vector<Daemon>& daemons);

/// Hears what daemons say from now on. prefix: of the only ones to hear; nothing for all on the bus.
void subscribe(Bus& bus, const std::optional<std::string>& prefix, DaemonsHeard& daemons);

} // namespace torqued
