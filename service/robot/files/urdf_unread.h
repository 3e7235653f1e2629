/// What stands in a URDF and is not read: motors' numbers, which a TOML file says, and vendors' words.
#pragma once

#include "robot/description.h"

#include <optional>
#include <string>
#include <string_view>
#include <tinyxml2.h>
#include <vector>

namespace torqued
{

/// What an element about a joint's motor or springs says, attribute by attribute: <dynamics>, <limit>,
/// <safety_controller>, and vendors' elements of that kind. What is 0 says nothing; nor do limits of an angle or a
/// rate, which change no torque, nor an effort that is negative or 10⁹ and more, as exporters write for "none".
std::vector<UnreadValue> unread_values(const tinyxml2::XMLElement& element);

/// A <transmission>: its joints, and what it says of gears and rotors. What it says of each of several joints is said
/// of all.
struct Transmission
{
  std::vector<std::string> joints;
  std::vector<UnreadValue> values;
  int line = 0;
};
/// All of a robot, those in <ros2_control> among them.
std::vector<Transmission> transmissions_of(const tinyxml2::XMLElement& robot);

/// "FILE:LINE: joint 'left_hip': <dynamics damping=2 friction=1> and <limit effort=50> are not read: set viscous,
/// coulomb, torque_limit in the TOML"
std::string note_of(const RobotDescription::UnreadEntry& entry);

/// "FILE: angle and torque of 'left_hip', 'right_hip' have the opposite sign of the URDF's: …", of the joints whose
/// actuator turns the same link against the same; empty if there is none.
std::string note_of_signs(const RobotDescription& description);

/// Why an element or attribute that URDF does not have may not be passed over: its name speaks of mechanics, or is that
/// of an element of URDF with a slip of the pen. Nothing if it may.
std::optional<std::string> mechanics_in(std::string_view name);
/// The same, of what a simulator's element, <gazebo> or <mujoco>, adds to the robot.
std::optional<std::string> mechanics_in(const tinyxml2::XMLElement& simulator);

/// What an element of a simulator or a vendor says that might be mechanics, as a note names it: "<springStiffness>",
/// "<compiler settotalmass=60>". None if it draws, senses or holds plugins alone.
std::vector<std::string> unread_parts(const tinyxml2::XMLElement& element);

/// Whether a <gazebo> takes gravity from a link by this child.
bool takes_gravity(const tinyxml2::XMLElement& child);

} // namespace torqued
