/// What the subcommands that work on a trajectory without a bus have in common.
#pragma once

#include "answer/config.h"
#include "motion/trajectory.h"
#include "study/tally.h"

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

/// Says how many desired states were answered. Throws Failure, bad_data, if none was.
void print_answered(const OfflineOptions& options, const Robot& robot, const DesiredMessages& desired,
                    const Tally& tally);

/// The columns of a motion that a subcommand makes: utime, absolute coordinates, the base point if it is given,
/// support.
std::vector<std::string> motion_columns(const Robot& robot, bool base_given);
/// The cells of a desired state, in absolute coordinates.
std::vector<std::string> motion_cells(const Robot& robot, const DesiredState& state, bool base_given);

/// Desired states, checked as the daemon checks them; all of them. Throws Failure, bad_data, with the place of the
/// first that cannot be used.
std::vector<DesiredState> decode_all(const Robot& robot, const DesiredMessages& desired);

/// Throws Failure, bad_data, unless the base point is given in all desired states, or in none.
void require_one_base(const Origin& origin, const std::vector<DesiredState>& states);

} // namespace torqued
