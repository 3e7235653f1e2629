/// Which robot a motion is of. It is said, or the file of the motion names it; it is never guessed.
///
/// Every CSV that is written for a robot names it in two comment lines below its header:
///
///   # robot: ck
///   # model_id: -1234567890123456789
///
/// An LCM log names its robot by the daemon's model message. A CSV made by hand may name a robot without its model_id.
#pragma once

#include "robot/robot.h"
#include "wire/messages.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// The two lines, each with its end.
std::string robot_lines(const std::string& name, std::int64_t model_id);

/// The robots that a motion's source names.
struct NamedRobots
{
  enum class Source
  {
    csv,
    log,
    daemon
  };
  struct Named
  {
    std::string name;
    std::optional<std::int64_t> model_id = {};
    std::optional<model_info_t> model = {}; ///< of a log or a daemon
  };

  Source source;
  std::string file; ///< used in complaints
  /// Each once, in the order of the file; of a CSV one at most, of a log several if its daemons differ.
  std::vector<Named> robots = {};
};

/// Reads them from a file's bytes. Throws Failure, bad_data, for comment lines that contradict one another.
NamedRobots robots_named_by(std::string_view bytes, const std::string& file, const Channels& channels);
NamedRobots robot_named_by(const model_info_t& daemon);

/// A robot that the user says; none if the name is empty.
struct SaidRobot
{
  std::string name_or_path;
  std::string by; ///< for complaints: "--robot says"
};
/// flag, config: what --robot and the configuration say; the flag wins.
SaidRobot said_robot(const std::string& flag, const std::string& config = "");

/// Loads a robot that ships or a file, and tells the user its notes. Throws FileError.
Robot load_said_robot(const std::string& name_or_path);
/// The same of a subcommand that reads no motion. Throws Failure, usage, if none is said.
Robot require_robot(const std::string& said);

/// The robot of a motion: the one that is said, or else the one that the file names, if it ships.
///
/// Throws FileError; Failure, bad_data, if neither names one, if they do not name the same one (same_robot()), or if
/// the file's has no file here.
Robot choose_robot(const SaidRobot& said, const NamedRobots& named);

/// The same for drawing: if none is said, the robot of a log or a daemon need not ship. It then comes from the model
/// message, without masses (robot_of_model()).
Robot choose_drawn_robot(const SaidRobot& said, const NamedRobots& named);

/// The same for tables of a log: the log's own model message if none is said.
model_info_t choose_model(const SaidRobot& said, const NamedRobots& log);

/// Refuses a motion that names another robot than this one: another model_id or, where that is missing, another name.
/// Throws Failure, bad_data. by: who names this one: "--robot says", "torqued computes".
void require_same_robot(const NamedRobots& named, const std::string& name, std::int64_t model_id,
                        const std::string& by);

} // namespace torqued
