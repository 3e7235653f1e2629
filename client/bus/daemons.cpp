#include "bus/daemons.h"

#include "answer/config.h"
#include "motion/old_messages.h"
#include "study/tally.h"
#include "text/printable.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string_view>
#include <tuple>

namespace torqued
{

namespace
{

constexpr double kSilent = 1.0;   // s: ten statuses
constexpr double kRateSpan = 1.0; // s
// More than anybody runs, and than one says in that time. Who makes up more must not fill the memory.
constexpr std::size_t kMostDaemons = 100, kMostStatuses = 100;

// In floating point throughout: whatever numbers a stranger publishes, their differences are defined.
double uptime(const status_t& status)
{
  return 1e-6 * static_cast<double>(status.uptime_us);
}

std::optional<Daemon::Rates> rates(const status_t& first, const status_t& last)
{
  const double seconds = uptime(last) - uptime(first);
  if (!(seconds > 0.0))
    return {};
  const auto rate = [&](std::int64_t status_t::*count)
  {
    return (static_cast<double>(last.*count) - static_cast<double>(first.*count)) / seconds;
  };
  return Daemon::Rates{rate(&status_t::received), rate(&status_t::answered), rate(&status_t::rejected),
                       rate(&status_t::superseded)};
}

// 2:03:07, or "3 days and 2:03:07"
std::string duration(std::int64_t microseconds)
{
  const std::int64_t seconds = microseconds / 1'000'000, days = seconds / 86400;
  return fmt::format("{}{}:{:02}:{:02}", days > 0 ? fmt::format("{} days and ", days) : "", seconds / 3600 % 24,
                     seconds / 60 % 60, seconds % 60);
}

// 0.4 ms, 12 s, 2:03:07
std::string age(std::int64_t microseconds)
{
  const double seconds = 1e-6 * static_cast<double>(microseconds);
  return seconds < 0.1    ? fmt::format("{:.1f} ms", 1e3 * seconds)
         : seconds < 60.0 ? fmt::format("{:.1f} s", seconds)
                          : duration(microseconds);
}

std::string robot_line(const std::optional<model_info_t>& model)
{
  if (!model)
    return "it has not said yet which robot it computes";
  std::string line =
      fmt::format("{}, {:.1f} kg, {} joints", printable(model->name), model->total_mass, model->num_joints);
  try
  {
    const Config config = read_config(model->settings, "settings");
    line += fmt::format(", method {}, {}", name_of(config.answers.methods.method),
                        config.every_sample
                            ? std::string("every sample")
                            : fmt::format("the newest sample if at most {:g} ms old", 1e3 * config.max_age));
  }
  catch (const std::exception&)
  {
    line += ", settings that this torquectl cannot read";
  }
  return line;
}

std::string state_line(const Daemon& daemon)
{
  const status_t& status = daemon.status;
  if (status.state == status_t::STOPPING)
    return fmt::format("ended {} ago, after {}", age(static_cast<std::int64_t>(1e6 * daemon.silent)),
                       duration(status.uptime_us));
  if (!daemon.present())
    return fmt::format("SILENT for {}: stopped, killed, or cut off from this bus",
                       age(static_cast<std::int64_t>(1e6 * daemon.silent)));
  return fmt::format("{}, up {}, {}", state_name(status.state), duration(status.uptime_us),
                     status.input_age_us < 0 ? "no sample yet"
                                             : fmt::format("last sample {} ago", age(status.input_age_us)));
}

std::string daemon_page(const Daemon& daemon)
{
  const status_t& status = daemon.status;
  std::string page =
      fmt::format("{}TORQUED_STATUS: torqued {}, {}\n{}\n{}\n\n", printable(daemon.prefix), printable(status.version),
                  daemon.present() ? fmt::format("instance {}", status.instance_id) : std::string("gone"),
                  robot_line(daemon.model), state_line(daemon));
  const Daemon::Rates rates = daemon.present() ? daemon.rates.value_or(Daemon::Rates{}) : Daemon::Rates{};
  page += fmt::format("  samples       received = {:>12} + {:>12} + {:>12}\n"
                      "  in all    {:>12} = {:>12} + {:>12} + {:>12}\n"
                      "  per second{:>12.1f} = {:>12.1f} + {:>12.1f} + {:>12.1f}\n",
                      "answered", "rejected", "superseded", status.received, status.answered, status.rejected,
                      status.superseded, rates.received, rates.answered, rates.rejected, rates.superseded);
  page += fmt::format("\n  latency, µs   p50 {:.0f}   p90 {:.0f}   p99 {:.0f}   p99.9 {:.0f}   max {:.0f}\n"
                      "  late {}   of another stream {}   log lines dropped {}   last rejection {}\n",
                      status.latency_us_p50, status.latency_us_p90, status.latency_us_p99, status.latency_us_p999,
                      status.latency_us_max, status.late, status.conflicts, status.dropped_logs,
                      status.last_reason == 0 ? "none" : reason_name(status.last_reason));
  if (static_cast<double>(status.received) != static_cast<double>(status.answered) +
                                                  static_cast<double>(status.rejected) +
                                                  static_cast<double>(status.superseded))
    page += "\n  WRONG: the counts do not add up. This is a fault of torqued: please report it.\n";
  return page;
}

} // namespace

std::string state_name(std::int8_t state)
{
  constexpr std::array names{"WAITING", "RUNNING", "STALE", "STOPPING"};
  const auto index = static_cast<std::size_t>(state);
  return state >= 0 && index < names.size() ? names[index] : fmt::format("{}", state);
}

std::string status_page(const std::vector<Daemon>& daemons)
{
  std::string page;
  for (std::size_t i = 0; i < daemons.size(); ++i)
  {
    if (i > 0)
      page += '\n';
    page += daemon_page(daemons[i]);
    const auto same = std::ranges::count_if(daemons, [&](const Daemon& other)
                                            { return other.present() && other.prefix == daemons[i].prefix; });
    const bool last_of_them = i + 1 == daemons.size() || daemons[i + 1].prefix != daemons[i].prefix;
    if (same > 1 && last_of_them)
      page += fmt::format("\nWRONG: {} daemons share these channels: clients get {} answers to each sample. Stop all "
                          "but one, or give them\nanother --prefix.\n",
                          same, same);
  }
  return page;
}

bool Daemon::present() const
{
  return silent < kSilent && status.state != status_t::STOPPING;
}

void DaemonsHeard::hear_status(const std::string& prefix, Bytes message, Clock::time_point now)
{
  status_t status;
  if (!decode(message, status) && !decode_old(message, status))
    return;
  if (heard_.size() == kMostDaemons && heard_.count(status.instance_id) == 0)
    heard_.erase(std::ranges::min_element(heard_, {}, [](const auto& entry) { return entry.second.last; }));
  Heard& heard = heard_[status.instance_id];
  heard.prefix = prefix;
  heard.last = now;
  while (!heard.statuses.empty() && uptime(heard.statuses.front()) < uptime(status) - kRateSpan)
    heard.statuses.pop_front();
  heard.statuses.push_back(std::move(status));
  if (heard.statuses.size() > kMostStatuses)
    heard.statuses.pop_front();
}

void DaemonsHeard::hear_model(Bytes message)
{
  model_info_t model;
  if (!decode(message, model))
    return;
  if (const auto heard = heard_.find(model.instance_id); heard != heard_.end())
    heard->second.model = std::move(model);
}

std::vector<Daemon> DaemonsHeard::at(Clock::time_point now) const
{
  std::vector<Daemon> daemons;
  for (const auto& [instance, heard] : heard_)
    daemons.push_back({heard.prefix, heard.statuses.back(), std::chrono::duration<double>(now - heard.last).count(),
                       rates(heard.statuses.front(), heard.statuses.back()), heard.model});
  // of each prefix those that publish first, then those that ended, the last one first
  std::ranges::stable_sort(daemons, {},
                           [](const Daemon& one)
                           { return std::tuple(std::string_view(one.prefix), one.present() ? -1.0 : one.silent); });
  const auto is_past = [](const Daemon& before, const Daemon& daemon)
  {
    return before.prefix == daemon.prefix && !daemon.present();
  };
  daemons.erase(std::unique(daemons.begin(), daemons.end(), is_past), daemons.end());
  return daemons;
}

void subscribe(Bus& bus, const std::optional<std::string>& prefix, DaemonsHeard& daemons)
{
  const auto subscribe_to = [&bus, prefix](const std::string& name, auto hear)
  {
    bus.subscribe_ending(name,
                         [=](const std::string& channel, Bytes message)
                         {
                           const std::string its_prefix = channel.substr(0, channel.size() - name.size());
                           if (!prefix || its_prefix == *prefix)
                             hear(its_prefix, message);
                         });
  };
  const Channels plain;
  subscribe_to(plain.status, [&daemons](const std::string& its_prefix, Bytes message)
               { daemons.hear_status(its_prefix, message, Bus::Clock::now()); });
  subscribe_to(plain.model, [&daemons](const std::string&, Bytes message) { daemons.hear_model(message); });
}

} // namespace torqued
