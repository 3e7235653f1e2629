/// The desired state that is sent over and over, and what comes back for it.
#pragma once

#include "wire/codec.h"

#include <chrono>
#include <cstring>
#include <endian.h>
#include <vector>

namespace torqued::bench
{

using Clock = std::chrono::steady_clock; // of Linux: CLOCK_MONOTONIC

inline constexpr const char* kRobot = "human-subject01";

/// Where every message of ours has its fingerprint, and those that are sent and answered their utime.
inline constexpr std::size_t kFingerprint = 0, kUtime = 8;

inline std::int64_t number_at(Bytes message, std::size_t offset)
{
  std::uint64_t number = 0;
  if (message.size() >= offset + sizeof number)
    std::memcpy(&number, message.data() + offset, sizeof number);
  return static_cast<std::int64_t>(be64toh(number));
}

/// One step of kRobot on its left sole, which moves as its contact allows. Encoded once: only its utime changes.
class Sample
{
public:
  Sample()
  {
    desired_state_t desired{};
    desired.stream_id = 1;
    desired.left_contact = desired_state_t::SOLE;
    desired.q = {0.0, -0.1, -0.2, 0.3, -0.2, -0.1, 0.05};
    desired.v = {0.0, -0.5, 0.4, 1.2, -0.8, 0.6, 0.1};
    desired.a = {0.0, 1.5, -1.0, 4.0, 2.0, -3.0, 0.5};
    desired.num_coordinates = static_cast<std::int32_t>(desired.q.size());
    encode(desired, bytes_);
  }

  /// The message; utime: µs. The view lives until the next call.
  Bytes at(std::int64_t utime)
  {
    const std::uint64_t number = htobe64(static_cast<std::uint64_t>(utime));
    std::memcpy(bytes_.data() + kUtime, &number, sizeof number);
    return bytes_;
  }

private:
  std::vector<std::byte> bytes_;
};

} // namespace torqued::bench
