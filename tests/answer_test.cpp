#include "catch.h"
#include "matchers.h"
#include "oracles.h"

#include "answer/answer.h"
#include "robot/files/load.h"

#include <cstring>
#include <limits>

namespace answer_test
{

using namespace torqued;

namespace
{

Answer answered(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired, StreamMemory& memory)
{
  const auto result = answer(robot, settings, desired, memory);
  if (const Refusal* refusal = std::get_if<Refusal>(&result))
    FAIL(std::string(refusal->detail()));
  return std::get<Answer>(result);
}

Reason refused(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired, StreamMemory& memory)
{
  const auto result = answer(robot, settings, desired, memory);
  REQUIRE(std::holds_alternative<Refusal>(result));
  return std::get<Refusal>(result).reason();
}

// ck, standing upright at rest on both soles
DesiredState standing()
{
  oracle::Motion motion;
  motion.X << 0, 0, 0, 0, 0, 0, 0, 0, 0.855;
  motion.V.setZero();
  motion.A.setZero();
  DesiredState desired = oracle::desired_state(motion, Contact::sole, Contact::sole, Side::left, 0.5);
  desired.support.phase = 0.5;
  return desired;
}

} // namespace

TEST_CASE("standing still, the ground carries the weight and each foot half of it", "[answer]")
{
  const Robot robot = load_robot("ck");
  StreamMemory memory;
  const Answer found = answered(robot, {}, standing(), memory);
  CHECK(found.flags == 0);
  CHECK(mismatch(found.ground[0].wrench.fz, 0.5 * 45.0 * 9.81, 1e-12) == "");
  CHECK(mismatch(found.ground[1].wrench.fz, 0.5 * 45.0 * 9.81, 1e-12) == "");
  // only the feet's masses lie off the vertical through the hip
  const double zmp = 2.0 * 0.7 * 0.03 / 45.0;
  CHECK(mismatch(found.zmp, zmp, 1e-12) == "");
  CHECK(mismatch(found.ground[0].cop, zmp, 1e-12) == "");
  CHECK(found.method == Method::constrained);
  CHECK(found.contact_speed == 0.0);
  CHECK(found.dynamics_residual < 1e-12);
}

TEST_CASE("in a symmetric posture half of load_transfer is half of the weight, by every method that shares the load",
          "[answer]")
{
  const Robot robot = load_robot("ck");
  DesiredState desired = standing();
  desired.base_given = false;
  desired.q.head<7>() << 0.0, 0.2, -0.2, -0.2, 0.2, 0.0, 0.0;
  // the ankles are at x = 0, so the centre of mass is the ground's lever about them; a foot weighs 0.7 kg, 0.03 m
  // before
  const double half = 0.5 * 45.0 * 9.81, ankle = -2.26078;
  for (const Method method :
       {Method::none, Method::linear_transition, Method::tracked_reaction, Method::tracked_internal,
        Method::constrained, Method::zmp_transition, Method::human_transition})
    for (const Side leading : kSides)
      for (const double phase : {0.0, 0.3, 0.5, 1.0})
      {
        CAPTURE(std::string(name_of(method)), name_of(leading), phase);
        desired.method = method;
        desired.support.leading = leading;
        desired.support.phase = phase;
        StreamMemory memory;
        const Answer found = answered(robot, {}, desired, memory);
        CHECK(found.flags == 0);
        for (const std::size_t side : {0u, 1u})
          CHECK_THAT(found.ground[side].wrench.fz, Catch::Matchers::WithinAbs(half, 1e-6));
        CHECK_THAT(found.torque(0), Catch::Matchers::WithinAbs(ankle, 5e-6));
        CHECK_THAT(found.torque(0), Catch::Matchers::WithinAbs(found.zmp * half - 0.7 * 9.81 * 0.03, 1e-6));
        CHECK(mismatch(found.torque, found.torque.reverse(), 1e-6) == "");
      }
}

TEST_CASE("a motion that contradicts its contacts is flagged, or refused by setting", "[answer]")
{
  const Robot robot = load_robot("ck");
  AnswerSettings refuse;
  refuse.consistency = OnExcess::refuse;
  const auto check = [&](const DesiredState& desired, std::int32_t expected)
  {
    StreamMemory memory;
    const std::int32_t found = answered(robot, {}, desired, memory).flags;
    CHECK((found & (flag::inconsistent | flag::contact_acceleration)) == expected);
    if (expected != 0)
      CHECK(refused(robot, refuse, desired, memory) == Reason::inconsistent);
    else
      answered(robot, refuse, desired, memory);
  };
  check(standing(), 0);
  DesiredState desired = standing();
  desired.v(7) = 0.009; // both ankles slide
  check(desired, 0);
  desired.v(7) = 0.011;
  check(desired, flag::inconsistent);
  desired = standing();
  desired.a(8) = 0.09;
  check(desired, 0);
  desired.a(8) = 0.11;
  check(desired, flag::contact_acceleration);
  desired.v(7) = 0.011;
  check(desired, flag::inconsistent | flag::contact_acceleration);
  desired = standing();
  desired.q(0) = -0.019;
  check(desired, 0);
  desired.q(0) = -0.021;
  check(desired, flag::inconsistent);
}

TEST_CASE("conditions that cannot be met are relaxed and flagged, or refused by setting", "[answer]")
{
  const Robot robot = load_robot("ck");
  DesiredState desired = standing();
  desired.q << 0, -0.3, 0.2, 0.3, 0.1, 0, 0, 0, 0.84; // one foot before the other
  desired.method = Method::constrained;
  StreamMemory memory;
  AnswerSettings refuse;
  refuse.methods.infeasible = OnInfeasible::refuse;
  Answer found = answered(robot, {}, desired, memory);
  CHECK((found.flags & (flag::relaxed | flag::slips | flag::lifts | flag::tips)) == 0);
  CHECK(found.method == Method::constrained);
  answered(robot, refuse, desired, memory);

  // leaning forward so fast that the zero-moment point leaves both feet
  desired.a.tail<2>() << -6.0, 0.0;
  found = answered(robot, {}, desired, memory);
  CHECK((found.flags & flag::relaxed) != 0);
  CHECK((found.flags & (flag::slips | flag::lifts | flag::tips)) != 0);
  CHECK(refused(robot, refuse, desired, memory) == Reason::infeasible);

  // a share that had to be clamped
  desired.a.setZero();
  desired.method = Method::tracked_internal;
  desired.support.load_transfer = 0.0;
  CHECK((answered(robot, {}, desired, memory).flags & flag::clamped) != 0);
  desired.support.load_transfer = 0.5;
  CHECK((answered(robot, {}, desired, memory).flags & flag::clamped) == 0);
}

TEST_CASE("torque limits are flagged, refused or clamped", "[answer]")
{
  Robot robot = load_robot("ck");
  DesiredState desired = standing();
  desired.q(6) = -0.5;                        // the trunk leans forward: both hips hold it
  desired.method = Method::linear_transition; // looks at no limit itself
  StreamMemory memory;
  const Answer free = answered(robot, {}, desired, memory);
  const double hip = std::abs(free.torque(2));
  REQUIRE(hip > 5.0);
  CHECK((free.flags & flag::over_torque) == 0);

  robot.actuators[2].torque_limit = hip - 1.0;
  const Answer flagged = answered(robot, {}, desired, memory);
  CHECK(flagged.flags == (free.flags | flag::over_torque));
  CHECK(mismatch(flagged.torque, free.torque, 0.0) == "");

  AnswerSettings settings;
  settings.limits = OnExcess::refuse;
  CHECK(refused(robot, settings, desired, memory) == Reason::over_limit);

  settings.limits = OnExcess::clamp;
  const Answer clamped = answered(robot, settings, desired, memory);
  CHECK(clamped.flags == (free.flags | flag::over_torque | flag::clamped));
  CHECK(std::abs(clamped.torque(2)) == hip - 1.0);
  CHECK(clamped.torque(3) == free.torque(3));
  // the equation of motion is off by what was cut, and says so
  CHECK(mismatch(clamped.dynamics_residual, 1.0, 1e-9) == "");
  CHECK(flagged.dynamics_residual < 1e-9);

  // over by no more than constrained grants a motor that gave way, 1e-8, is not over
  const auto is_over_by = [&](double share)
  {
    robot.actuators[2].torque_limit = hip / (1.0 + share);
    return (answered(robot, {}, desired, memory).flags & flag::over_torque) != 0;
  };
  CHECK_FALSE(is_over_by(1e-8));
  CHECK(is_over_by(4e-8));
}

TEST_CASE("torque-rate limits look at the stream's previous answer", "[answer]")
{
  Robot robot = load_robot("ck");
  robot.actuators[2].rate_limit = 100.0; // N m/s
  DesiredState first = standing();
  first.utime = 1'000'000;
  DesiredState second = first;
  second.q(6) = -0.1;
  second.utime = 1'010'000;
  const auto after_first = [&](const AnswerSettings& settings)
  {
    StreamMemory memory;
    answered(robot, settings, first, memory);
    return memory;
  };
  StreamMemory none;
  const Answer alone = answered(robot, {}, second, none);
  CHECK((alone.flags & flag::over_rate) == 0);

  StreamMemory memory = after_first({});
  const double before = memory.torque(2);
  REQUIRE(std::abs(alone.torque(2) - before) > 1.0 + 1e-6);
  CHECK((answered(robot, {}, second, memory).flags & flag::over_rate) != 0);

  AnswerSettings settings;
  settings.rate_limits = OnExcess::clamp;
  memory = after_first(settings);
  const Answer clamped = answered(robot, settings, second, memory);
  CHECK((clamped.flags & flag::clamped) != 0);
  const double towards = alone.torque(2) > before ? 1.0 : -1.0;
  CHECK(mismatch(clamped.torque(2), before + towards, 1e-12) == "");
  CHECK(mismatch(memory.torque, clamped.torque, 0.0) == "");

  settings.rate_limits = OnExcess::refuse;
  memory = after_first(settings);
  CHECK(refused(robot, settings, second, memory) == Reason::over_limit);
  // what was refused is not remembered; what comes later may change by more
  second.utime = 1'000'000 + 10'000'000;
  answered(robot, settings, second, memory);

  // another stream's torque is no reference
  memory = after_first(settings);
  second.utime = 1'010'000;
  second.stream_id = 2;
  answered(robot, settings, second, memory);
}

TEST_CASE("rates do not depend on the epoch of the sender's clock", "[answer]")
{
  Robot robot = load_robot("ck");
  for (Actuator& actuator : robot.actuators)
    actuator.rate_limit = 1.0;
  for (const std::int64_t epoch : {std::int64_t{0}, std::int64_t{1} << 60, std::numeric_limits<std::int64_t>::min()})
  {
    StreamMemory memory;
    DesiredState desired = standing();
    desired.utime = epoch;
    answered(robot, {}, desired, memory);
    desired.utime = epoch + 50; // 1 N m/s for 50 µs
    desired.q(6) = -1e-7;       // 5 µN m at the hips
    const Answer slow = answered(robot, {}, desired, memory);
    CHECK((slow.flags & flag::over_rate) == 0);
    desired.utime = epoch + 100;
    desired.q(6) = -1e-5;
    CHECK((answered(robot, {}, desired, memory).flags & flag::over_rate) != 0);
  }
  StreamMemory memory;
  DesiredState desired = standing();
  desired.utime = std::numeric_limits<std::int64_t>::min();
  answered(robot, {}, desired, memory);
  desired.utime = std::numeric_limits<std::int64_t>::max();
  answered(robot, {}, desired, memory);
}

TEST_CASE("against our own clock no rate limit is passed by the sender's clock, another stream or a gap", "[answer]")
{
  Robot robot = load_robot("ck");
  robot.actuators[2].rate_limit = 10.0; // N m/s
  AnswerSettings settings;
  settings.rate_limits = OnExcess::clamp;
  constexpr std::int64_t max_age = 20'000;
  constexpr std::int64_t hour = 3'600'000'000;

  // the step that is left of one of 8 N m: a sender's time and stream against our own time
  struct Step
  {
    std::int64_t utime, stream_id, now;
    double seconds; // that the step may take
  };
  const auto take = [&](const std::vector<Step>& steps)
  {
    StreamMemory memory;
    DesiredState desired = standing();
    desired.utime = 0;
    REQUIRE(std::holds_alternative<Answer>(answer(robot, settings, desired, memory, OwnClock{0, max_age})));
    desired.q(6) = -0.3;
    for (const Step& step : steps)
    {
      CAPTURE(step.utime, step.stream_id, step.now);
      const double before = memory.torque(2);
      desired.utime = step.utime;
      desired.stream_id = step.stream_id;
      const auto result = answer(robot, settings, desired, memory, OwnClock{step.now, max_age});
      REQUIRE(std::holds_alternative<Answer>(result));
      const Answer& found = std::get<Answer>(result);
      CHECK((found.flags & flag::over_rate) != 0);
      CHECK((found.flags & flag::clamped) != 0);
      CHECK(mismatch(std::abs(found.torque(2) - before), 10.0 * step.seconds, 1e-9) == "");
    }
  };
  const std::int64_t stream = standing().stream_id;
  take({{1000, stream, 1000, 0.001}});
  take({{10'000, stream, 0, 0.010}});                                       // jitter: the sender's own time
  take({{10'000, stream, 30'000, 0.010}, {20'000, stream, 30'000, 0.010}}); // a burst after a late sample, too
  take({{hour, stream, 1000, 0.021}}); // a clock that jumps: own time and max_age, once
  take({{hour, stream, 1000, 0.021}, {hour + 1000, stream, 2000, 0.001}, {2 * hour, stream, 3000, 0.001}});
  take({{1000, stream + 1, 7000, 0.007}});                              // another stream: own time
  take({{hour, stream + 1, 9'000'000, 0.100}});                         // at most 5 max_age of it
  take({{1000, stream + 1, 7000, 0.007}, {2000, stream, 9000, 0.002}}); // and back
  // a clock that was slow for ten seconds makes up no more than 5 max_age, and max_age that it may be ahead
  take({{1000, stream, 10'000'000, 0.001}, {10'000'000, stream, 10'000'000, 0.120}});
}

TEST_CASE("with an honest clock the bits are those without one", "[answer]")
{
  Robot robot = load_robot("ck");
  for (Actuator& actuator : robot.actuators)
    actuator.rate_limit = 300.0;
  AnswerSettings settings;
  settings.rate_limits = OnExcess::clamp;
  oracle::Random random(8);
  StreamMemory alone, beside;
  DesiredState desired = standing();
  for (int i = 0; i < 2000; ++i)
  {
    desired.utime = 1'000'000 + 1000 * i;
    desired.q(6) = 0.1 * std::sin(0.05 * i);
    const auto jitter = static_cast<std::int64_t>(oracle::uniform(random, 0.0, 19'000.0));
    const auto without = answer(robot, settings, desired, alone);
    const auto with = answer(robot, settings, desired, beside, OwnClock{77'000'000 + 1000 * i + jitter, 20'000});
    REQUIRE(std::holds_alternative<Answer>(without));
    REQUIRE(std::holds_alternative<Answer>(with));
    CHECK(mismatch(std::get<Answer>(with).torque, std::get<Answer>(without).torque, 0.0) == "");
    CHECK(std::get<Answer>(with).flags == std::get<Answer>(without).flags);
  }
}

TEST_CASE("a torque that no robot of this size can need is refused, whatever its limits", "[answer]")
{
  for (const std::string_view name : shipped_robot_names())
  {
    CAPTURE(name);
    Robot robot = load_robot(std::string(name));
    for (Actuator& actuator : robot.actuators)
      actuator.torque_limit = std::numeric_limits<double>::infinity();
    DesiredState desired{};
    desired.q = desired.v = desired.a = VectorQ::Zero(robot.mechanism.num_q());
    desired.support = {{Contact::sole, Contact::none}, Side::left, 0.5, 0.5};
    if (!robot.fixed_root() && !robot.foot(Side::left).has_extent()) // on one point it would be under-actuated
    {
      desired.support.contact = {Contact::toe, Contact::toe};
      desired.q.head<2>().setConstant(0.2); // one leg before the other
    }
    StreamMemory memory;
    answered(robot, {}, desired, memory);
    // whichever coordinate accelerates, but for a sole's own, which the ground holds
    const bool held = !robot.fixed_root() && desired.support.contact[0] == Contact::sole;
    for (int i = held ? 1 : 0; i < robot.num_coordinates(); ++i)
    {
      CAPTURE(i);
      double largest = 0.0; // of the torques that are answered, as parts of what is allowed
      int refusals = 0;
      for (double size = 1.0; size < 1e12; size *= 1.1)
      {
        desired.a.setZero();
        desired.a(i) = size;
        const auto result = answer(robot, {}, desired, memory);
        if (const Refusal* refusal = std::get_if<Refusal>(&result))
        {
          CHECK(refusal->reason() == Reason::numerical);
          ++refusals;
          continue;
        }
        CHECK(refusals == 0); // of a larger acceleration than one that was refused
        const Answer& found = std::get<Answer>(result);
        for (int j = 0; j < robot.num_joints(); ++j)
        {
          const bool slide = is_force(robot, robot.actuators[static_cast<std::size_t>(j)]);
          largest =
              std::max(largest, std::abs(found.torque(j)) / (10.0 * robot.weight() * (slide ? 1.0 : robot.leg_length)));
        }
      }
      CHECK(refusals > 0);
      CHECK(largest <= 1.0);
      CHECK(largest > 0.8);
    }
  }
}

TEST_CASE("numbers too large to compute with are refused, and finite answers are all that comes out", "[answer]")
{
  const Robot robot = load_robot("ck");
  oracle::Random random(51);
  StreamMemory memory;
  DesiredState desired = standing();
  desired.v(0) = 1e200;
  CHECK(refused(robot, {}, desired, memory) == Reason::numerical);
  desired = standing();
  desired.a.setConstant(1.7e308);
  CHECK(refused(robot, {}, desired, memory) == Reason::numerical);
  desired = standing();
  desired.q.head<7>().setConstant(1e308);
  desired.method = Method::linear_transition;
  answered(robot, {}, desired, memory);
  // a torque alone: the motion and what the ground does are small
  Robot sticky = robot;
  sticky.joint_friction = true;
  sticky.actuators[0].viscous = 1.7e308;
  desired = standing();
  desired.v.head<7>() << 10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  desired.method = Method::linear_transition;
  CHECK(refused(sticky, {}, desired, memory) == Reason::numerical);

  int answers = 0;
  for (int i = 0; i < 5000; ++i)
  {
    desired = standing();
    desired.base_given = i % 2 == 0;
    const int most = 1 << i / 2 % 11; // of exponents: numbers that are answered, and all others
    for (VectorQ* vector : {&desired.q, &desired.v, &desired.a})
      for (double& x : *vector)
        x = std::ldexp(oracle::uniform(random, -1.0, 1.0), static_cast<int>(random() % (2 * most)) - most);
    const auto result = answer(robot, {}, desired, memory);
    if (const Answer* found = std::get_if<Answer>(&result))
    {
      const bool finite = found->torque.allFinite() && std::isfinite(found->zmp) && std::isfinite(found->ground[0].cop);
      CHECK(finite);
      ++answers;
    }
  }
  CAPTURE(answers);
  CHECK(answers > 100);
}

TEST_CASE("the same desired state and memory give the same bits", "[answer]")
{
  flush_denormals();
  const Robot robot = load_robot("human-subject01");
  oracle::Random random(52);
  for (int i = 0; i < 200; ++i)
  {
    const DesiredState desired = oracle::desired_state(oracle::random_motion(random), Contact::sole, Contact::sole,
                                                       Side::left, oracle::uniform(random, 0.0, 1.0));
    StreamMemory first;
    StreamMemory second;
    const Answer a = answered(robot, {}, desired, first);
    const Answer b = answered(robot, {}, desired, second);
    CHECK(std::memcmp(a.torque.data(), b.torque.data(), sizeof(double) * 6) == 0);
    CHECK(std::memcmp(&a.ground, &b.ground, sizeof a.ground) == 0);
  }
}

TEST_CASE("the accelerations of an answer are those that were asked for, and the base point's that follow", "[answer]")
{
  const Robot robot = load_robot("human-subject01");
  oracle::Random random(53);
  StreamMemory memory;
  for (int i = 0; i < 50; ++i)
  {
    DesiredState desired =
        oracle::desired_state(oracle::random_motion(random), Contact::sole, Contact::none, Side::left, 0.0);
    Answer found = answered(robot, {}, desired, memory);
    CHECK(found.a == desired.a.head<7>());
    CHECK(found.base_a == desired.a.tail<2>());
    CHECK(found.adjustment == 0.0);
    desired.relative_a = VectorQ::LinSpaced(7, 1.0, 7.0); // what was sent, whatever it was made to
    CHECK(answered(robot, {}, desired, memory).a == desired.relative_a);

    // J a + J̇ v = 0 at the ankle of the foot that stands
    desired.base_given = false;
    found = answered(robot, {}, desired, memory);
    const Motion motion = std::get<Motion>(complete_motion(robot, desired));
    const auto [J, Jdot_v] = contact_rows(robot, motion.now, desired.support);
    VectorQ a = desired.a;
    a.tail<2>() = found.base_a;
    CHECK(((J * a + Jdot_v).head<2>().norm()) < 1e-12 * (1.0 + a.norm() + Jdot_v.norm()));
  }
}

TEST_CASE("the base point of a fixed root does not accelerate", "[answer]")
{
  oracle::Random random(54);
  const Robot robot = oracle::random_tree(random, true);
  DesiredState desired{};
  desired.support = {{Contact::none, Contact::none}, Side::left, 0.0, 0.0};
  for (const Side side : kSides)
    if (robot.is_root(robot.foot(side)))
      desired.support.contact[static_cast<std::size_t>(side)] = Contact::sole;
  desired.q = desired.v = desired.a = VectorQ::Zero(robot.mechanism.num_q());
  for (int i = 0; i < robot.num_coordinates(); ++i)
    desired.a(i) = oracle::uniform(random, -5.0, 5.0);
  StreamMemory memory;
  const Answer found = answered(robot, {}, desired, memory);
  CHECK(found.base_a == Eigen::Vector2d::Zero());
  CHECK(found.a == desired.a.head(robot.num_coordinates()));
}

} // namespace answer_test
