#include "bench/computations.h"
#include "methods/constrained.h"
#include "methods/torque_solution.h"

#include "bench/full_form.h"
#include "bench/peers.h"
#include "biped_of.h"
#include "udwadia_kalaba.h"

#include "answer/answer.h"
#include "motion/files.h"
#include "motion/gait.h"
#include "motion/trajectory.h"
#include "planar/dynamics.h"
#include "questions/elimination.h"
#include "robot/files/load.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <benchmark/benchmark.h>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>

namespace torqued::bench
{

namespace
{

// A walk of a robot: so many samples that no branch is foreseen because the same one came before.
struct Walk
{
  Robot robot;
  std::vector<DesiredState> single, both;

  explicit Walk(const std::string& name) : robot(load_robot(name))
  {
    name == "human-subject01" ? measured() : generated();
  }
  // the same with up to ± 5 rad/s² on every link, as feedback asks for them
  static std::vector<DesiredState> disturbed(std::vector<DesiredState> states, int links)
  {
    std::minstd_rand random(1);
    std::uniform_real_distribution<double> more(-5.0, 5.0);
    for (DesiredState& state : states)
      for (int k = 0; k < links; ++k)
        state.a(k) += more(random);
    return states;
  }

private:
  void add(const DesiredState& state)
  {
    const bool double_support =
        state.support.of(Side::left) != Contact::none && state.support.of(Side::right) != Contact::none;
    (double_support ? both : single).push_back(state);
  }
  void measured()
  {
    const std::string file = TRAJECTORIES "/subject01-walk/walk.csv";
    const Trajectory walk = parse_trajectory(read_file(file), file, coordinate_names(robot), false, Channels());
    std::vector<std::byte> buffer;
    for (const desired_state_t& state : walk.states)
      add(std::get<DesiredState>(decode_desired_state(encode(state, buffer), robot)));
  }
  void generated()
  {
    const Gait gait(robot, default_gait(robot));
    constexpr int samples = 60;
    for (const GaitPhase& phase : gait.phases())
      for (int i = 0; i < samples; ++i)
        add(gait.at(phase.begin + (phase.end - phase.begin) * (i + 0.5) / samples, phase));
  }
};

// goes round and round
template <typename T> class Cycle
{
public:
  explicit Cycle(const std::vector<T>& all) : all_(all) {}
  const T& next()
  {
    if (++at_ >= all_.size())
      at_ = 0;
    return all_[at_];
  }

private:
  const std::vector<T>& all_;
  std::size_t at_ = 0;
};

void answers(benchmark::State& state, const Walk& walk, Method method)
{
  AnswerSettings settings;
  settings.methods.method = method;
  StreamMemory memory;
  Cycle states(method == Method::none ? walk.single : walk.both);
  for (auto _ : state)
  {
    const Result<Answer> answered = answer(walk.robot, settings, states.next(), memory);
    if (!std::holds_alternative<Answer>(answered))
      state.SkipWithError("a sample was refused");
    benchmark::DoNotOptimize(&answered);
  }
}

// as many as the robot has directions, once per angle by libm: what any computation of this robot begins with
void sines_and_cosines(benchmark::State& state, const Walk& walk)
{
  const auto turns = (walk.robot.mechanism.W().array() != 0.0).rowwise().any();
  const auto count = static_cast<int>(turns.count());
  Cycle states(walk.single);
  std::array<double, 2 * kMaxDirections> e;
  for (auto _ : state)
  {
    const VectorQ& q = states.next().q;
    for (int k = 0; k < count; ++k)
    {
      const auto at = static_cast<std::size_t>(2 * k);
      sincos(q(k % q.size()), &e[at + 1], &e[at]);
    }
    benchmark::DoNotOptimize(e);
  }
}

std::pair<Motion, Support> middle_of_double_support(const Walk& walk)
{
  const DesiredState& desired = walk.both[walk.both.size() / 2];
  return {std::get<Motion>(complete_motion(walk.robot, desired)), desired.support};
}

void matrices(benchmark::State& state, const Walk& walk)
{
  std::vector<std::pair<Motion, Support>> motions;
  for (const DesiredState& desired : walk.both)
    motions.emplace_back(std::get<Motion>(complete_motion(walk.robot, desired)), desired.support);
  Cycle cycle(motions);
  for (auto _ : state)
  {
    const auto& [motion, support] = cycle.next();
    benchmark::DoNotOptimize(equation_of_motion(walk.robot, motion, support, Coordinates::absolute));
  }
}

// by F: z'' from the reduced equation, then a = F z'' + Ḟ z'
void reduced_acceleration(benchmark::State& state, const Walk& walk)
{
  const auto& [motion, support] = middle_of_double_support(walk);
  const EquationOfMotion equation = equation_of_motion(walk.robot, motion, support, Coordinates::absolute);
  for (auto _ : state)
  {
    const Elimination found =
        std::get<Elimination>(eliminate(equation.J, equation.Jdot, EliminationMethod::partitioning));
    const ReducedForm reduced = reduced_form(equation, found);
    const VectorQ rates = motion.v(found.independent);
    const VectorQ accelerations = reduced.mass.llt().solve(-reduced.gravity - reduced.coriolis * rates);
    const VectorQ a = found.F * accelerations + found.Fdot * rates;
    benchmark::DoNotOptimize(&a);
  }
}

void udwadia_and_kalaba(benchmark::State& state, const Walk& walk)
{
  const auto& [motion, support] = middle_of_double_support(walk);
  const EquationOfMotion equation = equation_of_motion(walk.robot, motion, support, Coordinates::absolute);
  const VectorJ torque = VectorJ::Zero(walk.robot.num_joints());
  for (auto _ : state)
    benchmark::DoNotOptimize(udwadia_kalaba(equation, torque));
}

void elimination(benchmark::State& state, const Walk& walk, EliminationMethod method)
{
  const auto& [motion, support] = middle_of_double_support(walk);
  const EquationOfMotion equation = equation_of_motion(walk.robot, motion, support, Coordinates::absolute);
  for (auto _ : state)
    benchmark::DoNotOptimize(eliminate(equation.J, equation.Jdot, method));
}

// the program of constrained, in one of two forms, by the same dense solver
void dense(benchmark::State& state, const Walk& walk,
           DenseProgram (*form)(const Robot&, const DesiredState&, const SupportEquations&, const Constrained&))
{
  std::vector<DenseProgram> programs;
  for (std::size_t i = 0; i < walk.both.size(); i += 10)
    programs.push_back(form(walk.robot, walk.both[i],
                            std::get<SupportEquations>(support_equations(walk.robot, walk.both[i])), Constrained{}));
  Cycle cycle(programs);
  for (auto _ : state)
  {
    const Eigen::VectorXd x = solve_dense(cycle.next());
    benchmark::DoNotOptimize(&x);
  }
}

// both forms give the torques of constrained
void check_dense(const Walk& walk)
{
  for (std::size_t i = 0; i < walk.both.size(); i += 10)
  {
    const DesiredState& desired = walk.both[i];
    const auto equations = std::get<SupportEquations>(support_equations(walk.robot, desired));
    const auto ours = std::get<TorqueSolution>(
        solve_torques(walk.robot, equations, desired.support, Method::constrained, MethodSettings{}, 1e-3));
    const int motors = walk.robot.num_joints();
    const Eigen::VectorXd full = solve_dense(full_form(walk.robot, desired, equations, Constrained{})).head(motors);
    const AdmissibleReactions all = admissible_reactions(walk.robot, equations, desired.support);
    const ReactionTorques torques = reaction_torques(walk.robot, equations, desired.support, all);
    const Eigen::VectorXd y = solve_dense(null_space_form(walk.robot, desired, equations, Constrained{}));
    const Eigen::VectorXd null_space = torques.tau0.head(motors) + torques.T.topRows(motors) * y;
    const double size = walk.robot.weight() * walk.robot.leg_length;
    if (!(full - ours.torque).isZero(1e-5 * size) || !(null_space - ours.torque).isZero(1e-6 * size))
      throw std::runtime_error("the dense solver finds other torques than constrained does");
  }
}

// on one sole, which is level; the other links anywhere
void answers_of_links(benchmark::State& state, const Robot& robot)
{
  const int n = robot.num_coordinates();
  std::vector<DesiredState> states;
  for (int i = 0; i < 100; ++i)
  {
    DesiredState desired{};
    desired.support = {{Contact::sole, Contact::none}, Side::left, 0.0, 0.0};
    desired.q = desired.v = desired.a = VectorQ::Zero(n + 2);
    for (int k = 0; k < n; ++k)
      if (k != robot.foot(Side::left).direction)
      {
        desired.q(k) = 0.3 * std::sin(1.0 + i + 2.0 * k);
        desired.v(k) = std::sin(2.0 + 2.0 * i + k);
        desired.a(k) = 5.0 * std::sin(3.0 + 3.0 * i + k);
      }
    states.push_back(desired);
  }
  const AnswerSettings settings;
  StreamMemory memory;
  Cycle cycle(states);
  for (auto _ : state)
  {
    const Result<Answer> answered = answer(robot, settings, cycle.next(), memory);
    if (!std::holds_alternative<Answer>(answered))
      state.SkipWithError("a sample was refused");
    benchmark::DoNotOptimize(&answered);
  }
}

void other_engine(benchmark::State& state, Peer& peer, int motions)
{
  int motion = 0;
  for (auto _ : state)
  {
    peer.compute(motion);
    motion = motion + 1 < motions ? motion + 1 : 0;
  }
}

// the median, in ns, of what the clock measures where nothing is done
double clock_alone()
{
  std::vector<double> ns(999);
  for (double& each : ns)
  {
    const auto begin = std::chrono::steady_clock::now();
    each = std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
  }
  std::nth_element(ns.begin(), ns.begin() + 499, ns.end());
  return ns[499];
}

// One call after another, each timed by itself and without the clock's own time: what a batch does not tell is how the
// slow ones compare.
void call_by_call(const Walk& walk, const std::vector<DesiredState>& states, const std::string& robot,
                  const AnswerSettings& settings, const std::string& name, Rounds& rounds, bool quick)
{
  StreamMemory memory;
  std::vector<double> ns;
  for (int pass = quick ? 1 : 20; pass > 0; --pass)
    for (const DesiredState& state : states)
    {
      const auto begin = std::chrono::steady_clock::now();
      const Result<Answer> answered = answer(walk.robot, settings, state, memory);
      ns.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count());
      benchmark::DoNotOptimize(&answered);
    }
  std::sort(ns.begin(), ns.end());
  const std::string group = robot + ", call by call";
  const double clock = clock_alone();
  rounds.add(group, name + " p50", "ns", ns[ns.size() / 2] - clock);
  rounds.add(group, name + " p99", "ns", ns[ns.size() * 99 / 100] - clock);
}

// keeps the times of one round; a benchmark's name is GROUP/NAME
class Keeper : public benchmark::BenchmarkReporter
{
public:
  explicit Keeper(Rounds& rounds) : rounds_(rounds) {}
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override
  {
    for (const Run& run : runs)
    {
      if (run.error_occurred)
        throw std::runtime_error(run.benchmark_name() + ": " + run.error_message);
      const std::string& name = run.run_name.function_name;
      const std::size_t slash = name.find('/');
      rounds_.add(name.substr(0, slash), name.substr(slash + 1), "ns", run.GetAdjustedRealTime());
    }
  }

private:
  Rounds& rounds_;
};

// The robots, and the engines that were told of them.
struct Subject
{
  Walk walk;
  std::string name;
  std::vector<std::unique_ptr<Peer>> peers;

