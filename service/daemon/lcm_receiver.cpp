#include "daemon/lcm_receiver.h"

#include "wire/lcm_bus.h"

#include <poll.h>

namespace torqued
{

LcmReceiver::~LcmReceiver()
{
  for (const Subscription& subscription : subscriptions_)
    lcm_unsubscribe(bus_.getUnderlyingLCM(), subscription.lcm);
}

// By LCM's C interface: the one for C++ makes a std::string of every channel's name. LCM takes channels for regular
// expressions, so what it hears may be of another one.
bool LcmReceiver::subscribe(const std::string& channel, Handler handler)
{
  Subscription& subscription = subscriptions_.emplace_back(Subscription{channel, std::move(handler), nullptr});
  subscription.lcm = lcm_subscribe(bus_.getUnderlyingLCM(), channel.c_str(), &LcmReceiver::hear, &subscription);
  if (subscription.lcm == nullptr)
  {
    subscriptions_.pop_back();
    return false;
  }
  lcm_subscription_set_queue_capacity(subscription.lcm, LcmBus::kQueue);
  return true;
}

void LcmReceiver::hear(const lcm_recv_buf_t* buffer, const char* channel, void* subscription) noexcept
{
  const auto& [own_channel, handler, lcm] = *static_cast<const Subscription*>(subscription);
  if (channel == own_channel)
    handler(received_bytes(buffer->data, buffer->data_size));
}

// by poll() alone: LCM's handleTimeout() would ask once more, by select()
bool LcmReceiver::take()
{
  pollfd bus{fd(), POLLIN, 0};
  return poll(&bus, 1, 0) > 0 && bus_.handle() == 0;
}

} // namespace torqued
