/// LCM's format for short messages over UDP: magic, sequence number, channel and its zero, message.
#pragma once

#include "wire/messages.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace torqued
{

inline constexpr std::uint32_t kPacketMagic = 0x4c433032; // "LC02", in network order as is the number
inline constexpr std::size_t kPacketHeader = 8;           // bytes before the channel

/// What a packet carries; both lie in its bytes.
struct Packet
{
  std::string_view channel;
  Bytes message;
};

/// Nothing for bytes that are no short message.
inline std::optional<Packet> read_packet(Bytes bytes)
{
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t zero = text.find('\0', kPacketHeader);
  if (!text.starts_with("LC02") || zero == std::string_view::npos)
    return std::nullopt;
  return Packet{text.substr(kPacketHeader, zero - kPacketHeader), bytes.subspan(zero + 1)};
}

/// The bytes of a short message.
inline std::vector<std::byte> make_packet(std::uint32_t sequence, std::string_view channel, Bytes message)
{
  std::vector<std::byte> bytes;
  bytes.reserve(kPacketHeader + channel.size() + 1 + message.size());
  for (const std::uint32_t number : {kPacketMagic, sequence})
    for (const int shift : {24, 16, 8, 0})
      bytes.push_back(static_cast<std::byte>(number >> shift));
  const auto name = std::as_bytes(std::span(channel));
  bytes.insert(bytes.end(), name.begin(), name.end());
  bytes.push_back(std::byte{0});
  bytes.insert(bytes.end(), message.begin(), message.end());
  return bytes;
}

} // namespace torqued
