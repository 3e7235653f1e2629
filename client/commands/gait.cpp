#include "motion/gait.h"
#include "commands/offline.h"
#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/console.h"
#include "motion/files.h"
#include "motion/unit_names.h"
#include "study/answer_table.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string_view>

namespace torqued
{

namespace
{

// A number of the gait as an option: m, s, a share, or degrees.
struct GaitNumber
{
  const char* option;
  double GaitOptions::*number;
  const char *unit, *what;

  double factor() const { return std::string_view(unit) == "DEGREES" ? kDegree : 1.0; }
};
constexpr const char* kHipHeight = "--hip-height";
constexpr std::array<GaitNumber, 10> kNumbers{
    {{"--step-length", &GaitOptions::step_length, "M", "from one foothold to the next; default: 0.45 leg lengths"},
     {"--step-time", &GaitOptions::step_time, "S",
      "of a single and a double support; default: 2.6 sqrt(leg length / gravity)"},
     {"--double-support", &GaitOptions::double_support, "SHARE", "share of the step time; default: 0.4"},
     {"--first-part", &GaitOptions::first_part, "SHARE",
      "share of double support in which the trailing foot is still flat; default: 0.5"},
     {"--heel-strike", &GaitOptions::heel_strike, "DEGREES", "pitch of the foot that lands, toe up; default: 10"},
     {"--toe-off", &GaitOptions::toe_off, "DEGREES", "pitch of the foot that lifts, heel up; default: 15"},
     {kHipHeight, &GaitOptions::hip_height, "M",
      "of the base point; default: 0.94 leg lengths above the ankles, or as much less as the steps need"},
     {"--clearance", &GaitOptions::clearance, "M", "how much the swinging foot is lifted; default: 0.04 leg lengths"},
     {"--trunk-angle", &GaitOptions::trunk_angle, "DEGREES",
      "counter-clockwise, so that negative leans forward; default: 0"},
     {"--standing", &GaitOptions::standing, "S",
      "how long to stand before the first and after the last step, feet side by side; default: not at all"}}};

struct GaitCommand
{
  std::string out, robot;
  std::map<std::string_view, double> numbers; // those that were given, by their option
  bool flat_footed = false, anyway = false;
  std::optional<int> steps;
  double rate = 200.0;

