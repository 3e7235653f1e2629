#include "client/answer_table.h"
#include "client/files.h"
#include "client/foreign_file.h"
#include "client/lcm_log.h"
#include "client/recorded.h"
#include "client/subcommands.h"
#include "client/tally.h"
#include "client/trajectory.h"
#include "robot/printable.h"

#include <CLI/CLI.hpp>

#include <Eigen/LU>
#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <optional>

namespace torqued
{

namespace
{

struct Options
{
  std::string log, out, robot;
  std::optional<std::string> prefix;
};

// Desired states as cells of a CSV that can be read as a trajectory again.
class StateTable
{
public:
  StateTable(const model_info_t& model, const Trajectory& trajectory) : model_(model)
  {
    const auto is_relative = [](const desired_state_t& s)
    {
      return s.coordinates == desired_state_t::RELATIVE;
    };
    const auto has_base = [](const desired_state_t& s)
    {
      return s.base == desired_state_t::GIVEN;
    };
    const std::vector<desired_state_t>& states = trajectory.states;
    relative_ = std::all_of(states.begin(), states.end(), is_relative);
    base_ = std::any_of(states.begin(), states.end(), has_base);
    for (std::size_t i = 0; i < states.size(); ++i)
      if (states[i].num_coordinates != model.num_coordinates)
        throw Failure(ExitCode::bad_data,
                      fmt::format("{}: found {} coordinates; expected {}, those of {}", trajectory.place(i),
                                  states[i].num_coordinates, model.num_coordinates, printable(model.name)));
  }

  std::vector<std::string> columns() const
  {
    std::vector<std::string> columns{"utime"};
    for (const std::string prefix : {"", "d", "dd"})
    {
      for (const std::string& name : relative_ ? model_.relative_names : model_.absolute_names)
        columns.push_back(prefix + name);
      if (base_)
        for (const std::string& name : model_.base_names)
          columns.push_back(prefix + name);
    }
    for (const char* name : {"contactL", "contactR", "leading", "load_transfer", "phase"})
      columns.emplace_back(name);
    return columns;
  }

