/// The daemon's configuration: a TOML file, flags over it, one checked struct.
#pragma once

#include "answer/settings.h"

#include <optional>
#include <string>
#include <vector>

namespace torqued
{

/// How the system treats the one thread that answers.
struct Scheduling
{
  enum class Policy
  {
    other, ///< as the process is started
    fifo,
    rr
  };
  Policy policy = Policy::other;
  std::optional<double> priority; ///< 1 to 99, whole; with fifo and rr alone
  std::string cpus;               ///< as processors() reads them; empty: all
};

/// Everything that can be set. Keys of the file carry the members' names, those of `answers` too, except for the
/// methods: `method` names the default one, and a table named after a method, [linear_transition], sets it.
struct Config
{
  std::string robot;                      ///< a robot that ships, or a file's path; empty: none is said
  std::string lcm_url;                    ///< empty: LCM's own default, which heeds LCM_DEFAULT_URL
  std::string lcm_url_set_by = "lcm_url"; ///< who sets it, for complaints: "lcm_url in FILE"
  std::string prefix;                     ///< stands before each channel's name
  bool every_sample = false;              ///< answer all samples in order instead of the newest
  double max_age = 0.020;                 ///< s
  double deadline = 0.001;                ///< s, arrival to publish
  std::string log_level = "info";
  bool lock_memory = false; ///< all of it stays in memory
  AnswerSettings answers;
  Scheduling scheduling;
};

/// Reads a configuration file, or its text; file: the name used in complaints. Unknown keys, wrong types and values out
/// of range are refused. Throws FileError.
Config read_config(const std::string& path);
Config read_config(std::string_view text, const std::string& file);

/// Set the default method by its name, the prefix, the log level. Throw std::invalid_argument with what would be right.
void set_method(Config& config, const std::string& name);
void set_prefix(Config& config, const std::string& prefix);
void set_log_level(Config& config, const std::string& level);

/// The processors of a list as taskset writes it: "2", "2,3", "2-5,8"; none of "". Throws std::invalid_argument.
std::vector<int> processors(const std::string& list);
std::string_view name_of(Scheduling::Policy policy);

/// Whether the settings fit the robot: weights need a row for each motor. Throws FileError.
void check_fits(const Config& config, const Robot& robot);

/// The whole configuration as TOML; read_config() of it gives it back.
std::string to_toml(Config config);

} // namespace torqued
