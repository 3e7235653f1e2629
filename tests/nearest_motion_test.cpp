#include "catch.h"
#include "matchers.h"
#include "nearest_samples.h"
#include "udwadia_kalaba.h"

#include "planar/dynamics.h"
#include "stance/joint_friction.h"

namespace nearest_motion_test
{

using namespace torqued;
using oracle::Answered;
using oracle::NearestProblem;

namespace
{

#ifdef NDEBUG
constexpr int kSamples = 10'000; // of each contact pair
constexpr int kProofs = 1000;
#else
constexpr int kSamples = 24;
constexpr int kProofs = 12;
#endif

constexpr double kKept = 1e-9; // of the largest term, of the weight, of weight × sole length

template <typename Check> void for_all_pairs(int seed, int samples, const Check& check)
{
  const NearestRobots robots;
  for (const Contact left : kContacts)
    for (const Contact right : kContacts)
    {
      oracle::Random random(static_cast<unsigned>(100 * seed + 4 * static_cast<int>(left) + static_cast<int>(right)));
      CAPTURE(name_of(left), name_of(right));
      check(
          [&](const auto& of_sample)
          {
            for (int i = 0; i < samples; ++i)
              of_sample(random_sample(random, robots, left, right, i), i);
          });
    }
}

} // namespace

TEST_CASE("in every answer the equation of motion holds, contacts move as they should and motors keep their range",
          "[nearest_motion][slow]")
{
  int answers = 0, adjusted = 0, given_way = 0, undecided = 0;
  for_all_pairs(801, kSamples,
                [&](const auto& for_each)
                {
                  Worst residual, contacts, range, moment, lacking, adjustment;
                  for_each(
                      [&](const NearestSample& sample, int i)
                      {
                        const Answer answer = sample.answer();
                        const NearestProblem problem = sample.problem();
                        const Answered found = oracle::answered(sample.robot, sample.desired, answer);
                        ++answers;
                        adjusted += (answer.flags & flag::adjusted) != 0 ? 1 : 0;
                        residual.see(problem.residual(found), i);
                        if (problem.full_rank())
                          contacts.see(problem.contact_error(found), i);
                        range.see(problem.out_of_range(found), i);
                        moment.see(found.moment_at_point, i);
                        const Eigen::VectorXd change = found.a - problem.a_d;
                        adjustment.see(std::abs(answer.adjustment - change.head(answer.a.size()).cwiseAbs().maxCoeff()),
                                       i);
                        const Eigen::VectorXd lacks = problem.lacking(found);
                        const double most = lacks.size() > 0 ? lacks.maxCoeff() : 0.0;
                        if (most <= kKept)
                          return;
                        // a condition may only give way where there is nothing that keeps them all
                        const auto feasible = problem.feasible();
                        undecided += feasible == NearestProblem::Feasible::undecided ? 1 : 0;
                        if (feasible == NearestProblem::Feasible::yes || (answer.flags & flag::relaxed) == 0)
                          lacking.see(most, i);
                        else
                          ++given_way;
                      });
                  CAPTURE(residual.at, contacts.at, range.at, moment.at, lacking.at, adjustment.at);
                  CHECK(residual.value <= kKept);
                  CHECK(contacts.value <= kKept);
                  CHECK(range.value <= kKept);
                  CHECK(moment.value <= kKept);
                  CHECK(lacking.value <= kKept);
                  CHECK(adjustment.value <= 1e-12);
                });
  CAPTURE(answers, adjusted, given_way, undecided);
  CHECK(adjusted > answers / 2);
  CHECK(given_way > answers / 50);
  CHECK(given_way < answers / 2);
  CHECK(undecided <= answers / 1000);
}

TEST_CASE("no other motion is nearer: multipliers of the right signs balance its gradient", "[nearest_motion]")
{
  for_all_pairs(802, kProofs,
                [&](const auto& for_each)
                {
                  Worst motion, violation;
                  for_each(
                      [&](const NearestSample& sample, int i)
                      {
                        const Answer answer = sample.answer();
                        const NearestProblem problem = sample.problem();
                        const Answered found = oracle::answered(sample.robot, sample.desired, answer);
                        motion.see(problem.motion_gradient_left(found), i);
                        const Eigen::VectorXd lacks = problem.lacking(found);
                        if (lacks.size() > 0 && lacks.maxCoeff() > kKept)
                          violation.see(problem.violation_gradient_left(found), i);
                      });
                  CAPTURE(motion.at, violation.at);
                  CHECK(motion.value <= 1e-8);
                  CHECK(violation.value <= 1e-5); // conditions that give way have some room
                });
}

TEST_CASE("of all torques and reactions for the nearest motion, the method's are chosen", "[nearest_motion]")
{
  int least = 0, nearest = 0;
  for_all_pairs(803, kProofs,
                [&](const auto& for_each)
                {
                  Worst least_torque, nearest_reactions;
                  for_each(
                      [&](const NearestSample& sample, int i)
                      {
                        const Support& support = sample.desired.support;
                        const Answer answer = sample.answer();
                        if ((answer.flags & flag::adjusted) == 0 || (answer.flags & flag::relaxed) != 0 ||
                            support.of(Side::left) == Contact::none || support.of(Side::right) == Contact::none)
                          return;
                        NearestProblem problem = sample.problem();
                        const Answered found = oracle::answered(sample.robot, sample.desired, answer);
                        const Eigen::VectorXd none = Eigen::VectorXd::Zero(found.w.size());
                        if (answer.method == Method::constrained)
                        {
                          ++least;
                          problem.set_windows(sample.robot, sample.settings, sample.desired, found.a);
                          least_torque.see(problem.choice_gradient_left(found, found.torque, none, 1e-2), i);
                          return;
                        }
                        // what the method itself says to that motion
                        DesiredState had = sample.desired;
                        had.base_given = true;
                        had.q.tail<2>() = problem.base;
                        had.v.tail<2>() = problem.base_rate;
                        had.a = of_mechanism(sample.robot, found.a);
                        AnswerSettings usual = sample.settings;
                        usual.methods.infeasible = OnInfeasible::relax;
                        usual.rate_limits = OnExcess::flag;
                        StreamMemory memory;
                        const auto plain = torqued::answer(sample.robot, usual, had, memory);
                        if (!std::holds_alternative<Answer>(plain))
                          return;
                        ++nearest;
                        const Answered own = oracle::answered(sample.robot, had, std::get<Answer>(plain));
                        const Eigen::VectorXd away =
                            (found.w - own.w).cwiseQuotient(problem.w_unit).cwiseQuotient(problem.w_unit);
                        nearest_reactions.see(
                            problem.choice_gradient_left(found, Eigen::VectorXd::Zero(found.torque.size()), away, 1e-2),
                            i);
                      });
                  CAPTURE(least_torque.at, nearest_reactions.at);
                  CHECK(least_torque.value <= 1e-6);
                  CHECK(nearest_reactions.value <= 1e-6);
                });
  CHECK(least > kProofs / 4);
  CHECK(nearest > 4 * kProofs);
}

TEST_CASE("however weak the motors, their limits and the equation of motion hold to the last; conditions give way",
          "[nearest_motion]")
{
  for_all_pairs(804, kProofs,
                [&](const auto& for_each)
                {
                  Worst residual, contacts, gradient;
                  int samples = 0, relaxed = 0, over = 0, standing = 0;
                  oracle::Random random(804);
                  for_each(
                      [&](const NearestSample& strong, int i)
                      {
                        Robot robot = strong.robot;
                        for (Actuator& actuator : robot.actuators)
                          actuator.torque_limit = oracle::uniform(random, 0.0, 5.0);
                        NearestSample sample{robot, strong.settings, strong.desired, {}};
                        const Answer answer = sample.answer();
                        const NearestProblem problem = sample.problem();
                        const Answered found = oracle::answered(robot, sample.desired, answer);
                        ++samples;
                        relaxed += (answer.flags & flag::relaxed) != 0 ? 1 : 0;
                        standing += found.w.size() > 0 ? 1 : 0;
                        over += problem.out_of_range(found) > 0.0 ? 1 : 0;
                        residual.see(problem.residual(found), i);
                        if (problem.full_rank())
                          contacts.see(problem.contact_error(found), i);
                        if (found.w.size() > 0)
                          gradient.see(problem.violation_gradient_left(found), i);
                      });
                  CAPTURE(residual.at, contacts.at, gradient.at);
                  CHECK(over == 0);
                  CHECK(residual.value <= kKept);
                  CHECK(contacts.value <= kKept);
                  CHECK(gradient.value <= 1e-5);
                  CAPTURE(samples, relaxed);
                  CHECK((standing == 0 || relaxed > 0));
                });
}

namespace
{

// ck upright on both soles: legs straight and parallel, so that Jᵀ has a force along them in its null space
struct Straight
{
  Robot robot = load_robot("ck");
  NearestSample sample;

