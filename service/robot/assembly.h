/// From a description to a robot.
#pragma once

#include "robot/description.h"

namespace torqued
{

/// Builds a robot; its notes are the description's, one for each unread entry, and one of all opposite signs. Throws
/// FileError (text_file.h) with file, line and what would be right.
///
/// Its leg length is the distance from the base point to the ankle of the straight robot (all angles 0), the longer
/// leg's; with a fixed root, or without feet, the longest way along the links from the base point to a centre of mass,
/// or 1 m if there is none.
Robot assemble(const RobotDescription& description);

} // namespace torqued
