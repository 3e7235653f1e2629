/// Robots by name or path.
#pragma once

#include "robot/robot.h"

#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// The robots that ship: names, and a shipped robot's TOML; empty if there is none of that name.
std::vector<std::string_view> shipped_robot_names();
std::string_view shipped_robot_toml(std::string_view name);

/// Loads a robot that ships, by its name, or a .toml or .urdf file, by its path. Throws FileError.
Robot load_robot(const std::string& name_or_path);

} // namespace torqued
