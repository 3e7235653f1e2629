#include "catch.h"
#include "matchers.h"
#include "methods/torque_solution.h"
#include "states.h"

#include "robot/files/load.h"

#include <Eigen/Dense>
#include <functional>
#include <numbers>

namespace closed_forms_test
{

using namespace torqued;

namespace
{

// random states of each set of parameters; the first set is that of the robot that ships
constexpr int kSets = 5;
constexpr int kStatesOfSet = kStates / 4;

// Service and closed form sum some 20 terms of like size, each rounded to 1e-16: what cancels is small against the
// largest entry, which is the scale. Random poses lie up to 3 rad from where cosines are exact.
constexpr double kRounding = 1e-12;

Contact any_contact(oracle::Random& random)
{
  return static_cast<Contact>(random() % 4);
}

Eigen::MatrixXd below(const Eigen::MatrixXd& upper, const Eigen::MatrixXd& lower)
{
  Eigen::MatrixXd both(upper.rows() + lower.rows(), upper.cols());
  both << upper, lower;
  return both;
}

// what a closed form says of one state
struct Terms
{
  Eigen::MatrixXd M, C;
  Eigen::VectorXd h, g;
  Eigen::MatrixXd B, J;
  Eigen::VectorXd Jdot_v;

  // in other coordinates, of which the old ones are S times the new ones, but for a constant
  Terms in(const Eigen::MatrixXd& S) const
  {
    return {S.transpose() * M * S,
            S.transpose() * C * S,
            S.transpose() * h,
            S.transpose() * g,
            S.transpose() * B,
            J * S,
            Jdot_v};
  }
};

// a line for every term that differs
std::string differences(const EquationOfMotion& found, const Terms& expected, const Eigen::VectorXd& a)
{
  const auto named = [](const char* name, const std::string& what)
  {
    return what.empty() ? what : fmt::format("{}: {}\n", name, what);
  };
  return named("M", mismatch(found.M, expected.M, kRounding)) + named("C", mismatch(found.C, expected.C, kRounding)) +
         named("h", mismatch(found.h, expected.h, kRounding)) + named("g", mismatch(found.g, expected.g, kRounding)) +
         named("B", mismatch(found.B, expected.B, kRounding)) + named("J", mismatch(found.J, expected.J, kRounding)) +
         named("J̇ v", mismatch(found.Jdot_v, expected.Jdot_v, kRounding)) +
         named("generalized force",
               mismatch(found.generalized_force, expected.M * a + expected.h + expected.g, kRounding));
}

Terms terms(const oracle::Biped& biped, const State& state, const Support& contacts)
{
  const oracle::Vector9 X = state.q;
  const oracle::Vector9 V = state.v;
  const Contact left = contacts.of(Side::left);
  const Contact right = contacts.of(Side::right);
  return {biped.D(X),
          biped.C(X, V),
          biped.H(X, V),
          biped.Q(X),
          biped.B(),
          below(biped.J(Side::left, left, X), biped.J(Side::right, right, X)),
          below(biped.Jdot_V(Side::left, left, X, V), biped.Jdot_V(Side::right, right, X, V))};
}

void check_biped(const oracle::Biped& biped, const Robot& robot, oracle::Random& random)
{
  const oracle::Matrix9 S = oracle::Biped::from_joint_angles();
  for (int i = 0; i < kStatesOfSet; ++i)
  {
    CAPTURE(i);
    const State state = random_state(random, robot);
    const Support contacts = support(robot, any_contact(random), any_contact(random));
    const Motion motion = motion_of(robot, state, contacts);
    const Terms expected = terms(biped, state, contacts);
    CHECK(differences(equation_of_motion(robot, motion, contacts, Coordinates::absolute), expected, state.a) == "");
    CHECK(differences(equation_of_motion(robot, motion, contacts, Coordinates::relative), expected.in(S),
                      S.inverse() * state.a) == "");
  }
}

} // namespace

TEST_CASE("ck and rk move as their closed forms say, in both kinds of coordinates", "[closed_forms]")
{
  oracle::Random random(101);
  check_biped(oracle::Biped{}, load_robot("ck"), random);
  check_biped(oracle::shipped_rk(), load_robot("rk"), random);
  for (int set = 1; set < kSets; ++set)
  {
    CAPTURE(set);
    const oracle::Biped ck = oracle::random_ck(random);
    check_biped(ck, ck.robot(), random);
    const oracle::Biped rk = oracle::random_rk(random, static_cast<Placement>(set % 3));
    check_biped(rk, rk.robot(), random);
  }
}

TEST_CASE("the closed forms of H and of the energy belong to that of D", "[closed_forms]")
{
  oracle::Random random(102);
  for (int i = 0; i < kStates; ++i)
  {
    CAPTURE(i);
    const oracle::Biped biped = i % 2 == 0 ? oracle::random_ck(random) : oracle::random_rk(random);
    const auto [X, V, A] = oracle::random_motion(random);
    CHECK(mismatch(biped.H(X, V), biped.C(X, V) * V, kRounding) == "");
    const auto potential = [&, X = X, V = V](double t)
    {
      return biped.energy(X + t * V, oracle::Vector9::Zero());
    };
    CHECK(mismatch(biped.energy(X, V) - potential(0.0), 0.5 * V.dot(biped.D(X) * V), kRounding) == "");
    // energies of some hundred J, rounded to 1e-13 J, by h
    CHECK(mismatch(oracle::slope(potential, 5e-3), biped.Q(X).dot(V), 1e-10) == "");
  }
}

TEST_CASE("rolling knees become pin knees as their circles shrink", "[closed_forms]")
{
  oracle::Random random(103);
  for (const double radius : {1e-3, 1e-5, 1e-7, 1e-9})
    for (int i = 0; i < kStatesOfSet; ++i)
    {
      CAPTURE(radius, i);
      const oracle::Biped pin = oracle::random_ck(random);
      oracle::Biped rolling = pin;
      rolling.r1 = radius;
      rolling.r2 = 0.7 * radius;
      const Robot robot = rolling.robot();
      const State state = random_state(random, robot);
      const Support contacts = support(robot, any_contact(random), any_contact(random));
      const Motion motion = motion_of(robot, state, contacts);
      const EquationOfMotion found = equation_of_motion(robot, motion, contacts, Coordinates::absolute);
      const Terms expected = terms(pin, state, contacts);
      // Everything is smooth in the radii; a mass on a leg of 0.4 m moves by less than 2 (r1 + r2), which changes its
      // share of an inertia by less than 4 (r1 + r2) / 0.4. Rates of the bar count twice in forces.
      const double allowed = 40.0 * radius + kRounding;
      CHECK(mismatch(found.M, expected.M, allowed) == "");
      CHECK(mismatch(found.C, expected.C, allowed) == "");
      CHECK(mismatch(found.h, expected.h, allowed) == "");
      CHECK(mismatch(found.g, expected.g, allowed) == "");
      CHECK(mismatch(found.J, expected.J, allowed) == "");
      CHECK(mismatch(found.Jdot_v, expected.Jdot_v, 4.0 * allowed) == "");
      CHECK(mismatch(found.B, expected.B, 0.0) == "");
    }
}

TEST_CASE("where a rolling knee's motor stands changes its torque, not what it does", "[closed_forms]")
{
  oracle::Random random(104);
  for (int i = 0; i < kStates; ++i)
  {
    CAPTURE(i);
    oracle::Biped biped = oracle::random_rk(random, Placement::links);
    const Robot direct = biped.robot();
    VectorJ torque(6);
    for (int j = 0; j < 6; ++j)
      torque(j) = oracle::uniform(random, -100.0, 100.0);
    const State state = random_state(random, direct);
    const VectorQ v = state.v.head(7);
    const VectorQ force = joint_forces(direct, torque);
    const double power = joint_rates(direct, v).dot(torque);

    const double r1 = biped.r1;
    const double r2 = biped.r2;
    const std::pair<Placement, double> placements[] = {
        {Placement::links, 1.0}, {Placement::bar_parent, r1 / (r1 + r2)}, {Placement::bar_child, r2 / (r1 + r2)}};
    for (const auto& [placement, kappa] : placements)
    {
      CAPTURE(name_of(placement));
      biped.knee = placement;
      const Robot robot = biped.robot();
      VectorJ expected = torque;
      expected(1) /= kappa;
      expected(4) /= kappa;
      const VectorJ found = joint_torques(robot, force);
      CHECK(mismatch(found, expected, kRounding) == "");
      CHECK(mismatch(joint_forces(robot, found), force, kRounding) == "");
      CHECK(mismatch(joint_rates(robot, v).dot(found), power, kRounding) == "");
      const auto B = input_matrix(robot);
      CHECK(mismatch(B, biped.B(), kRounding) == "");
      CHECK(mismatch(B(2, 1), kappa, kRounding) == "");
      CHECK(mismatch(B(1, 1), -kappa, kRounding) == "");
      CHECK(mismatch(B(3, 4), kappa, kRounding) == "");
      CHECK(mismatch(B(4, 4), -kappa, kRounding) == "");
    }
  }
}

TEST_CASE("the six-link biped moves as the reduction of ck and rk, on either foot", "[closed_forms]")
{
  oracle::Random random(105);
  const auto check = [&](const oracle::SixLink& six, const Robot& robot)
  {
    REQUIRE(robot.num_coordinates() == 6);
    oracle::SixLink direct = six;
    direct.biped.knee = Placement::links;
    const oracle::Matrix6 to_absolute = direct.A().transpose().inverse(); // the actuators' angles are Aᵀ q, less κ
    for (int i = 0; i < kStatesOfSet; ++i)
    {
      CAPTURE(i, name_of(six.stance));
      const State state = random_state(random, robot);
      const Contact swing = any_contact(random);
      const Support contacts = support(robot, swing, swing);
      const Motion motion = motion_of(robot, state, contacts);
      const oracle::Vector6 q = state.q;
      const oracle::Vector6 v = state.v;
      const oracle::Vector6 a = state.a;
      // Γ from left to right, τ from the stance foot up
      Eigen::MatrixXd B = six.biped.B();
      if (six.stance == Side::right)
        B.rowwise().reverseInPlace();
      CHECK(mismatch(six.F(q).transpose() * B, six.A(), 0.0) == "");
      const Terms expected{six.M(q), six.C(q, v),     six.C(q, v) * v,        six.g(q),
                           six.A(),  six.J(swing, q), six.Jdot_v(swing, q, v)};
      CHECK(differences(equation_of_motion(robot, motion, contacts, Coordinates::absolute), expected, a) == "");
      CHECK(differences(equation_of_motion(robot, motion, contacts, Coordinates::relative), expected.in(to_absolute),
                        to_absolute.inverse() * a) == "");

      // alone on its foot: the ankle's torque, and so what the ground gives
      DesiredState desired{};
      desired.support = support(robot, Contact::none, Contact::none);
      desired.q = of_mechanism(robot, q);
      desired.v = of_mechanism(robot, v);
      desired.a = of_mechanism(robot, a);
      const auto equations = support_equations(robot, desired);
      const auto solved = solve_torques(robot, std::get<SupportEquations>(equations), desired.support, Method::none,
                                        MethodSettings{}, 1e-3);
      REQUIRE(std::holds_alternative<TorqueSolution>(solved));
      const auto& solution = std::get<TorqueSolution>(solved);
      const oracle::Vector6 torque = six.A().inverse() * (six.M(q) * a + six.C(q, v) * v + six.g(q));
      CHECK(mismatch(solution.torque, torque, kRounding) == "");
      const Wrench& found = solution.ground[static_cast<std::size_t>(six.stance)];
      const Eigen::Vector3d ground = six.ground(q, v, a) + Eigen::Vector3d(0.0, 0.0, torque(0));
      CHECK(mismatch(Eigen::Vector3d(found.fx, found.fz, found.moment), ground, kRounding) == "");
    }
  };
  check({oracle::Biped{}, Side::left}, load_robot("six-link"));
  for (int set = 1; set < kSets; ++set)
    for (const Side stance : kSides)
    {
      CAPTURE(set);
      const oracle::SixLink ck{oracle::random_ck(random), stance};
      check(ck, ck.robot());
      const oracle::SixLink rk{oracle::random_rk(random, static_cast<Placement>(set % 3)), stance};
      check(rk, rk.robot());
    }
}

namespace
{

// a robot of section 4 or 5 of [De-León-Gómez 2017]: printed in both kinds of coordinates, q = A θ + b
template <typename Oracle> void check_both_coordinates(const Oracle& oracle, const Robot& robot, oracle::Random& random)
{
  const auto A = Oracle::A();
  const Eigen::Index n = A.rows();
  using Vector = Eigen::Matrix<double, decltype(A)::RowsAtCompileTime, 1>;
  CHECK(mismatch(robot.A.topLeftCorner(n, n), A, 0.0) == "");
  CHECK(mismatch(robot.b.head(n), Oracle::offset(), 1e-15) == "");
  for (int i = 0; i < kStatesOfSet; ++i)
  {
    CAPTURE(i);
    const State state = random_state(random, robot);
    const Support contacts = support(robot, Contact::none, Contact::none);
    const Motion motion = motion_of(robot, state, contacts);
    const Eigen::MatrixXd none(0, n);
    const Eigen::VectorXd nothing(0);

    const Vector theta = state.q;
    const Vector thetadot = state.v;
    const Terms absolute{oracle.M_bar(theta),
                         oracle.C_bar(theta, thetadot),
                         oracle.C_bar(theta, thetadot) * thetadot,
                         oracle.g_bar(theta),
                         A.transpose(),
                         none,
                         nothing};
    CHECK(differences(equation_of_motion(robot, motion, contacts, Coordinates::absolute), absolute, state.a) == "");

    const Vector q = A * theta + Oracle::offset();
    const Vector v = A * thetadot;
    const Terms relative{oracle.M(q), oracle.C(q, v), oracle.C(q, v) * v, oracle.g(q), Eigen::MatrixXd::Identity(n, n),
                         none,        nothing};
    CHECK(differences(equation_of_motion(robot, motion, contacts, Coordinates::relative), relative, A * state.a) == "");

    // the theorem, between what is printed for each
    CHECK(mismatch(absolute.M, A.transpose() * relative.M * A, kRounding) == "");
    CHECK(mismatch(absolute.C, A.transpose() * relative.C * A, kRounding) == "");
    CHECK(mismatch(absolute.g, A.transpose() * relative.g, kRounding) == "");
  }
}

} // namespace

TEST_CASE("the compass moves as its closed form says, in both kinds of coordinates", "[closed_forms]")
{
  oracle::Random random(106);
  check_both_coordinates(oracle::Compass{}, load_robot("compass"), random);
  for (int set = 1; set < kSets; ++set)
  {
    CAPTURE(set);
    const oracle::Compass compass = oracle::random_compass(random);
    check_both_coordinates(compass, compass.robot(), random);
  }
}

TEST_CASE("Bip-ITLag moves as its closed form says, in both kinds of coordinates", "[closed_forms]")
{
  oracle::Random random(107);
  check_both_coordinates(oracle::Itlag{}, load_robot("bip-itlag"), random);
  for (int set = 1; set < kSets; ++set)
  {
    CAPTURE(set);
    const oracle::Itlag itlag = oracle::random_itlag(random);
    check_both_coordinates(itlag, itlag.robot(), random);
  }
}

namespace
{

// (τ1, τ2) of the compass, or (τ̄1, τ̄2)
Eigen::Vector2d compass_torques(const Robot& compass, const State& state, Coordinates coordinates)
{
  const Support contacts = support(compass, Contact::none, Contact::none);
  return equation_of_motion(compass, motion_of(compass, state, contacts), contacts, coordinates).generalized_force;
}

struct Peak
{
  double at, value;
};

// The largest value on [from, to]: of a fine grid, then by golden section around it.
Peak largest(const std::function<double(double)>& f, double from, double to)
{
  constexpr int kSteps = 600;
  const double step = (to - from) / kSteps;
  double best = from;
  for (int i = 0; i <= kSteps; ++i)
    if (f(from + i * step) > f(best))
      best = from + i * step;
  double low = std::max(from, best - step);
  double high = std::min(to, best + step);
  const double ratio = 1.0 / std::numbers::phi;
  while (high - low > 1e-7)
  {
    const double left = high - ratio * (high - low);
    const double right = low + ratio * (high - low);
    if (f(left) < f(right))
      low = left;
    else
      high = right;
  }
  return {0.5 * (low + high), f(0.5 * (low + high))};
}

// A sin(2π t / 6), its rate and acceleration
Eigen::Vector3d sway(double amplitude, double t)
{
  const double w = 2.0 * std::numbers::pi / 6.0;
  return amplitude * Eigen::Vector3d(std::sin(w * t), w * std::cos(w * t), -w * w * std::sin(w * t));
}

} // namespace

TEST_CASE("the compass needs the torques that are printed for it", "[closed_forms]")
{
  // [De-León-Gómez 2017, section 4] prints truncated decimals: 145.9175, 121.3925, 24.525; 144.46; 152.73 and 135.38.
  // Here is what they come from, to a unit of its last digit.
  const Robot compass = load_robot("compass");
  const double digit = 1e-6;
  const double pi = std::numbers::pi;
  using Catch::Matchers::WithinAbs;

  SECTION("at rest")
  {
    const State state{Eigen::Vector2d(-pi / 4.0, pi / 2.0), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
    const Eigen::Vector2d relative = compass_torques(compass, state, Coordinates::relative);
    const Eigen::Vector2d absolute = compass_torques(compass, state, Coordinates::absolute);
    CHECK_THAT(relative(0), WithinAbs(145.917557, digit));
    CHECK_THAT(relative(1), WithinAbs(24.525, digit));
    CHECK_THAT(absolute(0), WithinAbs(121.392557, digit));
    CHECK_THAT(absolute(1), WithinAbs(24.525, digit));
  }

  SECTION("the swing leg sways about the stance leg's normal")
  {
    const auto torque = [&](double t, Coordinates coordinates)
    {
      // q1 = π/4, q2 = −π/2 + sway; θ_s = q1 − π/2, θ_ns = θ_s + q2 + π
      const Eigen::Vector3d swing = sway(pi / 4.0, t);
      const State state{Eigen::Vector2d(-pi / 4.0, pi / 4.0 + swing(0)), Eigen::Vector2d(0.0, swing(1)),
                        Eigen::Vector2d(0.0, swing(2))};
      return compass_torques(compass, state, coordinates)(0);
    };
    // and again as much later than 1.5 s as this is earlier
    const Peak relative = largest([&](double t) { return torque(t, Coordinates::relative); }, 0.0, 1.5);
    CHECK_THAT(relative.value, WithinAbs(144.465825, digit));
    CHECK_THAT(relative.at, WithinAbs(0.66562, 1e-5));
    const Peak absolute = largest([&](double t) { return torque(t, Coordinates::absolute); }, 0.0, 6.0);
    CHECK_THAT(absolute.value, WithinAbs(123.083687, digit));
  }

  SECTION("the stance leg sways")
  {
    for (const double sign : {1.0, -1.0})
    {
      CAPTURE(sign);
      const auto torque = [&](double t, Coordinates coordinates)
      {
        const Eigen::Vector3d stance = sway(sign * pi / 4.0, t);
        const State state{Eigen::Vector2d(stance(0), pi / 4.0), Eigen::Vector2d(stance(1), 0.0),
                          Eigen::Vector2d(stance(2), 0.0)};
        return compass_torques(compass, state, coordinates)(0);
      };
      const double when = sign > 0.0 ? 4.5 : 1.5; // θ_s = −π/4
      const Peak relative = largest([&](double t) { return torque(t, Coordinates::relative); }, 0.0, 6.0);
      CHECK_THAT(relative.value, WithinAbs(152.730239, digit));
      CHECK_THAT(relative.at, WithinAbs(when, 1e-5));
      const Peak absolute = largest([&](double t) { return torque(t, Coordinates::absolute); }, 0.0, 6.0);
      CHECK_THAT(absolute.value, WithinAbs(135.388445, digit));
      CHECK_THAT(absolute.at, WithinAbs(when, 1e-5));
    }
  }
}

} // namespace closed_forms_test
