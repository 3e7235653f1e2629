/// What is heard by LCM's library: any kind of bus that it knows.
#pragma once

#include "daemon/receiver.h"

#include <lcm/lcm-cpp.hpp>

#include <cstddef>
#include <list>

namespace torqued
{

class LcmReceiver : public Receiver
{
public:
  /// The bus must outlive the receiver.
  explicit LcmReceiver(lcm::LCM& bus) : bus_(bus) {}
  ~LcmReceiver() override;

  bool subscribe(const std::string& channel, Handler handler) override;
  int fd() override { return bus_.getFileno(); }
  bool holds() const override { return false; }
  bool take() override;
  std::int64_t most_lost() const override { return -1; }

private:
  struct Subscription
  {
    std::string channel;
    Handler handler;
    lcm_subscription_t* lcm;
  };
  static void hear(const lcm_recv_buf_t* buffer, const char* channel, void* subscription) noexcept;

  lcm::LCM& bus_;
  std::list<Subscription> subscriptions_; // LCM keeps their addresses
};

} // namespace torqued
