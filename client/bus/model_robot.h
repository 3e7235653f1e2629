/// The robot that a daemon's model message describes.
#pragma once

#include "robot/robot.h"
#include "wire/messages.h"

#include <string>

namespace torqued
{

/// The robot as far as the message goes, which is all that kinematics, contacts and drawings need: its links, feet,
/// coordinates, actuators' names and limits, its weight, and its model_id.
///
/// A model message has no masses, rotors and friction: the whole mass is at the origin of the root, and no motion can
/// be answered with this robot. kappa is NaN for an actuator of a rolling joint, since the message does not say between
/// which bodies it acts.
///
/// where: what holds the message, for complaints. Throws Failure, bad_data, if it describes no robot.
Robot robot_of_model(const model_info_t& model, const std::string& where);

} // namespace torqued
