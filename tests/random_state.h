/// States of any robot.
#pragma once

#include "oracles.h"

#include "planar/kinematics.h"

namespace torqued
{

/// Length num_q(): angles of all quadrants, rates of a few rad/s; a fixed root at rest.
struct State
{
  VectorQ q, v, a;

  Kinematics now(const Robot& robot) const { return kinematics(robot.mechanism, q, v); }
};

inline State random_state(oracle::Random& random, const Robot& robot)
{
  const int n = robot.mechanism.num_q();
  State state{VectorQ(n), VectorQ(n), VectorQ(n)};
  for (int i = 0; i < n; ++i)
  {
    state.q(i) = oracle::uniform(random, -3.0, 3.0);
    state.v(i) = oracle::uniform(random, -4.0, 4.0);
    state.a(i) = oracle::uniform(random, -20.0, 20.0);
  }
  if (robot.fixed_root())
    for (VectorQ* vector : {&state.q, &state.v, &state.a})
      vector->tail<3>().setZero();
  return state;
}

/// Robots that ship, and one of all that a robot file can say of a floating mechanism: a link fixed at an angle that
/// carries a rolling joint whose bar stands askew, a slide that carries a link that turns, actuators of every placement
/// between links that are not neighbours, rotors and friction.
inline std::vector<Robot> all_kinds_of_robots()
{
  std::vector<Robot> robots;
  for (const std::string_view name : shipped_robot_names())
    robots.push_back(load_robot(std::string(name)));
  robots.push_back(read_toml_robot(R"(
name = "odd"
[[link]]
name = "trunk"
joint = "floating"
mass = 10.0
com = [0.05, 0.2]
inertia = 0.4
[[link]]
name = "pack"
joint = "fixed"
parent = "trunk"
at = [-0.1, 0.3]
angle = 0.7
mass = 3.0
com = [0.02, -0.03]
inertia = 0.05
[[link]]
name = "roller"
joint = "rolling"
parent = "pack"
at = [0.03, -0.2]
parent_radius = 0.06
child_radius = 0.11
angle = 0.4
mass = 2.0
com = [0.1, -0.15]
inertia = 0.03
[[link]]
name = "second"
joint = "rolling"
parent = "roller"
at = [0.0, -0.3]
parent_radius = 0.08
child_radius = 0.02
angle = -0.2
mass = 1.5
com = [0.0, -0.1]
inertia = 0.02
[[link]]
name = "shuttle"
joint = "slide"
parent = "second"
at = [0.1, -0.2]
mass = 0.8
com = [0.01, 0.02]
inertia = 0.01
[[link]]
name = "pointer"
joint = "revolute"
parent = "shuttle"
at = [0.05, 0.0]
mass = 0.6
com = [0.2, 0.0]
inertia = 0.006
[[actuator]]
name = "a"
on = "trunk"
against = "roller"
coulomb = 0.4
viscous = 0.7
[[actuator]]
name = "b"
on = "second"
against = "roller"
between = "bar-child"
rotor_inertia = 0.05
stribeck = 0.3
stribeck_velocity = 0.6
friction_offset = 0.02
[[actuator]]
name = "c"
on = "shuttle"
against = "second"
[[actuator]]
name = "d"
on = "pointer"
against = "trunk"
offset = 0.3
)",
                                   "odd.toml"));
  return robots;
}

} // namespace torqued
