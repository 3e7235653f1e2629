#include "commands/robot_choice.h"

#include "bus/model_robot.h"
#include "motion/console.h"
#include "motion/failure.h"
#include "motion/lcm_log.h"
#include "motion/table_text.h"
#include "robot/files/load.h"
#include "text/number.h"
#include "text/plain_text.h"
#include "text/printable.h"
#include "wire/codec.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued
{

namespace
{

using Source = NamedRobots::Source;
using Named = NamedRobots::Named;

constexpr std::string_view kRobot = "robot:", kModelId = "model_id:";

std::string how_to_say()
{
  return fmt::format("say --robot NAME|FILE (robots that ship: {})", fmt::join(shipped_robot_names(), ", "));
}

constexpr std::string_view kAround = " \t\r,;"; // a comment's text: spreadsheets append empty cells to its line

// what the comment lines of a CSV say
std::optional<Named> robot_of_csv(std::string_view bytes, const std::string& file)
{
  std::optional<std::string> name;
  std::optional<std::int64_t> model_id;
  const TableText text(bytes, file);
  LineCutter lines = text.lines();
  const auto set = [&](auto& value, const auto& found, std::string_view key)
  {
    if (value && *value != found)
      throw Failure(ExitCode::bad_data, "{}:{}: found \"# {} {}\" after \"# {} {}\"; expected one robot in a file",
                    file, lines.number(), key, printable(fmt::format("{}", found)), key,
                    printable(fmt::format("{}", *value)));
    value = found;
  };
  for (std::string_view line; lines.next(line);)
  {
    line = trimmed(line);
    const std::string_view comment = line.starts_with('#') ? trimmed(line.substr(1), kAround) : "";
    const std::string said(trimmed(comment.substr(std::min(comment.find(':') + 1, comment.size())), kAround));
    if (comment.starts_with(kRobot))
    {
      if (said.empty())
        throw Failure(ExitCode::bad_data, "{}:{}: robot: found nothing; expected its name", file, lines.number());
      set(name, said, kRobot);
    }
    else if (comment.starts_with(kModelId))
    {
      const std::optional<std::int64_t> id = number_in<std::int64_t>(said);
      if (!id)
        throw Failure(ExitCode::bad_data,
                      "{}:{}: model_id: found \"{}\"; expected a whole number, as torquectl model prints it", file,
                      lines.number(), printable(said));
      set(model_id, *id, kModelId);
    }
  }
  if (!name && model_id)
    throw Failure(ExitCode::bad_data,
                  "{}: found a comment line \"# model_id:\" without a line \"# robot: NAME\"; expected both, or none",
                  file);
  return name ? std::optional(Named{*name, model_id}) : std::nullopt;
}

Named named(const model_info_t& model)
{
  return {printable(model.name), model.model_id, model};
}

std::vector<Named> robots_of_log(std::string_view bytes, const Channels& channels)
{
  std::vector<Named> robots;
  LogReader log(bytes);
  while (const auto record = log.next())
  {
    model_info_t model;
    if (record->channel != channels.model || !decode(record->data, model))
      continue;
    if (std::ranges::count(robots, model.model_id, &Named::model_id) == 0)
      robots.push_back(named(model));
  }
  return robots;
}

bool same(const Named& named, const std::string& name, std::int64_t model_id)
{
  return named.model_id ? *named.model_id == model_id : named.name == name;
}

// "ck (model_id 5)"
std::string shown_robot(const std::string& name, std::optional<std::int64_t> model_id)
{
  return model_id ? fmt::format("{} (model_id {})", printable(name), *model_id) : printable(name);
}

std::string shown_robot(const std::vector<Named>& robots)
{
  std::vector<std::string> all;
  for (const Named& robot : robots)
    all.push_back(shown_robot(robot.name, robot.model_id));
  return fmt::format("{}", fmt::join(all, " and "));
}

// "walk.csv names robot ck (model_id 5)"
std::string statement(const NamedRobots& named)
{
  switch (named.source)
  {
  case Source::csv: return fmt::format("{} names robot {}", named.file, shown_robot(named.robots));
  case Source::log: return fmt::format("{} was recorded with robot {}", named.file, shown_robot(named.robots));
  case Source::daemon: break;
  }
  return fmt::format("{} computes {}", named.file, shown_robot(named.robots));
}

// what to do if the robot that a source names is not the one that is wanted
std::string remedy(const NamedRobots& named)
{
  switch (named.source)
  {
  case Source::csv:
    return "use the robot for which the motion was made or, to use the motion with another one, remove the comment "
           "lines \"# robot:\" and \"# model_id:\"";
  case Source::log:
    return fmt::format("use the robot with which it was recorded or, to use its motion with another one, remove the "
                       "comment lines \"# robot:\" and \"# model_id:\" of torquectl export {} -o CSV",
                       named.file);
  case Source::daemon: break;
  }
  return "say the robot that it computes, or start it with the other one";
}

// Names of the same robot that differ in their model_id: its file, or what reads it, has changed.
std::string_view if_changed(const NamedRobots& named, const std::string& name)
{
  const bool same_name = std::ranges::count(named.robots, name, &Named::name) > 0;
  return same_name ? " (the robot has been changed since, or torqued has)" : "";
}

const Named& only_robot(const NamedRobots& named)
{
  if (named.robots.empty())
    throw Failure(ExitCode::bad_data, named.source == Source::log
                                          ? fmt::format("{} holds no model_info_t, which would name its robot: {}",
                                                        named.file, how_to_say())
                                          : fmt::format("{} does not name its robot: {}", named.file, how_to_say()));
  if (named.robots.size() > 1)
    throw Failure(ExitCode::bad_data, "{}: say by --robot which one is meant", statement(named));
  return named.robots.front();
}

bool ships(const std::string& name)
{
  return !shipped_robot_toml(name).empty();
}

// the robot that ships and is the same one; nothing if none is
std::optional<Robot> shipped_robot(const Named& named)
{
  if (!ships(named.name))
    return std::nullopt;
  Robot robot = load_said_robot(named.name);
  return same(named, robot.name, robot.model_id) ? std::optional(std::move(robot)) : std::nullopt;
}

} // namespace

std::string robot_lines(const std::string& name, std::int64_t model_id)
{
  return fmt::format("# {} {}\n# {} {}\n", kRobot, printable(name), kModelId, model_id);
}

NamedRobots robots_named_by(std::string_view bytes, const std::string& file, const Channels& channels)
{
  if (LogReader::is_log(bytes))
    return {Source::log, file, robots_of_log(bytes, channels)};
  NamedRobots named{Source::csv, file};
  if (const std::optional<Named> robot = robot_of_csv(bytes, file))
    named.robots.push_back(*robot);
  return named;
}

NamedRobots robot_named_by(const model_info_t& daemon)
{
  return {Source::daemon, "torqued", {named(daemon)}};
}

SaidRobot said_robot(const std::string& flag, const std::string& config)
{
  return flag.empty() ? SaidRobot{config, "the configuration says"} : SaidRobot{flag, "--robot says"};
}

Robot load_said_robot(const std::string& name_or_path)
{
  Robot robot = load_robot(name_or_path);
  note(robot.notes);
  return robot;
}

Robot require_robot(const std::string& said)
{
  if (said.empty())
    throw Failure(ExitCode::usage, "no robot is said: {}", how_to_say());
  return load_said_robot(said);
}

Robot choose_robot(const SaidRobot& said, const NamedRobots& named)
{
  if (!said.name_or_path.empty())
  {
    Robot robot = load_said_robot(said.name_or_path);
    require_same_robot(named, robot.name, robot.model_id, said.by);
    return robot;
  }
  const Named& only = only_robot(named);
  if (std::optional<Robot> robot = shipped_robot(only))
    return std::move(*robot);
  if (ships(only.name))
    require_same_robot(named, only.name, load_said_robot(only.name).model_id, "the one that ships is");
  throw Failure(ExitCode::bad_data, "{}, which does not ship; its masses are needed here: say --robot FILE",
                statement(named));
}

Robot choose_drawn_robot(const SaidRobot& said, const NamedRobots& named)
{
  if (!said.name_or_path.empty() || named.source == Source::csv)
    return choose_robot(said, named);
  const Named& only = only_robot(named);
  if (std::optional<Robot> robot = shipped_robot(only))
    return std::move(*robot);
  return robot_of_model(only.model.value(), named.file);
}

model_info_t choose_model(const SaidRobot& said, const NamedRobots& log)
{
  return said.name_or_path.empty() ? only_robot(log).model.value() : model_info(choose_robot(said, log), 0, 0, "");
}

void require_same_robot(const NamedRobots& named, const std::string& name, std::int64_t model_id, const std::string& by)
{
  if (named.robots.empty() ||
      std::ranges::any_of(named.robots, [&](const Named& robot) { return same(robot, name, model_id); }))
    return;
  throw Failure(ExitCode::bad_data, "{}, but {} {}{}: {}", statement(named), by, shown_robot(name, model_id),
                if_changed(named, name), remedy(named));
}

} // namespace torqued
