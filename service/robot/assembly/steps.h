/// The steps of assemble(): each takes what is known of the robot further, and may complain about a line of the file.
#pragma once

#include "robot/description.h"
#include "robot/files/text_file.h"

#include <cmath>
#include <fmt/format.h>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

[[noreturn]] inline void fail(const RobotDescription& description, int line, const std::string& message)
{
  throw FileError(fmt::format("{}:{}: {}", description.file, line, message));
}

/// entry: of a link, an actuator or a foot.
template <typename Entry>
[[noreturn]] void fail(const RobotDescription& description, const Entry& entry, const std::string& message)
{
  if constexpr (requires { entry.file; })
    if (!entry.file.empty())
      throw FileError(fmt::format("{}:{}: {}", entry.file, entry.line, message));
  fail(description, entry.line, message);
}

/// The index of the link that an entry names as its `role`.
template <typename Entry>
int link_index(const RobotDescription& description, const std::string& name, const Entry& entry, std::string_view role)
{
  for (std::size_t i = 0; i < description.links.size(); ++i)
    if (description.links[i].link.name == name)
      return static_cast<int>(i);
  fail(description, entry, fmt::format("{} \"{}\" is not the name of a link", role, name));
}

inline Eigen::Vector2d unit(double angle)
{
  return {std::cos(angle), std::sin(angle)};
}

/// A point of the mechanism, at r in a link's frame.
Point point_of(const Link& link, const Eigen::Vector2d& r);

/// Links, their directions and the mechanism; no actuators and no feet. links.cpp
Robot assemble_links(const RobotDescription& description);

/// The description's actuators; without any, one for each joint that moves. actuators.cpp
std::vector<RobotDescription::ActuatorEntry> actuator_entries(const Robot& robot, const RobotDescription& description);

/// q_relative = A q_absolute + b
void add_actuators(Robot& robot, const RobotDescription& description,
                   const std::vector<RobotDescription::ActuatorEntry>& entries);

/// What answers need of A and κ: B, B⁺, and the feet's torque shares.
void fold_motors(Robot& robot);

/// Feet, legs and their length. feet.cpp
void add_feet(Robot& robot, const RobotDescription& description);

} // namespace torqued
