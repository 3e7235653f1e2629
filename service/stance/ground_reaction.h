/// What the ground does to a foot, and where.
#pragma once

namespace torqued
{

/// The wrench (N, N m) of the ground on one foot: force, and moment about the ankle.
struct Wrench
{
  double fx = 0.0, fz = 0.0, moment = 0.0;
};

/// What the ground does to a foot; ground on robot, world frame.
struct GroundReaction
{
  Wrench wrench;               ///< N, N m about the ankle
  double cop = 0.0;            ///< m, along the sole from below the ankle, forward positive; 0 without load
  double friction_ratio = 0.0; ///< |fx| / fz; 0 without load
};

} // namespace torqued
