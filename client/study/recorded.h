/// The answers that a log holds.
#pragma once

#include "answer/command.h"
#include "wire/codec.h"

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace torqued
{

/// Throws Failure, bad_data, unless a command is one of this robot: as many accelerations as coordinates, and torques
/// as joints. where: of its desired state, for complaints.
void require_fit(const torque_command_t& command, int num_coordinates, int num_joints, const std::string& robot,
                 const std::string& where);

/// One answer, and when the logger heard it, µs by its clock.
struct RecordedAnswer
{
  std::variant<torque_command_t, rejection_t> message;
  std::int64_t timestamp;
};

/// A log's commands for one robot, and its rejections, by stream_id and utime of the desired state that they answer.
/// Commands may be old ones, old_messages.h.
class RecordedAnswers
{
public:
  /// file: the log's name. model_id: of the robot.
  RecordedAnswers(std::string_view log, const std::string& file, const Channels& channels, std::int64_t model_id);

  bool empty() const { return answers_.empty(); }
  /// What a user should know: commands for another robot, which are passed over. One line each.
  const std::vector<std::string>& notes() const { return notes_; }
  /// Takes the next answer to this desired state, in the log's order: one that was repeated has several.
  std::optional<RecordedAnswer> next(const desired_state_t& desired);

private:
  std::map<std::pair<std::int64_t, std::int64_t>, std::deque<RecordedAnswer>> answers_;
  std::vector<std::string> notes_;
};

} // namespace torqued
