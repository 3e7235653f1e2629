#include "planar/dynamics.h"
#include "answer/answer.h"
#include "answer/answer_dynamics.h"
#include "commands/offline.h"
#include "commands/options.h"
#include "commands/subcommands.h"
#include "motion/console.h"
#include "motion/files.h"
#include "stance/joint_friction.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

namespace torqued
{

namespace
{

using Json = nlohmann::ordered_json;

struct DynamicsOptions
{
  OfflineOptions offline;
  std::string coordinates = "absolute";
  bool regressor = false, reduced = false;
  std::string elimination{kEliminations[0].name};
};

// rows that are sent of a matrix that may keep more
Json rows(const std::vector<std::vector<double>>& matrix, std::int32_t count)
{
  Json result = Json::array();
  for (const std::vector<double>& row : std::span(matrix).first(static_cast<std::size_t>(count)))
    result.push_back(row);
  return result;
}

// F, what follows from it, and the multipliers of the torques that the configured method answers
void add_reduced(Json& json, const dynamics_t& reply, const Robot& robot, const EquationOfMotion& equation,
                 const Elimination& elimination, const Motion& motion, const Answer* answer)
{
  json["F"] = rows(reply.F, reply.n);
  json["Fdot"] = rows(reply.Fdot, reply.n);
  json["F_bar"] = rows(reply.F_bar, reply.n);
  json["reduced_mass"] = rows(reply.reduced_mass, reply.num_reduced);
  json["reduced_coriolis"] = rows(reply.reduced_coriolis, reply.num_reduced);
  json["reduced_gravity"] = reply.reduced_gravity;
  json["reduced_input"] = rows(reply.reduced_input, reply.num_reduced);
  json["independent"] = elimination.independent;
  json["multipliers"] = nullptr;
  if (answer)
    json["multipliers"] =
        multipliers(equation, elimination, answer->torque - joint_friction(robot, motion.v, motion.a));
}

Json answered(std::int64_t utime, const dynamics_t& equation, const Robot& robot, const Motion& motion, bool regressor)
{
  Json json{{"utime", utime},
            {"M", rows(equation.M, equation.n)},
            {"C", rows(equation.C, equation.n)},
            {"h", equation.h},
            {"g", equation.g},
            {"B", rows(equation.B, equation.n)},
            {"J", rows(equation.J, equation.num_contact_rows)},
            {"Jdot_v", equation.Jdot_v},
            {"generalized_force", equation.generalized_force},
            {"kinetic_energy", kinetic_energy(robot.mechanism, motion.now, motion.v)},
            {"potential_energy", potential_energy(robot.mechanism, motion.now)},
            {"power", motion.v.dot(inverse_dynamics(robot.mechanism, motion.now, motion.a))}};
  if (regressor)
  {
    json["Y"] = rows(equation.Y, equation.n);
    json["alpha"] = equation.alpha;
  }
  return json;
}

ExitCode dynamics(const DynamicsOptions& options)
{
  const std::string& path = options.offline.out;
  require_ending(path, {".json", ".jsonl"});
  // no structured binding: before Clang 16 no lambda captures one
  const OfflineInput input = read_offline_input(options.offline);
  const Config& config = input.config;
  const Robot& robot = input.robot;
  const DesiredMessages& desired = input.desired;
  const std::vector<BaseParameter> parameters =
      options.regressor ? base_parameters(robot) : std::vector<BaseParameter>();
  const Coordinates coordinates = options.coordinates == "absolute" ? Coordinates::absolute : Coordinates::relative;
  std::optional<EliminationMethod> elimination;
  if (options.reduced)
    elimination = std::ranges::find(kEliminations, options.elimination, &NamedElimination::name)->method;
  OutputFile out(path);
  dynamics_t equation{};
  StreamMemory memory;
  flush_denormals();
  std::size_t refused_samples = 0;
  std::string first_refusal;
  for (std::size_t i = 0; i < desired.messages.size(); ++i)
  {
    const std::int64_t utime = read_sender(desired.messages[i]).utime;
    const auto refuse_sample = [&](std::string_view why)
    {
      if (refused_samples++ == 0)
        first_refusal = fmt::format("{}: {}", desired.place(i), why);
      return Json{{"utime", utime}, {"error", why}};
    };
    const auto line = [&]() -> Json
    {
      const Result<DesiredState> decoded = decode_desired_state(desired.messages[i], robot);
      if (const Refusal* refusal = std::get_if<Refusal>(&decoded))
        return refuse_sample(refusal->detail());
      const Result<DesiredState> moved = answered_motion(robot, config.answers, std::get<DesiredState>(decoded));
      if (const Refusal* refusal = std::get_if<Refusal>(&moved))
        return refuse_sample(refusal->detail());
      const DesiredState& state = std::get<DesiredState>(moved);
      const Result<Motion> completed = complete_motion(robot, state);
      if (const Refusal* refusal = std::get_if<Refusal>(&completed))
        return refuse_sample(refusal->detail());
      const Motion& motion = std::get<Motion>(completed);
      describe_motion(equation, robot, parameters, motion, state.support, coordinates, elimination);
      if (!equation.error.empty())
        return refuse_sample(equation.error);
      Json json = answered(utime, equation, robot, motion, options.regressor);
      if (!std::isfinite(json["kinetic_energy"].get<double>()) || !std::isfinite(json["power"].get<double>()))
        return refuse_sample("the energy is not finite; the motion's numbers are too large");
      if (elimination)
      {
        const EquationOfMotion matrices = equation_of_motion(robot, motion, state.support, coordinates);
        const Result<Answer> found = answer(robot, config.answers, state, memory);
        add_reduced(json, equation, robot, matrices,
                    std::get<Elimination>(eliminate(matrices.J, matrices.Jdot, *elimination)), motion,
                    std::get_if<Answer>(&found));
      }
      return json;
    };
    out.write(line().dump() + "\n");
  }
  out.close();
  const std::size_t samples = desired.messages.size();
  print_summary(path, fmt::format("{}: {} of {} samples, in {} coordinates\n", robot.name, samples - refused_samples,
                                  samples, options.coordinates));
  if (refused_samples == samples)
    throw Failure(ExitCode::bad_data, "{}: all {} samples were refused; the first: {}", options.offline.file, samples,
                  first_refusal);
  if (refused_samples > 0)
    note(fmt::format("{} of {} samples were refused; the first: {}", refused_samples, samples, first_refusal));
  return ExitCode::done;
}

} // namespace

Subcommand add_dynamics(CLI::App& torquectl)
{
  const auto options = std::make_shared<DynamicsOptions>();
  CLI::App* app = torquectl.add_subcommand(
      "dynamics", "the equation of motion along a trajectory: M, C, h, g, B, J, one JSON object per sample");
  add_offline_options(*app, options->offline, ".json or .jsonl, one object per line; - is the standard output");
  app->add_option("--coordinates", options->coordinates, "absolute (default) or relative")
      ->check(CLI::IsMember({"absolute", "relative"}))
      ->type_name("KIND");
  app->add_flag("--regressor", options->regressor,
                "Y and alpha, too: Y alpha = generalized_force + B (rotors and friction); `torquectl model` says what "
                "each alpha stands for");
  CLI::Option* flag =
      app->add_flag("--reduced", options->reduced,
                    "the reduced form, too: F, Fdot, F_bar, reduced_mass, reduced_coriolis, reduced_gravity, "
                    "reduced_input, the independent coordinates by number from 0, and multipliers");
  std::vector<std::string> eliminations;
  for (const auto& known : kEliminations)
    eliminations.emplace_back(known.name);
  app->add_option("--elimination", options->elimination,
                  fmt::format("how F is found: {}; default: {}", fmt::join(eliminations, ", "), eliminations.front()))
      ->check(CLI::IsMember(eliminations))
      ->type_name("NAME")
      ->needs(flag);
  add_answer_options(*app, options->offline);
  app->get_option("--method")->needs(flag);
  app->footer(
      "M a + C v + g = B tau + J' w. Rows and columns are the robot's coordinates, then the base point's x and z if "
      "its root floats. power: of the generalized force, the rate of the energy; SI. A fixed root's own contact has no "
      "rows in J.\n\n"
      "v = F z', a = F z'' + Fdot z' for all motions that keep the contacts, J F = 0; multipliers: what the ground "
      "does\n"
      "if the motors' torques are those of the method (--method), in the order of the rows of J; null where there is "
      "no\n"
      "answer. With project = true in the configuration all is of the projected motion.\n\n"
      "Example, in the source directory:\n"
      "  torquectl dynamics client/trajectories/subject01-walk/walk.csv --robot human-subject01 -o /tmp/d.json");
  return {app, options, dynamics};
}

} // namespace torqued
