/// What an answer says of itself in one number.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

namespace torqued
{

/// The bits of torque_command_t.flags.
namespace flag
{
inline constexpr std::int32_t slips = 1;
inline constexpr std::int32_t lifts = 2;
inline constexpr std::int32_t tips = 4;
inline constexpr std::int32_t over_torque = 8;
inline constexpr std::int32_t clamped = 16;
inline constexpr std::int32_t relaxed = 32;
inline constexpr std::int32_t inconsistent = 64;
inline constexpr std::int32_t late = 128;
inline constexpr std::int32_t over_rate = 256;
inline constexpr std::int32_t projected = 512;
inline constexpr std::int32_t adjusted = 1024;
inline constexpr std::int32_t contact_acceleration = 2048;
inline constexpr std::int32_t prior = 4096;
} // namespace flag

/// Their names, as torque_command_t spells them.
inline constexpr std::array<std::pair<std::int32_t, std::string_view>, 13> kFlagNames{
    {{flag::slips, "SLIPS"},
     {flag::lifts, "LIFTS"},
     {flag::tips, "TIPS"},
     {flag::over_torque, "OVER_TORQUE"},
     {flag::clamped, "CLAMPED"},
     {flag::relaxed, "RELAXED"},
     {flag::inconsistent, "INCONSISTENT"},
     {flag::late, "LATE"},
     {flag::over_rate, "OVER_RATE"},
     {flag::projected, "PROJECTED"},
     {flag::adjusted, "ADJUSTED"},
     {flag::contact_acceleration, "CONTACT_ACCELERATION"},
     {flag::prior, "PRIOR"}}};

} // namespace torqued