  bool says_hip_height() const { return numbers.contains(kHipHeight); }
};

GaitOptions chosen(const GaitCommand& command, const Robot& robot)
{
  GaitOptions options = default_gait(robot);
  for (const GaitNumber& number : kNumbers)
    if (const auto given = command.numbers.find(number.option); given != command.numbers.end())
      options.*number.number = given->second * number.factor();
  options.flat_footed = command.flat_footed;
  options.steps = command.steps.value_or(options.steps);
  return options;
}

// Lowers the hips as far as it must where the user has not said how high they are.
Gait find_gait(const GaitCommand& command, const Robot& robot)
{
  GaitOptions options = chosen(command, robot);
  const double lowest = 0.75 * options.hip_height, step = 0.02 * options.hip_height;
  for (;; options.hip_height -= step)
    try
    {
      return Gait(robot, options);
    }
    catch (const LegTooShort&)
    {
      if (command.says_hip_height() || options.hip_height - step < lowest)
        throw;
    }
}

// Writes the walk at a rate, and at each change of contacts the instant twice: as the end of one phase, and 1 µs later
// as the begin of the next.
int write(const Gait& gait, const Robot& robot, double rate, OutputFile& file)
{
  file.write(csv_line(motion_columns(robot, true)) + robot_lines(robot.name, robot.model_id));
  const GaitOptions& o = gait.options();
  file.write("# torquectl gait --robot " + robot.name);
  for (const GaitNumber& number : kNumbers)
    file.write(number.factor() == 1.0 ? fmt::format(" {} {}", number.option, o.*number.number)
                                      : fmt::format(" {} {:.6g}", number.option, o.*number.number / number.factor()));
  file.write(fmt::format(" --steps {} --rate {}{}\n", o.steps, rate, o.flat_footed ? " --flat-footed" : ""));
  file.write("# Where contacts change, two rows show the same instant, 1 us apart: as the end of one phase and the "
             "begin of the next.\n");

  int rows = 0;
  const auto row = [&](std::int64_t utime, double t, const GaitPhase& phase)
  {
    DesiredState state = gait.at(t, phase);
    state.utime = utime;
    file.write(csv_line(motion_cells(robot, state, true)));
    ++rows;
  };
  const auto micros = [](double t)
  {
    return static_cast<std::int64_t>(std::llround(1e6 * t));
  };
  for (const GaitPhase& phase : gait.phases())
  {
    const std::int64_t begin = micros(phase.begin) + (phase.begin > 0.0 ? 1 : 0);
    const std::int64_t end = micros(phase.end);
    row(begin, phase.begin, phase);
    for (auto k = static_cast<std::int64_t>(std::ceil(phase.begin * rate)); micros(static_cast<double>(k) / rate) < end;
         ++k)
      if (const double t = static_cast<double>(k) / rate; micros(t) > begin)
        row(micros(t), t, phase);
    row(end, phase.end, phase);
  }
  return rows;
}

ExitCode run_gait(const GaitCommand& command)
{
  require_ending(command.out, {".csv"});
  const Robot robot = require_robot(command.robot);
  const Gait gait = find_gait(command, robot);
  const GaitOptions& options = gait.options();
  double shortest = std::numeric_limits<double>::infinity();
  for (const GaitPhase& phase : gait.phases())
    shortest = std::min(shortest, phase.end - phase.begin);
  if (!(shortest * command.rate >= 1.0 && command.rate <= 1e5))
    throw Failure(ExitCode::usage,
                  "--rate: found {:g}; expected {:.4g} to 100000 Hz, so that each phase has a sample of its own",
                  command.rate, 1.0 / shortest);
  const std::string obstacle = gait.obstacle();
  if (!obstacle.empty() && !command.anyway)
    throw Failure(ExitCode::usage, "{} cannot walk like this: {}; --anyway writes it all the same", robot.name,
                  obstacle);
  OutputFile file(command.out);
  const int rows = write(gait, robot, command.rate, file);
  file.close();

  const GaitReport& report = gait.report();
  note(fmt::format("{} walks {} steps of {:.3f} m and {:.3f} s, {:.2f} m/s{}; {} samples", robot.name, options.steps,
                   options.step_length, options.step_time, options.step_length / options.step_time,
                   options.standing > 0.0 ? ", from standing to standing" : "", rows));
  std::string margins = fmt::format("the zero-moment point stays {:.3f} m inside what carries", report.zmp_margin);
  if (std::isfinite(report.switch_margin))
    margins += fmt::format(", and {:.3f} m between toe and heel where the trailing heel lifts", report.switch_margin);
  note(margins);
  if (!command.says_hip_height() && options.hip_height < default_gait(robot).hip_height)
    note(fmt::format("the hips are {:.3f} m high, so that the legs reach", options.hip_height));
  if (!obstacle.empty())
    note(obstacle);
  return ExitCode::done;
}

} // namespace

Subcommand add_gait(CLI::App& torquectl)
{
  const auto command = std::make_shared<GaitCommand>();
  CLI::App* app = torquectl.add_subcommand("gait", "make up a walk of a robot with feet and knees");
  app->add_option("-o,--output", command->out, "where the walk goes, .csv; - is the standard output")
      ->type_name("OUT")
      ->required();
  add_robot_option(*app, command->robot, "no default");
  for (const GaitNumber& number : kNumbers)
    app->add_option_function<double>(
           number.option, [command, &number](double given) { command->numbers[number.option] = given; }, number.what)
        ->type_name(number.unit);
  app->add_flag("--flat-footed", command->flat_footed, "keep the feet level: no heel strike, no toe off");
  app->add_flag("--anyway", command->anyway, "write the walk even if feet or motors cannot do it");
  app->add_option("--steps", command->steps, "how many; default: 4")->type_name("N");
  app->add_option("--rate", command->rate, "samples per second; default: 200")->type_name("HZ");
  app->footer(
      "The walk goes SSP, DSP1 (trailing sole, leading heel), DSP2 (trailing toe, leading sole), SSP; flat-footed "
      "with\n"
      "both soles on the ground in between. It is refused, with what to change, if a leg is too short, or if with the\n"
      "method constrained a foot would slip, lift or tip or a motor would pass its limit. Feet rest where\n"
      "contacts change, and positions, rates and accelerations are continuous; at each change two rows, 1 us apart, "
      "show\n"
      "the same instant as the end of one phase and as the begin of the next.\n\n"
      "Example:\n"
      "  torquectl gait --robot rk --step-length 0.4 -o /tmp/walk.csv && torquectl compare /tmp/walk.csv --robot rk");
  return {app, command, run_gait};
}

} // namespace torqued
