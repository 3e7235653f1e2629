/// Options that several subcommands have.
#pragma once

#include "answer/config.h"
#include "wire/messages.h"

#include <initializer_list>
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
/// The channels that --prefix says. Throws Failure, usage.
Channels channels_with(const std::optional<std::string>& prefix);

/// Throws Failure, usage, unless an output is "-" or has a name that ends in one of these: ".csv".
void require_ending(const std::string& out, std::initializer_list<std::string_view> endings);

} // namespace torqued
