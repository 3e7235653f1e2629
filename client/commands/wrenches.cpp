#include "answer/answer.h"
#include "commands/offline.h"
#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/files.h"
#include "questions/newton_euler.h"
#include "stance/contacts.h"
#include "stance/joint_friction.h"
#include "study/answer_table.h"
#include "study/tally.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <fmt/format.h>
#include <memory>

namespace torqued
{

namespace
{

bool slides(const Robot& robot)
{
  return std::ranges::any_of(robot.links, [](const Link& link) { return link.type().slides(); });
}

std::vector<std::string> columns(const Robot& robot)
{
  std::vector<std::string> names{"utime"};
  for (int i = 0; i < static_cast<int>(robot.links.size()); ++i)
    if (i != robot.root())
    {
      for (const char* column : {"x", "z", "fx", "fz", "m"})
        names.push_back(fmt::format("{}_{}", column, robot.link(i).name));
      if (slides(robot))
        names.push_back("fy_" + robot.link(i).name);
    }
  for (const Actuator& actuator : robot.actuators)
    names.push_back("tau_" + actuator.name);
  for (const char* column : {"residual_fx", "residual_fz", "residual_m", "rejected"})
    names.push_back(column);
  return names;
}

// one answered sample, the motion that was answered: the wrenches of all joints under the ground reactions of the
// answer
std::vector<std::string> wrench_cells(const Robot& robot, const DesiredState& desired, const Answer& answer)
{
  const Motion motion = std::get<Motion>(complete_motion(robot, desired));
  std::array<Eigen::Vector3d, 2> ground;
  for (const std::size_t side : {0U, 1U})
  {
    const Wrench& wrench = answer.ground[side].wrench;
    ground[side] << wrench.fx, wrench.fz, wrench.moment;
  }
  const NewtonEuler found = newton_euler(robot, desired.q, motion.v, motion.a, ground);
  const VectorJ torque = found.torque + joint_friction(robot, motion.v, motion.a);

  std::vector<std::string> row{fmt::format("{}", desired.utime)};
  for (int i = 0; i < static_cast<int>(robot.links.size()); ++i)
  {
    const JointWrench& joint = found.joints[static_cast<std::size_t>(i)];
    if (i == robot.root())
      continue;
    const Eigen::Vector2d at = motion.now.base + joint.at;
    for (const double number : {at.x(), at.y(), joint.force.x(), joint.force.y(), joint.moment})
      row.push_back(number_cell(number));
    if (slides(robot))
      row.push_back(number_cell(joint.sideways));
  }
  for (const double number : torque)
    row.push_back(number_cell(number));
  const JointWrench& root = found.joints[static_cast<std::size_t>(robot.root())];
  for (const double number : {root.force.x(), root.force.y(), root.moment})
    row.push_back(number_cell(number));
  row.emplace_back();
  return row;
}

ExitCode wrenches(const OfflineOptions& options)
{
  require_ending(options.out, {".csv"});
  const auto [config, robot, desired] = read_offline_input(options);
  const std::vector<std::string> names = columns(robot);
  OutputFile out(options.out);
  out.write(csv_line(names) + robot_lines(robot.name, robot.model_id));
  StreamMemory memory;
  Tally tally;
  flush_denormals();
  for (std::size_t i = 0; i < desired.messages.size(); ++i)
  {
    const Result<DesiredState> state = decode_desired_state(desired.messages[i], robot);
    const Refusal* refusal = std::get_if<Refusal>(&state);
    const Result<Answer> answered =
        refusal ? Result<Answer>(*refusal) : answer(robot, config.answers, std::get<DesiredState>(state), memory);
    refusal = std::get_if<Refusal>(&answered);
    if (refusal)
    {
      std::vector<std::string> row(names.size());
      row.front() = fmt::format("{}", read_sender(desired.messages[i]).utime);
      row.back() = name_of(refusal->reason());
      tally.reject(static_cast<std::int32_t>(refusal->reason()),
                   fmt::format("{}: {}", desired.place(i), refusal->detail()));
      out.write(csv_line(row));
    }
    else
    {
      const Answer& found = std::get<Answer>(answered);
      tally.answer(found.flags);
      out.write(csv_line(wrench_cells(
          robot, std::get<DesiredState>(answered_motion(robot, config.answers, std::get<DesiredState>(state))),
          found)));
    }
  }
  out.close();
  print_answered(options, robot, desired, tally);
  return ExitCode::done;
}

} // namespace

Subcommand add_wrenches(CLI::App& torquectl)
{
  const auto options = std::make_shared<OfflineOptions>();
  CLI::App* app = torquectl.add_subcommand(
      "wrenches", "what each joint's bearings carry along a trajectory, by the recursion of Newton and Euler");
  add_offline_options(*app, *options, "a .csv, one row per sample; - is the standard output");
  add_answer_options(*app, *options);
  app->footer(
      "Each link but the root has x_, z_: where the joint to its parent is, of a rolling joint where the circles touch "
      "(m, world); fx_, fz_, m_: force and moment of the parent on the link there (N, N m; fy_: sideways, where "
      "something slides). tau_: the torques that the motion needs, a second way. residual_: what is missing in the "
      "whole robot's equations. The exit code is 65 if no sample was answered.\n\n"
      "Example, in the source directory:\n"
      "  torquectl wrenches client/trajectories/subject01-walk/walk.csv --robot human-subject01 -o /tmp/wrenches.csv");
  return {app, options, wrenches};
}

} // namespace torqued
