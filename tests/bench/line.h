/// A client of one server: sends samples, and hears what comes back.
#pragma once

#include "bench/packets.h"
#include "bench/sample.h"

#include <algorithm>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <poll.h>
#include <stdexcept>

namespace torqued::bench
{

class Line
{
public:
  /// fingerprint: of the messages that are replies.
  explicit Line(std::uint64_t fingerprint) : fingerprint_(static_cast<std::int64_t>(fingerprint)) {}
  virtual ~Line() = default;

  virtual void send(Bytes sample) = 0;
  /// A message of the server's; nothing if none comes until then. The view lives until the next call.
  virtual std::optional<Bytes> hear(Clock::time_point until) = 0;

  /// Sends a sample and waits for its reply. false: none came until then.
  bool ask(std::int64_t utime, Clock::time_point until)
  {
    send(sample_.at(utime));
    while (const auto reply = hear(until))
      if (is_reply(*reply) && number_at(*reply, kUtime) == utime)
        return true;
    return false;
  }

  /// Asks once a millisecond until there is a reply. name: of the server, for the complaint. Throws std::runtime_error
  /// if it is silent for ten seconds.
  void reach(const std::string& name)
  {
    for (const auto until = Clock::now() + std::chrono::seconds(10); Clock::now() < until;)
    {
      send(sample_.at(microseconds(Clock::now())));
      const auto reply = hear(Clock::now() + std::chrono::milliseconds(1));
      if (reply && is_reply(*reply))
        return;
    }
    throw std::runtime_error(name + " does not answer");
  }

  bool is_reply(Bytes message) const { return number_at(message, kFingerprint) == fingerprint_; }

  static timespec time_left(Clock::time_point until)
  {
    const auto left = std::max<std::int64_t>(std::chrono::nanoseconds(until - Clock::now()).count(), 0);
    return {left / 1'000'000'000, left % 1'000'000'000};
  }

protected:
  Sample sample_;

private:
  std::int64_t fingerprint_;
};

/// Over LCM: torqued's client, and the echo's.
class LcmLine : public Line
{
public:
  /// Throws std::runtime_error if there is no such bus.
  LcmLine(const std::string& bus, std::uint64_t fingerprint) : Line(fingerprint), bus_(bus)
  {
    if (!bus_.good())
      throw std::runtime_error("no LCM bus at " + bus);
    bus_.subscribeFunction(channels_.command, &LcmLine::take, this)->setQueueCapacity(10'000);
  }

  void send(Bytes sample) override
  {
    bus_.publish(channels_.desired, sample.data(), static_cast<unsigned>(sample.size()));
  }

  std::optional<Bytes> hear(Clock::time_point until) override
  {
    pollfd fd{bus_.getFileno(), POLLIN, 0};
    const timespec left = time_left(until);
    if (ppoll(&fd, 1, &left, nullptr) <= 0)
      return {};
    bus_.handle();
    return heard_;
  }

private:
  static void take(const lcm::ReceiveBuffer* buffer, const std::string&, LcmLine* line)
  {
    const Bytes bytes = received_bytes(buffer->data, buffer->data_size);
    line->heard_.assign(bytes.begin(), bytes.end());
  }

  const Channels channels_;
  lcm::LCM bus_;
  std::vector<std::byte> heard_;
};

/// Over bare sockets, in packets of the same size.
class UdpLine : public Line
{
public:
  UdpLine(int hears, int sends_to) : Line(desired_state_t::getHash()), packets_(hears, sends_to) {}

  void send(Bytes sample) override { packets_.publish(channels_.desired, sample); }

  std::optional<Bytes> hear(Clock::time_point until) override
  {
    pollfd fd{packets_.fd(), POLLIN, 0};
    const timespec left = time_left(until);
    if (ppoll(&fd, 1, &left, nullptr) <= 0)
      return {};
    return Packets::message_of(packets_.receive());
  }

private:
  const Channels channels_;
  Packets packets_;
};

} // namespace torqued::bench
