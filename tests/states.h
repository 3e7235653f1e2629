/// Random states of any robot, in the rows of its equation of motion.
#pragma once

#include "oracles.h"

#include "torque/equation_of_motion.h"

#include <stdexcept>

namespace torqued
{

/// The coordinates of EquationOfMotion, absolute: angles and slides, then a floating root's x and z.
struct State
{
  Eigen::VectorXd q, v, a;
};

/// Any pose, rates of some rad/s, accelerations of some ten rad/s².
inline State random_state(oracle::Random& random, const Robot& robot)
{
  const int n = robot.num_coordinates() + (robot.fixed_root() ? 0 : 2);
  State state{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (int i = 0; i < n; ++i)
  {
    state.q(i) = oracle::uniform(random, -3.0, 3.0);
    state.v(i) = oracle::uniform(random, -4.0, 4.0);
    state.a(i) = oracle::uniform(random, -30.0, 30.0);
  }
  return state;
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

/// The contacts, a fixed root's own included.
inline Support support(const Robot& robot, Contact left, Contact right)
{
  Support result{{left, right}, Side::left, 0.0, 0.0};
  for (const Side side : kSides)
    if (robot.is_root(robot.foot(side)))
      result.contact[static_cast<std::size_t>(side)] = Contact::sole;
  return result;
}

/// The motion as the service completes it.
inline Motion motion_of(const Robot& robot, const State& state, const Support& contacts)
{
  DesiredState desired{};
  desired.base_given = !robot.fixed_root();
  desired.support = contacts;
  desired.q = of_mechanism(robot, state.q);
  desired.v = of_mechanism(robot, state.v);
  desired.a = of_mechanism(robot, state.a);
  const auto completed = complete_motion(robot, desired);
  if (const Refusal* refusal = std::get_if<Refusal>(&completed))
    throw std::invalid_argument(std::string(refusal->detail()));
  return std::get<Motion>(completed);
}

} // namespace torqued
