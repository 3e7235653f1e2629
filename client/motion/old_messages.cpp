#include "motion/old_messages.h"

#include "wire/cursor.h"

#include <array>
#include <bit>
#include <endian.h>
#include <limits>

namespace torqued
{

namespace
{

constexpr std::uint64_t kOldCommand = 0x9ef6fb0910ac29c2, kOldStatus = 0x4bdd1b87b2ae75dc; // fingerprints
constexpr std::size_t kFingerprint = 8;
// where the old messages lack fields: behind compute_ns; behind dropped_logs
constexpr std::size_t kCommandGap = kFingerprint + 5 * 8 + 1 + 4 + 2 * 5 * 8 + 4 * 8 + 4;
constexpr std::size_t kStatusGap = kFingerprint + 5 * 8 + 1 + 7 * 8;

// Decodes an old message as a present one: under the present fingerprint, with the missing fields in their place.
template <typename Message, std::size_t Size>
bool decode_with(Bytes old, std::uint64_t fingerprint, std::size_t gap, const std::array<std::byte, Size>& fields,
                 Message& message)
{
  Cursor cursor(old);
  if (static_cast<std::uint64_t>(cursor.int64()) != fingerprint || old.size() < gap)
    return false;
  const auto present =
      std::bit_cast<std::array<std::byte, kFingerprint>>(htobe64(static_cast<std::uint64_t>(Message::getHash())));
  std::vector<std::byte> bytes(present.begin(), present.end());
  const Bytes before = old.subspan(kFingerprint, gap - kFingerprint), after = old.subspan(gap);
  bytes.insert(bytes.end(), before.begin(), before.end());
  bytes.insert(bytes.end(), fields.begin(), fields.end());
  bytes.insert(bytes.end(), after.begin(), after.end());
  return decode(bytes, message);
}

} // namespace

bool decode_old(Bytes bytes, torque_command_t& message)
{
  constexpr std::array<std::byte, 3 * 8 + 4> zeros{}; // base_a, adjustment, num_coordinates
  return decode_with(bytes, kOldCommand, kCommandGap, zeros, message);
}

bool decode_old(Bytes bytes, status_t& message)
{
  constexpr auto not_known = std::bit_cast<std::array<std::byte, 8>>(std::int64_t{-1});
  return decode_with(bytes, kOldStatus, kStatusGap, not_known, message);
}

void complete(torque_command_t& command, const desired_state_t& desired)
{
  if (command.num_coordinates != 0)
    return;
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const bool moved = (command.flags & torque_command_t::PROJECTED) != 0;
  const bool base_known = !moved && desired.base == desired_state_t::GIVEN;
  for (std::size_t i = 0; i < 2; ++i)
    command.base_a[i] = base_known ? desired.base_a[i] : unknown;
  command.adjustment = moved ? unknown : 0.0;
  command.num_coordinates = desired.num_coordinates;
  command.a = moved ? std::vector<double>(desired.a.size(), unknown) : desired.a;
}

} // namespace torqued
