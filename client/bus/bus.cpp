#include "bus/bus.h"

#include "motion/console.h"
#include "motion/failure.h"
#include "text/printable.h"
#include "wire/bus_url.h"

#include <algorithm>
#include <fmt/format.h>
#include <poll.h>
#include <time.h>
#include <utility>

namespace torqued
{

namespace
{

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

// What to say when the bus does not work. A log may be listened to.
std::string judge(const std::string& url)
{
  const ChosenBus bus = choose_bus(url, "--lcm-url");
  const bool is_log = fault_of(bus).empty() && read_bus_url(bus.url).provider == BusUrl::Provider::file;
  if (const std::string fault = is_log ? "" : fault_between_processes(bus); !fault.empty())
    throw Failure(ExitCode::no_bus, fmt::format("the LCM bus cannot be opened: {}", fault));
  return bus_trouble(url, "--lcm-url");
}

} // namespace

Bus::Bus(const std::string& url) : mask_while_waiting_(hold_back_stop_signals()), trouble_(judge(url)), lcm_(url)
{
  if (!lcm_.good())
    throw Failure(ExitCode::no_bus, fmt::format("the LCM bus cannot be opened: {}", trouble_));
}

void Bus::subscribe(const std::string& channel, Handler handler)
{
  subscribe(channel, Subscription{*this, [channel](const std::string& heard) { return heard == channel; },
                                  [handler = std::move(handler)](const std::string&, Bytes message)
                                  {
                                    handler(message);
                                  }});
}

void Bus::subscribe_ending(const std::string& ending, std::function<void(const std::string&, Bytes)> handler)
{
  subscribe(".*" + ending, Subscription{*this, [ending](const std::string& heard) { return heard.ends_with(ending); },
                                        std::move(handler)});
}

// LCM takes channel names for regular expressions, so what it hears may be of another one
void Bus::subscribe(const std::string& pattern, Subscription subscription)
{
  // LCM hears itself first; where it does not, its subscription must not be touched
  if (lcm_.getFileno() < 0)
    throw Failure(ExitCode::no_bus, fmt::format("the LCM bus does not carry messages, not even to this process itself: "
                                                "{}",
                                                trouble_));
  constexpr int queue = 10'000;
  Subscription& kept = subscriptions_.emplace_back(std::move(subscription));
  lcm_.subscribeFunction(pattern, &Subscription::receive, &kept)->setQueueCapacity(queue);
}

void Bus::Subscription::receive(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                                Subscription* subscription) noexcept
try
{
  if (subscription->is_meant(channel))
    subscription->handler(channel, received_bytes(buffer->data, buffer->data_size));
}
catch (...)
{
  // nothing may leave a handler: LCM would abort the process at its next call
  subscription->bus.thrown_ = std::current_exception();
}

void Bus::publish(const std::string& channel, Bytes message)
{
  if (lcm_.publish(channel, message.data(), static_cast<unsigned int>(message.size())) != 0)
    throw Failure(ExitCode::no_bus, fmt::format("the LCM bus takes no message: {}", trouble_));
}

void Bus::wait(Clock::time_point deadline)
{
  const auto left = std::max(deadline - Clock::now(), Clock::duration::zero());
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(left - seconds);
  const timespec timeout{static_cast<time_t>(seconds.count()), static_cast<long>(nanoseconds.count())};
  pollfd fd{lcm_.getFileno(), POLLIN, 0};
  if (ppoll(&fd, 1, &timeout, &mask_while_waiting_) <= 0)
    return;
  if (lcm_.handle() != 0)
    throw Failure(ExitCode::no_bus, fmt::format("the LCM bus cannot be read any more: {}", trouble_));
  if (thrown_)
    std::rethrow_exception(std::exchange(thrown_, nullptr));
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
    throw Failure(
        ExitCode::no_bus,
        fmt::format("no daemon has said on {} within {} s which robot it computes; is torqued running on this "
                    "bus and network, with the same --prefix? Here {}",
                    channels.model, kModelPatience.count(), trouble_));
  return !stopped();
}

} // namespace torqued