  explicit Straight(const oracle::Motion& motion)
      : sample{robot, {}, oracle::desired_state(motion, Contact::sole, Contact::sole, Side::left, 0.5), {}}
  {
    sample.settings.methods.infeasible = OnInfeasible::nearest;
  }
  Straight(const Straight&) = delete;
};

oracle::Motion upright(oracle::Random& random)
{
  oracle::Motion motion;
  motion.X << 0, 0, 0, 0, 0, 0, oracle::uniform(random, -0.1, 0.1), 0, 0.855;
  motion.V.setZero();
  for (double& a : motion.A)
    a = oracle::uniform(random, -2.0, 2.0);
  return motion;
}

} // namespace

TEST_CASE("straight legs whose knees turn unequally keep their contacts in least squares, and say so",
          "[nearest_motion]")
{
  oracle::Random random(805);
  for (int i = 0; i < kProofs / 4; ++i)
  {
    CAPTURE(i);
    oracle::Motion motion = upright(random);
    const oracle::Biped ck;
    // ankle and hip rest while the knee moves
    for (const auto& [shin, thigh] : {std::pair(1, 2), std::pair(4, 3)})
    {
      motion.V(shin) = oracle::uniform(random, -1.5, 1.5);
      motion.V(thigh) = -motion.V(shin) * ck.l1 / ck.l2;
    }
    Straight straight(motion);
    const NearestProblem problem = straight.sample.problem();
    REQUIRE_FALSE(problem.full_rank());
    const Answer answer = straight.sample.answer();
    const Answered found = oracle::answered(straight.robot, straight.sample.desired, answer);
    // each foot keeps half of what the legs' shortening differs by
    const auto shortens = [&](int shin, int thigh)
    {
      return ck.l1 * motion.V(shin) * motion.V(shin) + ck.l2 * motion.V(thigh) * motion.V(thigh);
    };
    const double half = 0.5 * std::abs(shortens(1, 2) - shortens(4, 3));
    const Eigen::VectorXd left = problem.J * found.a - problem.b;
    CHECK(mismatch(left.cwiseAbs().maxCoeff(), half, 1e-8) == "");
    const Eigen::VectorXd per_unit = left.cwiseQuotient(problem.contact_unit).cwiseQuotient(problem.contact_unit);
    CHECK(mismatch(problem.J.transpose() * per_unit, Eigen::VectorXd::Zero(9), 1e-8) == "");
    CHECK(((answer.flags & flag::relaxed) != 0 || half < 1e-6));
    CHECK(problem.out_of_range(found) == 0.0);
    CHECK(problem.residual(found) <= kKept);
  }
}

TEST_CASE("where straight legs leave a force along them open, the least reactions are taken", "[nearest_motion]")
{
  oracle::Random random(806);
  int free = 0;
  for (int i = 0; i < kProofs / 4; ++i)
  {
    CAPTURE(i);
    Straight straight(upright(random));
    straight.sample.settings.nearest.metric = i % 2 == 0 ? NearestMetric::mass : NearestMetric::angles;
    straight.sample.desired.method = static_cast<Method>(i % 10);
    const NearestProblem problem = straight.sample.problem();
    REQUIRE_FALSE(problem.full_rank());
    const Answer answer = straight.sample.answer();
    const Answered found = oracle::answered(straight.robot, straight.sample.desired, answer);
    CHECK(problem.residual(found) <= kKept);
    CHECK(problem.contact_error(found) <= kKept);
    CHECK((answer.flags & flag::adjusted) != 0);
    if (answer.method != Method::constrained || (answer.flags & flag::relaxed) != 0 ||
        (problem.conditions.G * found.w - problem.conditions.h).minCoeff() < 1e-6)
      continue;
    ++free;
    CHECK(mismatch(found.w(1), found.w(4), 1e-6) == "");
  }
  CHECK(free > kProofs / 40);
}

TEST_CASE("on one sole, by mass, a contradiction of the contacts is taken out by reactions alone", "[nearest_motion]")
{
  oracle::Random random(807);
  std::vector<Robot> robots{load_robot("ck"), load_robot("rk"), load_robot("ck"), load_robot("rk")};
  for (std::size_t i = 2; i < 4; ++i)
    make_motors_real(robots[i], random);
  int free = 0;
  for (int i = 0; i < 4 * kProofs; ++i)
  {
    CAPTURE(i);
    const Robot& robot = robots[static_cast<std::size_t>(i % 4)];
    const Side side = kSides[random() % 2];
    Support support{{Contact::none, Contact::none}, Side::left, 0.5, 0.5};
    support.contact[static_cast<std::size_t>(side)] = Contact::sole;
    State state = plausible_state(random, robot, support, 2.0);
    ask_what_ground_gives(random, robot, support, state);
    for (double& v : state.v)
      v += oracle::uniform(random, -0.02, 0.02);
    for (double& a : state.a)
      a += oracle::uniform(random, -2.0, 2.0);
    NearestSample sample{robot, {}, desired_of(robot, state, support), {}};
    sample.settings.methods.infeasible = OnInfeasible::nearest;
    sample.settings.nearest.contact_damping = i % 3 == 0 ? 40.0 : 0.0;
    const Answer answer = sample.answer();
    const NearestProblem problem = sample.problem();
    const Answered found = oracle::answered(robot, sample.desired, answer);
    if ((problem.conditions.G * found.w - problem.conditions.h).minCoeff() < 1e-6 ||
        (problem.most - found.torque).minCoeff() < 1e-6 || (found.torque - problem.least).minCoeff() < 1e-6)
      continue;
    ++free;
    AnswerSettings usual;
    StreamMemory memory;
    const auto plain = std::get<Answer>(torqued::answer(robot, usual, sample.desired, memory));
    CHECK(mismatch(found.torque, plain.torque, 1e-9) == "");
    CHECK((answer.flags & flag::adjusted) != 0);
    EquationOfMotion equation =
        equation_of_motion(robot, motion_of(robot, state, support), support, Coordinates::absolute);
    equation.M = problem.M;
    equation.g = problem.f - equation.h; // friction in it
    equation.Jdot_v = -problem.b;        // damping in it
    CHECK(mismatch(found.a, udwadia_kalaba(equation, answer.torque), 1e-9) == "");
  }
  CHECK(free > kProofs / 2);
}

TEST_CASE("in flight the centre of mass falls and angular momentum stays", "[nearest_motion]")
{
  const NearestRobots robots;
  oracle::Random random(808);
  const oracle::Biped ck, rk = oracle::shipped_rk();
  for (int i = 0; i < kProofs; ++i)
  {
    CAPTURE(i);
    const NearestSample sample = random_sample(random, robots, Contact::none, Contact::none, i);
    const Answered found = oracle::answered(sample.robot, sample.desired, sample.answer());
    const NearestProblem problem = sample.problem();
    Eigen::MatrixXd M = problem.M;
    Eigen::VectorXd rest = problem.f;
    if (const std::string& name = sample.robot.name; name != "rabbit") // in closed form
    {
      const oracle::Biped& biped = name == "ck" ? ck : rk;
      const oracle::Vector9 X = sample.desired.q, V = sample.desired.v;
      M = biped.D(X);
      rest = biped.H(X, V) + biped.Q(X);
    }
    // Newton's and Euler's equations of the whole robot: its rows without motors
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(found.a.size(), 3);
    N.bottomLeftCorner(2, 2).setIdentity();
    N.col(2).head(found.a.size() - 2).setOnes();
    const Eigen::VectorXd terms = N.transpose() * (M.cwiseAbs() * found.a.cwiseAbs() + rest.cwiseAbs());
    const Eigen::VectorXd momentum = N.transpose() * (M * found.a + rest);
    CHECK(momentum.cwiseQuotient(terms).cwiseAbs().maxCoeff() <= 1e-12);
  }
}

TEST_CASE("motors' power goes into kinetic and potential energy while contacts rest", "[nearest_motion]")
{
  const NearestRobots robots;
  const oracle::Biped ck, rk = oracle::shipped_rk();
  for (const Contact left : kContacts)
    for (const Contact right : kContacts)
    {
      oracle::Random random(80900 + 4 * static_cast<unsigned>(left) + static_cast<unsigned>(right));
      for (int i = 0; i < kProofs; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const NearestSample sample = random_sample(random, robots, left, right, i);
        const Robot& robot = sample.robot;
        const NearestProblem problem = sample.problem();
        const Motion motion = std::get<Motion>(complete_motion(robot, sample.desired));
        const Eigen::VectorXd v = motion.v;
        if (problem.J.rows() > 0 && (problem.J * v).cwiseAbs().maxCoeff() > 1e-9)
          continue;
        const Answered found = oracle::answered(robot, sample.desired, sample.answer());
        VectorQ q = sample.desired.q;
        q.tail<2>() = motion.now.base;
        const VectorQ a = found.a;
        const auto energy = [&](double t)
        {
          const VectorQ q_t = q + t * motion.v + 0.5 * t * t * a, v_t = motion.v + t * a;
          if (robot.name != "rabbit")
            return (robot.name == "ck" ? ck : rk).energy(oracle::Vector9(q_t), oracle::Vector9(v_t));
          const Kinematics now = kinematics(robot.mechanism, q_t, v_t);
          double all = kinetic_energy(robot.mechanism, now, v_t) + potential_energy(robot.mechanism, now);
          const Eigen::VectorXd rates = problem.B.transpose() * Eigen::VectorXd(v_t);
          for (int j = 0; j < robot.num_joints(); ++j)
            all += 0.5 * robot.actuators[static_cast<std::size_t>(j)].rotor_inertia * rates(j) * rates(j);
          return all;
        };
        // what friction takes is in f, and in no energy
        const Eigen::VectorXd rates = problem.B.transpose() * v;
        double power = rates.dot(found.torque);
        for (int j = 0; j < robot.num_joints(); ++j)
          power -= rates(j) * joint_friction(robot.actuators[static_cast<std::size_t>(j)], rates(j), 0.0);
        // energies of some kJ, rounded to 1e-16, by the stencil's step of 1e-4 s
        const double size = std::max(1.0, (v.cwiseAbs().dot(problem.M.cwiseAbs() * found.a.cwiseAbs())));
        CHECK(mismatch(oracle::slope(energy, 1e-4) / size, power / size, 1e-8) == "");
      }
    }
}

} // namespace nearest_motion_test
