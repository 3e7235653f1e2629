#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/console.h"
#include "motion/files.h"
#include "motion/foreign_file.h"
#include "motion/lcm_log.h"
#include "motion/trajectory.h"
#include "study/motion_table.h"
#include "study/recorded.h"
#include "study/tally.h"
#include "text/printable.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <optional>

namespace torqued
{

namespace
{

struct ExportOptions
{
  std::string log, out, robot;
  std::optional<std::string> prefix;
};

MotionTable table_of(const Trajectory& trajectory, const model_info_t& model)
{
  MotionTable table(model);
  for (std::size_t i = 0; i < trajectory.states.size(); ++i)
  {
    const desired_state_t& state = trajectory.states[i];
    if (state.num_coordinates != model.num_coordinates)
      throw Failure(ExitCode::bad_data, "{}: found {} coordinates; expected {}, those of {}", trajectory.place(i),
                    state.num_coordinates, model.num_coordinates, printable(model.name));
    table.see(state);
  }
  return table;
}

// a desired state and the next answer to it as a line; counts it
std::string next_line(const MotionTable& table, const desired_state_t& state, RecordedAnswers& answers,
                      const model_info_t& model, const std::string& place, Tally& tally)
{
  const std::optional<RecordedAnswer> answer = answers.next(state);
  if (!answer)
    return table.line(state, {}, "NO_ANSWER");
  if (const auto* rejection = std::get_if<rejection_t>(&answer->message))
  {
    tally.reject(rejection->reason, fmt::format("{}: {}", place, printable(rejection->detail)));
    return table.line(state, {}, reason_name(rejection->reason));
  }
  const auto& command = std::get<torque_command_t>(answer->message);
  require_fit(command, model.num_coordinates, model.num_joints, printable(model.name), place);
  tally.answer(command.flags);
  return table.line(state, {}, command);
}

ExitCode export_log(const ExportOptions& options)
{
  const Channels channels = channels_with(options.prefix);
  require_other_file(options.log, options.out);
  const std::string bytes = read_file(options.log);
  if (!LogReader::is_log(bytes))
    throw Failure(ExitCode::bad_data, "{}: is {}; expected what lcm-logger wrote", options.log,
                  foreign_file(bytes).value_or("no LCM log"));
  const Trajectory trajectory = parse_trajectory(bytes, options.log, {}, false, channels);
  const model_info_t model = choose_model(said_robot(options.robot), robots_named_by(bytes, options.log, channels));
  note(notes(trajectory));
  RecordedAnswers answers(bytes, options.log, channels, model.model_id);
  if (answers.empty() && std::ranges::all_of(trajectory.states, [&model](const desired_state_t& state)
                                             { return state.model_id != 0 && state.model_id != model.model_id; }))
    throw Failure(ExitCode::bad_data,
                  "{}: found desired states for model_id {}; expected {}, that of {}: they are another robot's",
                  options.log, trajectory.states.front().model_id, model.model_id, printable(model.name));
  note(answers.notes());
  const MotionTable table = table_of(trajectory, model);
  OutputFile csv(options.out);
  csv.write(table.header());
  csv.write(robot_lines(model.name, model.model_id));
  Tally tally;
  for (std::size_t i = 0; i < trajectory.states.size(); ++i)
    csv.write(next_line(table, trajectory.states[i], answers, model, trajectory.place(i), tally));
  csv.close();

  const std::size_t rows = trajectory.states.size();
  const auto silent = static_cast<std::int64_t>(rows) - tally.answered - tally.num_rejected();
  print_summary(options.out, tally.summary(printable(model.name), rows, fmt::format("{} without an answer, ", silent)));
  return ExitCode::done;
}

} // namespace

Subcommand add_export(CLI::App& torquectl)
{
  const auto options = std::make_shared<ExportOptions>();
  CLI::App* app =
      torquectl.add_subcommand("export", "a recorded log as CSV: desired states and their answers, one row each");
  app->add_option("LOG", options->log, "what lcm-logger recorded")->type_name("")->required();
  app->add_option("-o,--output", options->out, "the CSV; - for the standard output")->type_name("CSV")->required();
  add_robot_option(*app, options->robot, kRobotOfFile);
  add_prefix_option(*app, options->prefix);
  app->footer(
      "The CSV can be read as a trajectory again; its column `method` then asks for the methods that answered. "
      "`rejected`\n"
      "is NO_ANSWER where the log holds no answer. Of answers recorded before they said which accelerations their\n"
      "torques produce, columns a_… hold those that were asked for; they are empty where that is not known.\n\n"
      "Example, while torqued runs on this bus:\n"
      "  export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'\n"
      "  lcm-logger -q -f /tmp/walk.lcm & sleep 1\n"
      "  torquectl send client/trajectories/subject01-walk/walk.csv; kill $!; wait $!\n"
      "  torquectl export /tmp/walk.lcm -o /tmp/walk.csv");
  return {app, options, export_log};
}

} // namespace torqued
