/// Where a robot is as it walks, also if its desired states do not say it.
#pragma once

#include "stance/contacts.h"

#include <array>
#include <optional>

namespace torqued
{

/// Places one sample of a motion after another in the world.
///
/// A given base is where it is. One that follows FROM_CONTACT starts with its resting point at x = 0, and goes on so
/// that a foot which keeps contact from one sample to the next keeps its foothold: while it rolls from heel over sole
/// to toe it stays in one place.
class WorldPath
{
public:
  /// Requires: the robot outlives this.
  explicit WorldPath(const Robot& robot) : robot_(&robot) {}

  /// The robot at the next sample; nothing where its contacts cannot be (complete_motion() refuses).
  std::optional<Kinematics> next(const DesiredState& desired);

private:
  const Robot* robot_;
  double offset_ = 0.0;                              // of the base's x where it follows from contact, m
  std::array<std::optional<double>, 2> footholds_{}; // of the feet in contact at the sample before, world x, m
};

} // namespace torqued
