#include "catch.h"
#include "decompositions.h"
#include "matchers.h"
#include "methods/torque_solution.h"
#include "states.h"

#include "robot/files/load.h"
#include "robot/files/toml_robot.h"
#include "stance/checks.h"

namespace torque_solution_test
{

using namespace torqued;

namespace
{

constexpr double kTolerance = 1e-3;

Result<TorqueSolution> solve(const Robot& robot, const DesiredState& desired, const MethodSettings& settings = {})
{
  const auto equations = support_equations(robot, desired);
  return solve_torques(robot, std::get<SupportEquations>(equations), desired.support, desired.method, settings,
                       kTolerance);
}

TorqueSolution solution(const Robot& robot, const DesiredState& desired, const MethodSettings& settings = {})
{
  const auto solved = solve(robot, desired, settings);
  if (const Refusal* refusal = std::get_if<Refusal>(&solved))
    FAIL(std::string(refusal->detail()));
  return std::get<TorqueSolution>(solved);
}

// of the torques that solve it
double residual(const Robot& robot, const DesiredState& desired)
{
  const TorqueSolution found = solution(robot, desired);
  return dynamics_residual(robot, std::get<SupportEquations>(support_equations(robot, desired)), found);
}

Eigen::Vector3d vector(const Wrench& wrench)
{
  return {wrench.fx, wrench.fz, wrench.moment};
}

// Γ and the contact forces from the full closed-form system [B Jᵀ] (Γ, w) = D A + H + Q
Eigen::VectorXd closed_form(const oracle::Biped& ck, const oracle::Motion& motion, Side side, Contact contact)
{
  const Eigen::MatrixXd J = ck.J(side, contact, motion.X);
  Eigen::MatrixXd system(9, 6 + J.rows());
  system << ck.B(), J.transpose();
  return oracle::solve(system, ck.D(motion.X) * motion.A + ck.H(motion.X, motion.V) + ck.Q(motion.X));
}

std::pair<Contact, Contact> contacts(Side side, Contact contact)
{
  return side == Side::left ? std::pair(contact, Contact::none) : std::pair(Contact::none, contact);
}

// Turns the trunk's acceleration until the moment about a lone contact point vanishes: the trunk moves no contact.
oracle::Motion balanced_on_point(const oracle::Biped& ck, oracle::Motion motion, Side side, Contact contact)
{
  // the moment about the contact point is linear in the acceleration of one coordinate
  const auto moment = [&](double trunk_acceleration)
  {
    motion.A(6) = trunk_acceleration;
    const oracle::Vector9 r = ck.D(motion.X) * motion.A + ck.H(motion.X, motion.V) + ck.Q(motion.X);
    const Eigen::Vector2d lever = ck.contact_point(side, contact, motion.X) - motion.X.tail<2>();
    return r.head<7>().sum() - (lever.x() * r(8) - lever.y() * r(7));
  };
  const double at_0 = moment(0.0);
  const double at_1 = moment(1.0);
  motion.A(6) = at_0 / (at_0 - at_1);
  return motion;
}

} // namespace

TEST_CASE("single support on a sole gives the torques and the wrench of the closed form", "[torque_solution]")
{
  oracle::Random random(11);
  for (int i = 0; i < 1000; ++i)
  {
    const oracle::Biped ck = oracle::random_ck(random);
    const Robot robot = ck.robot();
    const Side side = i % 2 == 0 ? Side::left : Side::right;
    const auto [left, right] = contacts(side, Contact::sole);
    CAPTURE(i);
    const oracle::Motion motion =
        i % 4 < 2 ? oracle::random_motion(random) : oracle::random_consistent_motion(random, ck, left, right);
    const TorqueSolution found = solution(robot, oracle::desired_state(motion, left, right));
    const Eigen::VectorXd expected = closed_form(ck, motion, side, Contact::sole);
    CHECK(mismatch(found.torque, expected.head(6), 1e-10) == "");
    CHECK(mismatch(vector(found.ground[static_cast<std::size_t>(side)]), expected.tail(3), 1e-10) == "");
    CHECK(mismatch(vector(found.ground[static_cast<std::size_t>(other(side))]), Eigen::Vector3d::Zero(), 0.0) == "");
    CHECK(residual(robot, oracle::desired_state(motion, left, right)) < 1e-10 * (1.0 + expected.cwiseAbs().maxCoeff()));
    CHECK(found.method == Method::none);
  }
}

TEST_CASE("single support on a heel or toe is answered when the motion balances, and refused when it does not",
          "[torque_solution]")
{
  oracle::Random random(12);
  for (int i = 0; i < 400; ++i)
  {
    const oracle::Biped ck = oracle::random_ck(random);
    const Robot robot = ck.robot();
    const Side side = i % 2 == 0 ? Side::left : Side::right;
    const Contact contact = i % 4 < 2 ? Contact::heel : Contact::toe;
    const auto [left, right] = contacts(side, contact);
    CAPTURE(i);
    oracle::Motion motion =
        balanced_on_point(ck, oracle::random_consistent_motion(random, ck, left, right), side, contact);
    const TorqueSolution found = solution(robot, oracle::desired_state(motion, left, right));
    const Eigen::VectorXd expected = closed_form(ck, motion, side, contact);
    CHECK(mismatch(found.torque, expected.head(6), 1e-9) == "");
    const Wrench& wrench = found.ground[static_cast<std::size_t>(side)];
    CHECK(mismatch(Eigen::Vector2d(wrench.fx, wrench.fz), expected.tail(2), 1e-9) == "");
    const Eigen::Vector2d lever = ck.contact_point(side, contact, motion.X) - ck.ankle(side, motion.X);
    CHECK(mismatch(wrench.moment, lever.x() * wrench.fz - lever.y() * wrench.fx, 1e-10) == "");

    motion.A(6) += 5.0; // some 10 N m about the contact point
    const auto refused = solve(robot, oracle::desired_state(motion, left, right));
    REQUIRE(std::holds_alternative<Refusal>(refused));
    CHECK(std::get<Refusal>(refused).reason() == Reason::under_actuated);
  }
}

TEST_CASE("an answered imbalance within tolerance is left in the residual, not smeared over the torques",
          "[torque_solution]")
{
  oracle::Random random(13);
  const oracle::Biped ck;
  const Robot robot = ck.robot();
  oracle::Motion motion = balanced_on_point(
      ck, oracle::random_consistent_motion(random, ck, Contact::toe, Contact::none), Side::left, Contact::toe);
  const TorqueSolution balanced = solution(robot, oracle::desired_state(motion, Contact::toe, Contact::none));
  // the trunk's inertia about the hip turns 0.05 rad/s² into its moment, less than 1e-3 × weight × leg length
  const double I = ck.I3 + ck.m3 * ck.s3 * ck.s3;
  motion.A(6) += 0.05;
  const Eigen::Vector2d extra_force(-ck.m3 * ck.s3 * 0.05 * std::cos(motion.X(6)),
                                    -ck.m3 * ck.s3 * 0.05 * std::sin(motion.X(6)));
  const Eigen::Vector2d lever = ck.contact_point(Side::left, Contact::toe, motion.X) - motion.X.tail<2>();
  const double imbalance = 0.05 * I - (lever.x() * extra_force.y() - lever.y() * extra_force.x());
  const TorqueSolution found = solution(robot, oracle::desired_state(motion, Contact::toe, Contact::none));
  CHECK(mismatch(residual(robot, oracle::desired_state(motion, Contact::toe, Contact::none)), std::abs(imbalance),
                 1e-9) == "");
  // the right leg hangs from the hip: its torques do not feel the trunk
  CHECK(mismatch(found.torque.tail<3>(), balanced.torque.tail<3>(), 1e-10) == "");
}

TEST_CASE("flight is answered when ballistic, and refused when not", "[torque_solution]")
{
  oracle::Random random(14);
  const oracle::Biped ck = oracle::random_ck(random);
  const Robot robot = ck.robot();
  for (int i = 0; i < 100; ++i)
  {
    oracle::Motion motion = oracle::random_motion(random);
    // choose the base's and the trunk's acceleration so that no outside force or moment is needed
    const auto outside = [&](const Eigen::Vector3d& x)
    {
      oracle::Vector9 A = motion.A;
      A.tail<3>() = x;
      const oracle::Vector9 r = ck.D(motion.X) * A + ck.H(motion.X, motion.V) + ck.Q(motion.X);
      return Eigen::Vector3d(r(7), r(8), r.head<7>().sum());
    };
    const Eigen::Vector3d offset = outside(Eigen::Vector3d::Zero());
    Eigen::Matrix3d slope;
    for (int k = 0; k < 3; ++k)
      slope.col(k) = outside(Eigen::Vector3d::Unit(k)) - offset;
    motion.A.tail<3>() = oracle::solve(slope, -offset);

    const TorqueSolution found = solution(robot, oracle::desired_state(motion, Contact::none, Contact::none));
    const oracle::Vector9 r = ck.D(motion.X) * motion.A + ck.H(motion.X, motion.V) + ck.Q(motion.X);
    CHECK(mismatch(ck.B() * found.torque, r, 1e-9) == "");

    motion.A(8) += 1.0;
    const auto refused = solve(robot, oracle::desired_state(motion, Contact::none, Contact::none));
    REQUIRE(std::holds_alternative<Refusal>(refused));
    CHECK(std::get<Refusal>(refused).reason() == Reason::under_actuated);
  }
}

TEST_CASE("the torques' power is the rate of change of the robot's energy while its contacts rest", "[torque_solution]")
{
  oracle::Random random(15);
  const std::pair<Contact, Contact> pairs[] = {{Contact::sole, Contact::none}, {Contact::none, Contact::sole},
                                               {Contact::sole, Contact::heel}, {Contact::toe, Contact::sole},
                                               {Contact::sole, Contact::sole}, {Contact::toe, Contact::heel}};
  for (int i = 0; i < 600; ++i)
  {
    const oracle::Biped ck = oracle::random_ck(random);
    const auto [left, right] = pairs[i % 6];
    CAPTURE(i, name_of(left), name_of(right));
    const oracle::Motion motion = oracle::random_consistent_motion(random, ck, left, right);
    const TorqueSolution found = solution(ck.robot(), oracle::desired_state(motion, left, right, Side::right, 0.3));
    const double power = motion.V.dot(ck.B() * found.torque);
    const double h = 1e-5;
    const auto energy = [&](double t)
    {
      return ck.energy(motion.X + t * motion.V + 0.5 * t * t * motion.A, motion.V + t * motion.A);
    };
    // central difference: error h²/6 × the energy's third derivative (some 10⁶ W/s²), and rounding 1e-13/h of 10³ J
    CHECK(mismatch((energy(h) - energy(-h)) / (2.0 * h), power, 1e-5) == "");
  }
}

TEST_CASE("the base that rests on its contact gives the same torques as the same motion with its base given",
          "[torque_solution]")
{
  oracle::Random random(17);
  const std::pair<Contact, Contact> pairs[] = {{Contact::sole, Contact::none}, {Contact::none, Contact::sole},
                                               {Contact::sole, Contact::heel}, {Contact::toe, Contact::sole},
                                               {Contact::sole, Contact::sole}, {Contact::toe, Contact::heel}};
  for (int i = 0; i < 300; ++i)
  {
    const oracle::Biped ck = oracle::random_ck(random);
    const Robot robot = ck.robot();
    const auto [left, right] = pairs[i % 6];
    CAPTURE(i, name_of(left), name_of(right));
    const Side leading = i % 12 < 6 ? Side::left : Side::right;
    oracle::Motion motion = oracle::random_consistent_motion(random, ck, left, right);

    DesiredState desired = oracle::desired_state(motion, left, right, leading, 0.4);
    desired.base_given = false;
    desired.q.tail<2>().setConstant(NAN);
    desired.v.tail<2>().setConstant(NAN);
    desired.a.tail<2>().setConstant(NAN);
    const auto equations = std::get<SupportEquations>(support_equations(robot, desired));
    CHECK(equations.contact_speed < 1e-10);
    CHECK(equations.contact_residual < 1e-9);

    // where it is put: the resting point at x = 0, the sole or the contact point at z = 0
    const bool both_or_none = (left == Contact::sole) == (right == Contact::sole);
    const Side resting = right == Contact::none  ? Side::left
                         : left == Contact::none ? Side::right
                         : both_or_none          ? other(leading)
                                                 : (left == Contact::sole ? Side::left : Side::right);
    const Contact contact = desired.support.of(resting);
    const Eigen::Vector2d point = equations.foot(resting).point(contact);
    CHECK(mismatch(point, Eigen::Vector2d(0.0, contact == Contact::sole ? ck.h_p : 0.0), 1e-13) == "");

    motion.X.tail<2>() = equations.base();
    const TorqueSolution given = solution(robot, oracle::desired_state(motion, left, right, leading, 0.4));
    CHECK(mismatch(solution(robot, desired).torque, given.torque, 1e-9) == "");
  }
}

TEST_CASE("what a robot or a base cannot do is refused", "[torque_solution]")
{
  oracle::Random random(18);
  const oracle::Biped ck;
  Robot robot = ck.robot();
  const oracle::Motion motion = oracle::random_motion(random);

  DesiredState flight = oracle::desired_state(motion, Contact::none, Contact::none);
  flight.base_given = false;
  const auto no_base = support_equations(robot, flight);
  REQUIRE(std::holds_alternative<Refusal>(no_base));
  CHECK(std::get<Refusal>(no_base).reason() == Reason::not_supported);

  Foot& foot = robot.feet[0];
  foot.heel_at = foot.toe_at = foot.ankle_at;
  const auto no_sole = support_equations(robot, oracle::desired_state(motion, Contact::sole, Contact::none));
  REQUIRE(std::holds_alternative<Refusal>(no_sole));
  CHECK(std::get<Refusal>(no_sole).reason() == Reason::not_supported);
}

TEST_CASE("redundancy follows from the contacts alone", "[torque_solution]")
{
  const auto redundancy = [](Contact left, Contact right)
  {
    return Support{{left, right}, Side::left, 0.0, 0.0}.redundancy();
  };
  const Contact points[] = {Contact::heel, Contact::toe};
  CHECK(redundancy(Contact::none, Contact::none) == 0);
  CHECK(redundancy(Contact::sole, Contact::none) == 0);
  CHECK(redundancy(Contact::none, Contact::sole) == 0);
  CHECK(redundancy(Contact::sole, Contact::sole) == 3);
  for (const Contact point : points)
  {
    CHECK(redundancy(point, Contact::none) == 0);
    CHECK(redundancy(Contact::none, point) == 0);
    CHECK(redundancy(point, Contact::sole) == 2);
    CHECK(redundancy(Contact::sole, point) == 2);
    for (const Contact other_point : points)
      CHECK(redundancy(point, other_point) == 1);
  }
}

TEST_CASE("the mirrored motion needs the mirrored torques and ground reactions", "[torque_solution]")
{
  // the sagittal plane does not know left from right: swapping the legs' data permutes torques without a sign
  oracle::Random random(19);
  const Contact all[] = {Contact::heel, Contact::sole, Contact::toe};
  for (const Contact left : all)
    for (const Contact right : all)
      for (int i = 0; i < 30; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const oracle::Biped ck = oracle::random_ck(random);
        const Robot robot = ck.robot();
        const oracle::Motion motion = oracle::random_consistent_motion(random, ck, left, right);
        const auto mirrored = [](const oracle::Vector9& x)
        {
          oracle::Vector9 y;
          y << x(5), x(4), x(3), x(2), x(1), x(0), x(6), x(7), x(8);
          return y;
        };
        const oracle::Motion mirror{mirrored(motion.X), mirrored(motion.V), mirrored(motion.A)};
        const Side leading = i % 2 == 0 ? Side::left : Side::right;
        const double s = oracle::uniform(random, 0.0, 1.0);
        const TorqueSolution a = solution(robot, oracle::desired_state(motion, left, right, leading, s));
        const TorqueSolution b = solution(robot, oracle::desired_state(mirror, right, left, other(leading), s));
        CHECK(mismatch(b.torque, a.torque.reverse().eval(), 1e-9) == "");
        CHECK(mismatch(vector(b.ground[0]), vector(a.ground[1]), 1e-9) == "");
        CHECK(mismatch(vector(b.ground[1]), vector(a.ground[0]), 1e-9) == "");
      }
}

TEST_CASE("each foot's speed, acceleration and tilt against the ground is seen", "[torque_solution]")
{
  const oracle::Biped ck;
  const Robot robot = ck.robot();
  oracle::Motion still;
  still.X << 0, 0, 0, 0, 0, 0, 0, 0, ck.l1 + ck.l2 + ck.h_p;
  still.V.setZero();
  still.A.setZero();
  const auto equations = [&](const oracle::Motion& motion)
  {
    return std::get<SupportEquations>(
        support_equations(robot, oracle::desired_state(motion, Contact::sole, Contact::sole)));
  };
  CHECK(equations(still).contact_speed == 0.0);
  CHECK(equations(still).contact_residual == 0.0);
  for (const auto& [foot, shin] : {std::pair(0, 1), std::pair(5, 4)})
  {
    CAPTURE(foot);
    oracle::Motion motion = still;
    motion.V(shin) = 0.5; // the ankle swings about the knee
    CHECK(mismatch(equations(motion).contact_speed, 0.5 * ck.l1, 1e-12) == "");
    motion = still;
    motion.V(foot) = 0.7; // the foot turns about its ankle
    CHECK(mismatch(equations(motion).contact_speed, 0.7, 1e-12) == "");
    motion = still;
    motion.A(shin) = 0.3;
    CHECK(mismatch(equations(motion).contact_residual, 0.3 * ck.l1, 1e-12) == "");
    motion = still;
    motion.X(foot) = -0.2;
    CHECK(mismatch(equations(motion).sole_tilt, 0.2, 1e-12) == "");
  }
}

TEST_CASE("a tilted sole that places the base rests on the ground below its ankle", "[torque_solution]")
{
  const oracle::Biped ck;
  const Robot robot = ck.robot();
  oracle::Random random(20);
  for (int i = 0; i < 50; ++i)
  {
    DesiredState desired = oracle::desired_state(oracle::random_motion(random), Contact::sole, Contact::none);
    desired.base_given = false;
    const auto equations = std::get<SupportEquations>(support_equations(robot, desired));
    const FootPose& foot = equations.foot(Side::left);
    // the point of the sole below the ankle divides heel to toe as l_p to l_p1
    const Eigen::Vector2d below = (ck.l_p1 * foot.heel + ck.l_p * foot.toe) / (ck.l_p + ck.l_p1);
    CHECK(mismatch(below.y(), 0.0, 1e-14) == "");
    CHECK(mismatch(foot.ankle.x(), 0.0, 1e-14) == "");
  }
}

TEST_CASE("under-actuated motions are answered up to the tolerance and refused beyond it", "[torque_solution]")
{
  // tolerances: 1e-3 × weight for forces, 1e-3 × weight × leg length for moments
  const oracle::Biped ck;
  const Robot robot = ck.robot();
  const double force = 1e-3 * ck.mass() * ck.gravity;
  const double moment = force * (ck.l1 + ck.l2);
  const auto answered = [&](const DesiredState& desired)
  {
    return std::holds_alternative<TorqueSolution>(solve(robot, desired));
  };

  // in flight: free fall at rest, and then a little beside it
  oracle::Motion falling;
  falling.X.setZero();
  falling.V.setZero();
  falling.A.setZero();
  falling.A(8) = -ck.gravity;
  const auto flight = [&](int coordinate, double acceleration)
  {
    oracle::Motion motion = falling;
    motion.A(coordinate) += acceleration;
    return answered(oracle::desired_state(motion, Contact::none, Contact::none));
  };
  CHECK(flight(7, 0.0));
  // sideways and upward, the whole robot moves: the feet's offset gives a small moment, too
  CHECK(flight(8, 0.99 * force / ck.mass()));
  CHECK_FALSE(flight(8, 1.01 * force / ck.mass()));
  // the trunk alone turns: a moment, and a force that stays below its tolerance
  const double I = ck.I3 + ck.m3 * ck.s3 * ck.s3;
  REQUIRE(moment / I * ck.m3 * ck.s3 > force);
  oracle::Biped centred = ck;
  centred.s3 = 1e-6; // now its turning needs no force
  const Robot centred_robot = centred.robot();
  const auto turning = [&](double acceleration)
  {
    oracle::Motion motion = falling;
    motion.A(6) = acceleration;
    return std::holds_alternative<TorqueSolution>(
        solve(centred_robot, oracle::desired_state(motion, Contact::none, Contact::none)));
  };
  CHECK(turning(0.99 * moment / centred.I3));
  CHECK_FALSE(turning(1.01 * moment / centred.I3));

  // on one toe: balanced, and then a little beside it
  oracle::Random random(27);
  const oracle::Motion balanced =
      balanced_on_point(centred, oracle::random_consistent_motion(random, centred, Contact::toe, Contact::none),
                        Side::left, Contact::toe);
  const auto on_toe = [&](double acceleration)
  {
    oracle::Motion motion = balanced;
    motion.A(6) += acceleration;
    return std::holds_alternative<TorqueSolution>(
        solve(centred_robot, oracle::desired_state(motion, Contact::toe, Contact::none)));
  };
  CHECK(on_toe(0.98 * moment / centred.I3));
  CHECK_FALSE(on_toe(1.02 * moment / centred.I3));
}

TEST_CASE("a foot and an actuator on a link fixed at an angle are those of the link they ride on", "[torque_solution]")
{
  // ck whose left sole is a plate that rides on the foot link, turned by 0.4 rad
  oracle::Random random(28);
  const Robot plain = load_robot("ck");
  std::string text(shipped_robot_toml("ck"));
  const double angle = 0.4;
  const std::string foot = "side = \"left\"\nlink = \"left_foot\"";
  text.replace(text.find(foot), foot.size(), "side = \"left\"\nlink = \"plate\"");
  const std::string against = "against = \"left_foot\"";
  text.replace(text.find(against), against.size(), "against = \"plate\"");
  text += fmt::format(
      "\n[[link]]\nname = \"plate\"\njoint = \"fixed\"\nparent = \"left_foot\"\nat = [0.0, 0.0]\nangle = {}\n"
      "mass = 0.0\ninertia = 0.0\n",
      angle);
  const Robot plated = read_toml_robot(text, "plated.toml");
  CHECK(mismatch(plated.b(0), -angle, 1e-15) == "");
  CHECK(mismatch(plated.A, plain.A, 0.0) == "");

  // the plate is level when its link's angle is −0.4: then both robots stand alike, but for the foot link's own mass
  for (int i = 0; i < 50; ++i)
  {
    oracle::Motion motion = oracle::random_motion(random);
    const auto level = std::get<SupportEquations>(
        support_equations(plain, oracle::desired_state(motion, Contact::sole, Contact::none)));
    motion.X(0) -= angle;
    const auto turned = std::get<SupportEquations>(
        support_equations(plated, oracle::desired_state(motion, Contact::sole, Contact::none)));
    CHECK(mismatch(turned.foot(Side::left).heel, level.foot(Side::left).heel, 1e-13) == "");
    CHECK(mismatch(turned.foot(Side::left).toe, level.foot(Side::left).toe, 1e-13) == "");
    CHECK(mismatch(turned.foot(Side::left).e, level.foot(Side::left).e, 1e-13) == "");
    CHECK(mismatch(turned.sole_tilt, level.sole_tilt, 1e-13) == "");
    const Kinematics &of_turned = turned.now, &of_level = level.now;
    const Support& support = oracle::desired_state(motion, Contact::sole, Contact::none).support;
    CHECK(mismatch(contact_rows(plated, of_turned, support).J, contact_rows(plain, of_level, support).J, 1e-13) == "");
  }
}

TEST_CASE(
    "by a rule that looks at the ground alone motors give what rotors and friction take on top, and it feels none",
    "[torque_solution]")
{
  oracle::Random random(77);
  for (const char* name : {"ck", "rk", "six-link"})
  {
    const Robot ideal = load_robot(name);
    Robot real = ideal;
    make_motors_real(real, random);
    for (int i = 0; i < 200; ++i)
    {
      CAPTURE(name, i);
      const DesiredState desired =
          desired_of(ideal, random_state(random, ideal), {{Contact::sole, Contact::heel}, Side::right, 0.4, 0.0});
      const auto solve = [&](const Robot& robot)
      {
        const auto equations = std::get<SupportEquations>(support_equations(robot, desired));
        const auto solution = std::get<TorqueSolution>(
            solve_torques(robot, equations, desired.support, Method::zmp_transition, {}, 1e-3));
        const double size = std::max(1.0, equations.r.cwiseAbs().maxCoeff());
        CHECK(dynamics_residual(robot, equations, solution) < 1e-11 * size);
        return solution;
      };
      const TorqueSolution with = solve(real), without = solve(ideal);
      CHECK(mismatch(with.w, without.w, 0.0) == "");
      const Eigen::MatrixXd B = input_matrix(real);
      for (int j = 0; j < real.num_joints(); ++j)
      {
        const Actuator& motor = real.actuators[static_cast<std::size_t>(j)];
        const double rate = B.col(j).dot(desired.v), acceleration = B.col(j).dot(desired.a);
        const double slow = rate / motor.stribeck_velocity;
        const double taken = motor.rotor_inertia * acceleration + motor.viscous * rate + motor.friction_offset +
                             (rate > 0.0 ? 1.0 : -1.0) * (motor.coulomb + motor.stribeck * std::exp(-slow * slow));
        const double size = without.torque.cwiseAbs().maxCoeff();
        CHECK(std::abs(with.torque(j) - without.torque(j) - taken) < 1e-12 * std::max(1.0, size));
      }
    }
  }
}

} // namespace torque_solution_test
