/// The subcommands of torquectl.
#pragma once

#include "client/failure.h"
#include "daemon/config.h"

#include <functional>
#include <optional>
#include <string>
#include <string_view>

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
  std::function<ExitCode()> run; ///< throws Failure; FileError for a robot or a configuration
};

Subcommand add_send(CLI::App& torquectl);
Subcommand add_echo(CLI::App& torquectl);
Subcommand add_eval(CLI::App& torquectl);
Subcommand add_compare(CLI::App& torquectl);
Subcommand add_dynamics(CLI::App& torquectl);
Subcommand add_wrenches(CLI::App& torquectl);
Subcommand add_gait(CLI::App& torquectl);
Subcommand add_project(CLI::App& torquectl);
Subcommand add_export(CLI::App& torquectl);
Subcommand add_report(CLI::App& torquectl);
Subcommand add_view(CLI::App& torquectl);
Subcommand add_model(CLI::App& torquectl);
Subcommand add_status(CLI::App& torquectl);
Subcommand add_doctor(CLI::App& torquectl);

/// What happens without --robot where a motion is read.
inline constexpr const char* kRobotOfFile = "default: the one that the file names";
/// Adds an option --robot that says which robots ship, and what happens without it.
void add_robot_option(CLI::App& subcommand, std::string& robot, const std::string& without);
/// The methods' names, one after another.
std::string method_names();
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

/// Tells the user, in one line on stderr, something that does not end the program.
void note(std::string_view line);

/// Prints what a subcommand says at its end: on stdout, or on stderr if its output, "-", goes to stdout.
void print_summary(const std::string& output, std::string_view text);

} // namespace torqued
