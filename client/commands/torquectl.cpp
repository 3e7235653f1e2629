#include "commands/torquectl.h"

#include "commands/subcommands.h"
#include "motion/files.h"
#include "robot/files/load.h"
#include "robot/files/strict_toml.h"
#include "text/printable.h"
#include "wire/lcm_bus.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
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
  CLI::App app{"torquectl works with torqued, the daemon that computes joint torques of a planar biped: it sends "
               "motions, shows and evaluates answers, and describes robots.",
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
    return std::ranges::find_if(subcommands, [](const Subcommand& s) { return s.app->parsed(); });
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

} // namespace torqued
