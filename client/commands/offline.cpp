#include "commands/offline.h"

#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/files.h"

#include <CLI/CLI.hpp>

#include <fmt/format.h>
#include <memory>

namespace torqued
{

void add_offline_options(CLI::App& subcommand, OfflineOptions& options, const std::string& out)
{
  subcommand.add_option("FILE", options.file, "a trajectory CSV, or an LCM log of desired states")
      ->type_name("")
      ->required();
  if (!out.empty())
    subcommand.add_option("-o,--output", options.out, out)->type_name("OUT")->required();
  add_robot_option(subcommand, options.robot, kRobotOfFile);
  add_prefix_option(subcommand, options.prefix);
  add_differentiation_options(subcommand, options.differentiation);
}

void add_answer_options(CLI::App& subcommand, OfflineOptions& options)
{
  subcommand.add_option("--config", options.config, "the daemon's configuration file; flags win")->type_name("FILE");
  add_method_option(subcommand, options.method, "how double support is resolved where a desired state does not say");
}

OfflineInput read_offline_input(const OfflineOptions& options)
{
  if (!options.out.empty())
    require_other_file(options.file, options.out);
  Config config = options.config.empty() ? Config() : read_config(options.config);
  set_flag("--method", set_method, config, options.method);
  set_flag("--prefix", set_prefix, config, options.prefix);
  const Channels channels(config.prefix);
  const auto input = std::make_shared<const InputFile>(options.file);
  const SaidRobot said = said_robot(options.robot, config.robot);
  Robot robot = choose_robot(said, robots_named_by(input->bytes(), options.file, channels));
  config.robot = said.name_or_path.empty() ? robot.name : said.name_or_path;
  check_fits(config, robot);
  DesiredMessages desired =
      read_messages(input, options.file, coordinate_names(robot), options.differentiation, channels);
  for (const std::string& line : notes(desired))
    note(line);
  return {std::move(config), std::move(robot), std::move(desired)};
}

std::vector<DesiredState> decode_all(const Robot& robot, const DesiredMessages& desired)
{
  std::vector<DesiredState> states;
  for (std::size_t i = 0; i < desired.messages.size(); ++i)
  {
    const Result<DesiredState> state = decode_desired_state(desired.messages[i], robot);
    if (const Refusal* refusal = std::get_if<Refusal>(&state))
      throw Failure(ExitCode::bad_data, fmt::format("{}: {}", desired.place(i), refusal->detail()));
    states.push_back(std::get<DesiredState>(state));
  }
  return states;
}

} // namespace torqued
