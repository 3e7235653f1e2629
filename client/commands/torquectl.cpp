#include "commands/torquectl.h"

#include "commands/subcommands.h"
#include "motion/differentiation.h"
#include "motion/files.h"
#include "robot/files/strict_toml.h"
#include "text/printable.h"
#include "wire/lcm_bus.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <new>
#include <stdexcept>
#include <vector>

#ifndef TORQUED_VERSION
#error "TORQUED_VERSION comes from the build"
#endif

namespace torqued
{

namespace
{

int complain(ExitCode code, std::string_view message)
{
  std::fflush(stdout);
  fmt::print(stderr, "torquectl: {}\n", printable_line(message));
  return static_cast<int>(code);
}

int parse_and_run(int argc, const char* const* argv)
{
  CLI::App app{
      "torquectl works with torqued, the daemon that computes joint torques of a planar biped: it sends motions, "
      "shows and evaluates answers, and describes robots.",
      "torquectl"};
  app.set_version_flag("--version", "torquectl " TORQUED_VERSION);
  app.require_subcommand(1);
  app.footer("Each subcommand has its own --help, with an example. A first look, without daemon or bus:\n"
             "  torquectl model --robot human-subject01\n\n"
             "Exit codes: 0 done, 64 wrong usage, 65 bad input data, 69 no bus, 78 bad configuration or robot,\n"
             "1 anything else.");
  const std::vector<Subcommand> subcommands = add_subcommands(app);
  const auto chosen = [&]
  {
    return std::find_if(subcommands.begin(), subcommands.end(), [](const Subcommand& s) { return s.app->parsed(); });
  };
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::ParseError& error)
  {
    if (error.get_exit_code() == 0)
      return app.exit(error);
    if (chosen() != subcommands.end())
      return complain(ExitCode::usage, fmt::format("{}; torquectl {} --help says what is right", error.what(),
                                                   chosen()->app->get_name()));
    const std::string what = app.remaining().empty() ? std::string("a subcommand is required")
                                                     : fmt::format("\"{}\" is not known here", app.remaining().front());
    return complain(ExitCode::usage, what + "; torquectl --help lists what there is");
  }
  const ExitCode code = chosen()->run();
  OutputFile("-").flush();
  return static_cast<int>(code);
}

} // namespace

int torquectl(int argc, const char* const* argv)
try
{
  return parse_and_run(argc, argv);
}
catch (const Failure& failure)
{
  return complain(failure.code(), failure.what());
}
catch (const BusError& error)
{
  return complain(ExitCode::no_bus, error.what());
}
catch (const FileError& error)
{
  return complain(ExitCode::bad_configuration, error.what());
}
catch (const std::bad_alloc&)
{
  return complain(ExitCode::failed, "there is not enough memory for this");
}
catch (const std::exception& error)
{
  return complain(ExitCode::failed, fmt::format("an unexpected error ended the program: {}", error.what()));
}

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

namespace
{

// the number that a whole text is; NaN if it is none
double finite_number(const std::string& text)
{
  double number = 0.0;
  const char* end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data(), end, number);
  return read == end && error == std::errc() && std::isfinite(number) ? number : NAN;
}

} // namespace

std::string check_positive(const std::string& text)
{
  return finite_number(text) > 0.0 ? "" : fmt::format("found \"{}\"; expected a positive number", text);
}

std::string check_time(const std::string& text)
{
  return finite_number(text) >= 0.0 ? "" : fmt::format("found \"{}\"; expected a time in s, 0 or more", text);
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
    throw Failure(ExitCode::usage, fmt::format("{}: {}", flag, error.what()));
  }
}

} // namespace torqued
