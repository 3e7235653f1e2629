#include "catch.h"
#include "decompositions.h"
#include "matchers.h"
#include "states.h"

#include "planar/dynamics.h"
#include "questions/regressor.h"
#include "robot/files/load.h"
#include "stance/joint_friction.h"

namespace regressor_test
{

using namespace torqued;

namespace
{

Motion motion_of(const Robot& robot, const State& state)
{
  return {kinematics(robot.mechanism, state.q, state.v), state.v, state.a};
}

Eigen::VectorXd values(const std::vector<BaseParameter>& parameters)
{
  Eigen::VectorXd alpha(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    alpha(static_cast<Eigen::Index>(i)) = parameters[i].value;
  return alpha;
}

// rows that a robot's coordinates show: all of a floating robot, those before the root's of a fixed one
Eigen::Index shown_rows(const Robot& robot)
{
  return robot.num_coordinates() + (robot.fixed_root() ? 0 : 2);
}

double value_of(const std::vector<BaseParameter>& parameters, const std::string& first)
{
  for (const BaseParameter& parameter : parameters)
    if (parameter.name.starts_with(first))
      return parameter.value;
  FAIL("there is no parameter that begins with " << first);
  return 0.0;
}

} // namespace

TEST_CASE("Y alpha is the generalized force, friction and rotors included", "[regressor]")
{
  oracle::Random random(1);
  for (const Robot& robot : all_kinds_of_motors())
  {
    const std::vector<BaseParameter> parameters = base_parameters(robot);
    const Eigen::VectorXd alpha = values(parameters);
    for (int i = 0; i < kStates; ++i)
    {
      CAPTURE(robot.name, i);
      const State state = of_mechanism(robot, random_state(random, robot));
      VectorQ r = inverse_dynamics(robot.mechanism, kinematics(robot.mechanism, state.q, state.v), state.a);
      r.head(robot.mechanism.num_theta()) += joint_forces(robot, joint_friction(robot, state.v, state.a));
      const Eigen::MatrixXd Y = regressor(robot, parameters, motion_of(robot, state));
      CHECK(mismatch((Y * alpha).head(shown_rows(robot)), r.head(shown_rows(robot)), 1e-10) == "");
    }
  }
}

TEST_CASE("base parameters are as many as the rank of Y: 10 for pin knees, 11 for rolling knees", "[regressor]")
{
  oracle::Random random(2);
  for (const Robot& robot : all_kinds_of_motors())
  {
    CAPTURE(robot.name);
    const std::vector<BaseParameter> parameters = base_parameters(robot);
    const Eigen::Index rows = shown_rows(robot);
    Eigen::MatrixXd stacked(200 * rows, static_cast<Eigen::Index>(parameters.size()));
    for (int i = 0; i < 200; ++i)
      stacked.middleRows(i * rows, rows) =
          regressor(robot, parameters, motion_of(robot, of_mechanism(robot, random_state(random, robot))))
              .topRows(rows);
    // columns of one size, so that the smallest singular value tells dependence from small units
    stacked.colwise().normalize();
    const Eigen::VectorXd singular = oracle::singular_values(stacked);
    CHECK(singular.minCoeff() > 1e-4 * singular.maxCoeff());
    if (robot.name == "ck")
      CHECK(parameters.size() == 10);
    if (robot.name == "rk")
      CHECK(parameters.size() == 11);
  }
}

TEST_CASE("the rank of the regressor of all standard parameters is that of the base parameters", "[regressor]")
{
  // random biped with pin or rolling knees, standard parameters one by one by what a change of each does
  oracle::Random random(3);
  for (const auto& [name, rank] : {std::pair{"ck", 10}, std::pair{"rk", 11}})
  {
    const Robot robot = load_robot(name);
    CAPTURE(robot.name);
    std::vector<Mechanism> units;
    const std::vector<std::vector<int>> kinds{{0, 5}, {1, 4}, {2, 3}, {6}};
    for (const std::vector<int>& kind : kinds)
      for (int parameter = 0; parameter < 4; ++parameter)
      {
        std::vector<Body> bodies;
        for (const int link : kind)
        {
          Body body = body_of(robot.link(link));
          body.mass = parameter == 0 ? 1.0 : 0.0;
          body.moment = {parameter == 1 ? 1.0 : 0.0, parameter == 2 ? 1.0 : 0.0};
          body.inertia = parameter == 3 ? 1.0 : 0.0;
          bodies.push_back(body);
        }
        if (parameter != 1 || kind.front() == 0) // only the feet's centres of mass lie off their axes
          units.emplace_back(robot.mechanism.W(), bodies, robot.mechanism.gravity());
      }
    REQUIRE(units.size() == 13);
    Eigen::MatrixXd stacked(100 * 9, 13);
    for (int i = 0; i < 100; ++i)
    {
      const State state = of_mechanism(robot, random_state(random, robot));
      for (int k = 0; k < 13; ++k)
        stacked.block<9, 1>(9 * i, k) = inverse_dynamics(units[static_cast<std::size_t>(k)],
                                                         kinematics(robot.mechanism, state.q, state.v), state.a);
    }
    stacked.colwise().normalize();
    CHECK(oracle::rank(stacked) == rank);
  }
}

TEST_CASE("base parameters are the sums that the closed form shows", "[regressor]")
{
  // [Hobon 2013]'s symbols: m0 … m3, l1, l2, s1 … s3 of ck and rk, r1, r2 of rk
  const double m0 = 0.7, m1 = 2.2, m2 = 5.0, m3 = 29.2, I1 = 0.028, I2 = 0.066, I3 = 0.81;
  const double l1 = 0.39, l2 = 0.40, s1 = 0.16, s2 = 0.17, s3 = 0.19, r1 = 0.05, r2 = 0.035, mA = m0 + m1;
  const double foot = 0.0025 + m0 * (0.03 * 0.03 + 0.04 * 0.04);
  const double mt = 2.0 * (m0 + m1 + m2) + m3;
  for (const bool rolls : {false, true})
  {
    const std::vector<BaseParameter> found = base_parameters(load_robot(rolls ? "rk" : "ck"));
    const double l1c = rolls ? l1 - r1 : l1, l2c = rolls ? l2 - r2 : l2, s1c = rolls ? s1 - r1 : s1;
    CHECK(mismatch(value_of(found, "I(left_foot, right_foot)"), foot, 1e-10) == "");
    CHECK(mismatch(value_of(found, "mx(left_foot, right_foot)"), m0 * 0.03, 1e-10) == "");
    CHECK(mismatch(value_of(found, "mz(left_foot, right_foot)"), -m0 * 0.04, 1e-10) == "");
    CHECK(mismatch(value_of(found, "I(left_shin, right_shin)"), I1 + m0 * l1c * l1c + m1 * s1c * s1c, 1e-10) == "");
    CHECK(mismatch(value_of(found, "mz(left_shin, right_shin)"), -(m0 * l1c + m1 * s1c), 1e-10) == "");
    // of rolling knees the mass beyond the knee shows by itself; else it is part of what it loads
    const double separate = rolls ? mA : 0.0;
    if (rolls)
      CHECK(mismatch(value_of(found, "m(left_shin, right_shin)"), mA, 1e-10) == "");
    CHECK(mismatch(value_of(found, "I(left_thigh, right_thigh)"), I2 + m2 * s2 * s2 + (mA - separate) * l2c * l2c,
                   1e-10) == "");
    CHECK(mismatch(value_of(found, "mz(left_thigh, right_thigh)"), -(m2 * s2 + (mA - separate) * l2c), 1e-10) == "");
    CHECK(mismatch(value_of(found, "I(trunk)"), I3 + m3 * s3 * s3, 1e-10) == "");
    CHECK(mismatch(value_of(found, "mz(trunk)"), m3 * s3, 1e-10) == "");
    CHECK(mismatch(value_of(found, "m(trunk)"), mt - 2.0 * separate, 1e-10) == "");
  }
}

TEST_CASE("friction shows in Y at any rate, however slow its own", "[regressor]")
{
  oracle::Random random(4);
  for (const double slow : {1e-3, 1e-2, 0.1, 1.0, 10.0})
  {
    Robot robot = load_robot("rabbit");
    make_motors_real(robot, random);
    for (Actuator& actuator : robot.actuators)
      actuator.stribeck_velocity = slow;
    robot.actuators.front().stick_velocity = slow;
    const std::vector<BaseParameter> parameters = base_parameters(robot);
    for (int i = 0; i < 20; ++i)
    {
      CAPTURE(slow, i);
      State state = of_mechanism(robot, random_state(random, robot));
      state.v *= 0.25 * slow;
      VectorQ r = inverse_dynamics(robot.mechanism, kinematics(robot.mechanism, state.q, state.v), state.a);
      r.head(robot.mechanism.num_theta()) += joint_forces(robot, joint_friction(robot, state.v, state.a));
      CHECK(mismatch(regressor(robot, parameters, motion_of(robot, state)) * values(parameters), r, 1e-10) == "");
    }
  }
}

} // namespace regressor_test
