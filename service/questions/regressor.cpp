#include "questions/regressor.h"

#include "planar/dynamics.h"
#include "questions/equation_of_motion.h"
#include "stance/joint_friction.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <random>
#include <tuple>

namespace torqued
{

namespace
{

// Links with the same numbers, in the order in which they appear.
std::vector<std::vector<int>> kinds_of_links(const Robot& robot)
{
  const auto numbers = [&robot](int link)
  {
    const Link& l = robot.link(link);
    return std::make_tuple(l.mass, l.com.x(), l.com.y(), l.inertia);
  };
  std::vector<std::vector<int>> kinds;
  for (int i = 0; i < static_cast<int>(robot.links.size()); ++i)
  {
    const auto same =
        std::ranges::find_if(kinds, [&](const std::vector<int>& kind) { return numbers(kind.front()) == numbers(i); });
    if (same == kinds.end())
      kinds.push_back({i});
    else
      same->push_back(i);
  }
  return kinds;
}

// A standard parameter of a kind of links, set to 1.
BaseParameter standard_parameter(const Robot& robot, std::string_view symbol, const std::vector<int>& kind,
                                 double value, double mass, const Eigen::Vector2d& moment, double inertia)
{
  std::string name;
  std::vector<Body> bodies;
  for (const int i : kind)
  {
    const Link& link = robot.link(i);
    name += (name.empty() ? "" : ", ") + link.name;
    Body body = body_of(link);
    body.mass = mass;
    body.moment = rotate(link.heading, moment);
    body.inertia = inertia;
    bodies.push_back(body);
  }
  return {fmt::format("{}({})", symbol, name), value,
          Mechanism(robot.mechanism.W(), bodies, robot.mechanism.gravity())};
}

// inertias and moments of every kind of link, then the masses from the root outwards
std::vector<BaseParameter> standard_parameters(const Robot& robot)
{
  std::vector<std::vector<int>> kinds = kinds_of_links(robot);
  std::vector<BaseParameter> parameters;
  const auto add = [&](std::string_view symbol, const std::vector<int>& kind, double value, double mass,
                       const Eigen::Vector2d& moment, double inertia)
  {
    if (value != 0.0)
      parameters.push_back(standard_parameter(robot, symbol, kind, value, mass, moment, inertia));
  };
  for (const std::vector<int>& kind : kinds)
  {
    const Link& link = robot.link(kind.front());
    add("I", kind, link.inertia + link.mass * link.com.squaredNorm(), 0.0, {0.0, 0.0}, 1.0);
    add("mx", kind, link.mass * link.com.x(), 0.0, {1.0, 0.0}, 0.0);
    add("mz", kind, link.mass * link.com.y(), 0.0, {0.0, 1.0}, 0.0);
  }
  for (const int i : robot.order)
    for (const std::vector<int>& kind : kinds)
      if (kind.front() == i)
        add("m", kind, robot.link(i).mass, 1.0, {0.0, 0.0}, 0.0);
  return parameters;
}

// A number of every motor and what it is called.
struct MotorField
{
  std::string_view symbol;
  double Actuator::*value;
};
constexpr std::array<MotorField, 1> kRotor{{{"I", &Actuator::rotor_inertia}}};
constexpr std::array<MotorField, 4> kFriction{{{"coulomb", &Actuator::coulomb},
                                               {"viscous", &Actuator::viscous},
                                               {"stribeck", &Actuator::stribeck},
                                               {"offset", &Actuator::friction_offset}}};

template <std::size_t N>
void add_motor_parameters(const Robot& robot, const std::array<MotorField, N>& fields,
                          std::vector<BaseParameter>& parameters)
{
  for (int j = 0; j < robot.num_joints(); ++j)
  {
    const Actuator& actuator = robot.actuators[static_cast<std::size_t>(j)];
    for (const auto& [symbol, value] : fields)
    {
      if (actuator.*value == 0.0)
        continue;
      Actuator motor;
      motor.stribeck_velocity = actuator.stribeck_velocity;
      motor.stick_velocity = actuator.stick_velocity;
      motor.*value = 1.0;
      parameters.push_back({fmt::format("{}(motor {})", symbol, actuator.name), actuator.*value,
                            Mechanism(robot.mechanism.W(), {}, robot.mechanism.gravity()), j, motor});
    }
  }
}

// Y at many states, one below the other, in the rows that the robot's coordinates show
Eigen::MatrixXd stacked_regressor(const Robot& robot, const std::vector<BaseParameter>& parameters)
{
  constexpr int states = 30; // each gives as many rows as there are coordinates: far more than parameters
  std::mt19937_64 random(1);
  const auto number = [&random](double size)
  {
    return size * (std::ldexp(static_cast<double>(random() >> 11), -52) - 1.0); // −size to size
  };
  const int num_q = robot.mechanism.num_q();
  Eigen::MatrixXd stacked(0, static_cast<Eigen::Index>(parameters.size()));
  for (int state = 0; state < states; ++state)
  {
    VectorQ q(num_q), v(num_q), a(num_q);
    for (int i = 0; i < num_q; ++i)
    {
      q(i) = number(3.0);
      v(i) = number(3.0);
      a(i) = number(10.0);
    }
    if (robot.fixed_root())
      for (VectorQ* motion : {&q, &v, &a})
        motion->tail<3>().setZero(); // its angle, and the base point
    const Motion motion{kinematics(robot.mechanism, q, v), v, a};
    const Eigen::MatrixXd Y = regressor(robot, parameters, motion);
    const int n = robot.num_coordinates() + (robot.fixed_root() ? 0 : 2);
    stacked.conservativeResize(stacked.rows() + n, Eigen::NoChange);
    for (Eigen::Index column = 0; column < Y.cols(); ++column)
      stacked.col(column).tail(n) = in_coordinates(robot, Y.col(column), Coordinates::absolute);
  }
  return stacked;
}

} // namespace

std::vector<BaseParameter> base_parameters(const Robot& robot)
{
  std::vector<BaseParameter> standard = standard_parameters(robot);
  add_motor_parameters(robot, kRotor, standard);
  const Eigen::MatrixXd Y = stacked_regressor(robot, standard);

  // keep each column that those kept before do not give (Gram and Schmidt, twice for rounding's sake), and add the
  // others to those that give them
  constexpr double rounding = 1e-9;
  std::vector<BaseParameter> parameters;
  std::vector<std::size_t> left_out;
  Eigen::MatrixXd kept(Y.rows(), Y.cols()), basis(Y.rows(), Y.cols());
  Eigen::Index rank = 0;
  for (std::size_t i = 0; i < standard.size(); ++i)
  {
    const Eigen::VectorXd column = Y.col(static_cast<Eigen::Index>(i));
    Eigen::VectorXd rest = column;
    for (int pass = 0; pass < 2; ++pass)
      rest -= basis.leftCols(rank) * (basis.leftCols(rank).transpose() * rest);
    if (rest.norm() <= rounding * column.norm() || column.norm() <= rounding * Y.norm())
    {
      left_out.push_back(i);
      continue;
    }
    basis.col(rank) = rest.normalized();
    kept.col(rank) = column;
    ++rank;
    parameters.push_back(standard[i]);
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(kept.leftCols(rank));
  for (const std::size_t i : left_out)
  {
    const Eigen::VectorXd share = qr.solve(Y.col(static_cast<Eigen::Index>(i)));
    for (std::size_t k = 0; k < parameters.size(); ++k)
      if (const double factor = share(static_cast<Eigen::Index>(k)); std::abs(factor) > rounding)
      {
        parameters[k].value += factor * standard[i].value;
        parameters[k].name += fmt::format(
            " {} {}{}", factor < 0.0 ? "-" : "+",
            std::abs(std::abs(factor) - 1.0) < rounding ? std::string() : fmt::format("{:.6g} ", std::abs(factor)),
            standard[i].name);
      }
  }

  // nothing else is a sign, or linear, in a motor's rate: friction always shows
  add_motor_parameters(robot, kFriction, parameters);
  return parameters;
}

VectorQ regressor_column(const Robot& robot, const BaseParameter& parameter, const Motion& motion)
{
  VectorQ column = inverse_dynamics(parameter.unit, motion.now, motion.a);
  if (parameter.joint >= 0)
  {
    const int size = robot.mechanism.num_theta();
    VectorJ torque = VectorJ::Zero(robot.num_joints());
    torque(parameter.joint) = joint_friction(parameter.motor, joint_rates(robot, motion.v.head(size))(parameter.joint),
                                             joint_rates(robot, motion.a.head(size))(parameter.joint));
    column.head(size) += joint_forces(robot, torque);
  }
  return column;
}

Eigen::MatrixXd regressor(const Robot& robot, const std::vector<BaseParameter>& parameters, const Motion& motion)
{
  Eigen::MatrixXd Y(robot.mechanism.num_q(), static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    Y.col(static_cast<Eigen::Index>(i)) = regressor_column(robot, parameters[i], motion);
  return Y;
}

} // namespace torqued
