#include "commands/offline.h"
#include "commands/options.h"
#include "motion/console.h"

#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/files.h"
#include "motion/motion_columns.h"
#include "study/answer_table.h"

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
  note(notes(desired));
  return {std::move(config), std::move(robot), std::move(desired)};
}

void print_answered(const OfflineOptions& options, const Robot& robot, const DesiredMessages& desired,
                    const Tally& tally)
{
  print_summary(options.out, tally.summary(robot.name, desired.messages.size()));
  tally.require_answers(options.file);
}

std::vector<std::string> motion_columns(const Robot& robot, bool base_given)
{
  std::vector<std::string> names = robot.absolute_names;
  if (base_given)
    names.insert(names.end(), robot.base_names.begin(), robot.base_names.end());
  return written_columns(names);
}

std::vector<std::string> motion_cells(const Robot& robot, const DesiredState& state, bool base_given)
{
  std::vector<std::string> cells{fmt::format("{}", state.utime)};
  const int count = robot.num_coordinates() + (base_given ? 2 : 0);
  for (const VectorQ* numbers : {&state.q, &state.v, &state.a})
    for (const double number : numbers->head(count))
      cells.push_back(number_cell(number));
  for (const Side side : kSides)
    cells.emplace_back(name_of(state.support.of(side)));
  cells.emplace_back(state.support.leading == Side::left ? "L" : "R");
  cells.push_back(number_cell(state.support.load_transfer));
  cells.push_back(number_cell(state.support.phase));
  return cells;
}

std::vector<DesiredState> decode_all(const Robot& robot, const DesiredMessages& desired)
{
  std::vector<DesiredState> states;
  for (std::size_t i = 0; i < desired.messages.size(); ++i)
  {
    const Result<DesiredState> state = decode_desired_state(desired.messages[i], robot);
    if (const Refusal* refusal = std::get_if<Refusal>(&state))
      throw Failure(ExitCode::bad_data, "{}: {}", desired.place(i), refusal->detail());
    states.push_back(std::get<DesiredState>(state));
  }
  return states;
}

void require_one_base(const Origin& origin, const std::vector<DesiredState>& states)
{
  for (std::size_t i = 0; i < states.size(); ++i)
    if (states[i].base_given != states.front().base_given)
      throw Failure(ExitCode::bad_data,
                    "{}: base is {}; expected it GIVEN in all desired states, or FROM_CONTACT in all", origin.place(i),
                    states[i].base_given ? "GIVEN" : "FROM_CONTACT");
}

} // namespace torqued
