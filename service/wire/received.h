/// A message as LCM hands it over.
#pragma once

#include "wire/codec.h"

#include <cstdint>

namespace torqued
{

/// The bytes of a message. Of a packet that ends within its channel's name LCM 1.3.1 makes a message of nearly 2³²
/// bytes; no message is that long, and there is nothing to be read: no bytes.
inline Bytes received_bytes(const void* data, std::uint32_t size)
{
  constexpr std::uint32_t longest = std::uint32_t{1} << 30;
  return {static_cast<const std::byte*>(data), size <= longest ? size : 0};
}

} // namespace torqued
