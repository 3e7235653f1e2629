/// Between bytes and what they mean: the messages of lcmtypes/, checked before they are decoded.
///
/// The decoders that lcm-gen writes trust a message's counts before its length, so a bad message can make them throw,
/// allocate gigabytes or read past its end. Everything here checks fingerprint, counts and exact size first.
#pragma once

#include "torque/checks.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <torqued/desired_state_t.hpp>
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

/// Who sent a desired state and when, as far as it can be read: 0 where it cannot.
struct Sender
{
  std::int64_t utime = 0, stream_id = 0;
};
Sender read_sender(Bytes message);

/// Whose status this is: its instance_id; 0 if it is no status. Does not allocate.
std::int64_t read_status_instance(Bytes message);

/// Checks and decodes a desired state for this robot.
///
/// Checked in this order: fingerprint, count, exact size, model, every number finite, every field in its range, method.
/// RELATIVE coordinates become ABSOLUTE. Does not allocate and does not throw, whatever the bytes.
/// Refuses: undecodable, wrong_size, wrong_model, not_finite, out_of_range, unknown_method.
Result<DesiredState> decode_desired_state(Bytes message, const Robot& robot);

/// What is published for a desired state that was answered.
struct Answer
{
  std::int64_t utime, stream_id;
  Method method;
  std::int32_t flags;
  std::array<GroundReaction, 2> ground; ///< indexed by Side
  double zmp;                           ///< m
  double dynamics_residual;             ///< N, N m
  double contact_speed;                 ///< m/s, rad/s
  double contact_residual;              ///< m/s², rad/s²
  VectorJ torque;                       ///< N m
};

/// Fills a command; all but sequence and compute_ns, which belong to the loop. Allocates only if command.torque grows.
void fill(torque_command_t& command, const Answer& answer, std::int64_t model_id, std::int64_t settings_id);

/// Fills a rejection. Allocates only if rejection.detail grows.
void fill(rejection_t& rejection, const Sender& sender, const Refusal& refusal);

/// Describes a robot; instance_id and settings are the daemon's.
model_info_t model_info(const Robot& robot, std::int64_t instance_id, std::int64_t settings_id,
                        const std::string& settings);

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

} // namespace torqued
