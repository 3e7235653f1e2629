#include "catch.h"
#include "matchers.h"
#include "nearest_samples.h"

#include "methods/method.h"
#include "wire/codec.h"

#include <cstring>

namespace nearest_answer_test
{

using namespace torqued;
using oracle::Answered;
using oracle::NearestProblem;

namespace
{

#ifdef NDEBUG
constexpr int kWalking = 400; // of each contact pair
constexpr int kPaths = 40;
#else
constexpr int kWalking = 8;
constexpr int kPaths = 1;
#endif

constexpr double kKept = 1e-9; // of the weight, of weight × sole length

// A state that the ground can carry, on ck, rk or rabbit, to be asked for by a method.
NearestSample walking(oracle::Random& random, const Robot& robot, Contact left, Contact right)
{
  const Support support{
      {left, right}, kSides[random() % 2], oracle::uniform(random, 0.0, 1.0), oracle::uniform(random, 0.0, 1.0)};
  State state = plausible_state(random, robot, support, 2.0);
  state.a *= 0.2;
  ask_what_ground_gives(random, robot, support, state);
  NearestSample sample{robot, {}, desired_of(robot, state, support), {}};
  sample.desired.utime = sample.desired.stream_id = 1;
  sample.settings.methods.infeasible = OnInfeasible::nearest;
  return sample;
}

// check(sample, i): of walking robots without limits of rates, all contact pairs in turn
template <typename Check> void for_all_walking(unsigned seed, int samples, const Check& check)
{
  std::vector<Robot> robots;
  for (const char* name : {"ck", "rk", "rabbit"})
    robots.push_back(load_robot(name));
  for (Actuator& actuator : robots.back().actuators)
    actuator.torque_limit = 500.0; // without any, some motions need more torque than any robot has, and are refused
  for (const Contact left : kContacts)
    for (const Contact right : kContacts)
    {
      oracle::Random random(100 * seed + 4 * static_cast<unsigned>(left) + static_cast<unsigned>(right));
      const bool points = left != Contact::sole && right != Contact::sole;
      for (int i = 0; i < samples; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        check(walking(random, robots[static_cast<std::size_t>(i) % (points ? 3 : 2)], left, right), random, i);
      }
    }
}

Result<Answer> answer_of(const NearestSample& sample, OnInfeasible infeasible)
{
  AnswerSettings settings = sample.settings;
  settings.methods.infeasible = infeasible;
  StreamMemory memory = sample.before;
  return answer(sample.robot, settings, sample.desired, memory);
}

bool same_bits(const Answer& one, const Answer& two)
{
  const auto bits = [](const auto& a, const auto& b)
  {
    return a.size() == b.size() &&
           std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
  };
  return bits(one.torque, two.torque) && bits(one.a, two.a) && one.base_a == two.base_a && one.flags == two.flags &&
         one.method == two.method && one.zmp == two.zmp && one.dynamics_residual == two.dynamics_residual &&
         one.contact_speed == two.contact_speed && one.contact_residual == two.contact_residual &&
         one.adjustment == two.adjustment && std::memcmp(&one.ground, &two.ground, sizeof one.ground) == 0;
}

// by how much an answer lacks what is asked of it; negative: the room that is left
double lacks(const NearestProblem& problem, const Answered& found)
{
  double most = -1.0;
  if (found.w.size() > 0)
    most = std::max(most, (problem.conditions.h - problem.conditions.G * found.w).maxCoeff());
  for (const Eigen::VectorXd& out :
       {Eigen::VectorXd(found.torque - problem.most), Eigen::VectorXd(problem.least - found.torque)})
    most = std::max(most, out.cwiseQuotient(problem.torque_unit).maxCoeff());
  return most;
}

desired_state_t message_of(const Robot& robot, const DesiredState& desired, bool relative)
{
  const int n = robot.num_coordinates();
  desired_state_t message{};
  message.utime = desired.utime;
  message.stream_id = desired.stream_id;
  message.model_id = robot.model_id;
  message.coordinates = relative ? desired_state_t::RELATIVE : desired_state_t::ABSOLUTE;
  message.base = desired.base_given ? desired_state_t::GIVEN : desired_state_t::FROM_CONTACT;
  message.left_contact = static_cast<std::int8_t>(desired.support.contact[0]);
  message.right_contact = static_cast<std::int8_t>(desired.support.contact[1]);
  message.leading_foot = desired.support.leading == Side::left ? desired_state_t::LEFT : desired_state_t::RIGHT;
  message.method = static_cast<std::int8_t>(desired.method);
  message.load_transfer = desired.support.load_transfer;
  message.phase = desired.support.phase;
  for (int i = 0; i < 2; ++i)
  {
    message.base_q[i] = desired.q(n + i);
    message.base_v[i] = desired.v(n + i);
    message.base_a[i] = desired.a(n + i);
  }
  message.num_coordinates = n;
  const Eigen::MatrixXd A = relative ? Eigen::MatrixXd(robot.A.topLeftCorner(n, n)) : Eigen::MatrixXd::Identity(n, n);
  const auto sent = [](const Eigen::VectorXd& x)
  {
    return std::vector<double>(x.begin(), x.end());
  };
  message.q = sent(A * desired.q.head(n) + (relative ? Eigen::VectorXd(robot.b.head(n)) : Eigen::VectorXd::Zero(n)));
  message.v = sent(A * desired.v.head(n));
  message.a = sent(A * desired.a.head(n));
  return message;
}

DesiredState received(const Robot& robot, const desired_state_t& message)
{
  std::vector<std::byte> buffer;
  return std::get<DesiredState>(decode_desired_state(encode(message, buffer), robot));
}

} // namespace

TEST_CASE("a motion that can be had is answered as without the nearest motion, to the last bit", "[nearest_answer]")
{
  int kept = 0, adjusted = 0;
  for_all_walking(821, kWalking,
                  [&](NearestSample sample, oracle::Random&, int)
                  {
                    for (const MethodRow& known : methods())
                    {
                      CAPTURE(known.name);
                      sample.desired.method = known.method;
                      const Result<Answer> usual = answer_of(sample, OnInfeasible::relax);
                      const Result<Answer> nearest = answer_of(sample, OnInfeasible::nearest);
                      REQUIRE(std::holds_alternative<Answer>(nearest));
                      const Answer& found = std::get<Answer>(nearest);
                      if (!std::holds_alternative<Answer>(usual))
                        continue;
                      const Answer& expected = std::get<Answer>(usual);
                      const double lack =
                          lacks(sample.problem(), oracle::answered(sample.robot, sample.desired, expected));
                      if (lack < -kKept)
                      {
                        ++kept;
                        CHECK(same_bits(found, expected));
                        CHECK((found.flags & flag::adjusted) == 0);
                      }
                      else if (lack > 3.0 * kKept)
                      {
                        ++adjusted;
                        CHECK((found.flags & flag::adjusted) != 0);
                        CHECK((found.flags & (flag::over_torque | flag::over_rate)) == 0);
                      }
                    }
                  });
  CHECK(kept > 16 * kWalking);
  CHECK(adjusted > 16 * kWalking);
}

TEST_CASE("where only the method's choice cannot be had, reactions move and the motion does not", "[nearest_answer]")
{
  int moved = 0;
  for_all_walking(822, kWalking / 4,
                  [&](NearestSample sample, oracle::Random&, int)
                  {
                    sample.desired.method = Method::constrained;
                    const Result<Answer> least = answer_of(sample, OnInfeasible::relax);
                    const NearestProblem problem = sample.problem();
                    if (!std::holds_alternative<Answer>(least) ||
                        lacks(problem, oracle::answered(sample.robot, sample.desired, std::get<Answer>(least))) > 0.0)
                      return;
                    for (const MethodRow& known : methods())
                    {
                      CAPTURE(known.name);
                      sample.desired.method = known.method;
                      const Answer found = sample.answer();
                      CHECK(lacks(problem, oracle::answered(sample.robot, sample.desired, found)) <= kKept);
                      // what the conditions have of room, 1e-10 of the weight, moves light shins
                      CHECK(found.adjustment <= 1e-7);
                      moved += (found.flags & flag::adjusted) != 0 ? 1 : 0;
                    }
                  });
  CHECK(moved > kWalking);
}

TEST_CASE("the nearest motion, asked for, is answered", "[nearest_answer]")
{
  const NearestRobots robots;
  oracle::Random random(823);
  Worst adjustment;
  int asked = 0;
  for (int i = 0; i < 10 * kWalking; ++i)
  {
    NearestSample sample = random_sample(random, robots, kContacts[random() % 4], kContacts[random() % 4], i);
    const Answer first = sample.answer();
    if (sample.problem().feasible() != NearestProblem::Feasible::yes ||
        sample.settings.nearest.contacts == NearestContacts::as_desired)
      continue;
    CAPTURE(i);
    const Answered found = oracle::answered(sample.robot, sample.desired, first);
    const NearestProblem problem = sample.problem();
    sample.desired.base_given = true;
    sample.desired.q.tail<2>() = problem.base;
    sample.desired.v.tail<2>() = problem.base_rate;
    sample.desired.a = of_mechanism(sample.robot, found.a);
    if ((sample.problem().conditions.h - problem.conditions.h).norm() > 1e-12)
      continue; // windows cap f_min by the load that is asked for
    ++asked;
    adjustment.see(sample.answer().adjustment / std::max(1.0, found.a.cwiseAbs().maxCoeff()), i);
  }
  CAPTURE(adjustment.at);
  CHECK(adjustment.value <= 1e-7);
  CHECK(asked > 4 * kWalking);
}

TEST_CASE("the answer is the same whichever coordinates the desired state comes in", "[nearest_answer]")
{
  const NearestRobots robots;
  int adjusted = 0;
  for (const Contact left : kContacts)
    for (const Contact right : kContacts)
    {
      oracle::Random random(82400 + 4 * static_cast<unsigned>(left) + static_cast<unsigned>(right));
      for (int i = 0; i < kWalking / 4; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        NearestSample sample = random_sample(random, robots, left, right, i);
        const Robot& robot = sample.robot;
        if (!sample.desired.base_given)
          for (VectorQ* numbers : {&sample.desired.q, &sample.desired.v, &sample.desired.a})
            numbers->tail<2>().setZero();
        const DesiredState asked = sample.desired;
        sample.desired = received(robot, message_of(robot, asked, false));
        const Answer absolute = sample.answer();
        sample.desired = received(robot, message_of(robot, asked, true));
        const Answer relative = sample.answer();
        adjusted += (absolute.flags & flag::adjusted) != 0 ? 1 : 0;
        // rounding of the angles, 1e-16, counts like that of weights × lengths
        const double scale = std::max(1.0, absolute.adjustment / 100.0);
        CHECK(mismatch(relative.torque, absolute.torque, 1e-8 * scale) == "");
        // a foot without load has a share of 0 but for rounding, of either sign
        CHECK((relative.flags & ~flag::clamped) == (absolute.flags & ~flag::clamped));
        const Eigen::MatrixXd A = robot.A.topLeftCorner(absolute.a.size(), absolute.a.size());
        CHECK(mismatch(relative.a, A * absolute.a, 1e-8 * scale) == "");
        CHECK(mismatch(relative.base_a, absolute.base_a, 1e-8 * scale) == "");
        for (const std::size_t side : {0u, 1u})
        {
          const Wrench &one = absolute.ground[side].wrench, &other = relative.ground[side].wrench;
          CHECK(mismatch(Eigen::Vector3d(other.fx, other.fz, other.moment), Eigen::Vector3d(one.fx, one.fz, one.moment),
                         1e-8 * scale) == "");
        }
        // in the coordinates that were sent
        const VectorQ change = relative.a - A * asked.a.head(absolute.a.size());
        CHECK(mismatch(relative.adjustment, change.cwiseAbs().maxCoeff(), 1e-9 * scale) == "");
      }
    }
  CHECK(adjusted > 3 * kWalking);
}

namespace
{

// An answer as numbers that are of size 1: torques, reactions, accelerations.
Eigen::VectorXd numbers(const NearestSample& sample, const NearestProblem& problem, const Eigen::VectorXd& a)
{
  NearestSample at = sample;
  at.desired.a = of_mechanism(sample.robot, a);
  const Answered found = oracle::answered(sample.robot, at.desired, at.answer());
  Eigen::VectorXd all(found.torque.size() + found.w.size() + found.a.size());
  all << found.torque.cwiseQuotient(problem.torque_unit), found.w.cwiseQuotient(problem.w_unit), found.a / 100.0;
  return all;
}

} // namespace

TEST_CASE("along a path out of what can be had the answer is continuous, by every method", "[nearest_answer]")
{
  int left_it = 0, paths = 0;
  Worst jump;
  for_all_walking(
      825, kPaths,
      [&](NearestSample sample, oracle::Random& random, int i)
      {
        sample.settings.nearest.metric = random() % 2 == 0 ? NearestMetric::mass : NearestMetric::angles;
        sample.settings.nearest.margin = random() % 2 == 0 ? 0.0 : 0.005;
        const NearestProblem start = sample.problem();
        Eigen::VectorXd way(start.a_d.size());
        for (double& entry : way)
          entry = oracle::uniform(random, -20.0, 20.0);
        if (i % 2 == 0 && start.J.rows() > 0) // of those that keep the contacts, feasibility has an end within the path
          way -= oracle::solve(start.J, start.J * way);
        for (const MethodRow& known : methods())
        {
          sample.desired.method = known.method;
          const auto at = [&](double s)
          {
            return numbers(sample, start, start.a_d + s * way);
          };
          const auto adjusted = [&](double s)
          {
            NearestSample there = sample;
            there.desired.a = of_mechanism(sample.robot, start.a_d + s * way);
            return (there.answer().flags & flag::adjusted) != 0;
          };
          left_it += !adjusted(0.0) && adjusted(1.0) ? 1 : 0;
          ++paths;
          constexpr int kSteps = 16, kHalvings = 30;
          double from = 0.0, step = 1.0 / kSteps, largest = -1.0;
          Eigen::VectorXd before = at(0.0), low, high;
          for (int k = 0; k < kSteps; ++k)
          {
            const Eigen::VectorXd after = at((k + 1) * step);
            if (const double d = (after - before).cwiseAbs().maxCoeff(); d > largest)
            {
              largest = d;
              from = k * step;
              low = before;
              high = after;
            }
            before = after;
          }
          // the larger half, again and again: what is continuous becomes ever smaller, a jump stays
          for (int k = 0; k < kHalvings; ++k)
          {
            step *= 0.5;
            const Eigen::VectorXd middle = at(from + step);
            const double first = (middle - low).cwiseAbs().maxCoeff(), second = (high - middle).cwiseAbs().maxCoeff();
            if (first > second)
              high = middle;
            else
            {
              low = middle;
              from += step;
            }
            largest = std::max(first, second);
          }
          CAPTURE(known.name, from);
          CHECK(largest < 1e-4);
          jump.see(largest, i);
        }
      });
  CAPTURE(paths, left_it, jump.value);
  CHECK(left_it > paths / 10);
}

TEST_CASE("an acceleration that contradicts the contacts is no reason to refuse; speed, tilt and height are",
          "[nearest_answer]")
{
  const Robot robot = load_robot("ck");
  AnswerSettings settings;
  settings.methods.infeasible = OnInfeasible::nearest;
  settings.consistency = OnExcess::refuse;
  oracle::Motion standing;
  standing.X << 0, 0, 0, 0, 0, 0, 0, 0, 0.855;
  standing.V.setZero();
  standing.A.setZero();
  const auto flags = [&](const oracle::Motion& motion) -> std::optional<std::int32_t>
  {
    DesiredState desired = oracle::desired_state(motion, Contact::sole, Contact::sole, Side::left, 0.5);
    StreamMemory memory;
    const auto result = answer(robot, settings, desired, memory);
    if (const Refusal* refusal = std::get_if<Refusal>(&result))
    {
      CHECK(refusal->reason() == Reason::inconsistent);
      return {};
    }
    return std::get<Answer>(result).flags;
  };
  CHECK(flags(standing) == 0);
  oracle::Motion motion = standing;
  motion.A << 5, -5, 5, 3, -4, 2, 1, 1, -1;
  CHECK((flags(motion).value() & (flag::adjusted | flag::contact_acceleration)) ==
        (flag::adjusted | flag::contact_acceleration));
  motion.V(7) = 0.02;
  CHECK(!flags(motion));
  motion = standing;
  motion.X(0) = -0.03;
  CHECK(!flags(motion));
  motion = standing;
  motion.X(8) += 0.05;
  CHECK(!flags(motion));
}

TEST_CASE("a motion is projected first; the acceleration and its adjustment are against what was asked",
          "[nearest_answer]")
{
  oracle::Random random(826);
  const Robot robot = load_robot("rk");
  int adjusted = 0;
  for (int i = 0; i < kWalking; ++i)
  {
    CAPTURE(i);
    oracle::Motion motion;
    motion.X << 0.0, -0.2, 0.2, -0.3, -0.4, -0.2, 0.0, 0.0, 0.85;
    for (double& v : motion.V)
      v = oracle::uniform(random, -0.1, 0.1);
    for (double& a : motion.A)
      a = oracle::uniform(random, -5.0, 5.0);
    DesiredState desired = oracle::desired_state(motion, Contact::sole, Contact::none, Side::left, 0.5);
    desired.base_given = false;
    AnswerSettings settings;
    settings.methods.infeasible = OnInfeasible::nearest;
    settings.project = true;
    StreamMemory memory, other;
    const Answer found = std::get<Answer>(answer(robot, settings, desired, memory));
    CHECK((found.flags & flag::projected) != 0);
    CHECK(mismatch(found.adjustment, (found.a - desired.a.head<7>()).cwiseAbs().maxCoeff(), 1e-12) == "");
    // the same as without, for the motion to which it was projected
    DesiredState projected = std::get<DesiredState>(answered_motion(robot, settings, desired));
    settings.project = false;
    const Answer expected = std::get<Answer>(answer(robot, settings, projected, other));
    CHECK(mismatch(found.a, expected.a, 0.0) == "");
    CHECK(mismatch(found.torque, expected.torque, 0.0) == "");
    CHECK((found.flags & flag::adjusted) == (expected.flags & flag::adjusted));
    adjusted += (found.flags & flag::adjusted) != 0 ? 1 : 0;
  }
  CHECK(adjusted > kWalking / 4);
}

TEST_CASE("robots whose root is fixed keep their motors' limits and have no other conditions", "[nearest_answer]")
{
  for (const char* name : {"compass", "six-link", "bip-itlag"})
  {
    CAPTURE(name);
    Robot robot = load_robot(name);
    for (Actuator& actuator : robot.actuators)
      actuator.torque_limit = 30.0;
    oracle::Random random(827);
    int adjusted = 0;
    Worst residual, range, gradient;
    for (int i = 0; i < kWalking; ++i)
    {
      const State state = random_state(random, robot);
      NearestSample sample{robot, {}, desired_of(robot, state, support(robot, Contact::none, Contact::none)), {}};
      sample.settings.methods.infeasible = OnInfeasible::nearest;
      sample.settings.nearest.metric = i % 2 == 0 ? NearestMetric::mass : NearestMetric::angles;
      const Answer answer = sample.answer();
      const NearestProblem problem = sample.problem();
      const Answered found = oracle::answered(robot, sample.desired, answer);
      residual.see(problem.residual(found), i);
      range.see(problem.out_of_range(found), i);
      gradient.see(problem.motion_gradient_left(found), i);
      adjusted += (answer.flags & flag::adjusted) != 0 ? 1 : 0;
      CHECK((answer.flags & flag::relaxed) == 0);
      CHECK(answer.base_a == Eigen::Vector2d::Zero());
    }
    CAPTURE(residual.at, range.at, gradient.at);
    CHECK(residual.value <= kKept);
    CHECK(range.value <= kKept);
    CHECK(gradient.value <= 1e-8);
    CHECK(adjusted > kWalking / 2);
  }
}

TEST_CASE("flight whose base point nothing places is not supported", "[nearest_answer]")
{
  oracle::Random random(828);
  DesiredState desired = oracle::desired_state(oracle::random_motion(random), Contact::none, Contact::none);
  desired.base_given = false;
  AnswerSettings settings;
  settings.methods.infeasible = OnInfeasible::nearest;
  StreamMemory memory;
  const auto result = answer(load_robot("ck"), settings, desired, memory);
  REQUIRE(std::holds_alternative<Refusal>(result));
  CHECK(std::get<Refusal>(result).reason() == Reason::not_supported);
}

} // namespace nearest_answer_test
