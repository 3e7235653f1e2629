/// Finiteness by bit pattern, which no compiler option can take away.
#pragma once

#include <bit>
#include <cstdint>

namespace torqued
{

inline bool is_finite(double x)
{
  constexpr std::uint64_t exponent = 0x7ff0'0000'0000'0000;
  return (std::bit_cast<std::uint64_t>(x) & exponent) != exponent;
}

} // namespace torqued
