#include "catch.h"
#include "matchers.h"
#include "oracles.h"

#include "torque/checks.h"

#include <Eigen/Dense>

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

Eigen::Vector3d vector(const Wrench& wrench)
{
  return {wrench.fx, wrench.fz, wrench.moment};
}

// Γ and the contact forces from the full closed-form system [B Jᵀ] (Γ, w) = D A + H + Q
Eigen::VectorXd closed_form(const oracle::Ck& ck, const oracle::Motion& motion, Side side, Contact contact)
{
  const Eigen::MatrixXd J = ck.J(side, contact, motion.X);
  Eigen::MatrixXd system(9, 6 + J.rows());
  system << oracle::Ck::B(), J.transpose();
  return system.colPivHouseholderQr().solve(ck.D(motion.X) * motion.A + ck.H(motion.X, motion.V) + ck.Q(motion.X));
}

std::pair<Contact, Contact> contacts(Side side, Contact contact)
{
  return side == Side::left ? std::pair(contact, Contact::none) : std::pair(Contact::none, contact);
}

// Turns the trunk's acceleration until the moment about a lone contact point vanishes: the trunk moves no contact.
oracle::Motion balanced_on_point(const oracle::Ck& ck, oracle::Motion motion, Side side, Contact contact)
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

TEST_CASE("single support on a sole gives the torques and the wrench of the closed form", "[torque_method]")
{
  oracle::Random random(11);
  for (int i = 0; i < 1000; ++i)
  {
    const oracle::Ck ck = oracle::random_ck(random);
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
    CHECK(found.residual < 1e-10 * (1.0 + expected.cwiseAbs().maxCoeff()));
    CHECK(found.method == Method::none);
  }
}

TEST_CASE("single support on a heel or toe is answered when the motion balances, and refused when it does not",
          "[torque_method]")
{
  oracle::Random random(12);
  for (int i = 0; i < 400; ++i)
  {
    const oracle::Ck ck = oracle::random_ck(random);
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
          "[torque_method]")
{
  oracle::Random random(13);
  const oracle::Ck ck;
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
  CHECK(mismatch(found.residual, std::abs(imbalance), 1e-9) == "");
  // the right leg hangs from the hip: its torques do not feel the trunk
  CHECK(mismatch(found.torque.tail<3>(), balanced.torque.tail<3>(), 1e-10) == "");
}

TEST_CASE("flight is answered when ballistic, and refused when not", "[torque_method]")
{
  oracle::Random random(14);
  const oracle::Ck ck = oracle::random_ck(random);
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
    motion.A.tail<3>() = slope.partialPivLu().solve(-offset);

    const TorqueSolution found = solution(robot, oracle::desired_state(motion, Contact::none, Contact::none));
    const oracle::Vector9 r = ck.D(motion.X) * motion.A + ck.H(motion.X, motion.V) + ck.Q(motion.X);
    CHECK(mismatch(oracle::Ck::B() * found.torque, r, 1e-9) == "");

    motion.A(8) += 1.0;
    const auto refused = solve(robot, oracle::desired_state(motion, Contact::none, Contact::none));
    REQUIRE(std::holds_alternative<Refusal>(refused));
    CHECK(std::get<Refusal>(refused).reason() == Reason::under_actuated);
  }
}

TEST_CASE("the torques' power is the rate of change of the robot's energy while its contacts rest", "[torque_method]")
{
  oracle::Random random(15);
  const std::pair<Contact, Contact> pairs[] = {{Contact::sole, Contact::none}, {Contact::none, Contact::sole},
                                               {Contact::sole, Contact::heel}, {Contact::toe, Contact::sole},
                                               {Contact::sole, Contact::sole}, {Contact::toe, Contact::heel}};
  for (int i = 0; i < 600; ++i)
  {
    const oracle::Ck ck = oracle::random_ck(random);
    const auto [left, right] = pairs[i % 6];
    CAPTURE(i, name_of(left), name_of(right));
    const oracle::Motion motion = oracle::random_consistent_motion(random, ck, left, right);
    const TorqueSolution found = solution(ck.robot(), oracle::desired_state(motion, left, right, Side::right, 0.3));
    const double power = motion.V.dot(oracle::Ck::B() * found.torque);
    const double h = 1e-5;
    const auto energy = [&](double t)
    {
      return ck.energy(motion.X + t * motion.V + 0.5 * t * t * motion.A, motion.V + t * motion.A);
    };
    // central difference: error h²/6 × the energy's third derivative (some 10⁶ W/s²), and rounding 1e-13/h of 10³ J
    CHECK(mismatch((energy(h) - energy(-h)) / (2.0 * h), power, 1e-5) == "");
  }
}

TEST_CASE("in every support the equation of motion holds and the total ground wrench does not depend on the method",
          "[torque_method]")
{
  oracle::Random random(16);
  const Contact all[] = {Contact::heel, Contact::sole, Contact::toe};
  for (const Contact left : all)
    for (const Contact right : all)
      for (int i = 0; i < 50; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const oracle::Ck ck = oracle::random_ck(random);
        const Robot robot = ck.robot();
        const oracle::Motion motion = oracle::random_consistent_motion(random, ck, left, right);
        MethodSettings settings;
        if (i % 2 == 1)
          settings.linear_transition.leading_cop = 0.4;
        const DesiredState desired = oracle::desired_state(motion, left, right, i % 4 < 2 ? Side::left : Side::right,
                                                           oracle::uniform(random, 0.0, 1.0));
        const TorqueSolution found = solution(robot, desired, settings);
        CHECK(found.method == Method::linear_transition);

        // D A + H + Q = B Γ + J_Lᵀ w_L + J_Rᵀ w_R, the wrenches at the ankles
        const oracle::Vector9 r = ck.D(motion.X) * motion.A + ck.H(motion.X, motion.V) + ck.Q(motion.X);
        oracle::Vector9 sum = oracle::Ck::B() * found.torque;
        for (const Side side : kSides)
          sum += ck.J(side, Contact::sole, motion.X).transpose() * vector(found.ground[static_cast<std::size_t>(side)]);
        const double forces = std::max(std::abs(found.ground[0].fz), std::abs(found.ground[1].fz));
        CHECK(mismatch(sum, r, 1e-11 * (1.0 + forces / r.cwiseAbs().maxCoeff())) == "");
      }
}

TEST_CASE("the base that rests on its contact gives the same torques as the same motion with its base given",
          "[torque_method]")
{
  oracle::Random random(17);
  const std::pair<Contact, Contact> pairs[] = {{Contact::sole, Contact::none}, {Contact::none, Contact::sole},
                                               {Contact::sole, Contact::heel}, {Contact::toe, Contact::sole},
                                               {Contact::sole, Contact::sole}, {Contact::toe, Contact::heel}};
  for (int i = 0; i < 300; ++i)
  {
    const oracle::Ck ck = oracle::random_ck(random);
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

    motion.X.tail<2>() = equations.base;
    const TorqueSolution given = solution(robot, oracle::desired_state(motion, left, right, leading, 0.4));
    CHECK(mismatch(solution(robot, desired).torque, given.torque, 1e-9) == "");
  }
}

TEST_CASE("what a robot or a base cannot do is refused", "[torque_method]")
{
  oracle::Random random(18);
  const oracle::Ck ck;
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

TEST_CASE("redundancy follows from the contacts alone", "[torque_method]")
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
