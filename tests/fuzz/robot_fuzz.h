/// What the readers of robot files promise of any input: a robot that can be computed with, or a FileError.
#pragma once

#include "robot/robot.h"

namespace torqued
{

/// Ends the process with a word on stderr if the robot's dynamics at rest are not finite, or if the robot as TOML does
/// not read back as the same robot.
void check_usable(const Robot& robot);

} // namespace torqued
