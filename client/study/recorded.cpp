#include "study/recorded.h"

#include "motion/failure.h"
#include "motion/lcm_log.h"
#include "motion/old_messages.h"

#include <fmt/format.h>

namespace torqued
{

void require_fit(const torque_command_t& command, int num_coordinates, int num_joints, const std::string& robot,
                 const std::string& where)
{
  if (command.num_coordinates != num_coordinates || command.num_joints != num_joints)
    throw Failure(ExitCode::bad_data,
                  "{}: was answered with {} accelerations and {} torques; expected {} and {}, those of {}", where,
                  command.num_coordinates, command.num_joints, num_coordinates, num_joints, robot);
}

RecordedAnswers::RecordedAnswers(std::string_view log, const std::string& file, const Channels& channels,
                                 std::int64_t model_id)
{
  std::map<std::int64_t, std::int64_t> strangers; // commands by their model_id
  LogReader reader(log);
  while (const auto record = reader.next())
  {
    torque_command_t command;
    rejection_t rejection;
    if (record->channel == channels.command && (decode(record->data, command) || decode_old(record->data, command)))
    {
      if (command.model_id == model_id)
        answers_[{command.stream_id, command.utime}].push_back({std::move(command), record->timestamp});
      else
        ++strangers[command.model_id];
    }
    else if (record->channel == channels.rejected && decode(record->data, rejection))
      answers_[{rejection.stream_id, rejection.utime}].push_back({std::move(rejection), record->timestamp});
  }
  for (const auto& [stranger, count] : strangers)
    notes_.push_back(fmt::format("{}: {} commands are for another robot (model_id {}, not {}) and are left out", file,
                                 count, stranger, model_id));
}

std::optional<RecordedAnswer> RecordedAnswers::next(const desired_state_t& desired)
{
  const auto found = answers_.find({desired.stream_id, desired.utime});
  if (found == answers_.end() || found->second.empty())
    return std::nullopt;
  RecordedAnswer answer = std::move(found->second.front());
  found->second.pop_front();
  if (auto* command = std::get_if<torque_command_t>(&answer.message))
    complete(*command, desired);
  return answer;
}

} // namespace torqued
