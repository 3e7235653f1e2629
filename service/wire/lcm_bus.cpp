#include "wire/lcm_bus.h"

#include "wire/bus_url.h"

#include <algorithm>
#include <poll.h>
#include <string_view>
#include <time.h>
#include <utility>

namespace torqued
{

namespace
{

std::string trouble_of(const std::string& url, const std::string& given_by)
{
  if (const std::string fault = fault_of(choose_bus(url, given_by)); !fault.empty())
    throw BusError("the LCM bus cannot be opened: " + fault);
  return bus_trouble(url, given_by);
}

} // namespace

LcmBus::LcmBus(const std::string& url, const std::string& given_by) : trouble_(trouble_of(url, given_by)), lcm_(url)
{
  if (!lcm_.good())
    throw BusError("the LCM bus cannot be opened: " + trouble_);
  // LCM hears itself first; where it does not, a subscription must not be touched
  if (lcm_.getFileno() < 0)
    throw BusError("the LCM bus does not carry messages, not even to this process itself: " + trouble_);
}

void LcmBus::subscribe(const std::string& channel, Handler handler)
{
  subscribe(channel, Subscription{*this, [channel](const std::string& heard) { return heard == channel; },
                                  [handler = std::move(handler)](const std::string&, Bytes message)
                                  {
                                    handler(message);
                                  }});
}

void LcmBus::subscribe_ending(const std::string& ending, std::function<void(const std::string&, Bytes)> handler)
{
  subscribe(".*" + ending, Subscription{*this, [ending](const std::string& heard) { return heard.ends_with(ending); },
                                        std::move(handler)});
}

// LCM takes channel names for regular expressions, so what it hears may be of another one
void LcmBus::subscribe(const std::string& pattern, Subscription subscription)
{
  Subscription& kept = subscriptions_.emplace_back(std::move(subscription));
  lcm_.subscribeFunction(pattern, &Subscription::receive, &kept)->setQueueCapacity(kQueue);
}

void LcmBus::Subscription::receive(const lcm::ReceiveBuffer* buffer, const std::string& channel,
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

void LcmBus::publish(const std::string& channel, Bytes message)
{
  if (lcm_.publish(channel, message.data(), static_cast<unsigned int>(message.size())) != 0)
    throw BusError("the LCM bus takes no message: " + trouble_);
}

bool LcmBus::wait(Clock::time_point deadline, const sigset_t* mask)
{
  const auto left = std::max(deadline - Clock::now(), Clock::duration::zero());
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(left - seconds);
  const timespec timeout{static_cast<time_t>(seconds.count()), static_cast<long>(nanoseconds.count())};
  pollfd fd{lcm_.getFileno(), POLLIN, 0};
  if (ppoll(&fd, 1, &timeout, mask) <= 0)
    return false;
  if (lcm_.handle() != 0)
    throw BusError("the LCM bus cannot be read any more: " + trouble_);
  if (thrown_)
    std::rethrow_exception(std::exchange(thrown_, nullptr));
  return true;
}

} // namespace torqued
