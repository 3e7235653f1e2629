#include "catch.h"
#include "matchers.h"
#include "methods/constrained.h"
#include "methods/torque_solution.h"
#include "oracles.h"
#include "run_torquectl.h"

#include "motion/failure.h"
#include "motion/gait.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"
#include "robot/files/toml_robot.h"
#include "stance/checks.h"

#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <numbers>

namespace gait_test
{

using namespace torqued;

namespace
{

constexpr double kDegree = std::numbers::pi / 180.0;

SupportEquations equations_of(const Robot& robot, const DesiredState& state)
{
  return std::get<SupportEquations>(support_equations(robot, state));
}

TorqueSolution solution(const Robot& robot, const DesiredState& state, Method method,
                        const MethodSettings& settings = {})
{
  const auto solved = solve_torques(robot, equations_of(robot, state), state.support, method, settings, 1e-3);
  if (const Refusal* refusal = std::get_if<Refusal>(&solved))
    FAIL(std::string(refusal->detail()));
  return std::get<TorqueSolution>(solved);
}

GaitOptions random_options(oracle::Random& random, const Robot& robot)
{
  GaitOptions options = default_gait(robot);
  options.step_length = oracle::uniform(random, 0.28, 0.5);
  options.step_time = oracle::uniform(random, 0.55, 1.2);
  options.double_support = oracle::uniform(random, 0.25, 0.6);
  options.first_part = oracle::uniform(random, 0.35, 0.65);
  options.heel_strike = oracle::uniform(random, 0.0, 15.0) * kDegree;
  options.toe_off = oracle::uniform(random, 0.0, 20.0) * kDegree;
  options.trunk_angle = oracle::uniform(random, -8.0, 4.0) * kDegree;
  options.hip_height = oracle::uniform(random, 0.88, 0.95) * robot.leg_length + robot.feet[0].ankle_height();
  options.clearance = oracle::uniform(random, 0.03, 0.06);
  options.steps = 3;
  return options;
}

// A random walk of a robot; none if the options are out of its reach.
std::optional<Gait> try_random_gait(oracle::Random& random, const Robot& robot)
{
  const GaitOptions options = random_options(random, robot);
  try
  {
    return Gait(robot, options);
  }
  catch (const Failure&)
  {
    return {};
  }
}

// Half of the options at least are within reach: ten in a row that are not are a fault of Gait.
Gait random_gait(oracle::Random& random, const Robot& robot)
{
  std::optional<Gait> gait;
  for (int tries = 0; !gait && tries < 10; ++tries)
    gait = try_random_gait(random, robot);
  REQUIRE(gait);
  return *gait;
}

std::string failure_of(const Robot& robot, const GaitOptions& options)
{
  try
  {
    const Gait gait(robot, options);
    return "";
  }
  catch (const Failure& failure)
  {
    return failure.what();
  }
}

#ifdef NDEBUG
constexpr int kWalks = 50;
#else
constexpr int kWalks = 2;
#endif

} // namespace

TEST_CASE("a walk's rates and accelerations are the derivatives of its angles", "[gait]")
{
  oracle::Random random(701);
  for (const char* name : {"ck", "rk", "human-subject01"})
  {
    const Robot robot = load_robot(name);
    const Gait gait(robot, default_gait(robot));
    for (const GaitPhase& phase : gait.phases())
    {
      const double margin = 0.1 * (phase.end - phase.begin);
      const double t = oracle::uniform(random, phase.begin + margin, phase.end - margin);
      CAPTURE(name, t);
      const DesiredState state = gait.at(t, phase);
      const auto q = [&](double h)
      {
        return Eigen::VectorXd(gait.at(t + h, phase).q);
      };
      const auto v = [&](double h)
      {
        return Eigen::VectorXd(gait.at(t + h, phase).v);
      };
      // the eighth-order stencil: rounding 1e-15 / 1e-3; its error is (10 h)⁸ of changes over a tenth of a second
      CHECK(mismatch(oracle::slope(q, 1e-3), state.v, 1e-9) == "");
      CHECK(mismatch(oracle::slope(v, 1e-3), state.a, 1e-8) == "");
    }
  }
}

TEST_CASE("where contacts change a walk is continuous up to accelerations, and the foot concerned rests", "[gait]")
{
  oracle::Random random(702);
  int changes = 0;
  for (int i = 0; i < kWalks; ++i)
  {
    const Robot robot = load_robot(i % 2 == 0 ? "ck" : "rk");
    const Gait gait = random_gait(random, robot);
    CAPTURE(i);
    const auto& phases = gait.phases();
    for (std::size_t k = 1; k < phases.size(); ++k)
    {
      const double t = phases[k].begin;
      REQUIRE(phases[k - 1].end == t);
      const DesiredState before = gait.at(t, phases[k - 1]), after = gait.at(t, phases[k]);
      CHECK(mismatch(before.q, after.q, 1e-12) == "");
      CHECK(mismatch(before.v, after.v, 1e-10) == "");
      CHECK(mismatch(before.a, after.a, 1e-8) == "");
      CHECK(before.support.phase == 1.0);
      CHECK(after.support.phase == 0.0);
      // ankle, heel and toe of the foot whose contact changes, and of the other if it is loaded, are at rest
      const auto equations = equations_of(robot, after);
      for (const Side side : kSides)
      {
        if (after.support.of(side) == before.support.of(side))
          continue;
        ++changes;
        const Foot& foot = robot.foot(side);
        Jacobian J(4, robot.mechanism.num_q());
        const Kinematics& now = equations.now;
        point_jacobian(robot.mechanism, now, foot.heel, 0, J);
        point_jacobian(robot.mechanism, now, foot.toe, 2, J);
        CHECK((J * after.v).cwiseAbs().maxCoeff() < 1e-11);
        CHECK((J.topRows<2>() * after.a + jacobian_rate_times_v(now, foot.heel)).cwiseAbs().maxCoeff() < 1e-9);
        CHECK((J.bottomRows<2>() * after.a + jacobian_rate_times_v(now, foot.toe)).cwiseAbs().maxCoeff() < 1e-9);
      }
    }
  }
  // of three steps: touch-downs, changes from DSP1 to DSP2, which both feet do, and lift-offs
  CHECK(changes == kWalks * (3 + 3 * 2 + 2));
}

TEST_CASE("a walk keeps its contacts and stays above the ground", "[gait]")
{
  oracle::Random random(703);
  for (int i = 0; i < kWalks; ++i)
  {
    const Robot robot = load_robot(i % 2 == 0 ? "ck" : "rk");
    const Gait gait = random_gait(random, robot);
    CAPTURE(i);
    for (const GaitPhase& phase : gait.phases())
      for (int k = 0; k <= 10; ++k)
      {
        const DesiredState state = gait.at(phase.begin + (phase.end - phase.begin) * k / 10.0, phase);
        const SupportEquations equations = equations_of(robot, state);
        CHECK(equations.contact_speed < 1e-11);
        CHECK(equations.contact_residual < 1e-9);
        CHECK(equations.sole_tilt < 1e-15);
        for (const Side side : kSides)
        {
          const FootPose pose = foot_pose(robot, equations.now, robot.foot(side));
          CHECK(std::min(pose.heel.y(), pose.toe.y()) > -1e-9);
          // what carries is on the ground, and nowhere else but at its foothold
          if (state.support.of(side) != Contact::none)
            CHECK(std::abs((state.support.of(side) == Contact::heel ? pose.heel : pose.toe).y()) < 1e-12);
        }
        // knees bend like a human's: the thigh before the shin
        CHECK(state.q(2) - state.q(1) >= gait.report().knee_flexion - 1e-3);
        CHECK(state.q(3) - state.q(4) > 0.0);
      }
  }
}

TEST_CASE("each step of a walk is the mirror image of the one before, a step further on", "[gait]")
{
  const Robot robot = load_robot("rk");
  const GaitOptions options = default_gait(robot);
  const Gait gait(robot, options);
  const auto& phases = gait.phases();
  REQUIRE(phases.size() == 3 * static_cast<std::size_t>(options.steps));
  for (std::size_t k = 0; k + 3 < phases.size(); ++k)
    for (const double share : {0.0, 0.3, 0.8})
    {
      const auto at = [&](const GaitPhase& phase)
      {
        return gait.at(phase.begin + share * (phase.end - phase.begin), phase);
      };
      const DesiredState one = at(phases[k]), next = at(phases[k + 3]);
      VectorQ mirrored = one.q;
      for (int c = 0; c < 6; ++c)
        mirrored(c) = one.q(5 - c);
      mirrored(7) += options.step_length;
      CHECK(mismatch(next.q, mirrored, 1e-12) == "");
      CHECK(next.support.leading == other(one.support.leading));
      CHECK(next.support.contact[0] == one.support.contact[1]);
      CHECK(mismatch(next.support.load_transfer, one.support.load_transfer, 1e-12) == "");
    }
  // load_transfer runs over the whole double support, phase over each part
  CHECK(gait.at(phases[1].begin, phases[1]).support.load_transfer == Approx(0.0).margin(1e-12));
  CHECK(gait.at(phases[1].end, phases[1]).support.load_transfer == Approx(options.first_part));
  CHECK(gait.at(phases[2].end, phases[2]).support.load_transfer == 1.0);
  CHECK(gait.at(phases[0].begin, phases[0]).support.leading == Side::left);
  CHECK(gait.at(phases[1].begin, phases[1]).support.leading == Side::right);
}

TEST_CASE("the zero-moment point is where a walk says", "[gait]")
{
  for (const char* name : {"ck", "rk", "human-subject01"})
  {
    CAPTURE(name);
    const Robot robot = load_robot(name);
    const Gait gait(robot, default_gait(robot));
    CHECK(gait.report().zmp_margin > 0.04);
    CHECK(gait.report().switch_margin > 0.02);
    CHECK(gait.report().zmp_error < 0.04);
    double least = 1.0;
    for (const GaitPhase& phase : gait.phases())
      for (int k = 0; k <= 50; ++k)
      {
        const DesiredState state = gait.at(phase.begin + (phase.end - phase.begin) * k / 50.0, phase);
        if (state.support.redundancy() > 0)
          continue;
        const TorqueSolution found = solution(robot, state, Method::none);
        const auto equations = equations_of(robot, state);
        const Side side = state.support.leading;
        const auto index = static_cast<std::size_t>(side);
        const GroundReaction ground =
            ground_reaction(robot, robot.foot(side), equations.foot(side), found.ground[index]);
        CHECK(contact_flags(robot, robot.foot(side), equations.foot(side), Contact::sole, found.ground[index]) == 0);
        least = std::min({least, ground.cop - robot.foot(side).heel_x(), robot.foot(side).toe_x() - ground.cop});
      }
    // at every fourth of the report's samples
    CHECK(least >= gait.report().zmp_margin - 1e-12);
    CHECK(least < gait.report().zmp_margin + 1e-3);
  }
}

TEST_CASE("with rolling knees of no radius the walk is that of pin knees", "[gait]")
{
  const oracle::Biped ck;
  oracle::Biped rk = ck;
  rk.r1 = rk.r2 = 1e-9;
  const GaitOptions options = default_gait(ck.robot());
  const Gait pin(ck.robot(), options), rolling(rk.robot(), options);
  for (const GaitPhase& phase : pin.phases())
  {
    const double t = 0.5 * (phase.begin + phase.end);
    CHECK(mismatch(pin.at(t, phase).q, rolling.at(t, phase).q, 1e-7) == "");
    CHECK(mismatch(pin.at(t, phase).a, rolling.at(t, phase).a, 1e-6) == "");
  }
}

TEST_CASE("on random walks no torque jumps with zmp-transition, nor with constrained, which keeps all conditions",
          "[gait][slow]")
{
  oracle::Random random(704);
  int walks = 0, out_of_reach = 0, tipping = 0, changes = 0, jumps = 0, relaxed = 0, samples = 0;
  for (int i = 0; i < 2 * kWalks; ++i)
  {
    CAPTURE(i);
    const Robot robot = load_robot(i % 2 == 0 ? "ck" : "rk");
    const auto gait = try_random_gait(random, robot);
    if (!gait)
    {
      ++out_of_reach;
      continue;
    }
    // feasible: the zero-moment point stays in the sole, and where the trailing heel lifts between toe and heel
    if (std::min(gait->report().zmp_margin, gait->report().switch_margin) < 1e-3)
    {
      ++tipping;
      continue;
    }
    ++walks;
    const auto& phases = gait->phases();
    for (std::size_t k = 1; k < phases.size(); ++k)
    {
      const double t = phases[k].begin;
      const DesiredState before = gait->at(t, phases[k - 1]), after = gait->at(t, phases[k]);
      const auto jump = [&](Method method)
      {
        return (solution(robot, before, method).torque - solution(robot, after, method).torque).cwiseAbs().maxCoeff();
      };
      ++changes;
      CHECK(jump(Method::zmp_transition) < 1e-6);
      CHECK(jump(Method::constrained) < 1e-6);
      jumps += jump(Method::internal_wrench) > 0.1 ? 1 : 0;
      CHECK_FALSE(solution(robot, before, Method::constrained).relaxed);
      CHECK_FALSE(solution(robot, after, Method::constrained).relaxed);
    }
    // between: windows may relax, contacts and motors not, unless they cannot be met whatever the windows
    MethodSettings refusing;
    refusing.infeasible = OnInfeasible::refuse;
    refusing.of<Constrained>().windows = false;
    for (const GaitPhase& phase : phases)
      for (int k = 0; k <= 10; ++k)
      {
        const DesiredState state = gait->at(phase.begin + (phase.end - phase.begin) * k / 10.0, phase);
        if (state.support.redundancy() == 0)
          continue;
        const SupportEquations equations = equations_of(robot, state);
        const auto plain = solve_torques(robot, equations, state.support, Method::constrained, refusing, 1e-3);
        if (std::holds_alternative<Refusal>(plain))
          continue;
        ++samples;
        const TorqueSolution found = solution(robot, state, Method::constrained);
        relaxed += found.relaxed ? 1 : 0;
        for (const Side side : kSides)
          CHECK(contact_flags(robot, robot.foot(side), equations.foot(side), state.support.of(side),
                              found.ground[static_cast<std::size_t>(side)]) == 0);
        CHECK(found.torque.cwiseAbs().maxCoeff() < 150.0 * (1.0 + 1e-7));
      }
  }
  CAPTURE(walks, out_of_reach, tipping, changes, jumps, relaxed, samples);
  CHECK(walks > kWalks / 2);
  CHECK(out_of_reach <= kWalks); // of twice as many
  CHECK(jumps > 9 * changes / 10);
  CHECK(relaxed < samples / 10);
}

TEST_CASE("walks that cannot be are refused with what to change", "[gait]")
{
  const Robot ck = load_robot("ck");
  const auto with = [&](auto change)
  {
    GaitOptions options = default_gait(ck);
    change(options);
    return failure_of(ck, options);
  };
  CHECK(with([](auto&) {}) == "");
  CHECK(with([](auto& o) { o.step_length = -0.1; }) == "--step-length: found -0.1; expected 0 to 1.58 m");
  CHECK(with([](auto& o) { o.step_time = 0.0; }) == "--step-time: found 0; expected 0.05 to 60 s");
  CHECK(with([](auto& o) { o.double_support = 1.0; }) ==
        "--double-support: found 1; expected 0.01 to 0.99 of the step time");
  CHECK(with([](auto& o) { o.first_part = NAN; }) ==
        "--first-part: found nan; expected 0.01 to 0.99 of double support");
  CHECK(with([](auto& o) { o.heel_strike = 70.0 * kDegree; }) == "--heel-strike: found 70; expected 0 to 60 degrees");
  CHECK(with([](auto& o) { o.toe_off = -1.0 * kDegree; }) == "--toe-off: found -1; expected 0 to 60 degrees");
  CHECK(with([](auto& o) { o.steps = 0; }) == "--steps: found 0; expected 1 to 1000");
  CHECK(
      with([](auto& o) { o.hip_height = 0.9; }).ends_with("a lower --hip-height or a shorter --step-length would do"));
  CHECK(with([](auto& o) { o.hip_height = 0.15; }).ends_with("a higher --hip-height or less --clearance would do"));
  const auto dragging = [&](double heel_strike)
  {
    return with(
        [&](auto& o)
        {
          o.hip_height = 0.78;
          o.clearance = o.toe_off = 0.0;
          o.heel_strike = heel_strike;
        });
  };
  CHECK(dragging(0.0) == ""); // the foot slides over the ground
  const std::string below = dragging(40.0 * kDegree);
  CHECK(below.ends_with(" m below the ground; more --clearance would do"));
  // some centimetres, not the first that is found
  CHECK(std::stod(below.substr(below.find("would be ") + 9)) > 0.005);
  CHECK(failure_of(load_robot("rabbit"), default_gait(load_robot("rabbit")))
            .starts_with("rabbit cannot walk like this: its left foot has no extent; expected a floating trunk"));
  CHECK(failure_of(load_robot("six-link"), default_gait(ck))
            .starts_with("six-link cannot walk like this: its root is fixed to the world;"));
  std::string arm =
      std::string(shipped_robot_toml("ck")) +
      "[[link]]\nname = \"arm\"\njoint = \"revolute\"\nparent = \"trunk\"\nat = [0, 0.5]\nmass = 1\n"
      "com = [0, -0.3]\ninertia = 0.01\ncoordinate = \"arm\"\n[[actuator]]\nname = \"shoulder\"\non = \"arm\"\n"
      "against = \"trunk\"\n";
  CHECK(failure_of(read_toml_robot(arm, "arm.toml"), default_gait(ck)).find("it has 8 coordinates") !=
        std::string::npos);
}

TEST_CASE("torquectl gait writes a walk that reads back as the same numbers, each change of contacts twice", "[gait]")
{
  const TemporaryFolder folder;
  const std::string out = folder.file("walk.csv");
  const Run made = run({"gait", "--robot", "rk", "--steps", "2", "--step-length", "0.4", "--rate", "100", "-o", out});
  CAPTURE(made.err);
  CHECK(made.code == 0);
  CHECK(made.out.empty());
  CHECK(made.err.find("rk walks 2 steps of 0.400 m and ") != std::string::npos);
  CHECK(made.err.find("m inside what carries, and ") != std::string::npos);

  const Robot robot = load_robot("rk");
  GaitOptions options = default_gait(robot);
  options.steps = 2;
  options.step_length = 0.4;
  const Gait gait(robot, options);
  const Trajectory read = parse_trajectory(read_file(out), out, coordinate_names(robot), false, Channels());
  std::size_t k = 0;
  std::size_t rows = 0;
  for (const desired_state_t& state : read.states)
  {
    const auto utime = [](double t)
    {
      return std::llround(1e6 * t);
    };
    const auto& phases = gait.phases();
    if (k + 1 < phases.size() && state.utime > utime(phases[k].end))
    {
      // the last row was the end of its phase, this one is the same instant
      const desired_state_t& last = read.states[rows - 1];
      CHECK(last.utime == utime(phases[k].end));
      CHECK(last.phase == 1.0);
      CHECK(state.utime == last.utime + 1);
      CHECK(state.phase == 0.0);
      const auto same = [](const std::vector<double>& a, const std::vector<double>& b)
      {
        return mismatch(Eigen::Map<const Eigen::VectorXd>(a.data(), static_cast<Eigen::Index>(a.size())),
                        Eigen::Map<const Eigen::VectorXd>(b.data(), static_cast<Eigen::Index>(b.size())), 1e-9);
      };
      CHECK(same(last.q, state.q) == "");
      CHECK(same(last.v, state.v) == "");
      CHECK(same(last.a, state.a) == "");
      ++k;
    }
    ++rows;
    // at the time of the row, but for what 1 µs and its rounding change
    const DesiredState expected = gait.at(1e-6 * static_cast<double>(state.utime), phases[k]);
    CHECK(mismatch(Eigen::Map<const Eigen::VectorXd>(state.q.data(), 7), expected.q.head<7>(), 1e-5) == "");
    CHECK(state.left_contact == static_cast<int>(expected.support.of(Side::left)));
    CHECK(state.right_contact == static_cast<int>(expected.support.of(Side::right)));
    CHECK(state.leading_foot == static_cast<int>(expected.support.leading));
    CHECK(state.base == desired_state_t::GIVEN);
  }
  CHECK(k == 5);

  const Run eval = run({"eval", out, "--robot", "rk", "-o", folder.file("answers.csv")});
  CHECK(eval.code == 0);
  CHECK(eval.out.find(fmt::format("rk: {0} of {0} samples answered, 0 rejected", read.states.size())) !=
        std::string::npos);
  CHECK(eval.out.find("INCONSISTENT") == std::string::npos);
}

TEST_CASE("torquectl gait says what is wrong with its options", "[gait]")
{
  const TemporaryFolder folder;
  const std::string out = folder.file("walk.csv");
  const auto error = [&](std::vector<std::string> words)
  {
    words.insert(words.begin(), {"gait", "--robot", "ck"});
    const Run ended = run(words);
    return fmt::format("{} {}", ended.code, ended.err);
  };
  CHECK(error({"-o", folder.file("walk.lcm")}) ==
        fmt::format("64 torquectl: -o: found \"{}\"; expected a name that ends in .csv, or -\n",
                    folder.file("walk.lcm")));
  CHECK(
      error({"-o", out, "--rate", "1"})
          .starts_with("64 torquectl: --rate: found 1; expected 6.777 to 100000 Hz, so that each phase has a sample"));
  CHECK(run({"gait", "-o", out, "--robot", "compass"}).err.starts_with("torquectl: compass cannot walk like this"));
  CHECK(error({"-o", out, "--toe-off", "90"}) == "64 torquectl: --toe-off: found 90; expected 0 to 60 degrees\n");
  CHECK(error({}).starts_with("64 torquectl: --output is required"));
  // a walk that the motors cannot do is refused, and written if it is wanted anyway
  const std::string weak = error({"-o", out, "--step-time", "0.3"});
  CHECK(weak.starts_with("64 torquectl: ck cannot walk like this: at 0."));
  CHECK(weak.find("a longer --step-time would do; --anyway writes it all the same") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(out));
  const Run anyway = run({"gait", "--robot", "ck", "-o", out, "--step-time", "0.3", "--anyway"});
  CHECK(anyway.code == 0);
  CHECK(anyway.err.find("left_hip would need ") != std::string::npos);
  CHECK(error({"-o", out, "--standing", "0.01"}) == "64 torquectl: --standing: found 0.01; expected 0.1 to 60 s\n");
}

TEST_CASE("a walk from standing to standing rests at both ends, with its feet side by side", "[gait]")
{
#ifdef NDEBUG
  const std::vector<std::pair<const char*, bool>> cases{
      {"ck", false}, {"ck", true}, {"rk", false}, {"rk", true}, {"human-subject01", false}, {"human-subject01", true}};
#else
  const std::vector<std::pair<const char*, bool>> cases{{"rk", true}};
#endif
  for (const auto& [name, flat_footed] : cases)
  {
    CAPTURE(name, flat_footed);
    const Robot robot = load_robot(name);
    GaitOptions options = default_gait(robot);
    options.standing = 1.0;
    options.flat_footed = flat_footed;
    options.hip_height *= 0.95;
    options.steps = 3;
    const Gait gait(robot, options);
    CHECK(gait.obstacle() == "");
    CHECK(gait.report().zmp_margin > 0.03);
    const auto& phases = gait.phases();
    const double lengths[] = {0.0, 2.0 * options.step_length};
    for (const int end : {0, 1})
    {
      const GaitPhase& phase = end == 0 ? phases.front() : phases.back();
      const DesiredState state = gait.at(end == 0 ? phase.begin : phase.end, phase);
      CHECK(state.support.contact == std::array{Contact::sole, Contact::sole});
      CHECK(state.support.load_transfer == 0.5);
      CHECK(state.support.phase == 0.5);
      CHECK(state.v.cwiseAbs().maxCoeff() < 1e-12);
      CHECK(state.a.cwiseAbs().maxCoeff() < 1e-10);
      const SupportEquations equations = equations_of(robot, state);
      for (const Side side : kSides)
        CHECK(mismatch(equations.foot(side).ankle.x(), lengths[end], 1e-9) == "");
      // at rest the zero-moment point is below the centre of mass, in the middle of the soles
      const Foot& foot = robot.foot(Side::left);
      CHECK(mismatch(zero_moment_point(robot, equations), lengths[end] + 0.5 * (foot.heel_x() + foot.toe_x()), 1e-4) ==
            "");
    }
    // continuous where contacts change, no foot below the ground, rates the derivatives of angles
    for (std::size_t k = 0; k < phases.size(); ++k)
    {
      const double t = phases[k].begin;
      if (k > 0)
      {
        const DesiredState before = gait.at(t, phases[k - 1]), after = gait.at(t, phases[k]);
        CHECK(mismatch(before.q, after.q, 1e-12) == "");
        CHECK(mismatch(before.v, after.v, 1e-10) == "");
        CHECK(mismatch(before.a, after.a, 1e-8) == "");
        const auto jump =
            (solution(robot, before, Method::constrained).torque - solution(robot, after, Method::constrained).torque)
                .cwiseAbs()
                .maxCoeff();
        CHECK(jump < 1e-6);
      }
      const double middle = 0.5 * (phases[k].begin + phases[k].end);
      const DesiredState state = gait.at(middle, phases[k]);
      const SupportEquations equations = equations_of(robot, state);
      CHECK(equations.contact_speed < 1e-11);
      CHECK(equations.contact_residual < 1e-9);
      // knots are 18 ms apart: within a stencil of ±4 × 0.2 ms the fifth derivative is one or two constants
      const auto q = [&](double h)
      {
        return Eigen::VectorXd(gait.at(middle + h, phases[k]).q);
      };
      const auto v = [&](double h)
      {
        return Eigen::VectorXd(gait.at(middle + h, phases[k]).v);
      };
      CHECK(mismatch(oracle::slope(q, 2e-4), state.v, 1e-8) == "");
      CHECK(mismatch(oracle::slope(v, 2e-4), state.a, 1e-6) == "");
    }
  }
}

TEST_CASE("flat-footed, both soles are on the ground in double support, and a walk goes from one foot to the other",
          "[gait]")
{
  const Robot robot = load_robot("ck");
  GaitOptions options = default_gait(robot);
  options.flat_footed = true;
  options.hip_height *= 0.95;
  const Gait gait(robot, options);
  REQUIRE(gait.phases().size() == 2 * static_cast<std::size_t>(options.steps));
  for (const GaitPhase& phase : gait.phases())
    for (const double share : {0.0, 0.4, 1.0})
    {
      const DesiredState state = gait.at(phase.begin + share * (phase.end - phase.begin), phase);
      CHECK(state.q(0) == 0.0); // feet level, also while they swing
      CHECK(state.q(5) == 0.0);
      if (phase.kind != GaitPhaseKind::flat)
        continue;
      CHECK(state.support.contact == std::array{Contact::sole, Contact::sole});
      CHECK(mismatch(state.support.load_transfer, share, 1e-12) == "");
      CHECK(state.support.leading == (phase.step % 2 == 0 ? Side::right : Side::left));
    }
}

TEST_CASE("over a grid, walks are refused with a reason, or constrained keeps all conditions and limits",
          "[gait][slow]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("walk.csv"), answers = folder.file("answers.csv");
#ifdef NDEBUG
  const std::vector<std::string> lengths{"0.15", "0.3", "0.45", "0.6"}, times{"0.45", "0.7", "1.1"},
      shares{"0.2", "0.5"};
#else
  const std::vector<std::string> lengths{"0.3"}, times{"0.7"}, shares{"0.5"};
#endif
  int walked = 0;
  std::map<std::string, int> refused; // by the reason's beginning
#ifdef NDEBUG
  const std::vector<std::string> robots{"ck", "rk"};
#else
  const std::vector<std::string> robots{"rk"};
#endif
  for (const std::string& robot : robots)
    for (const std::string& length : lengths)
      for (const std::string& time : times)
        for (const std::string& share : shares)
          for (const std::vector<std::string>& manner :
               std::vector<std::vector<std::string>>{{},
                                                     {"--flat-footed"},
                                                     {"--standing", "0.8"},
                                                     {"--standing", "0.8", "--flat-footed"},
                                                     {"--trunk-angle", "-8", "--toe-off", "20"}})
          {
            std::vector<std::string> words{"gait", "--robot", robot, "--step-length",    length, "--step-time",
                                           time,   "--steps", "2",   "--double-support", share,  "--rate",
                                           "100",  "-o",      walk};
            words.insert(words.end(), manner.begin(), manner.end());
            CAPTURE(words);
            const Run made = run(words);
            if (made.code != 0)
            {
              REQUIRE(made.code == 64);
              REQUIRE(made.err.find(" would do") != std::string::npos);
              for (const char* reason :
                   {"the leg can be", "would tip", "would slip", "have to pull", "would need", "below the ground"})
                refused[reason] += made.err.find(reason) != std::string::npos ? 1 : 0;
              continue;
            }
            ++walked;
            const Run eval = run({"eval", walk, "--robot", robot, "--method", "constrained", "-o", answers});
            CAPTURE(eval.out);
            REQUIRE(eval.code == 0);
            CHECK(eval.out.find(" 0 rejected") != std::string::npos);
            for (const char* flag : {"SLIPS", "LIFTS", "TIPS", "OVER_TORQUE", "INCONSISTENT"})
              CHECK(eval.out.find(flag) == std::string::npos);
          }
  const int all = static_cast<int>(robots.size() * lengths.size() * times.size() * shares.size() * 5);
  int with_reason = 0;
  std::string reasons;
  for (const auto& [reason, count] : refused)
  {
    with_reason += count;
    reasons += fmt::format("{}: {}, ", reason, count);
  }
  CAPTURE(walked, all, reasons);
  CHECK(walked + with_reason == all);
#ifdef NDEBUG
  CHECK(all >= 200);
  CHECK(walked > all / 4);
  CHECK(with_reason > all / 10);
#endif
}

TEST_CASE("torquectl compare shows what each method makes of a walk", "[gait]")
{
  const TemporaryFolder folder;
  const std::string out = folder.file("walk.csv");
  REQUIRE(run({"gait", "--robot", "ck", "-o", out, "--steps", "2"}).code == 0);
  const Run compared = run({"compare", out, "--robot", "ck"});
  CAPTURE(compared.out, compared.err);
  CHECK(compared.code == 0);
  CHECK(compared.out.starts_with("ck: "));

  // the cells of a method's line
  const auto cells = [&](const std::string& method)
  {
    const std::size_t begin = compared.out.find("| " + method + " ");
    REQUIRE(begin != std::string::npos);
    std::vector<std::string> found;
    std::istringstream line(compared.out.substr(begin + 1, compared.out.find('\n', begin) - begin));
    for (std::string cell; std::getline(line, cell, '|');)
    {
      const std::size_t from = cell.find_first_not_of(' ');
      found.push_back(from == std::string::npos ? "" : cell.substr(from, cell.find_last_not_of(' ') - from + 1));
    }
    return found;
  };
  const auto header = cells("method");
  REQUIRE(header.size() >= 8);
  CHECK(std::vector<std::string>(header.begin() + 1, header.begin() + 8) ==
        std::vector<std::string>{"SSP→DSP1", "DSP1→DSP2", "DSP2→SSP", "peak", "∫τ²dt", "contacts held", "relaxed"});
  for (const std::string method : {"zmp-transition", "constrained"})
    for (const std::size_t column : {1, 2, 3})
      CHECK(cells(method)[column] == "0");
  CHECK(cells("constrained")[6] == "100.0 %");
  CHECK(cells("linear-transition")[1] == "0");
  CHECK(cells("linear-transition")[3] == "0");
  CHECK(cells("tracked-internal")[2] == cells("linear-transition")[2]);

  // numbers from their definition, for one method that jumps everywhere
  const Robot robot = load_robot("ck");
  const Trajectory walk = parse_trajectory(read_file(out), out, coordinate_names(robot), false, Channels());
  std::array<double, 3> jumps{};
  double peak = 0.0, effort = 0.0;
  std::optional<VectorJ> before;
  for (std::size_t i = 0; i < walk.states.size(); ++i)
  {
    std::vector<std::byte> buffer;
    const auto state = std::get<DesiredState>(decode_desired_state(encode(walk.states[i], buffer), robot));
    const VectorJ torque = solution(robot, state, Method::internal_wrench).torque;
    peak = std::max(peak, torque.cwiseAbs().maxCoeff());
    if (before)
    {
      effort += 0.5e-6 * static_cast<double>(walk.states[i].utime - walk.states[i - 1].utime) *
                (torque.squaredNorm() + before->squaredNorm());
      const auto contacts = [&](std::size_t k)
      {
        return std::pair(walk.states[k].left_contact, walk.states[k].right_contact);
      };
      if (contacts(i) != contacts(i - 1))
      {
        // 3: contacts are those of SSP (none), DSP1 (heel), DSP2 (toe)
        const auto [left, right] = contacts(i);
        const std::size_t kind = left * right == 0 ? 2 : left + right == 3 ? 0 : 1;
        jumps[kind] = std::max(jumps[kind], (torque - *before).cwiseAbs().maxCoeff());
      }
    }
    before = torque;
  }
  const auto found = cells("internal-wrench");
  for (const std::size_t kind : {0, 1, 2})
    CHECK(found[1 + kind] == fmt::format("{:.2f}", jumps[kind]));
  CHECK(found[4] == fmt::format("{:.1f}", peak));
  CHECK(found[5] == fmt::format("{:.0f}", effort));

  // what cannot be answered is said
  const std::string flight =
      folder.write("flight.csv", "time,q0,q1,q2,q3,q4,q5,q6,dq0,dq1,dq2,dq3,dq4,dq5,dq6,ddq0,ddq1,"
                                 "ddq2,ddq3,ddq4,ddq5,ddq6,contactL,contactR\n"
                                 "0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,none,none\n");
  const Run none = run({"compare", flight, "--robot", "ck"});
  CHECK(none.code == 65);
  CHECK(none.err.find("note: constrained: 1 of 1 samples were not answered; torquectl eval --method says why") !=
        std::string::npos);
  CHECK(none.err.ends_with(fmt::format("torquectl: {}: no sample was answered by any method: by pseudo-inverse, "
                                       "NOT_SUPPORTED 1; torquectl eval says what was refused\n",
                                       flight)));
}

} // namespace gait_test
