#include "bus/bus.h"

#include "motion/console.h"
#include "motion/failure.h"
#include "text/printable.h"
#include "wire/bus_url.h"

#include <fmt/format.h>
#include <utility>

namespace torqued
{

namespace
{

constexpr const char* kGivenBy = "--lcm-url";

volatile sig_atomic_t stop_signal = 0;

// Lets SIGINT and SIGTERM through only while wait() waits, in this thread and in those that LCM starts: so none is
// missed between a look at stopped() and the next wait.
sigset_t hold_back_stop_signals()
{
  struct sigaction action
  {
  };
  action.sa_handler = [](int signal)
  {
    stop_signal = signal;
  };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);

  sigset_t stop_signals;
  sigset_t mask_before;
  sigemptyset(&stop_signals);
  sigaddset(&stop_signals, SIGINT);
  sigaddset(&stop_signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &stop_signals, &mask_before);
  sigdelset(&mask_before, SIGINT);
  sigdelset(&mask_before, SIGTERM);
  return mask_before;
}

// A log may be listened to.
const std::string& require_heard_bus(const std::string& url)
{
  const ChosenBus bus = choose_bus(url, kGivenBy);
  const bool is_log = fault_of(bus).empty() && read_bus_url(bus.url).provider == BusUrl::Provider::file;
  if (const std::string fault = is_log ? "" : fault_between_processes(bus); !fault.empty())
    throw BusError("the LCM bus cannot be opened: " + fault);
  return url;
}

} // namespace

Bus::Bus(const std::string& url) : mask_while_waiting_(hold_back_stop_signals()), lcm_(require_heard_bus(url), kGivenBy)
{
}

bool Bus::stopped() const
{
  return stop_signal != 0;
}

void Bus::hear_model(const std::string& channel, Bytes bytes)
{
  model_info_t model;
  const bool readable = decode(bytes, model);
  const std::string flaw = readable ? flaw_of(model) : "it cannot be read as model_info_t";
  if (flaw.empty())
  {
    model_ = std::move(model);
    return;
  }
  if (!flaw_told_)
    note(fmt::format("a message on {}{} is passed over, as are others like it: {}", printable(channel),
                     readable ? fmt::format(", named \"{}\",", printable(model.name)) : "", flaw));
  flaw_told_ = true;
}

bool Bus::wait_for_model(const Channels& channels)
{
  subscribe(channels.model, [this, channel = channels.model](Bytes bytes) { hear_model(channel, bytes); });
  const auto wait_until = [this](Clock::time_point deadline)
  {
    while (!model_ && !stopped() && Clock::now() < deadline)
      wait(deadline);
  };
  const auto start = Clock::now();
  wait_until(start + std::chrono::seconds(1));
  if (!model_ && !stopped())
    note(fmt::format("waiting for torqued to say on {} which robot it computes", channels.model));
  wait_until(start + kModelPatience);
  if (!model_ && !stopped())
    throw Failure(ExitCode::no_bus,
                  "no daemon has said on {} within {} s which robot it computes; is torqued running on this bus and "
                  "network, with the same --prefix? torquectl doctor looks for what is wrong. Here {}",
                  channels.model, kModelPatience.count(), lcm_.trouble());
  return !stopped();
}

} // namespace torqued