  explicit Subject(const std::string& robot) : walk(robot), name(robot)
  {
    peers.push_back(make_mujoco(walk.robot));
    peers.push_back(make_dart(walk.robot));
    peers.push_back(make_kdl(walk.robot));
    for (const std::unique_ptr<Peer>& peer : peers)
      for (const DesiredState& state : walk.single)
      {
        const Motion motion = std::get<Motion>(complete_motion(walk.robot, state));
        VectorQ q = state.q;
        q.tail<2>() = motion.now.base;
        peer->compute(peer->remember(q, motion.v, motion.a));
        const VectorQ ours = inverse_dynamics(walk.robot.mechanism, motion.now, motion.a);
        if (!(peer->generalized_force() - ours).isZero(1e-9 * walk.robot.weight()))
          throw std::runtime_error(std::string(peer->name()) + " computes other forces than we do");
      }
  }
};

const std::vector<std::unique_ptr<Subject>>& subjects()
{
  static const std::vector<std::unique_ptr<Subject>> all = []
  {
    std::vector<std::unique_ptr<Subject>> subjects;
    for (const char* robot : {"ck", "rk", "human-subject01"})
      subjects.push_back(std::make_unique<Subject>(robot));
    return subjects;
  }();
  return all;
}

const std::vector<Robot>& bipeds()
{
  static const std::vector<Robot> all = []
  {
    std::vector<Robot> robots;
    for (int links = 3; links <= 13; links += 2)
      robots.push_back(biped_of(links));
    return robots;
  }();
  return all;
}

void register_all(double seconds)
{
  const auto add = [seconds](const std::string& group, std::string_view name, const auto& function)
  {
    benchmark::RegisterBenchmark((group + "/" + std::string(name)).c_str(), function)->MinTime(seconds);
  };
  for (const std::unique_ptr<Subject>& subject : subjects())
  {
    const Walk* const walk = &subject->walk;
    add(subject->name, "sines and cosines", [walk](benchmark::State& state) { sines_and_cosines(state, *walk); });
    add(subject->name, "single support", [walk](benchmark::State& state) { answers(state, *walk, Method::none); });
    for (const MethodRow& known : methods())
      add(subject->name, known.name,
          [walk, method = known.method](benchmark::State& state) { answers(state, *walk, method); });
    add(subject->name, "M, C, g, B, J", [walk](benchmark::State& state) { matrices(state, *walk); });
    for (const std::unique_ptr<Peer>& peer : subject->peers)
      add(subject->name, peer->name(),
          [walk, &peer](benchmark::State& state)
          { other_engine(state, *peer, static_cast<int>(walk->single.size())); });
  }
  for (const Robot& robot : bipeds())
    add("links, single support", std::to_string(robot.links.size()),
        [&robot](benchmark::State& state) { answers_of_links(state, robot); });
  const Walk* const ck = &subjects().front()->walk;
  check_dense(*ck);
  add("quadratic program, ck, by a dense solver", "in y",
      [ck](benchmark::State& state) { dense(state, *ck, null_space_form); });
  add("quadratic program, ck, by a dense solver", "in torques and reactions",
      [ck](benchmark::State& state) { dense(state, *ck, full_form); });
  // double support of the measured walk: 3 coordinates are free of 9
  const Walk* const walk = &subjects().back()->walk;
  const std::string group = "free coordinates, human-subject01";
  for (const NamedElimination& known : kEliminations)
    add(group, "F, Fdot, F_bar: " + std::string(known.name),
        [walk, method = known.method](benchmark::State& state) { elimination(state, *walk, method); });
  add(group, "acceleration, reduced", [walk](benchmark::State& state) { reduced_acceleration(state, *walk); });
  add(group, "acceleration, Udwadia-Kalaba", [walk](benchmark::State& state) { udwadia_and_kalaba(state, *walk); });
}

void promise_all(const std::string& robot, const std::string& mujoco, Rounds& rounds)
{
  rounds.promise({robot, "single support", mujoco, 1.0 / 12.0});
  rounds.promise({robot, "single support", "sines and cosines", 2.5});
  for (const MethodRow& known : methods())
    if (known.method != Method::constrained)
      rounds.promise({robot, std::string(known.name), "single support", 2.0});
  rounds.promise({robot + ", call by call", "constrained p50", "single support p50", 4.0});
  // at the measured walk's 99th percentile windows give way: four programs in turn
  rounds.promise(
      {robot + ", call by call", "constrained p99", "single support p50", robot == "human-subject01" ? 40.0 : 10.0});
  const std::string group = robot + ", call by call";
  for (const std::string support : {"single", "double"})
  {
    rounds.promise({group, "nearest, " + support + " support p50", "single support p50", 10.0});
    rounds.promise({group, "nearest, " + support + " support p99", "single support p50", 20.0});
  }
}

} // namespace

