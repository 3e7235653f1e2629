/// A client that sends more than it should.
#pragma once

#include "daemon_bench.h"

#include <atomic>
#include <thread>

namespace torqued
{

/// Another client, which publishes the same bytes so many times a second, or as often as this machine can; those of a
/// sample have the time of their sending.
class Flood
{
public:
  Flood(std::vector<std::byte> bytes, std::int64_t rate)
      : bytes_(std::move(bytes)), rate_(rate), thread_(&Flood::run, this)
  {
  }
  ~Flood()
  {
    ends_ = true;
    thread_.join();
  }
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;

  std::int64_t sent() const { return sent_; }

private:
  void run()
  {
    lcm::LCM bus;
    const auto begin = Bench::Clock::now();
    for (; !ends_; ++sent_)
    {
      if (sent_ % 50 == 0)
        std::this_thread::sleep_until(begin + std::chrono::microseconds(1'000'000 * sent_ / rate_));
      const auto utime = static_cast<std::uint64_t>(Bench::now());
      for (std::size_t i = 0; i < 8; ++i)
        bytes_[8 + i] = static_cast<std::byte>(utime >> (56 - 8 * i));
      bus.publish("TORQUED_DESIRED", bytes_.data(), static_cast<unsigned>(bytes_.size()));
    }
  }

  std::vector<std::byte> bytes_;
  std::int64_t rate_;
  std::atomic<bool> ends_ = false;
  std::atomic<std::int64_t> sent_ = 0;
  std::thread thread_;
};

/// Where a client has sent nothing for nearly so long, the daemon may rightly follow another one.
constexpr std::chrono::milliseconds kSilence{80};

} // namespace torqued
