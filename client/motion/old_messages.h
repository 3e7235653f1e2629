/// Messages as logs hold them that were recorded when their types had fewer fields.
#pragma once

#include "wire/messages.h"

namespace torqued
{

/// Decodes a torque_command_t without base_a, adjustment, num_coordinates and a, or a status_t without
/// dropped_upper_bound. false: not that type, or cut, or extended, or a count out of bounds; the message is then
/// unchanged.
///
/// What such a command does not say follows from its desired state: until complete() its num_coordinates is 0, which no
/// robot's is. Such a status has dropped_upper_bound −1, not known.
bool decode_old(Bytes bytes, torque_command_t& message);
bool decode_old(Bytes bytes, status_t& message);

/// Gives a command that decode_old() read, and no other, the accelerations that its desired state asked for, and
/// adjustment 0. NaN where they are not known: all of a PROJECTED motion; base_a where the base was not GIVEN.
void complete(torque_command_t& command, const desired_state_t& desired);

} // namespace torqued
