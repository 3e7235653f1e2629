#include "client/files.h"
#include "client/offline.h"
#include "client/subcommands.h"
#include "daemon/answer_dynamics.h"

#include <CLI/CLI.hpp>

#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>

namespace torqued
{

namespace
{

using Json = nlohmann::ordered_json;

struct Options
{
  OfflineOptions offline;
  std::string coordinates = "absolute";
  bool regressor = false;
};

// rows that are sent of a matrix that may keep more
Json rows(const std::vector<std::vector<double>>& matrix, std::int32_t count)
{
  Json result = Json::array();
  for (const std::vector<double>& row : std::span(matrix).first(static_cast<std::size_t>(count)))
    result.push_back(row);
  return result;
}

Json line(std::int64_t utime, const dynamics_t& equation, bool regressor)
{
  if (!equation.error.empty())
    return {{"utime", utime}, {"error", equation.error}};
  Json json{{"utime", utime},
            {"M", rows(equation.M, equation.n)},
            {"C", rows(equation.C, equation.n)},
            {"h", equation.h},
            {"g", equation.g},
            {"B", rows(equation.B, equation.n)},
            {"J", rows(equation.J, equation.num_contact_rows)},
            {"Jdot_v", equation.Jdot_v},
            {"generalized_force", equation.generalized_force}};
  if (regressor)
  {
    json["Y"] = rows(equation.Y, equation.n);
    json["alpha"] = equation.alpha;
  }
  return json;
}

ExitCode dynamics(const Options& options)
{
  const auto [config, robot, trajectory] = read_offline_input(options.offline);
  const std::vector<BaseParameter> parameters =
      options.regressor ? base_parameters(robot) : std::vector<BaseParameter>();
  const Coordinates coordinates = options.coordinates == "absolute" ? Coordinates::absolute : Coordinates::relative;
  OutputFile out(options.offline.out);
  dynamics_t equation{};
  std::vector<std::byte> buffer;
  std::size_t refused = 0;
  for (std::size_t i = 0; i < trajectory.states.size(); ++i)
  {
    const auto complain = [&](const Refusal& refusal)
    {
      if (refused++ == 0)
        note(fmt::format("{}: {}", trajectory.place(i), refusal.detail()));
      refuse(equation, robot, 0, refusal.detail());
    };
    const Result<DesiredState> desired = decode_desired_state(encode(trajectory.states[i], buffer), robot);
    if (const Refusal* refusal = std::get_if<Refusal>(&desired))
      complain(*refusal);
    else
    {
      const DesiredState& state = std::get<DesiredState>(desired);
      const Result<Motion> motion = complete_motion(robot, state);
      if (const Refusal* undefined = std::get_if<Refusal>(&motion))
        complain(*undefined);
      else
        fill(equation, robot, parameters, std::get<Motion>(motion), state.support, coordinates);
    }
    out.write(line(trajectory.states[i].utime, equation, options.regressor).dump() + "\n");
  }
  out.close();
  if (options.offline.out != "-")
    fmt::print("{}: {} of {} samples, in {} coordinates\n", robot.name, trajectory.states.size() - refused,
               trajectory.states.size(), options.coordinates);
  return ExitCode::done;
}

} // namespace

Subcommand add_dynamics(CLI::App& torquectl)
{
  const auto options = std::make_shared<Options>();
  CLI::App* app = torquectl.add_subcommand(
      "dynamics", "the equation of motion along a trajectory: M, C, h, g, B, J, one JSON object per sample");
  add_offline_options(*app, options->offline, "where the objects go, one line each; - for the terminal");
  app->add_option("--coordinates", options->coordinates, "absolute (default) or relative")
      ->check(CLI::IsMember({"absolute", "relative"}))
      ->type_name("KIND");
  app->add_flag("--regressor", options->regressor,
                "Y and alpha, too: Y alpha = generalized_force + B (rotors and friction); `torquectl model` says what "
                "each alpha stands for");
  app->footer(
      "M a + C v + g = B tau + J' w. Rows and columns are the robot's coordinates, then the base point's x and z "
      "if its root floats.\n\n"
      "Example, in the source directory:\n"
      "  torquectl dynamics client/trajectories/subject01-walk/walk.csv --robot human-subject01 -o /tmp/d.json");
  return {app, [options]
          {
            return dynamics(*options);
          }};
}

} // namespace torqued
