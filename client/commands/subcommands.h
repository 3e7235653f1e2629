/// The subcommands of torquectl.
#pragma once

#include "answer/config.h"
#include "motion/console.h"
#include "motion/failure.h"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI
{
class App;
}

namespace torqued
{

struct Differentiation;

/// A subcommand that has been added to the app: its options are parsed into what `run` works on.
struct Subcommand
{
  CLI::App* app;
  std::function<ExitCode()> run; ///< throws Failure; FileError for a robot or a configuration; BusError
};

/// All subcommands, in the order in which --help lists them.
std::vector<Subcommand> add_subcommands(CLI::App& torquectl);

/// What happens without --robot where a motion is read.
inline constexpr const char* kRobotOfFile = "default: the one that the file names";
/// Adds an option --robot that says which robots ship, and what happens without it.
void add_robot_option(CLI::App& subcommand, std::string& robot, const std::string& without);
/// Adds an option --method that says which methods there are.
void add_method_option(CLI::App& subcommand, std::optional<std::string>& method, const std::string& what);
/// Adds an option --prefix.
void add_prefix_option(CLI::App& subcommand, std::optional<std::string>& prefix);
/// Adds options --differentiate and --lowpass.
void add_differentiation_options(CLI::App& subcommand, Differentiation& differentiation);
/// Adds an option --lcm-url.
void add_bus_option(CLI::App& subcommand, std::string& lcm_url);

/// Checks of an option's text: empty if it is a positive number, or a time in s from 0; else the complaint.
std::string check_positive(const std::string& text);
std::string check_time(const std::string& text);

/// Sets what a flag says; nothing if it was not given. Throws Failure, usage.
void set_flag(std::string_view flag, void (*set)(Config&, const std::string&), Config& config,
              const std::optional<std::string>& value);

} // namespace torqued