  std::vector<std::string> cells(const desired_state_t& state) const
  {
    std::vector<std::string> cells{fmt::format("{}", state.utime)};
    const auto add_motion = [&](const std::vector<double>& angles, bool position, const double* base)
    {
      for (const double number :
           !relative_ && state.coordinates == desired_state_t::RELATIVE ? to_absolute(angles, position) : angles)
        cells.push_back(number_cell(number));
      for (int i = 0; base_ && i < 2; ++i)
        cells.push_back(state.base == desired_state_t::GIVEN ? number_cell(base[i]) : "");
    };
    add_motion(state.q, true, state.base_q);
    add_motion(state.v, false, state.base_v);
    add_motion(state.a, false, state.base_a);
    cells.push_back(fmt::format("{}", state.left_contact));
    cells.push_back(fmt::format("{}", state.right_contact));
    cells.push_back(state.leading_foot == desired_state_t::LEFT    ? "L"
                    : state.leading_foot == desired_state_t::RIGHT ? "R"
                                                                   : fmt::format("{}", state.leading_foot));
    cells.push_back(number_cell(state.load_transfer));
    cells.push_back(number_cell(state.phase));
    return cells;
  }

private:
  // q_relative = A q_absolute + b, solved for the absolute angles or their derivatives
  std::vector<double> to_absolute(const std::vector<double>& relative, bool position) const
  {
    const Eigen::Index n = model_.num_coordinates;
    Eigen::MatrixXd A(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      A.row(i) = Eigen::Map<const Eigen::RowVectorXd>(model_.A[static_cast<std::size_t>(i)].data(), n);
    Eigen::VectorXd right = Eigen::Map<const Eigen::VectorXd>(relative.data(), n);
    if (position)
      right -= Eigen::Map<const Eigen::VectorXd>(model_.b.data(), n);
    const Eigen::VectorXd absolute = A.partialPivLu().solve(right);
    return {absolute.begin(), absolute.end()};
  }

  const model_info_t& model_;
  bool relative_, base_;
};

model_info_t robot_of(const Trajectory& trajectory, const std::string& robot)
{
  if (!robot.empty())
    return model_info(load_robot(robot), 0, 0, "");
  if (!trajectory.recorded_model)
    throw Failure(
        ExitCode::bad_data,
        fmt::format("{}: holds no model_info_t, so the names of its coordinates and joints are not known; --robot "
                    "says which robot it was",
                    trajectory.file));
  return *trajectory.recorded_model;
}

// the next answer to a desired state as cells; counts it
std::vector<std::string> next_answer(RecordedAnswers& answers, const desired_state_t& state, const model_info_t& model,
                                     const std::string& place, Tally& tally)
{
  const auto joints = static_cast<std::size_t>(model.num_joints);
  const std::optional<RecordedAnswer> answer = answers.next(state);
  if (!answer)
    return rejected_cells(joints, "NO_ANSWER");
  if (const auto* rejection = std::get_if<rejection_t>(&answer->message))
  {
    tally.reject(rejection->reason, fmt::format("{}: {}", place, printable(rejection->detail)));
    return rejected_cells(joints, reason_name(rejection->reason));
  }
  const auto& command = std::get<torque_command_t>(answer->message);
  if (command.num_joints != model.num_joints)
    throw Failure(ExitCode::bad_data, fmt::format("{}: was answered with {} torques; expected {}, those of {}", place,
                                                  command.num_joints, model.num_joints, printable(model.name)));
  tally.answer(command.flags);
  return answer_cells(command);
}

ExitCode export_log(const Options& options)
{
  Config config;
  set_flag("--prefix", set_prefix, config, options.prefix);
  const Channels channels(config.prefix);
  require_other_file(options.log, options.out);
  const std::string bytes = read_file(options.log);
  if (!LogReader::is_log(bytes))
    throw Failure(ExitCode::bad_data, fmt::format("{}: is {}; expected what lcm-logger wrote", options.log,
                                                  foreign_file(bytes).value_or("no LCM log")));
  const Trajectory trajectory = parse_trajectory(bytes, options.log, {}, false, channels);
  const model_info_t model = robot_of(trajectory, options.robot);
  for (const std::string& line : notes(trajectory, model.name, model.model_id))
    note(line);

  RecordedAnswers answers(bytes, channels);
  const StateTable table(model, trajectory);
  OutputFile csv(options.out);
  const auto write_row = [&csv](std::vector<std::string> cells, const std::vector<std::string>& more)
  {
    cells.insert(cells.end(), more.begin(), more.end());
    csv.write(csv_line(cells));
  };
  write_row(table.columns(), answer_columns(model.joint_names));
  Tally tally;
  for (std::size_t i = 0; i < trajectory.states.size(); ++i)
  {
    const desired_state_t& state = trajectory.states[i];
    write_row(table.cells(state), next_answer(answers, state, model, trajectory.place(i), tally));
  }
  csv.close();

  const auto rows = static_cast<std::int64_t>(trajectory.states.size());
  if (options.out != "-")
    fmt::print("{}: {} of {} samples answered, {} without an answer, {}\n{}{}", printable(model.name), tally.answered,
               rows, rows - tally.answered - tally.num_rejected(), tally.rejections(), tally.flag_line(),
               tally.first_of_each());
  return ExitCode::done;
}

} // namespace

Subcommand add_export(CLI::App& torquectl)
{
  const auto options = std::make_shared<Options>();
  CLI::App* app =
      torquectl.add_subcommand("export", "a recorded log as CSV: desired states and their answers, one row each");
  app->add_option("LOG", options->log, "what lcm-logger recorded")->type_name("")->required();
  app->add_option("-o,--output", options->out, "the CSV; - for the standard output")->type_name("CSV")->required();
  add_robot_option(*app, options->robot, "default: the one that the log says");
  add_prefix_option(*app, options->prefix);
  app->footer("The CSV can be read as a trajectory again; its column `method` then asks for the methods that answered. "
              "`rejected`\n"
              "is NO_ANSWER where the log holds no answer.\n\n"
              "Example, while torqued runs on this bus:\n"
              "  export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'\n"
              "  lcm-logger -q -f /tmp/walk.lcm & sleep 1\n"
              "  torquectl send client/trajectories/subject01-walk/walk.csv; kill $!; wait $!\n"
              "  torquectl export /tmp/walk.lcm -o /tmp/walk.csv");
  return {app, [options]
          {
            return export_log(*options);
          }};
}

} // namespace torqued
