/// A bad network between two LCM buses of this machine.
#pragma once

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <poll.h>
#include <random>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace torqued
{

/// What happens to packets: shares of them, 0 to 1, and times in ms.
struct NetworkFaults
{
  double loss = 0.0;     ///< do not arrive
  double repeat = 0.0;   ///< arrive once more, up to 2 ms later
  double reorder = 0.0;  ///< are held back for up to 5 ms, while others pass
  double corrupt = 0.0;  ///< one to eight of their bits are changed
  double truncate = 0.0; ///< lose a part of their end
  double delay = 0.0;    ///< each is later by this
  double jitter = 0.0;   ///< and by up to this
  /// So many bytes at the start of each packet are neither changed nor lost: without further ado LCM's magic number, of
  /// which one changed bit makes a fragment, and fragments are read beyond their end.
  std::size_t whole = 4;
};

/// Passes the UDP packets of one multicast port to another. The same seed decides the same about the nth packet.
class Relay
{
public:
  static constexpr const char* kGroup = "239.255.76.67";

  Relay(std::uint16_t from, std::uint16_t to, std::uint64_t seed)
      : in_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)), out_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)),
        to_(address(to)), random_(seed)
  {
    const int yes = 1;
    setsockopt(in_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    const int buffer = 1 << 21;
    setsockopt(in_, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
    const sockaddr_in here = address(from);
    const ip_mreq group{here.sin_addr, {htonl(INADDR_ANY)}};
    const unsigned char ttl = 0;
    if (bind(in_, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0 ||
        setsockopt(in_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0 ||
        setsockopt(out_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0)
      throw std::runtime_error("the relay cannot use this network");
    thread_ = std::thread(&Relay::run, this);
  }
  ~Relay()
  {
    stop_ = true;
    thread_.join();
    close(in_);
    close(out_);
  }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  void set(const NetworkFaults& faults)
  {
    const std::lock_guard lock(mutex_);
    faults_ = faults;
  }

  /// Packets so far.
  int received() const { return received_; }
  int lost() const { return lost_; }
  int repeated() const { return repeated_; }
  int damaged() const { return damaged_; }
  int passed() const { return passed_; }

private:
  using Clock = std::chrono::steady_clock;
  using Packet = std::vector<std::uint8_t>;

  static sockaddr_in address(std::uint16_t port)
  {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_port = htons(port);
    inet_pton(AF_INET, kGroup, &result.sin_addr);
    return result;
  }

  double share() { return std::uniform_real_distribution<double>()(random_); }
  static Clock::duration milliseconds(double number)
  {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::milli>(number));
  }

  void run()
  {
    std::array<std::uint8_t, 65536> buffer;
    while (!stop_)
    {
      pollfd fd{in_, POLLIN, 0};
      if (poll(&fd, 1, waiting_.empty() ? 10 : 0) > 0)
        if (const ssize_t size = recv(in_, buffer.data(), buffer.size(), 0); size > 0)
          decide(Packet(buffer.begin(), buffer.begin() + size));
      while (!waiting_.empty() && waiting_.begin()->first <= Clock::now())
      {
        const Packet& packet = waiting_.begin()->second;
        sendto(out_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
        ++passed_;
        waiting_.erase(waiting_.begin());
      }
      if (!waiting_.empty())
        std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
  }

  void decide(Packet packet)
  {
    ++received_;
    NetworkFaults faults;
    {
      const std::lock_guard lock(mutex_);
      faults = faults_;
    }
    // as many numbers for each packet, whatever happens to it
    std::array<double, 10> dice;
    for (double& number : dice)
      number = share();
    if (dice[0] < faults.loss)
    {
      ++lost_;
      return;
    }
    const Packet before = packet;
    const std::size_t whole = std::min(faults.whole, packet.size() - 1);
    const std::size_t rest = packet.size() - whole;
    if (dice[1] < faults.corrupt)
    {
      std::mt19937_64 bits(static_cast<std::uint64_t>(dice[2] * 1e15));
      for (int count = 1 + static_cast<int>(dice[3] * 8.0); count > 0; --count)
      {
        const std::uint64_t bit = 8 * whole + bits() % (8 * rest);
        packet[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      }
    }
    if (dice[4] < faults.truncate)
      packet.resize(whole + static_cast<std::size_t>(dice[5] * static_cast<double>(rest)));
    damaged_ += packet != before ? 1 : 0;
    const double held_back = dice[6] < faults.reorder ? 5.0 * dice[7] : 0.0;
    const auto due = Clock::now() + milliseconds(faults.delay + faults.jitter * dice[8] + held_back);
    if (dice[9] < faults.repeat)
    {
      ++repeated_;
      waiting_.emplace(due + milliseconds(2.0 * dice[7]), packet);
    }
    waiting_.emplace(due, std::move(packet));
  }

  const int in_, out_;
  const sockaddr_in to_;
  std::mt19937_64 random_;
  std::multimap<Clock::time_point, Packet> waiting_;
  std::mutex mutex_;
  NetworkFaults faults_;
  std::atomic<bool> stop_{false};
  std::atomic<int> received_{0}, lost_{0}, repeated_{0}, damaged_{0}, passed_{0};
  std::thread thread_;
};

} // namespace torqued
