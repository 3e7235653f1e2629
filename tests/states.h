/// Random states of any robot, in the rows of its equation of motion.
#pragma once

#include "biped_of.h"
#include "oracles.h"

#include "questions/equation_of_motion.h"
#include "robot/files/load.h"

#include <fmt/format.h>
#include <stdexcept>
#include <string>
#include <vector>

namespace torqued
{

/// Random states of a robot for each law. A build without optimization is some 50 times as slow, and is there to look
/// for faults of memory, not of numbers.
#ifdef NDEBUG
inline constexpr int kStates = 1000;
#else
inline constexpr int kStates = 40;
#endif

/// The coordinates of EquationOfMotion, absolute: angles and slides, then a floating root's x and z.
struct State
{
  Eigen::VectorXd q, v, a;
};

/// Any pose, rates of some rad/s, accelerations of some ten rad/s².
inline State random_state(oracle::Random& random, int n)
{
  State state{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (int i = 0; i < n; ++i)
  {
    state.q(i) = oracle::uniform(random, -3.0, 3.0);
    state.v(i) = oracle::uniform(random, -4.0, 4.0);
    state.a(i) = oracle::uniform(random, -30.0, 30.0);
  }
  return state;
}
inline State random_state(oracle::Random& random, const Robot& robot)
{
  return random_state(random, robot.num_coordinates() + (robot.fixed_root() ? 0 : 2));
}

/// In the coordinates of the mechanism: a fixed root's angle and the base point, at rest, are among them.
inline VectorQ of_mechanism(const Robot& robot, const Eigen::VectorXd& values)
{
  VectorQ all = VectorQ::Zero(robot.mechanism.num_q());
  all.head(robot.num_coordinates()) = values.head(robot.num_coordinates());
  if (!robot.fixed_root())
    all.tail<2>() = values.tail<2>();
  return all;
}

inline State of_mechanism(const Robot& robot, const State& state)
{
  return {of_mechanism(robot, state.q), of_mechanism(robot, state.v), of_mechanism(robot, state.a)};
}

/// Every robot that ships, one with many links, and random ones, named for what they have that those have not: rolling
/// knees with each kind of motor, a rolling knee whose parent is the shin, and whatever else can be described.
inline std::vector<Robot> all_kinds_of_robots()
{
  std::vector<Robot> robots;
  const auto add = [&robots](std::string name, Robot robot)
  {
    robot.name = std::move(name);
    robots.push_back(std::move(robot));
  };
  for (const std::string_view name : shipped_robot_names())
    robots.push_back(load_robot(std::string(name)));
  add("13 links", biped_of(13));
  oracle::Random random(200);
  for (const Placement knee : {Placement::links, Placement::bar_parent, Placement::bar_child})
    add(fmt::format("rk, {}", name_of(knee)), oracle::random_rk(random, knee).robot());
  add("six-link with rolling knees", oracle::SixLink{oracle::random_rk(random), Side::right}.robot());
  for (const bool fixed_root : {false, true})
    for (int i = 0; i < 3; ++i)
      add(fmt::format("tree {}, {}", i, fixed_root ? "fixed" : "floating"), oracle::random_tree(random, fixed_root));
  return robots;
}

/// Gives every motor a rotor and all kinds of friction.
inline void make_motors_real(Robot& robot, oracle::Random& random)
{
  robot.joint_friction = true;
  for (Actuator& actuator : robot.actuators)
  {
    actuator.rotor_inertia = oracle::uniform(random, 0.1, 1.0);
    actuator.coulomb = oracle::uniform(random, 0.1, 2.0);
    actuator.viscous = oracle::uniform(random, 0.1, 2.0);
    actuator.stribeck = oracle::uniform(random, 0.1, 2.0);
    actuator.stribeck_velocity = oracle::uniform(random, 0.5, 2.0);
    actuator.friction_offset = oracle::uniform(random, -1.0, 1.0);
  }
}

/// All kinds of robots, real motors on those that do not ship.
inline std::vector<Robot> all_kinds_of_motors()
{
  std::vector<Robot> robots = all_kinds_of_robots();
  oracle::Random random(203);
  for (std::size_t i = shipped_robot_names().size(); i < robots.size(); ++i)
    make_motors_real(robots[i], random);
  return robots;
}

/// The contacts, a fixed root's own included.
inline Support support(const Robot& robot, Contact left, Contact right)
{
  Support result{{left, right}, Side::left, 0.0, 0.0};
  for (const Side side : kSides)
    if (robot.is_root(robot.foot(side)))
      result.contact[static_cast<std::size_t>(side)] = Contact::sole;
  return result;
}

/// A state as it is asked for, the base point given where the root is not fixed.
inline DesiredState desired_of(const Robot& robot, const State& state, const Support& contacts)
{
  DesiredState desired{};
  desired.base_given = !robot.fixed_root();
  desired.support = contacts;
  desired.q = of_mechanism(robot, state.q);
  desired.v = of_mechanism(robot, state.v);
  desired.a = of_mechanism(robot, state.a);
  return desired;
}

/// The motion as the service completes it.
inline Motion motion_of(const Robot& robot, const State& state, const Support& contacts)
{
  const auto completed = complete_motion(robot, desired_of(robot, state, contacts));
  if (const Refusal* refusal = std::get_if<Refusal>(&completed))
    throw std::invalid_argument(std::string(refusal->detail()));
  return std::get<Motion>(completed);
}

} // namespace torqued
