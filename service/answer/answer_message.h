/// The whole service but for bus and clock: from the bytes of a desired state to what is published for it.
#pragma once

#include "answer/answer.h"
#include "wire/codec.h"

namespace torqued
{

/// What is published for one desired state: a command, or a rejection. To be used again, so that nothing is allocated.
struct Reply
{
  torque_command_t command{};
  rejection_t rejection{};
};

/// Whether it was answered, so that reply.command is filled, all but sequence and compute_ns; else reply.rejection is.
/// memory: of the answers before; settings_id: that of the settings. Refuses what decode_desired_state() and answer()
/// refuse.
bool answer_message(const Robot& robot, const AnswerSettings& settings, std::int64_t settings_id, Bytes message,
                    StreamMemory& memory, Reply& reply);

} // namespace torqued
