/// What a user must know about an answer: centres of pressure, and whether feet and motors can do what it asks.
#pragma once

#include "stance/support_equations.h"

#include <array>
#include <cmath>
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

/// What the ground does to a foot; ground on robot, world frame.
struct GroundReaction
{
  Wrench wrench;               ///< N, N m about the ankle
  double cop = 0.0;            ///< m, along the sole from below the ankle, forward positive; 0 without load
  double friction_ratio = 0.0; ///< |fx| / fz; 0 without load
};

/// A foot's force (f_x', f_z') in the foot's frame.
inline Eigen::Vector2d in_foot(const FootPose& pose, const Wrench& wrench)
{
  return {pose.e.x() * wrench.fx + pose.e.y() * wrench.fz, pose.e.x() * wrench.fz - pose.e.y() * wrench.fx};
}

/// Centre of pressure and friction of a foot.
///
/// The centre of pressure is where the force's line of action meets the line of the sole; with (f_x', f_z') the force
/// in the foot's frame, x_c = (M − h_p f_x') / f_z'.
inline GroundReaction ground_reaction(const Robot& robot, const Foot& foot, const FootPose& pose, const Wrench& wrench)
{
  const double no_load = kNoLoad * robot.weight();
  const bool loaded = std::abs(wrench.fz) >= no_load;
  const Eigen::Vector2d f = in_foot(pose, wrench);
  const double cop = loaded && std::abs(f.y()) >= no_load ? (wrench.moment - foot.ankle_height() * f.x()) / f.y() : 0.0;
  return {{wrench.fx, wrench.fz, wrench.moment}, cop, loaded ? std::abs(wrench.fx) / wrench.fz : 0.0};
}

/// Whether a foot in contact slips (|fx| > μ fz), lifts (fz < 0) or tips: flag bits.
///
/// A sole tips when the moment about the line of the sole is more than the pressure from heel to toe can give:
/// M − h_p f_x' must lie between x_heel f_z' and x_toe f_z', in the foot's frame; so a moment without load tips, too. A
/// fixed root without extent does not tip. Slack, for rounding: kNoLoad × weight on forces, and that × the sole's
/// length on the moment.
std::int32_t contact_flags(const Robot& robot, const Foot& foot, const FootPose& pose, Contact contact,
                           const Wrench& wrench);

/// World x of the total zero-moment point on the ground z = 0, m; 0 without load.
double zero_moment_point(const Robot& robot, const SupportEquations& equations);

} // namespace torqued
