#include "commands/options.h"

#include "methods/method_settings.h"
#include "motion/differentiation.h"
#include "motion/failure.h"
#include "robot/files/load.h"
#include "text/number.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <stdexcept>
#include <vector>

namespace torqued
{

void add_robot_option(CLI::App& subcommand, std::string& robot, const std::string& without)
{
  subcommand
      .add_option("--robot", robot,
                  fmt::format("a robot that ships ({}) or a .toml or .urdf file; {}",
                              fmt::join(shipped_robot_names(), ", "), without))
      ->type_name("NAME|FILE");
}

void add_method_option(CLI::App& subcommand, std::optional<std::string>& method, const std::string& what)
{
  subcommand.add_option("--method", method, fmt::format("{}: {}", what, method_names()))->type_name("NAME");
}

void add_prefix_option(CLI::App& subcommand, std::optional<std::string>& prefix)
{
  subcommand.add_option("--prefix", prefix, "stands before each channel's name")->type_name("TEXT");
}

void add_differentiation_options(CLI::App& subcommand, Differentiation& differentiation)
{
  CLI::Option* wanted =
      subcommand.add_flag("--differentiate", differentiation.wanted,
                          "find the derivatives by a quintic spline through the samples, six or more; CSV only");
  subcommand
      .add_option("--lowpass", differentiation.lowpass,
                  "before that, low-pass all coordinates: Butterworth, second order, forward and backward (no lag); HZ "
                  "is the cut-off of one pass, 6 to 10 for measured walks")
      ->type_name("HZ")
      ->check(check_positive)
      ->needs(wanted);
}

void add_bus_option(CLI::App& subcommand, std::string& lcm_url)
{
  subcommand.add_option("--lcm-url", lcm_url, "the bus; default: LCM_DEFAULT_URL, or LCM's own default")
      ->type_name("URL");
}

std::string check_positive(const std::string& text)
{
  const double number = number_in<double>(text).value_or(NAN);
  return number > 0.0 && std::isfinite(number) ? "" : fmt::format("found \"{}\"; expected a positive number", text);
}

std::string check_time(const std::string& text)
{
  const double number = number_in<double>(text).value_or(NAN);
  return number >= 0.0 && std::isfinite(number) ? ""
                                                : fmt::format("found \"{}\"; expected a time in s, 0 or more", text);
}

void set_flag(std::string_view flag, void (*set)(Config&, const std::string&), Config& config,
              const std::optional<std::string>& value)
{
  if (!value)
    return;
  try
  {
    set(config, *value);
  }
  catch (const std::invalid_argument& error)
  {
    throw Failure(ExitCode::usage, "{}: {}", flag, error.what());
  }
}

Channels channels_with(const std::optional<std::string>& prefix)
{
  Config config;
  set_flag("--prefix", set_prefix, config, prefix);
  return Channels(config.prefix);
}

void require_ending(const std::string& out, std::initializer_list<std::string_view> endings)
{
  if (out != "-" && std::ranges::none_of(endings, [&out](std::string_view ending) { return out.ends_with(ending); }))
    throw Failure(ExitCode::usage, "-o: found \"{}\"; expected a name that ends in {}, or -", out,
                  fmt::join(endings, " or "));
}

} // namespace torqued
