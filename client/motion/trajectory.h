/// Desired motions as files: tables of comma-separated values, or recorded LCM traffic.
///
/// CSV: the first line that is not a comment (#) names the columns, which may stand in any order.
///
///   time | utime          s, rounded to µs | µs; strictly increasing. With both, utime counts, and time must say the
///                         same to 1 µs, but for a constant
///   q0, dq0, ddq0, …      each coordinate by its name, rad, with its first and second derivative: all absolute names,
///                         or all relative ones; absolute if both are complete
///   xH, zH, dxH, …        the base point by its names, m, with derivatives: all six, and the base is GIVEN; or none,
///   and
///                         it follows FROM_CONTACT
///   (with --differentiate: the positions alone; a cell may be empty, nan or NA)
///   contactL, contactR    0, 1, 2, 3, or none, heel, sole, toe
///   leading               L or R                                      may be missing: see follow_contacts()
///   load_transfer, phase  0 to 1                                      may be missing: see follow_contacts()
///   method                a method's name or number; default or none  may be missing, or empty: default
///
/// Further columns are not looked at. Numbers have a decimal point in every locale. Other ways of writing the same
/// table are read where they are unambiguous, and Origin::assumptions says so: encodings, separators, decimal commas
/// and OpenSim's header (TableText); names in another case, names in a comment, other units (read_column_names()).
/// Comment lines may name the robot, robot_choice.h.
#pragma once

#include "motion/differentiation.h"
#include "motion/files.h"
#include "robot/robot.h"
#include "wire/codec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// The names of a robot's coordinates.
struct CoordinateNames
{
  std::vector<std::string> absolute, relative;
  std::array<std::string, 2> base;          ///< empty if the base point does not move
  std::set<std::string> displacements = {}; ///< those that are in m, of slides; all others are angles
};
CoordinateNames coordinate_names(const Robot& robot);
CoordinateNames coordinate_names(const model_info_t& model);

/// Where the states of a desired motion come from.
struct Origin
{
  std::string file;
  std::vector<std::size_t> places; ///< of each state: its line in the CSV, from 1, or its record in the log, from 0
  bool from_log = false;
  std::vector<std::int64_t> heard; ///< of each state of a log: when the logger heard it, µs by its clock
  std::vector<double> seconds;     ///< of each state of a CSV with a column time: its time, s, not rounded

  std::size_t undecodable = 0;   ///< messages of the log that are no desired states
  std::size_t damaged_bytes = 0; ///< of the log, in no whole record

  std::vector<std::string> assumptions; ///< on how the file is meant, where it does not say; a sentence each

  /// "walk.csv:17" or "walk.lcm: record 16".
  std::string place(std::size_t state) const;
};

/// A desired motion.
struct Trajectory : Origin
{
  std::vector<desired_state_t> states;
};

/// A desired motion as the daemon would hear it: bytes. Those of a log are not decoded.
struct DesiredMessages : Origin
{
  std::vector<Bytes> messages;       ///< one or more
  std::shared_ptr<const void> owner; ///< of their bytes
};

/// Reads a trajectory from a file's bytes, unpacked. Whether they are a CSV or a log follows from them, not from the
/// file's name, which is used in complaints only.
///
/// CSV: stream_id is 1 and model_id 0. Derivative columns are taken if all are there; with `how.wanted`, none is:
/// derivatives are those that differentiate() finds. Units that the numbers do not look like are among the assumptions.
/// Log: the desired states on their channel as they are, in the log's order; names and how do not matter.
///
/// Throws Failure, bad_data: "FILE:LINE: column NAME: found …; expected …".
Trajectory parse_trajectory(std::string_view bytes, const std::string& file, const CoordinateNames& names,
                            const Differentiation& how, const Channels& channels);

/// The same, without decoding what was recorded. Throws as parse_trajectory() does.
DesiredMessages read_messages(const std::shared_ptr<const InputFile>& input, const std::string& file,
                              const CoordinateNames& names, const Differentiation& how, const Channels& channels);

/// A trajectory's states as messages.
DesiredMessages encode_all(const Trajectory& trajectory);

/// What a user should know about a file before its desired states are used: assumptions; damage of a log, undecodable
/// messages. One line each.
std::vector<std::string> notes(const Origin& origin);

} // namespace torqued
