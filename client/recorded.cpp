#include "client/recorded.h"

#include "client/lcm_log.h"

namespace torqued
{

RecordedAnswers::RecordedAnswers(std::string_view log, const Channels& channels)
{
  LogReader reader(log);
  while (const auto record = reader.next())
  {
    torque_command_t command;
    rejection_t rejection;
    if (record->channel == channels.command && decode(record->data, command))
      answers_[{command.stream_id, command.utime}].push_back({std::move(command), record->timestamp});
    else if (record->channel == channels.rejected && decode(record->data, rejection))
      answers_[{rejection.stream_id, rejection.utime}].push_back({std::move(rejection), record->timestamp});
  }
}

std::optional<RecordedAnswer> RecordedAnswers::next(const desired_state_t& desired)
{
  const auto found = answers_.find({desired.stream_id, desired.utime});
  if (found == answers_.end() || found->second.empty())
    return std::nullopt;
  RecordedAnswer answer = std::move(found->second.front());
  found->second.pop_front();
  return answer;
}

} // namespace torqued
