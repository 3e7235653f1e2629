// What computations cost: one row each.

#include "udwadia_kalaba.h"

#include "client/files.h"
#include "client/trajectory.h"
#include "daemon/answer.h"
#include "torque/elimination.h"

#include <benchmark/benchmark.h>
#include <string>

using namespace torqued;

namespace
{

// Double support in the middle of the measured walk: 3 coordinates are free of 9.
struct Sample
{
  Robot robot = load_robot("human-subject01");
  DesiredState desired;
  Motion motion;
  EquationOfMotion equation;

  Sample()
  {
    const std::string file = TRAJECTORIES "/subject01-walk/walk.csv";
    const Trajectory walk = parse_trajectory(read_file(file), file, coordinate_names(robot), false, Channels());
    std::vector<DesiredState> both;
    std::vector<std::byte> buffer;
    for (const desired_state_t& state : walk.states)
      if (state.left_contact != desired_state_t::NONE && state.right_contact != desired_state_t::NONE)
        both.push_back(std::get<DesiredState>(decode_desired_state(encode(state, buffer), robot)));
    desired = both[both.size() / 2];
    motion = std::get<Motion>(complete_motion(robot, desired));
    equation = equation_of_motion(robot, motion, desired.support, Coordinates::absolute);
  }
};

const Sample& sample()
{
  static const Sample one;
  return one;
}

void eliminated(benchmark::State& state, EliminationMethod method)
{
  const EquationOfMotion& equation = sample().equation;
  for (auto _ : state)
    benchmark::DoNotOptimize(eliminate(equation.J, equation.Jdot, method));
}

void udwadia_and_kalaba(benchmark::State& state)
{
  const Sample& now = sample();
  const VectorJ torque = VectorJ::Zero(now.robot.num_joints());
  for (auto _ : state)
    benchmark::DoNotOptimize(udwadia_kalaba(now.equation, torque));
}

// by F: z'' from the reduced equation, then a = F z'' + Ḟ z'
void reduced_acceleration(benchmark::State& state)
{
  const Sample& now = sample();
  for (auto _ : state)
  {
    const Elimination found =
        std::get<Elimination>(eliminate(now.equation.J, now.equation.Jdot, EliminationMethod::partitioning));
    const ReducedForm reduced = reduced_form(now.equation, found);
    const VectorQ rates = now.motion.v(found.independent);
    const VectorQ accelerations = reduced.mass.llt().solve(-reduced.gravity - reduced.coriolis * rates);
    const VectorQ a = found.F * accelerations + found.Fdot * rates;
    benchmark::DoNotOptimize(a);
  }
}

void matrices(benchmark::State& state)
{
  const Sample& now = sample();
  for (auto _ : state)
    benchmark::DoNotOptimize(equation_of_motion(now.robot, now.motion, now.desired.support, Coordinates::absolute));
}

void answered(benchmark::State& state, Method method)
{
  const Sample& now = sample();
  AnswerSettings settings;
  settings.methods.method = method;
  StreamMemory memory;
  for (auto _ : state)
    benchmark::DoNotOptimize(answer(now.robot, settings, now.desired, memory));
}

} // namespace

int main(int argc, char** argv)
{
  flush_denormals();
  for (const NamedElimination& known : kEliminations)
    benchmark::RegisterBenchmark(("F, Fdot, F_bar: " + std::string(known.name)).c_str(), eliminated, known.method);
  benchmark::RegisterBenchmark("acceleration: reduced, partitioning", reduced_acceleration);
  benchmark::RegisterBenchmark("acceleration: Udwadia-Kalaba", udwadia_and_kalaba);
  benchmark::RegisterBenchmark("M, C, g, B, J", matrices);
  for (const NamedMethod& known : kMethods)
    benchmark::RegisterBenchmark(("answer: " + std::string(known.name)).c_str(), answered, known.method);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
    return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