void measure_computations(Rounds& rounds, bool quick)
{
  static const bool registered = [quick]
  {
    register_all(quick ? 0.001 : 0.05);
    return true;
  }();
  static_cast<void>(registered);
  flush_denormals();
  Keeper keeper(rounds);
  benchmark::RunSpecifiedBenchmarks(&keeper);
  for (const std::unique_ptr<Subject>& subject : subjects())
  {
    const Walk& walk = subject->walk;
    const auto each_call =
        [&](const std::vector<DesiredState>& states, OnInfeasible infeasible, const std::string& name)
    {
      AnswerSettings settings;
      settings.methods.infeasible = infeasible;
      call_by_call(walk, states, subject->name, settings, name, rounds, quick);
    };
    each_call(walk.single, OnInfeasible::relax, "single support");
    each_call(walk.both, OnInfeasible::relax, "constrained");
    // where nothing gives, and where the acceleration does
    each_call(walk.single, OnInfeasible::nearest, "single support, had");
    each_call(walk.both, OnInfeasible::nearest, "constrained, had");
    const int links = walk.robot.num_coordinates();
    each_call(Walk::disturbed(walk.single, links), OnInfeasible::nearest, "nearest, single support");
    each_call(Walk::disturbed(walk.both, links), OnInfeasible::nearest, "nearest, double support");
    promise_all(subject->name, std::string(subject->peers.front()->name()), rounds);
  }
}

} // namespace torqued::bench
