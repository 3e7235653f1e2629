/// The messages of lcmtypes/ as what they are: bytes on channels. Knows nothing of robots.
///
/// The decoders that lcm-gen writes trust a message's counts before its length, so a bad message can make them throw,
/// allocate gigabytes or read past its end. Everything here checks fingerprint, counts and exact size first.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <torqued/desired_state_t.hpp>
#include <torqued/dynamics_t.hpp>
#include <torqued/model_info_t.hpp>
#include <torqued/rejection_t.hpp>
#include <torqued/status_t.hpp>
#include <torqued/torque_command_t.hpp>

namespace torqued
{

using Bytes = std::span<const std::byte>;

/// The channels, with the prefix that stands before each.
struct Channels
{
  explicit Channels(const std::string& prefix = "")
      : desired(prefix + "TORQUED_DESIRED"), command(prefix + "TORQUED_COMMAND"), rejected(prefix + "TORQUED_REJECTED"),
        status(prefix + "TORQUED_STATUS"), model(prefix + "TORQUED_MODEL"),
        dynamics_request(prefix + "TORQUED_DYNAMICS_REQUEST"), dynamics(prefix + "TORQUED_DYNAMICS")
  {
  }
  std::string desired, command, rejected, status, model, dynamics_request, dynamics;
};

/// Encodes a message into a buffer that is kept between calls: it grows, and never shrinks. The view lives until the
/// next call with the same buffer.
template <typename Message> Bytes encode(const Message& message, std::vector<std::byte>& buffer)
{
  const auto size = static_cast<std::size_t>(message.getEncodedSize());
  if (buffer.size() < size)
    buffer.resize(size);
  message.encode(buffer.data(), 0, static_cast<int>(size));
  return Bytes(buffer.data(), size);
}

/// Decode what the daemon, or a client, publishes. false: not this type, or cut, or extended, or a count out of
/// bounds; the message is then unchanged. For clients: allocate.
bool decode(Bytes bytes, desired_state_t& message);
bool decode(Bytes bytes, torque_command_t& message);
bool decode(Bytes bytes, rejection_t& message);
bool decode(Bytes bytes, status_t& message);
bool decode(Bytes bytes, model_info_t& message);

/// Whether decode() makes a desired_state_t of these bytes. Does not allocate.
bool is_desired_state(Bytes bytes);

/// What keeps a decoded model message from being a robot's, in words: "gravity is nan"; empty if nothing does. Looks at
/// what clients go by: name, coordinates and joints, A and b, gravity, mass, limits.
std::string flaw_of(const model_info_t& model);

/// A time of the monotonic clock as utime says it, µs.
inline std::int64_t microseconds(std::chrono::steady_clock::time_point time)
{
  return std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
}

/// A stream_id or instance_id: random, 1 or more.
std::int64_t random_id();

/// A message as LCM hands it over. Of a packet that ends within its channel's name LCM 1.3.1 makes a message of nearly
/// 2³² bytes; no message is that long, and there is nothing to be read: no bytes.
inline Bytes received_bytes(const void* data, std::uint32_t size)
{
  constexpr std::uint32_t longest = std::uint32_t{1} << 30;
  return {static_cast<const std::byte*>(data), size <= longest ? size : 0};
}

} // namespace torqued
