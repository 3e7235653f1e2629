#include "catch.h"
#include "matchers.h"
#include "methods/linear_transition.h"
#include "methods/torque_solution.h"
#include "oracles.h"

#include "robot/files/load.h"
#include "stance/checks.h"

namespace linear_transition_test
{

using namespace torqued;

namespace
{

struct Solved
{
  SupportEquations equations;
  TorqueSolution solution;
  std::array<GroundReaction, 2> ground;

  const GroundReaction& foot(Side side) const { return ground[static_cast<std::size_t>(side)]; }
};

Solved solve(const Robot& robot, DesiredState desired, const MethodSettings& settings = {})
{
  desired.method = Method::linear_transition;
  const auto equations = std::get<SupportEquations>(support_equations(robot, desired));
  const auto result = solve_torques(robot, equations, desired.support, desired.method, settings, 1e-3);
  if (const Refusal* refusal = std::get_if<Refusal>(&result))
    FAIL(std::string(refusal->detail()));
  Solved solved{equations, std::get<TorqueSolution>(result), {}};
  for (std::size_t side = 0; side < 2; ++side)
    solved.ground[side] =
        ground_reaction(robot, robot.feet[side], solved.equations.feet[side], solved.solution.ground[side]);
  return solved;
}

// Two level soles on the ground and a total ground force, made up: x of heel, ankle and toe of the left and right foot.
SupportEquations two_soles(oracle::Random& random, const Robot& robot, double F_z)
{
  SupportEquations equations;
  equations.now.base = {oracle::uniform(random, -0.3, 0.3), 0.8};
  for (const Side side : kSides)
  {
    const Foot& foot = robot.foot(side);
    const double x = oracle::uniform(random, -0.5, 0.5);
    equations.feet[static_cast<std::size_t>(side)] = {
        {x, foot.ankle_height()}, {x + foot.heel_x(), 0.0}, {x + foot.toe_x(), 0.0}, {1.0, 0.0}};
  }
  equations.d = {oracle::uniform(random, -100.0, 100.0), F_z, 0.0};
  return equations;
}

double cop(const Robot& robot, Side side, const WrenchVector& w)
{
  const auto wrench = w.segment<3>(side == Side::left ? 0 : 3);
  return (wrench(2) - robot.foot(side).ankle_height() * wrench(0)) / wrench(1);
}

} // namespace

TEST_CASE("linear transition meets single support where the other foot carries nothing", "[linear_transition]")
{
  // the foot that carries everything stands on its sole: s = 0 the trailing one, s = 1 the leading one
  oracle::Random random(21);
  for (const Contact rolling : {Contact::heel, Contact::toe, Contact::sole})
    for (int i = 0; i < 200; ++i)
    {
      CAPTURE(name_of(rolling), i);
      const oracle::Biped ck = oracle::random_ck(random);
      const Robot robot = ck.robot();
      const Side flat = i % 2 == 0 ? Side::left : Side::right;
      const Contact left = flat == Side::left ? Contact::sole : rolling;
      const Contact right = flat == Side::right ? Contact::sole : rolling;
      const double s = i % 4 < 2 ? 0.0 : 1.0;
      const Side leading = s == 0.0 ? other(flat) : flat;
      const oracle::Motion motion = oracle::random_consistent_motion(random, ck, left, right);
      const Solved both = solve(robot, oracle::desired_state(motion, left, right, leading, s));
      const Solved alone =
          solve(robot, oracle::desired_state(motion, flat == Side::left ? Contact::sole : Contact::none,
                                             flat == Side::right ? Contact::sole : Contact::none));

      CHECK(mismatch(both.solution.torque, alone.solution.torque, 1e-10) == "");
    }
}

TEST_CASE("linear transition gives each foot its share of the total force", "[linear_transition]")
{
  oracle::Random random(22);
  for (const Contact left : {Contact::heel, Contact::sole, Contact::toe})
    for (const Contact right : {Contact::heel, Contact::sole, Contact::toe})
      for (int i = 0; i < 50; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const oracle::Biped ck = oracle::random_ck(random);
        const oracle::Motion motion = oracle::random_consistent_motion(random, ck, left, right);
        const double s = oracle::uniform(random, 0.0, 1.0);
        const Side leading = i % 2 == 0 ? Side::left : Side::right;
        const Solved solved = solve(ck.robot(), oracle::desired_state(motion, left, right, leading, s));
        const oracle::Vector9 r = ck.D(motion.X) * motion.A + ck.H(motion.X, motion.V) + ck.Q(motion.X);
        CHECK(mismatch(solved.foot(leading).wrench.fx, s * r(7), 1e-12) == "");
        CHECK(mismatch(solved.foot(other(leading)).wrench.fx, (1.0 - s) * r(7), 1e-12) == "");
        if (left == Contact::sole || right == Contact::sole)
        {
          CHECK(mismatch(solved.foot(leading).wrench.fz, s * r(8), 1e-12) == "");
          CHECK(mismatch(solved.foot(other(leading)).wrench.fz, (1.0 - s) * r(8), 1e-12) == "");
        }
        // at a heel or toe there is a force and no moment
        for (const Side side : kSides)
          if (const Contact contact = side == Side::left ? left : right; contact != Contact::sole)
          {
            const Wrench& wrench = solved.foot(side).wrench;
            const Eigen::Vector2d lever = ck.contact_point(side, contact, motion.X) - ck.ankle(side, motion.X);
            CHECK(mismatch(wrench.moment, lever.x() * wrench.fz - lever.y() * wrench.fx, 1e-11) == "");
          }
      }
}

TEST_CASE("on two soles both pressures stay inside whenever this split of the load allows it", "[linear_transition]")
{
  oracle::Random random(23);
  const Robot robot = load_robot("ck");
  int inside = 0, outside = 0;
  for (int i = 0; i < 2000; ++i)
  {
    const double F_z = oracle::uniform(random, 50.0, 800.0);
    const double s = oracle::uniform(random, 0.01, 0.99);
    SupportEquations equations = two_soles(random, robot, F_z);
    const Support support{{Contact::sole, Contact::sole}, i % 2 == 0 ? Side::left : Side::right, s, 0.0};
    const FootPose& leading = equations.foot(support.leading);
    const FootPose& trailing = equations.foot(support.trailing());
    // the zero-moment points that some pair of pressures inside the soles can give, and a little beyond
    const double from = s * leading.heel.x() + (1.0 - s) * trailing.heel.x();
    const double to = s * leading.toe.x() + (1.0 - s) * trailing.toe.x();
    const double zmp = from + oracle::uniform(random, -0.2, 1.2) * (to - from);
    equations.d(2) = zmp * F_z - cross(equations.base(), equations.force());
    CAPTURE(i, s, F_z, zmp, from, to);

    const auto w = std::get<Reactions>(linear_transition(robot, equations, support, {})).w;
    const double left = cop(robot, Side::left, w);
    const double right = cop(robot, Side::right, w);
    const Foot& foot = robot.foot(Side::left); // both have the same sole
    const double slack = 1e-9 / std::min(s, 1.0 - s);
    const bool both_inside =
        std::min(left, right) >= foot.heel_x() - slack && std::max(left, right) <= foot.toe_x() + slack;
    const double margin = 1e-9 * (to - from);
    if (zmp > from + margin && zmp < to - margin)
    {
      CHECK(both_inside);
      ++inside;
    }
    else if (zmp < from - 1e-3 || zmp > to + 1e-3)
    {
      CHECK_FALSE(both_inside);
      ++outside;
    }
    // the moments add up, wherever the pressures lie
    const auto moment = [&](Side side)
    {
      const auto wrench = w.segment<3>(side == Side::left ? 0 : 3);
      return wrench(2) + cross(equations.foot(side).ankle - equations.base(), wrench.head<2>());
    };
    CHECK(mismatch(moment(Side::left) + moment(Side::right), equations.d(2), 1e-10) == "");
  }
  CHECK(inside > 1000);
  CHECK(outside > 300);
}

TEST_CASE("on two soles the trailing foot follows the zero-moment point at the soles' height, the leading one the rest",
          "[linear_transition]")
{
  oracle::Random random(27);
  const Robot robot = load_robot("ck");
  for (int i = 0; i < 1000; ++i)
  {
    const double F_z = oracle::uniform(random, 50.0, 800.0), s = oracle::uniform(random, 0.01, 0.99);
    const double height = i % 2 == 0 ? 0.0 : oracle::uniform(random, -10.0, 10.0);
    CAPTURE(i, s, height);
    SupportEquations equations = two_soles(random, robot, F_z);
    equations.now.base.y() += height;
    for (FootPose& pose : equations.feet)
      for (Eigen::Vector2d* point : {&pose.ankle, &pose.heel, &pose.toe})
        point->y() += height;
    const Support support{{Contact::sole, Contact::sole}, i % 4 < 2 ? Side::left : Side::right, s, 0.0};
    const FootPose& leading = equations.foot(support.leading);
    const FootPose& trailing = equations.foot(support.trailing());
    const double from = s * leading.heel.x() + (1.0 - s) * trailing.heel.x();
    const double to = s * leading.toe.x() + (1.0 - s) * trailing.toe.x();
    const double zmp = from + oracle::uniform(random, 0.0, 1.0) * (to - from); // some pair of pressures inside gives it
    equations.d(2) = cross(Eigen::Vector2d(zmp, height) - equations.base(), equations.force());

    const double nearest = std::clamp(zmp, trailing.heel.x(), trailing.toe.x());
    const double x_f = std::clamp((zmp - (1.0 - s) * nearest) / s, leading.heel.x(), leading.toe.x());
    const double x_r = (zmp - s * x_f) / (1.0 - s);
    const auto w = std::get<Reactions>(linear_transition(robot, equations, support, {})).w;
    const double slack = 1e-12 / std::min(s, 1.0 - s);
    CHECK(std::abs(leading.ankle.x() + cop(robot, support.leading, w) - x_f) < slack);
    CHECK(std::abs(trailing.ankle.x() + cop(robot, support.trailing(), w) - x_r) < slack);
  }
}

TEST_CASE("on two soles a fixed fraction holds the leading foot's pressure there", "[linear_transition]")
{
  oracle::Random random(24);
  const Robot robot = load_robot("ck");
  const Foot& foot = robot.foot(Side::left);
  for (const double fraction : {0.0, 0.25, 1.0})
    for (const Side leading : kSides)
    {
      SupportEquations equations = two_soles(random, robot, 400.0);
      equations.d(2) = 20.0;
      const Support support{{Contact::sole, Contact::sole}, leading, 0.6, 0.0};
      const auto w = std::get<Reactions>(linear_transition(robot, equations, support, {fraction})).w;
      CHECK(mismatch(cop(robot, leading, w), foot.heel_x() + fraction * (foot.toe_x() - foot.heel_x()), 1e-12) == "");
    }
}

TEST_CASE("on two soles without load the feet carry no more than the moment that is asked", "[linear_transition]")
{
  oracle::Random random(25);
  const Robot robot = load_robot("ck");
  SupportEquations equations = two_soles(random, robot, 0.0);
  equations.d = {0.0, 0.0, 7.0};
  const Support support{{Contact::sole, Contact::sole}, Side::left, 0.3, 0.0};
  const auto w = std::get<Reactions>(linear_transition(robot, equations, support, {})).w;
  CHECK(mismatch(w, (WrenchVector(6) << 0.0, 0.0, 2.1, 0.0, 0.0, 4.9).finished(), 1e-12) == "");
}

TEST_CASE("contact points above one another leave the normal forces undetermined", "[linear_transition]")
{
  oracle::Random random(26);
  const Robot robot = load_robot("ck");
  SupportEquations equations = two_soles(random, robot, 400.0);
  equations.feet[1] = equations.feet[0];
  const Support support{{Contact::toe, Contact::toe}, Side::left, 0.5, 0.0};
  const auto refused = linear_transition(robot, equations, support, {});
  REQUIRE(std::holds_alternative<Refusal>(refused));
  CHECK(std::get<Refusal>(refused).reason() == Reason::numerical);
}

} // namespace linear_transition_test
