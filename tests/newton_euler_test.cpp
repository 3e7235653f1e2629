#include "catch.h"
#include "matchers.h"
#include "states.h"

#include "planar/dynamics.h"
#include "questions/newton_euler.h"
#include "robot/files/load.h"
#include "stance/contacts.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace newton_euler_test
{

using namespace torqued;

namespace
{

using Ground = std::array<Eigen::Vector3d, 2>;

Ground random_ground(oracle::Random& random, const Robot& robot)
{
  Ground ground{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (const Side side : kSides)
    if (robot.foot(side).exists())
      ground[static_cast<std::size_t>(side)] << oracle::uniform(random, -300.0, 300.0),
          oracle::uniform(random, -200.0, 900.0), oracle::uniform(random, -80.0, 80.0);
  return ground;
}

// Jᵀ w of wrenches about the ankles
VectorQ generalized(const Robot& robot, const Kinematics& now, const Ground& ground)
{
  VectorQ force = VectorQ::Zero(robot.mechanism.num_q());
  for (const Side side : kSides)
    if (const Foot& foot = robot.foot(side); foot.exists())
    {
      const Eigen::Vector3d& w = ground[static_cast<std::size_t>(side)];
      Jacobian J(2, robot.mechanism.num_q());
      point_jacobian(robot.mechanism, now, foot.ankle, 0, J);
      force += J.transpose() * w.head<2>();
      force.head(robot.mechanism.num_theta()) +=
          w(2) * robot.mechanism.W().row(robot.link(foot.link).direction).transpose();
    }
  return force;
}

// (F_x, F_z, moment about the base point)
Eigen::Vector3d on_the_whole(const Robot& robot, const VectorQ& force)
{
  const int size = robot.mechanism.num_theta();
  const double moment = robot.A_inverse.col(size - 1).dot(force.head(size));
  return {force(size), force(size + 1), moment};
}

bool carries(const Robot& robot, int ancestor, int link)
{
  while (link != ancestor && link >= 0)
    link = robot.link(link).parent;
  return link == ancestor;
}

bool has_parallel_links(const Robot& robot)
{
  return std::any_of(robot.links.begin(), robot.links.end(),
                     [](const Link& link) { return link.joint == JointKind::parallel; });
}

} // namespace

TEST_CASE("torques and the whole robot's residual equal those of the closed form for any ground wrenches",
          "[newton_euler]")
{
  oracle::Random random(1);
  for (const Robot& robot : all_kinds_of_robots())
    for (int i = 0; i < kStates; ++i)
    {
      CAPTURE(robot.name, i);
      const State state = of_mechanism(robot, random_state(random, robot));
      const Ground ground = random_ground(random, robot);
      const Kinematics now = kinematics(robot.mechanism, state.q, state.v);
      const VectorQ rest = inverse_dynamics(robot.mechanism, now, state.a) - generalized(robot, now, ground);
      const NewtonEuler found = newton_euler(robot, state.q, state.v, state.a, ground);

      const JointWrench& root = found.joints[static_cast<std::size_t>(robot.root())];
      const Eigen::Vector3d residual(root.force.x(), root.force.y(), root.moment);
      // some hundred terms of the size of the largest moment
      CHECK(mismatch(found.torque, joint_torques(robot, rest.head(robot.mechanism.num_theta())), 1e-11) == "");
      CHECK(mismatch(residual, on_the_whole(robot, rest), 1e-11) == "");
    }
}

TEST_CASE("each joint carries what Newton's and Euler's equations of all beyond it leave", "[newton_euler]")
{
  // all beyond a joint, as a mechanism of its own whose other links have no mass: its rows of the base point are the
  // force, and their moment about the base point, that it needs
  oracle::Random random(2);
  for (const Robot& robot : all_kinds_of_robots())
    for (int joint = 0; joint < static_cast<int>(robot.links.size()); ++joint)
    {
      std::vector<Body> beyond;
      for (int link = 0; link < static_cast<int>(robot.links.size()); ++link)
        if (carries(robot, joint, link))
          beyond.push_back(body_of(robot.link(link)));
      const Mechanism part(robot.mechanism.W(), beyond, robot.mechanism.gravity());
      for (int i = 0; i < kStates / 20; ++i)
      {
        CAPTURE(robot.name, robot.link(joint).name, i);
        const State state = of_mechanism(robot, random_state(random, robot));
        const Ground ground = random_ground(random, robot);
        const Kinematics now = kinematics(robot.mechanism, state.q, state.v);
        Eigen::Vector3d needed = on_the_whole(robot, inverse_dynamics(part, now, state.a));
        for (const Side side : kSides)
          if (const Foot& foot = robot.foot(side); foot.exists() && carries(robot, joint, foot.link))
          {
            const Eigen::Vector3d& w = ground[static_cast<std::size_t>(side)];
            needed.head<2>() -= w.head<2>();
            needed(2) -= w(2) + cross(from_base(now, foot.ankle), w.head<2>());
          }
        const JointWrench found =
            newton_euler(robot, state.q, state.v, state.a, ground).joints[static_cast<std::size_t>(joint)];
        CHECK(mismatch(found.force, needed.head<2>(), 1e-11) == "");
        if (!has_parallel_links(robot))
          CHECK(mismatch(found.moment + cross(found.at, found.force), needed(2), 1e-11) == "");
      }
    }
}

TEST_CASE("a rolling joint's wrench acts where the circles touch, and its moment is kappa times the motor's",
          "[newton_euler]")
{
  oracle::Random random(3);
  const Robot robot = load_robot("rk");
  for (int i = 0; i < kStates; ++i)
  {
    const State state = of_mechanism(robot, random_state(random, robot));
    const NewtonEuler found = newton_euler(robot, state.q, state.v, state.a, random_ground(random, robot));
    // r1 = 0.05 on the shin, r2 = 0.035 on the thigh, l2' = 0.365; knees turn the thigh against the shin
    const auto knee = [&](int thigh, int shin)
    {
      const double gamma = (0.05 * state.q(shin) + 0.035 * state.q(thigh)) / 0.085;
      const auto u = [](double angle)
      {
        return Eigen::Vector2d(std::sin(angle), -std::cos(angle));
      };
      return Eigen::Vector2d(0.365 * u(state.q(thigh)) + 0.035 * u(gamma));
    };
    CHECK(mismatch(found.joints[1].at, knee(2, 1), 1e-14) == "");
    CHECK(mismatch(found.joints[4].at, knee(3, 4), 1e-14) == "");
    CHECK(mismatch(found.joints[1].moment, -0.05 / 0.085 * found.torque(1), 1e-11) == "");
    CHECK(mismatch(found.joints[4].moment, -0.05 / 0.085 * found.torque(4), 1e-11) == "");
  }
}

TEST_CASE("with a fixed root the root's wrench is the ground reaction", "[newton_euler]")
{
  // six-link is ck whose left foot does not move: the same motion of both, and the wrench on ck's foot that makes its
  // residual vanish
  oracle::Random random(4);
  const Robot six = load_robot("six-link");
  const Robot ck = load_robot("ck");
  const Ground none{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (int i = 0; i < kStates; ++i)
  {
    const State state = of_mechanism(six, random_state(random, six));
    const NewtonEuler found = newton_euler(six, state.q, state.v, state.a, none);
    const JointWrench& root = found.joints[static_cast<std::size_t>(six.root())];

    DesiredState desired;
    desired.base_given = false;
    desired.support = {{Contact::sole, Contact::none}, Side::left, 0.0, 0.0};
    const auto as_ck = [](const VectorQ& of)
    {
      VectorQ x(9);
      x << 0.0, of(0), of(1), of(3), of(4), of(5), of(2), 0.0, 0.0;
      return x;
    };
    desired.q = as_ck(state.q);
    desired.v = as_ck(state.v);
    desired.a = as_ck(state.a);
    const Motion motion = std::get<Motion>(complete_motion(ck, desired));
    const Ground ground{Eigen::Vector3d(root.force.x(), root.force.y(), root.moment), Eigen::Vector3d::Zero()};
    const NewtonEuler same = newton_euler(ck, desired.q, motion.v, motion.a, ground);
    const JointWrench& residual = same.joints[static_cast<std::size_t>(ck.root())];
    CHECK(mismatch(same.torque, found.torque, 1e-11) == "");
    CHECK(mismatch(residual.force, Eigen::Vector2d(0.0, 0.0), 1e-9) == "");
    CHECK(mismatch(residual.moment, 0.0, 1e-9) == "");
  }
}

TEST_CASE("a link's own matrices give its net wrench, its energy, and C is skew", "[newton_euler]")
{
  oracle::Random random(5);
  for (int i = 0; i < kStates; ++i)
  {
    const auto number = [&random](double size)
    {
      return oracle::uniform(random, -size, size);
    };
    Link link;
    link.mass = 1.0 + number(0.9);
    link.inertia = 0.1 + number(0.05);
    link.com = {number(0.3), number(0.3)};
    const double angle = number(3.0), omega = number(5.0), alpha = number(20.0), gravity = 9.81;
    const Eigen::Rotation2Dd R(angle);
    const Eigen::Vector2d v(number(3.0), number(3.0)), a(number(9.0), number(9.0)); // of the origin, world frame
    const auto turned = [](const Eigen::Vector2d& r)
    {
      return Eigen::Vector2d(-r.y(), r.x());
    };

    // in the link's frame, the components change by what the frame turns
    const Eigen::Vector2d v_B = R.inverse() * v;
    const Eigen::Vector2d vdot_B = R.inverse() * a - omega * turned(v_B);
    const Eigen::Vector3d V(v_B.x(), v_B.y(), omega), Vdot(vdot_B.x(), vdot_B.y(), alpha);
    const LinkDynamics link_B = link_dynamics(link, {std::cos(angle), std::sin(angle)}, omega, gravity);
    const Eigen::Vector3d f_B = link_B.M * Vdot + link_B.C * V + link_B.g;

    const Eigen::Vector2d c = R * link.com;
    const Eigen::Vector2d v_com = v + omega * turned(c);
    const Eigen::Vector2d a_com = a + alpha * turned(c) - omega * omega * c;
    const Eigen::Vector2d force = link.mass * (a_com + Eigen::Vector2d(0.0, gravity));
    const Eigen::Vector2d force_B = R.inverse() * force;
    CHECK(mismatch(f_B, Eigen::Vector3d(force_B.x(), force_B.y(), link.inertia * alpha + cross(c, force)), 1e-13) ==
          "");
    CHECK(mismatch(0.5 * V.dot(link_B.M * V),
                   0.5 * link.mass * v_com.squaredNorm() + 0.5 * link.inertia * omega * omega, 1e-13) == "");
    CHECK((link_B.C + link_B.C.transpose()).isZero(0.0));
  }
}

} // namespace newton_euler_test
