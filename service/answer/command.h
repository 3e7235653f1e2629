/// Answers as messages.
#pragma once

#include "answer/answer.h"
#include "wire/command_fields.h"

namespace torqued
{

/// Fills a command; all but sequence and compute_ns, which belong to who publishes it. Allocates only if command.a or
/// command.torque grows.
void fill(torque_command_t& command, const Answer& answer, std::int64_t model_id, std::int64_t settings_id);

/// A command as the daemon had it.
Answer to_answer(const torque_command_t& command);

} // namespace torqued
