/// Robots written in TOML.
#pragma once

#include "robot/robot.h"

#include <string>
#include <string_view>

namespace torqued
{

/// Reads a robot from TOML text; file is the name used in complaints. Throws FileError.
///
/// With the key `urdf`, the path of a URDF as seen from the file's folder, links and joints are those of the URDF. A
/// [[link]] then names one of them and may add a coordinate's name, the base point's names and a drawing.
Robot read_toml_robot(std::string_view text, const std::string& file);

} // namespace torqued
