/// The subcommands of torquectl.
#pragma once

#include "motion/failure.h"

#include <functional>
#include <memory>
#include <vector>

namespace CLI
{
class App;
}

namespace torqued
{

/// A subcommand that has been added to the app: its options are parsed into what `run` works on.
struct Subcommand
{
  template <typename Options>
  Subcommand(CLI::App* added, std::shared_ptr<Options> options, ExitCode (*work)(const Options&))
      : app(added), run([=] { return work(*options); })
  {
  }

  CLI::App* app;
  std::function<ExitCode()> run; ///< throws Failure; FileError for a robot or a configuration; BusError
};

/// All subcommands, in the order in which --help lists them.
std::vector<Subcommand> add_subcommands(CLI::App& torquectl);

} // namespace torqued
