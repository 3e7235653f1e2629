#include "stance/projection.h"

#include "commands/offline.h"
#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/console.h"
#include "motion/files.h"
#include "study/answer_table.h"
#include "study/extent.h"

#include <CLI/CLI.hpp>

#include <array>
#include <fmt/format.h>
#include <memory>
#include <vector>

namespace torqued
{

namespace
{

bool in_contact(const DesiredState& state, Side side)
{
  return state.support.of(side) != Contact::none;
}

// Footholds by the mean over each stance of a foot.
//
// Where the base follows from contact nothing says how far the robot has come, so that in double support only the
// distance between both feet has a mean.
std::vector<Footholds> find_footholds(const Robot& robot, const Origin& origin, const std::vector<DesiredState>& states)
{
  std::vector<std::array<double, 2>> marks(states.size());
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    const Result<Motion> motion = complete_motion(robot, states[i]);
    if (const Refusal* refusal = std::get_if<Refusal>(&motion))
      throw Failure(ExitCode::bad_data, "{}: {}", origin.place(i), refusal->detail());
    for (const Side side : kSides)
      if (in_contact(states[i], side))
        marks[i][static_cast<std::size_t>(side)] =
            foothold(robot, std::get<Motion>(motion).now, side, states[i].support.of(side));
  }

  std::vector<Footholds> footholds(states.size());
  // for each stretch of samples of which `belongs` is true
  const auto each_stretch = [&](const auto& belongs, const auto& treat)
  {
    for (std::size_t from = 0; from < states.size(); ++from)
    {
      std::size_t to = from;
      while (to < states.size() && belongs(states[to]))
        ++to;
      if (to > from)
        treat(from, to);
      from = to;
    }
  };
  const auto mean = [](std::size_t from, std::size_t to, const auto& value)
  {
    double sum = 0.0; // of differences to the first, so that the mean of equal numbers is that number
    for (std::size_t i = from; i < to; ++i)
      sum += value(i) - value(from);
    return value(from) + sum / static_cast<double>(to - from);
  };
  if (states.front().base_given)
    for (const std::size_t side : {0U, 1U})
      each_stretch([side](const DesiredState& state) { return in_contact(state, kSides[side]); },
                   [&](std::size_t from, std::size_t to)
                   {
                     const double x = mean(from, to, [&](std::size_t i) { return marks[i][side]; });
                     for (std::size_t i = from; i < to; ++i)
                       footholds[i][side] = x;
                   });
  else
    each_stretch([](const DesiredState& state)
                 { return in_contact(state, Side::left) && in_contact(state, Side::right); },
                 [&](std::size_t from, std::size_t to)
                 {
                   const double between = mean(from, to, [&](std::size_t i) { return marks[i][1] - marks[i][0]; });
                   const bool right_is_root = robot.is_root(robot.foot(Side::right));
                   for (std::size_t i = from; i < to; ++i)
                     footholds[i] = right_is_root ? Footholds{marks[i][1] - between, marks[i][1]}
                                                  : Footholds{marks[i][0], marks[i][0] + between};
                 });
  return footholds;
}

// What projection found and did, over a whole motion.
struct Report
{
  Extent position, tilt, speed, acceleration; // off the contacts, by sample
  std::array<Extent, 3> angle, base;          // change of coordinates, rates and accelerations

  void add(const Robot& robot, const std::string& place, const DesiredState& from, const Projection& projection)
  {
    const ContactErrors& errors = projection.before;
    position.add(errors.position, place);
    tilt.add(errors.tilt, place);
    speed.add(errors.speed, place);
    acceleration.add(errors.acceleration, place);
    const std::array<const VectorQ*, 3> before{&from.q, &from.v, &from.a};
    const std::array<const VectorQ*, 3> after{&projection.state.q, &projection.state.v, &projection.state.a};
    for (std::size_t order = 0; order < 3; ++order)
    {
      for (int i = 0; i < robot.num_coordinates(); ++i)
        angle[order].add((*after[order])(i) - (*before[order])(i), place,
                         robot.absolute_names[static_cast<std::size_t>(i)]);
      if (from.base_given)
        for (const int i : {0, 1})
          base[order].add((after[order]->tail<2>() - before[order]->tail<2>())(i), place,
                          robot.base_names[static_cast<std::size_t>(i)]);
    }
  }

  std::string text(const Robot& robot) const
  {
    const auto unit = [&robot](std::string_view per)
    {
      return coordinate_unit(robot, per);
    };
    std::string lines = "the motion was off its contacts by up to\n";
    lines += position.line("position", "m") + tilt.line("angle of a sole", "rad") +
             speed.line("speed", "m/s or rad/s") + acceleration.line("acceleration", "m/s^2 or rad/s^2");
    lines += "and was moved by up to\n";
    lines += angle[0].line("coordinates", unit("")) + base[0].line("base point", "m") +
             angle[1].line("coordinates' rates", unit("/s")) + base[1].line("base point's velocity", "m/s") +
             angle[2].line("coordinates' accelerations", unit("/s^2")) +
             base[2].line("base point's acceleration", "m/s^2");
    return lines;
  }
};

ExitCode run_project(const OfflineOptions& options)
{
  require_ending(options.out, {".csv"});
  const auto [config, robot, desired] = read_offline_input(options);
  const std::vector<DesiredState> states = decode_all(robot, desired);
  require_one_base(desired, states);
  const std::vector<Footholds> footholds = find_footholds(robot, desired, states);
  const bool base_given = states.front().base_given;

  std::string text = csv_line(motion_columns(robot, base_given), {"method"}) + robot_lines(robot.name, robot.model_id);
  Report report;
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    const Result<Projection> result = project(robot, states[i], footholds[i]);
    if (const Refusal* refusal = std::get_if<Refusal>(&result))
      throw Failure(ExitCode::bad_data, "{}: {}", desired.place(i), refusal->detail());
    const Projection& projection = std::get<Projection>(result);
    report.add(robot, desired.place(i), states[i], projection);
    const Method method = projection.state.method;
    text += csv_line(motion_cells(robot, projection.state, base_given),
                     {method == Method::none ? "default" : std::string(name_of(method))});
  }
  OutputFile out(options.out);
  out.write(text);
  out.close();
  print_summary(options.out, fmt::format("{}: {} samples\n{}", robot.name, states.size(), report.text(robot)));
  return ExitCode::done;
}

} // namespace

Subcommand add_project(CLI::App& torquectl)
{
  const auto options = std::make_shared<OfflineOptions>();
  CLI::App* app =
      torquectl.add_subcommand("project", "move a motion that nearly keeps its contacts onto them, and say how far");
  add_offline_options(*app, *options, "a trajectory .csv, absolute coordinates; - is the standard output");
  app->footer(
      "Feet in contact are put on the ground, soles level, each stance of a foot at one place: the mean of where it\n"
      "was; where the base follows from contact, the mean distance of both feet in each double support. Then rates "
      "and\n"
      "accelerations are moved to those that keep the contacts at rest. All by the least change, angles times leg\n"
      "length. Motions farther off than 5 % of the leg length, or 0.1 rad of a sole, are refused. Further columns of\n"
      "the file are left out. The daemon does the same sample by sample with project = true, but for the footholds,\n"
      "which are where each sample has them.\n\n"
      "Example:\n"
      "  torquectl gait --robot ck -o /tmp/walk.csv && torquectl project /tmp/walk.csv -o /tmp/projected.csv");
  return {app, options, run_project};
}

} // namespace torqued
