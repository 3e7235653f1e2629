/// Random questions for the nearest motion.
#pragma once

#include "decompositions.h"
#include "nearest_oracle.h"
#include "states.h"

#include <array>

namespace torqued
{

inline constexpr Contact kContacts[] = {Contact::none, Contact::heel, Contact::sole, Contact::toe};

/// A desired state, all that its answer depends on, and its answer.
struct NearestSample
{
  const Robot& robot;
  AnswerSettings settings;
  DesiredState desired;
  StreamMemory before; ///< the answer

  Answer answer() const
  {
    StreamMemory memory = before;
    const auto result = torqued::answer(robot, settings, desired, memory);
    if (const Refusal* refusal = std::get_if<Refusal>(&result))
      throw std::runtime_error(std::string(refusal->detail()));
    return std::get<Answer>(result);
  }
  oracle::NearestProblem problem() const { return {robot, settings, desired, before}; }
};

/// The two feet's walkers that ship, and the one on points with rotors; with limits of torque rates, and that one with
/// limits of torques, too.
class NearestRobots
{
public:
  NearestRobots()
  {
    for (const char* name : {"ck", "rk", "rabbit"})
    {
      robots_.push_back(load_robot(name));
      Robot limited = robots_.back();
      for (Actuator& actuator : limited.actuators)
      {
        actuator.torque_limit = std::min(actuator.torque_limit, 150.0);
        actuator.rate_limit = 2000.0;
        actuator.coulomb = 2.0;
        actuator.viscous = 0.5;
      }
      limited.joint_friction = true;
      for (Foot& foot : limited.feet)
        foot.f_min = 20.0;
      robots_.push_back(limited);
    }
  }

