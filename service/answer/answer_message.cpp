#include "answer/answer_message.h"

#include "answer/command.h"

namespace torqued
{

bool answer_message(const Robot& robot, const AnswerSettings& settings, std::int64_t settings_id, Bytes message,
                    StreamMemory& memory, Reply& reply)
{
  const auto reject = [&](const Refusal& refusal)
  {
    fill(reply.rejection, read_sender(message), refusal);
    return false;
  };

  // every field checked, in ABSOLUTE coordinates
  const Result<DesiredState> desired = decode_desired_state(message, robot);
  if (const Refusal* refusal = std::get_if<Refusal>(&desired))
    return reject(*refusal);

  // equations of its support, a method's reactions, torques, checks, limits
  const Result<Answer> answered = answer(robot, settings, std::get<DesiredState>(desired), memory);
  if (const Refusal* refusal = std::get_if<Refusal>(&answered))
    return reject(*refusal);

  fill(reply.command, std::get<Answer>(answered), robot.model_id, settings_id);
  return true;
}

} // namespace torqued
