#include "catch.h"
#include "double_support.h"
#include "matchers.h"
#include "states.h"
#include "udwadia_kalaba.h"

#include "questions/elimination.h"
#include "questions/regressor.h"
#include "robot/files/load.h"

#include <functional>

namespace elimination_test
{

using namespace torqued;

namespace
{

using Eigen::MatrixXd;
using Eigen::VectorXd;
using oracle::Vector9;

constexpr Contact kContacts[] = {Contact::none, Contact::heel, Contact::sole, Contact::toe};
constexpr Coordinates kBoth[] = {Coordinates::absolute, Coordinates::relative};

MatrixXd identity(Eigen::Index size)
{
  return MatrixXd::Identity(size, size);
}

// v in the coordinates of EquationOfMotion
VectorXd in(Coordinates coordinates, const Robot& robot, const VectorXd& v)
{
  VectorXd result = v;
  const int n = robot.num_coordinates();
  if (coordinates == Coordinates::relative)
    result.head(n) = robot.A.topLeftCorner(n, n) * v.head(n);
  return result;
}

// a robot with a floating root, at some pose and at rates that keep its contacts
struct Moving
{
  Robot robot;
  Support contacts;
  Coordinates coordinates;
  VectorXd q, v_absolute, v;
  EquationOfMotion equation;
  double condition; // of J: by so much is rounding magnified

  Moving(const Robot& of, const Support& on, Coordinates in_these, const VectorXd& pose, const VectorXd& near)
      : robot(of), contacts(on), coordinates(in_these), q(pose), v_absolute(near)
  {
    const MatrixXd J = contact_rows(robot, kinematics(robot.mechanism, q, near), contacts).J;
    if (J.rows() > 0)
      for (int twice = 0; twice < 2; ++twice)
        v_absolute -= oracle::solve(J, J * v_absolute);
    v = in(coordinates, robot, v_absolute);
    equation = after(0.0);
    condition = 1.0;
    if (equation.J.rows() > 0)
    {
      const VectorXd sigma = oracle::singular_values(equation.J);
      condition = sigma(0) / sigma(sigma.size() - 1);
    }
  }

  // on the straight line through the pose
  EquationOfMotion after(double t) const
  {
    const VectorQ moved = q + t * v_absolute;
    return equation_of_motion(robot,
                              {kinematics(robot.mechanism, moved, v_absolute), v_absolute, VectorQ::Zero(q.size())},
                              contacts, coordinates);
  }
  // derivative of what the pose determines: of F, too, whose frequencies are those of the rates times the condition
  template <typename F> MatrixXd rate(const F& of_pose) const
  {
    const double h = 0.02 / (condition * v.cwiseAbs().maxCoeff());
    return oracle::slope([&](double t) { return MatrixXd(of_pose(after(t))); }, h);
  }