  /// i: any number, by which they take turns.
  const Robot& for_pair(Contact left, Contact right, int i) const
  {
    const bool points = left != Contact::sole && right != Contact::sole;
    return robots_[static_cast<std::size_t>(i) % (points ? 6 : 4)];
  }

private:
  std::vector<Robot> robots_;
};

/// A pose whose feet are pitched as their contacts need.
inline State plausible_state(oracle::Random& random, const Robot& robot, const Support& support, double rate)
{
  const int n = robot.num_coordinates() + 2;
  State state{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (int i = 0; i < n; ++i)
  {
    state.q(i) = oracle::uniform(random, -0.7, 0.7);
    state.v(i) = oracle::uniform(random, -rate, rate);
    state.a(i) = oracle::uniform(random, -30.0, 30.0);
  }
  state.v.tail<2>() *= 0.5;
  state.a.tail<2>() *= 0.3;
  for (const Side side : kSides)
    if (const Foot& foot = robot.foot(side); foot.has_extent())
    {
      double& pitch = state.q(robot.link(foot.link).coordinate);
      const Contact contact = support.of(side);
      pitch = contact == Contact::sole   ? oracle::uniform(random, -0.02, 0.02) * static_cast<double>(random() % 2)
              : contact == Contact::heel ? oracle::uniform(random, 0.05, 0.4)
              : contact == Contact::toe  ? oracle::uniform(random, -0.6, -0.05)
                                         : pitch;
    }
  return state;
}

/// Moves a state to the nearest rates, and accelerations if they are asked for, that keep its contacts.
inline void keep_contacts(const Robot& robot, const Support& support, bool accelerations, State& state)
{
  if (support.wrench_components() == 0)
    return;
  const auto equation = [&]
  {
    return equation_of_motion(robot, motion_of(robot, state, support), support, Coordinates::absolute);
  };
  const EquationOfMotion at = equation();
  state.v -= oracle::solve(at.J, at.J * state.v);
  if (accelerations)
    state.a -= oracle::solve(at.J, at.J * state.a + equation().Jdot_v);
}

/// Moves a state to accelerations that the ground can give it: each foot pushes at a point of its own within its
/// friction. In flight the whole robot falls.
inline void ask_what_ground_gives(oracle::Random& random, const Robot& robot, const Support& support, State& state)
{
  keep_contacts(robot, support, true, state);
  const Motion motion = motion_of(robot, state, support);
  const EquationOfMotion at = equation_of_motion(robot, motion, support, Coordinates::absolute);
  const int n = robot.num_coordinates();
  const double F_z = robot.weight() * oracle::uniform(random, 0.8, 1.2);
  const Eigen::Vector2d force(oracle::uniform(random, -0.3, 0.3) * F_z, F_z);
  Eigen::Vector3d wanted = Eigen::Vector3d::Zero(); // N, N, N m about the base point
  double share = support.of(Side::right) == Contact::none  ? 1.0
                 : support.of(Side::left) == Contact::none ? 0.0
                                                           : oracle::uniform(random, 0.2, 0.8);
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    const Foot& foot = robot.foot(side);
    const double along = contact == Contact::heel  ? 0.0
                         : contact == Contact::toe ? 1.0
                                                   : oracle::uniform(random, 0.2, 0.8);
    const Eigen::Vector2d point =
        (1.0 - along) * position(motion.now, foot.heel) + along * position(motion.now, foot.toe);
    const Eigen::Vector2d own = (contact == Contact::none ? 0.0 : share) * force;
    wanted.head<2>() += own;
    wanted(2) += cross(point - motion.now.base, own);
    share = 1.0 - share;
  }
  // the rows without motors: the base point's, and the turn of the whole robot
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(n + 2, 3);
  N.bottomLeftCorner(2, 2).setIdentity();
  N.col(2).head(n).setOnes();
  Eigen::MatrixXd S(at.J.rows() + 3, n + 2);
  S << at.J, N.transpose() * at.M;
  Eigen::VectorXd asked(S.rows());
  asked << -at.Jdot_v, wanted - N.transpose() * (at.h + at.g);
  state.a += oracle::solve(S, asked - S * state.a);
}

/// Any of all settings, methods, rates up to 3 and 10 rad/s; of every four states one moves its contacts, two let them
/// rest, and one asks what their rest allows, but for a disturbance.
inline NearestSample random_sample(oracle::Random& random, const Robot& robot, Contact left, Contact right)
{
  const auto one_of = [&](int n)
  {
    return static_cast<int>(random() % static_cast<unsigned>(n));
  };
  NearestSample sample{robot, {}, {}, {}};
  AnswerSettings& settings = sample.settings;
  settings.methods.infeasible = OnInfeasible::nearest;
  settings.nearest.metric = one_of(2) == 0 ? NearestMetric::mass : NearestMetric::angles;
  settings.nearest.contacts = one_of(4) == 0 ? NearestContacts::as_desired : NearestContacts::rest;
  settings.nearest.margin = one_of(2) == 0 ? 0.0 : 0.005;
  settings.nearest.contact_damping = one_of(3) == 0 ? 40.0 : 0.0;
  settings.methods.of<Constrained>().windows = one_of(4) != 0;
  if (one_of(8) == 0)
    settings.methods.of<Constrained>().f_min = oracle::uniform(random, 0.0, 100.0);

  const auto share = [&]
  {
    const int which = one_of(8);
    return which == 0 ? 0.0 : which == 1 ? 1.0 : oracle::uniform(random, 0.0, 1.0);
  };
  const Support support{{left, right}, kSides[static_cast<std::size_t>(one_of(2))], share(), share()};
  const int kind = one_of(4);
  State state = plausible_state(random, sample.robot, support, one_of(2) == 0 ? 3.0 : 10.0);
  if (kind > 0)
    keep_contacts(sample.robot, support, kind == 3, state);
  if (kind == 3)
    for (double& a : state.a)
      a += oracle::uniform(random, -1.0, 1.0);
  DesiredState& desired = sample.desired = desired_of(sample.robot, state, support);
  desired.utime = 1'000'000;
  desired.stream_id = 1;
  desired.method = static_cast<Method>(one_of(10));
  if (support.wrench_components() > 0)
    desired.base_given = one_of(3) != 0;
  if (std::isfinite(sample.robot.actuators[0].rate_limit) && one_of(4) == 0)
  {
    settings.rate_limits = OnExcess::clamp;
    DesiredState earlier = desired;
    earlier.utime -= 1000 * (1 + one_of(10));
    earlier.a *= oracle::uniform(random, 0.8, 1.0);
    static_cast<void>(torqued::answer(sample.robot, settings, earlier, sample.before));
  }
  return sample;
}

/// The same, of robots in turn. Without limits of torques some motions need more than any robot has, and are refused.
inline NearestSample random_sample(oracle::Random& random, const NearestRobots& robots, Contact left, Contact right,
                                   int i)
{
  for (;;)
  {
    const NearestSample sample = random_sample(random, robots.for_pair(left, right, i), left, right);
    StreamMemory memory = sample.before;
    if (std::isfinite(sample.robot.actuators[0].torque_limit) ||
        std::holds_alternative<Answer>(answer(sample.robot, sample.settings, sample.desired, memory)))
      return sample;
  }
}

/// The largest of what was seen, and where.
struct Worst
{
  double value = 0.0;
  int at = -1;

  void see(double other, int i)
  {
    if (other <= value) // not so of what is no number
      return;
    value = other;
    at = i;
  }
};

} // namespace torqued
