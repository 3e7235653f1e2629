#include "motion/trajectory.h"

#include "motion/csv_trajectory.h"
#include "motion/failure.h"
#include "motion/files.h"
#include "motion/lcm_log.h"
#include "text/printable.h"

#include <fmt/format.h>
#include <functional>
#include <set>
#include <string_view>
#include <utility>

namespace torqued
{

namespace
{

[[noreturn]] void fail_without_states(std::string_view bytes, const Origin& origin, const Channels& channels)
{
  std::set<std::string, std::less<>> heard;
  LogReader log(bytes);
  while (const auto record = log.next())
    heard.emplace(record->channel);
  throw Failure(ExitCode::bad_data,
                "{}: found no desired state on channel {} of this LCM log ({} undecodable there); it holds {}; "
                "--prefix names another channel",
                origin.file, channels.desired, origin.undecodable, listed(heard, 8));
}

// the desired states of a log, which all are whole; they lie in its bytes
std::vector<Bytes> find_messages(std::string_view bytes, const std::string& file, const Differentiation& how,
                                 const Channels& channels, Origin& origin)
{
  std::vector<Bytes> messages;
  origin.file = file;
  origin.from_log = true;
  if (how.wanted)
    origin.assumptions.emplace_back(
        "a log's desired states have their derivatives, which are taken; --differentiate and --lowpass are for CSV");
  LogReader log(bytes);
  if (log.cut() > 0)
    origin.assumptions.push_back(
        fmt::format("begins in the middle of a record; its first {} bytes were passed over", log.cut()));
  while (const auto record = log.next())
  {
    if (record->channel != channels.desired)
      continue;
    if (is_desired_state(record->data))
    {
      messages.push_back(record->data);
      origin.places.push_back(static_cast<std::size_t>(record->number));
      origin.heard.push_back(record->timestamp);
    }
    else
    {
      ++origin.undecodable;
    }
  }
  origin.damaged_bytes = log.skipped() - log.cut();
  if (messages.empty())
    fail_without_states(bytes, origin, channels);
  return messages;
}

} // namespace

CoordinateNames coordinate_names(const Robot& robot)
{
  return coordinate_names(model_info(robot, 0, 0, ""));
}

CoordinateNames coordinate_names(const model_info_t& model)
{
  CoordinateNames names{model.absolute_names, model.relative_names, {model.base_names[0], model.base_names[1]}, {}};
  std::vector<bool> slides(model.absolute_names.size());
  for (std::size_t i = 0; i < model.joint_kinds.size(); ++i)
    if (const auto at = static_cast<std::size_t>(model.link_coordinates[i]),
        kind = static_cast<std::size_t>(model.joint_kinds[i]);
        kind < kJointTypes.size() && kJointTypes[kind].slides() && at < slides.size())
      slides[at] = true;
  for (std::size_t i = 0; i < slides.size(); ++i)
  {
    if (slides[i])
      names.displacements.insert(model.absolute_names[i]);
    bool displacement = true; // a sum of displacements only: q_relative = A q_absolute + b
    for (std::size_t j = 0; j < slides.size(); ++j)
      displacement = displacement && (slides[j] || model.A[i][j] == 0.0);
    if (displacement)
      names.displacements.insert(model.relative_names[i]);
  }
  return names;
}

std::string Origin::place(std::size_t state) const
{
  return from_log ? fmt::format("{}: record {}", file, places[state]) : fmt::format("{}:{}", file, places[state]);
}

Trajectory parse_trajectory(std::string_view bytes, const std::string& file, const CoordinateNames& names,
                            const Differentiation& how, const Channels& channels)
{
  if (!LogReader::is_log(bytes))
    return parse_csv_trajectory(bytes, file, names, how);
  Trajectory trajectory;
  for (const Bytes message : find_messages(bytes, file, how, channels, trajectory))
    decode(message, trajectory.states.emplace_back());
  return trajectory;
}

DesiredMessages read_messages(const std::shared_ptr<const InputFile>& input, const std::string& file,
                              const CoordinateNames& names, const Differentiation& how, const Channels& channels)
{
  if (!LogReader::is_log(input->bytes()))
    return encode_all(parse_csv_trajectory(input->bytes(), file, names, how));
  DesiredMessages desired;
  desired.messages = find_messages(input->bytes(), file, how, channels, desired);
  desired.owner = input;
  return desired;
}

DesiredMessages encode_all(const Trajectory& trajectory)
{
  const auto buffers = std::make_shared<std::vector<std::vector<std::byte>>>(trajectory.states.size());
  DesiredMessages desired{trajectory, {}, buffers};
  for (std::size_t i = 0; i < trajectory.states.size(); ++i)
    desired.messages.push_back(encode(trajectory.states[i], (*buffers)[i]));
  return desired;
}

std::vector<std::string> notes(const Origin& origin)
{
  std::vector<std::string> lines;
  for (const std::string& assumption : origin.assumptions)
    lines.push_back(fmt::format("{}: {}", origin.file, assumption));
  if (origin.damaged_bytes > 0)
    lines.push_back(fmt::format("{}: {} bytes belong to no whole record of the log; they were passed over", origin.file,
                                origin.damaged_bytes));
  if (origin.undecodable > 0)
    lines.push_back(fmt::format("{}: {} messages cannot be decoded as desired states; they were passed over",
                                origin.file, origin.undecodable));
  return lines;
}

} // namespace torqued