  Elimination eliminated(EliminationMethod method) const
  {
    const auto result = eliminate(equation.J, equation.Jdot, method);
    if (const Refusal* refusal = std::get_if<Refusal>(&result))
      FAIL(std::string(refusal->detail()));
    return std::get<Elimination>(result);
  }
};

Support on(Contact left, Contact right)
{
  return {{left, right}, Side::left, 0.0, 0.0};
}

// some random bipeds on each pair of contacts, in both kinds of coordinates
void for_all(int cases, const std::function<void(const Moving&, oracle::Random&)>& check)
{
  for (const Contact left : kContacts)
    for (const Contact right : kContacts)
      for (int i = 0; i < cases && (left != Contact::none || right != Contact::none); ++i)
      {
        oracle::Random random(static_cast<unsigned>(1000 * i) + 10 * static_cast<unsigned>(left) +
                              static_cast<unsigned>(right));
        const oracle::Biped biped = random_biped(random, i);
        const Robot robot = biped.robot();
        const oracle::Motion motion = oracle::random_motion(random);
        for (const Coordinates coordinates : kBoth)
        {
          CAPTURE(name_of(left), name_of(right), i, static_cast<int>(coordinates));
          check(Moving(robot, on(left, right), coordinates, motion.X, motion.V), random);
        }
      }
}

// all that must hold of F, F̄ and Ḟ at one instant
void check_elimination(const Moving& now, EliminationMethod method)
{
  const Elimination found = now.eliminated(method);
  const MatrixXd J = now.equation.J, Jdot = now.equation.Jdot, F = found.F, Fdot = found.Fdot, F_bar = found.F_bar;
  const MatrixXd J_plus = J.rows() > 0 ? oracle::pseudo_inverse(J) : MatrixXd(J.cols(), 0);
  const Eigen::Index n = J.cols(), n_c = J.rows();
  REQUIRE(F.cols() == n - n_c);
  // of numbers up to 3, in sums of ten, through a solution that magnifies by the condition of J
  const double rounding = 2e-14 * now.condition;
  CHECK(mismatch(J * F, MatrixXd::Zero(n_c, n - n_c), rounding) == "");
  CHECK(mismatch(J * F_bar, identity(n_c), rounding) == "");
  CHECK(mismatch(F * oracle::pseudo_inverse(F), identity(n) - J_plus * J, rounding) == "");
  // Jdot grows with the rates
  const double moving = rounding * now.condition * std::max(1.0, Jdot.size() > 0 ? Jdot.cwiseAbs().maxCoeff() : 0.0);
  CHECK(mismatch(Jdot * F + J * Fdot, MatrixXd::Zero(n_c, n - n_c), moving) == "");
  if (method == EliminationMethod::partitioning)
  {
    REQUIRE(found.independent.size() == n - n_c);
    CHECK(std::is_sorted(found.independent.begin(), found.independent.end()));
    for (Eigen::Index i = 0; i < n - n_c; ++i)
    {
      CHECK(F.row(found.independent(i)) == identity(n - n_c).row(i));
      CHECK(Fdot.row(found.independent(i)).isZero(0.0));
      CHECK(F_bar.row(found.independent(i)).isZero(0.0));
    }
  }
  else
  {
    CHECK(found.independent.size() == 0);
    CHECK(mismatch(F.transpose() * F, identity(n - n_c), 1e-14) == "");
    CHECK(mismatch(F_bar, J_plus, rounding * now.condition) == "");
    CHECK(mismatch(F.transpose() * Fdot, MatrixXd::Zero(n - n_c, n - n_c), moving) == "");
  }
}

// the accelerations and multipliers of some torques: reduced, of the whole system, and Udwadia and Kalaba's
void check_answers(const Moving& now, const VectorXd& torque)
{
  const EquationOfMotion& equation = now.equation;
  const Eigen::Index n = equation.n, n_c = equation.J.rows();
  MatrixXd whole = MatrixXd::Zero(n + n_c, n + n_c);
  whole << equation.M, -equation.J.transpose(), equation.J, MatrixXd::Zero(n_c, n_c);
  VectorXd right(n + n_c);
  right << equation.B * torque - equation.h - equation.g, -equation.Jdot_v;
  const VectorXd both = oracle::solve(whole, right);
  const VectorXd a = both.head(n), lambda = both.tail(n_c);
  // the conditions of J and, some 1e4, of M; the reduced rates are rounded like v
  const double rounding = 1e-11 * now.condition * now.condition;
  CHECK(mismatch(udwadia_kalaba(equation, torque), a, rounding) == "");
  for (const auto& [method, name] : kEliminations)
  {
    CAPTURE(name);
    const Elimination found = now.eliminated(method);
    const ReducedForm reduced = reduced_form(equation, found);
    const VectorXd zdot = oracle::pseudo_inverse(found.F) * now.v;
    CHECK(mismatch(found.F * zdot, now.v, 1e-13 * now.condition) == "");
    const VectorXd zddot =
        oracle::solve(reduced.mass, reduced.input * torque - reduced.gravity - reduced.coriolis * zdot);
    const VectorXd found_a = found.F * zddot + found.Fdot * zdot;
    CHECK(mismatch(found_a, a, rounding) == "");
    EquationOfMotion moving = equation;
    moving.generalized_force = equation.M * found_a + equation.h + equation.g;
    CHECK(mismatch(multipliers(moving, found, torque), lambda, rounding) == "");
  }
}

VectorXd random_torque(const Robot& robot, oracle::Random& random)
{
  return VectorXd::NullaryExpr(robot.num_joints(),
                               [&](Eigen::Index) { return oracle::uniform(random, -100.0, 100.0); });
}

} // namespace

TEST_CASE("J̇ is the derivative of J, and J̇ v what it does to v", "[elimination]")
{
  for_all(kCases / 4,
          [](const Moving& now, oracle::Random&)
          {
            const EquationOfMotion& equation = now.equation;
            CHECK(mismatch(equation.Jdot * now.v, equation.Jdot_v, 1e-12) == "");
            CHECK(mismatch(equation.Jdot, now.rate([](const EquationOfMotion& at) { return at.J; }),
                           1e-11 * now.condition) == "");
          });
}

TEST_CASE("F spans what the contacts leave free, by every method the same", "[elimination][slow]")
{
  for_all(2 * kCases, // as many of ck as of rk
          [](const Moving& now, oracle::Random&)
          {
            for (const auto& [method, name] : kEliminations)
            {
              CAPTURE(name, now.condition);
              check_elimination(now, method);
            }
          });
}

TEST_CASE("Ḟ is the derivative of an F that goes on smoothly", "[elimination][slow]")
{
  for_all(kCases / 10,
          [](const Moving& now, oracle::Random&)
          {
            for (const auto& [method, name] : kEliminations)
            {
              CAPTURE(name, now.condition);
              const Elimination found = now.eliminated(method);
              // the same coordinates; the same columns, projected on what is free next
              const auto next = [&, method = method](const EquationOfMotion& at) -> MatrixXd
              {
                if (method != EliminationMethod::partitioning)
                  return found.F - oracle::pseudo_inverse(at.J) * (at.J * found.F);
                MatrixXd both = MatrixXd::Zero(at.n, at.n);
                both.topRows(at.J.rows()) = at.J;
                for (Eigen::Index i = 0; i < found.independent.size(); ++i)
                  both(at.J.rows() + i, found.independent(i)) = 1.0;
                return oracle::pseudo_inverse(both).rightCols(found.F.cols());
              };
              CHECK(mismatch(found.Fdot, now.rate(next), 1e-11 * now.condition * now.condition) == "");
            }
          });
}

TEST_CASE("the reduced mass is positive definite; its rate less twice the reduced C is skew", "[elimination][slow]")
{
  double printed = 0.0;
  for_all(kCases,
          [&](const Moving& now, oracle::Random&)
          {
            // M from poses around, so that C is not tested against itself
            const MatrixXd Mdot = now.rate([](const EquationOfMotion& at) { return at.M; });
            for (const auto& [method, name] : kEliminations)
            {
              CAPTURE(name, now.condition);
              const auto [F, Fdot, F_bar, independent] = now.eliminated(method);
              const ReducedForm reduced = reduced_form(now.equation, {F, Fdot, F_bar, independent});
              CHECK(mismatch(reduced.mass, reduced.mass.transpose(), 1e-13 * now.condition) == "");
              CHECK(oracle::eigenvalues(reduced.mass)(0) > 0.0);
              const MatrixXd C = reduced.coriolis;
              const MatrixXd rate = Fdot.transpose() * now.equation.M * F + F.transpose() * Mdot * F +
                                    F.transpose() * now.equation.M * Fdot;
              CHECK(mismatch(rate, C + C.transpose(), 1e-10 * now.condition * now.condition) == "");
              // what (23) prints
              const MatrixXd N =
                  rate - 2.0 * F.transpose() * now.equation.M * Fdot - F.transpose() * now.equation.C * F;
              printed = std::max(printed, (N + N.transpose()).cwiseAbs().maxCoeff());
            }
          });
  CHECK(printed > 1.0);
}

TEST_CASE("accelerations and multipliers are those of the whole system, and Udwadia and Kalaba's",
          "[elimination][slow]")
{
  for_all(2 * kCases,
          [](const Moving& now, oracle::Random& random) { check_answers(now, random_torque(now.robot, random)); });
}

TEST_CASE("the reduced equation is linear in the robot's base parameters", "[elimination]")
{
  oracle::Random random(5);
  for (const char* name : {"ck", "rk"})
  {
    const Robot robot = load_robot(name);
    const std::vector<BaseParameter> parameters = base_parameters(robot);
    VectorXd alpha(parameters.size());
    for (std::size_t i = 0; i < parameters.size(); ++i)
      alpha(static_cast<Eigen::Index>(i)) = parameters[i].value;
    for (int i = 0; i < kStates / 10; ++i)
      for (const Coordinates coordinates : kBoth)
        for (const auto& [method, elimination] : kEliminations)
        {
          CAPTURE(name, i, elimination);
          const oracle::Motion motion = oracle::random_motion(random);
          const Moving now(robot, on(Contact::sole, Contact::heel), coordinates, motion.X, motion.V);
          const Elimination found = now.eliminated(method);
          const ReducedForm reduced = reduced_form(now.equation, found);
          const VectorXd zdot = oracle::pseudo_inverse(found.F) * now.v;
          const VectorXd zddot = VectorXd::Random(zdot.size());
          VectorXd a = found.F * zddot + found.Fdot * zdot;
          if (coordinates == Coordinates::relative)
            a.head<7>() = robot.A_inverse * a.head<7>();
          const MatrixXd Y = regressor(
              robot, parameters, {kinematics(robot.mechanism, now.q, now.v_absolute), now.v_absolute, VectorQ(a)});
          const VectorXd force = in_coordinates(robot, Y * alpha, coordinates);
          CHECK(mismatch(found.F.transpose() * force, reduced.mass * zddot + reduced.coriolis * zdot + reduced.gravity,
                         1e-11 * now.condition) == "");
        }
  }
}

TEST_CASE("straight knees and feet at one place are answered; dependent contacts are refused by every method",
          "[elimination]")
{
  oracle::Random random(6);
  const Robot robot = load_robot("ck");
  const VectorXd rates = oracle::random_motion(random).V;
  int answered = 0, refused = 0;
  for (const double bend : {0.0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 3e-6, 1e-5, 1e-4, 1e-3})
    for (const double stride : {0.0, 0.5})
      for (const Contact left : kContacts)
        for (const Contact right : kContacts)
        {
          // both shins in line with their thighs but for the bend, the legs a stride apart
          VectorXd q(9);
          q << 0.1, 0.2 - bend, 0.2, 0.2 - stride, 0.2 - stride - bend, 0.1, 0.0, 0.0, 0.9;
          const Moving now(robot, on(left, right), Coordinates::relative, q, rates);
          CAPTURE(bend, stride, name_of(left), name_of(right), now.condition);
          const bool dependent = left == Contact::sole && right == Contact::sole && stride == 0.0;
          for (const auto& [method, name] : kEliminations)
          {
            CAPTURE(name);
            const auto result = eliminate(now.equation.J, now.equation.Jdot, method);
            const Refusal* refusal = std::get_if<Refusal>(&result);
            CHECK((refusal != nullptr) == (now.condition * kIndependentContacts > 1.0));
            CHECK((refusal == nullptr || dependent));
            if (refusal)
            {
              CHECK(refusal->reason() == Reason::numerical);
              CHECK(refusal->detail().find("the contacts are not independent: the smallest singular value of J is ") ==
                    0);
              CHECK(refusal->detail().ends_with(" of the largest; it must be at least 1e-06"));
              ++refused;
            }
            else
            {
              check_elimination(now, method);
              ++answered;
            }
          }
          if (now.condition < 1e3)
            check_answers(now, random_torque(robot, random));
        }
  CHECK(refused >= 6 * 6);
  CHECK(answered > 6 * 300);
  // feet at one place, knees bent
  VectorXd q(9);
  q << 0.0, -0.3, 0.3, 0.3, -0.3, 0.0, 0.0, 0.0, 0.9;
  check_answers(Moving(robot, on(Contact::sole, Contact::sole), Coordinates::absolute, q, rates),
                random_torque(robot, random));
}

TEST_CASE("a fixed root's own contact leaves all coordinates free, and more contacts than coordinates none",
          "[elimination]")
{
  oracle::Random random(7);
  const Robot compass = load_robot("compass");
  const State state = random_state(random, compass);
  const Support contacts = support(compass, Contact::none, Contact::none);
  const EquationOfMotion equation =
      equation_of_motion(compass, motion_of(compass, state, contacts), contacts, Coordinates::absolute);
  REQUIRE(equation.J.rows() == 0);
  for (const auto& [method, name] : kEliminations)
  {
    CAPTURE(name);
    const Elimination all = std::get<Elimination>(eliminate(equation.J, equation.Jdot, method));
    CHECK(all.F == identity(2));
    CHECK(all.Fdot.isZero(0.0));
    CHECK(all.F_bar.cols() == 0);
    CHECK(all.independent.size() == (method == EliminationMethod::partitioning ? 2 : 0));
    const ReducedForm reduced = reduced_form(equation, all);
    CHECK(mismatch(reduced.mass, equation.M, 0.0) == "");
    CHECK(mismatch(reduced.coriolis, equation.C, 0.0) == "");
    CHECK(multipliers(equation, all, VectorJ::Zero(compass.num_joints())).size() == 0);

    // every coordinate rests; then one row more than there are coordinates
    Jacobian J = Jacobian::Identity(2, 2);
    const Elimination none = std::get<Elimination>(eliminate(J, Jacobian::Zero(2, 2), method));
    CHECK(none.F.rows() == 2);
    CHECK(none.F.cols() == 0);
    CHECK(mismatch(none.F_bar, identity(2), 1e-15) == "");
    J = Jacobian::Ones(3, 2);
    const auto result = eliminate(J, J, method);
    REQUIRE(std::holds_alternative<Refusal>(result));
    CHECK(std::get<Refusal>(result).detail() ==
          "the contacts have 3 rows in J, the robot has 2 coordinates: they cannot all rest");
  }
  const Robot six = load_robot("six-link");
  const Support both = support(six, Contact::sole, Contact::heel);
  for (int i = 0; i < 20; ++i)
  {
    const State moves = random_state(random, six);
    const EquationOfMotion of_six = equation_of_motion(six, motion_of(six, moves, both), both, Coordinates::absolute);
    const Elimination found = std::get<Elimination>(eliminate(of_six.J, of_six.Jdot, EliminationMethod::partitioning));
    CHECK(found.F.cols() == 4);
    CHECK(mismatch(of_six.J * found.F, MatrixXd::Zero(2, 4), 1e-12) == "");
  }
}

} // namespace elimination_test
