/// What the subcommands that work on a trajectory without a bus have in common.
#pragma once

#include "answer/config.h"
#include "motion/trajectory.h"

#include <optional>
#include <string>
#include <vector>

namespace CLI
{
class App;
}

namespace torqued
{

/// Options as given.
struct OfflineOptions
{
  std::string file, out, robot, config;
  std::optional<std::string> method, prefix;
  Differentiation differentiation;
};

/// Adds FILE, --output, --robot, --prefix, --differentiate and --lowpass. out: what the output is; empty: there is
/// none.
void add_offline_options(CLI::App& subcommand, OfflineOptions& options, const std::string& out);
/// Adds --config and --method, for what depends on how double support is resolved.
void add_answer_options(CLI::App& subcommand, OfflineOptions& options);

/// The options' meaning.
struct OfflineInput
{
  Config config;
  Robot robot;
  DesiredMessages desired;
};

/// Reads configuration, robot and desired states, and tells the user what to know about them. Throws Failure;
/// FileError.
OfflineInput read_offline_input(const OfflineOptions& options);

/// Desired states, checked as the daemon checks them; all of them. Throws Failure, bad_data, with the place of the
/// first that cannot be used.
std::vector<DesiredState> decode_all(const Robot& robot, const DesiredMessages& desired);

} // namespace torqued
