/// What is heard by a socket of our own: LCM's messages by UDP multicast, which LCM's library takes no part in.
///
/// That library receives in a thread of its own, keeps every channel's name that it ever saw, and puts fragments
/// together without a look at their bounds. No message that the daemon hears is fragmented, so this looks at short
/// messages alone.
#pragma once

#include "daemon/receiver.h"
#include "wire/bus_url.h"

#include <cstddef>
#include <memory>
#include <vector>

struct sock_filter;

namespace torqued
{

/// The system filters for it: only short messages of LCM's on subscribed channels wake the process, and, on a bus whose
/// ttl is 0, only those of this machine. What was sent to this machine's own address is not heard.
class MulticastReceiver : public Receiver
{
public:
  /// Throws std::system_error if the system gives no socket, or does not let it join the bus's group.
  explicit MulticastReceiver(const BusUrl& url);
  ~MulticastReceiver() override;

  bool subscribe(const std::string& channel, Handler handler) override;
  int fd() override { return fd_; }
  bool holds() const override { return next_ < read_; }
  bool take() override;
  /// But for messages that come in fragments of IP of less than 24 bytes, whose losses may go uncounted.
  std::int64_t most_lost() const override { return most_lost_; }

private:
  struct Subscription
  {
    std::string channel;
    Handler handler;
  };
  struct Batch; // datagrams that one system call brings

  bool read_batch();
  void count_lost(std::uint32_t lost);
  void hand_over(Bytes datagram) const;
  std::vector<sock_filter> filter() const;

  int fd_;
  bool only_this_machine_;
  std::vector<Subscription> subscriptions_;
  std::unique_ptr<Batch> batch_;
  std::size_t next_ = 0, read_ = 0;
  std::int64_t room_ = 0;    // bytes of the socket's buffer that are there for certain
  std::int64_t waiting_ = 0; // at most so many were in use at once since none was
  bool may_have_lost_ = false;
  std::uint32_t lost_ = 0; // the system's count, which has all that its filter refuses, too
  std::int64_t most_lost_ = 0;
};

} // namespace torqued
