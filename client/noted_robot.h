/// A robot that the user names.
#pragma once

#include "robot/robot.h"

#include <string>

namespace torqued
{

/// load_robot(), and a note for each thing that the user should know about how the file was read. Throws FileError.
Robot load_noted_robot(const std::string& name_or_path);

} // namespace torqued
