#include "catch.h"
#include "double_support.h"
#include "matchers.h"
#include "methods/human_transition.h"
#include "methods/torque_solution.h"

#include "stance/checks.h"

namespace human_transition_test
{

using namespace torqued;

namespace
{

// Two soles on the ground, the total force pressing at a share of the way from the trailing toe to the leading heel.
Case stance(oracle::Random& random, int i, Contact leading_contact, Contact trailing_contact, double at, double s,
            double p)
{
  const Side leading = i % 4 < 2 ? Side::left : Side::right;
  const bool left = leading == Side::left;
  const Stance feet{left ? leading_contact : trailing_contact, left ? trailing_contact : leading_contact, leading};
  auto [biped, motion] = posed(random, i, feet);
  const double toe = biped.contact_point(other(leading), Contact::toe, motion.X).x();
  const double heel = biped.contact_point(leading, Contact::heel, motion.X).x();
  ask_of_ground(random, biped, feet, toe + at * (heel - toe), motion);
  return Case(biped, motion, feet.left, feet.right, leading, s, p);
}

MethodSettings with(const HumanTransition& shape)
{
  MethodSettings settings;
  settings.of<HumanTransition>() = shape;
  return settings;
}

// force and centre of pressure of a foot
GroundReaction foot(const Case& now, const TorqueSolution& solution, Side side)
{
  const auto k = static_cast<std::size_t>(side);
  return ground_reaction(now.robot, now.robot.feet[k], now.equations.feet[k], solution.ground[k]);
}

// world x of the pressure below a level foot
double pressure(const Case& now, const TorqueSolution& solution, Side side)
{
  return now.biped.ankle(side, now.motion.X).x() + foot(now, solution, side).cop;
}

double centre_of_mass_x(const Case& now)
{
  // gravity's moment about the base point, of the turn of the whole robot: x m g
  return now.motion.X(7) +
         (now.N().col(2).transpose() * now.biped.Q(now.motion.X))(0) / (now.biped.mass() * now.biped.gravity);
}

double centre_of_mass_z(const Case& now)
{
  // the same, lying on its back: every angle a quarter turn on, so that z is where x was
  oracle::Vector9 X = now.motion.X;
  X.head<7>().array() -= 0.5 * M_PI;
  return now.motion.X(8) + (now.N().col(2).transpose() * now.biped.Q(X))(0) / (now.biped.mass() * now.biped.gravity);
}

} // namespace

TEST_CASE("each foot of a human transition presses at its point, the trailing force through the centre of mass",
          "[human_transition]")
{
  oracle::Random random(601);
  int both = 0, steep = 0; // both: cases in which both feet carry
  for (int i = 0; i < 4 * kCases; ++i)
  {
    CAPTURE(i);
    const double s = oracle::uniform(random, 0.1, 0.9); // beyond the fades
    const Case now = stance(random, i, Contact::sole, Contact::sole, oracle::uniform(random, 0.1, 0.9), s, s);
    const HumanTransition shape{.trailing_cop = oracle::uniform(random, 0.5, 1.0),
                                .leading_cop = oracle::uniform(random, 0.0, 0.5),
                                .time_weight = 0.0,
                                .fade = 0.1};
    const TorqueSolution found = now.solution(Method::human_transition, with(shape));
    const Side leading = now.support().leading, trailing = other(leading);
    const double x_r = now.biped.contact_point(trailing, Contact::heel, now.motion.X).x() +
                       shape.trailing_cop * (now.biped.l_p + now.biped.l_p1);
    const double x_f = now.biped.contact_point(leading, Contact::heel, now.motion.X).x() +
                       shape.leading_cop * (now.biped.l_p + now.biped.l_p1);
    const Eigen::Vector3d d = now.d();
    const double zmp = now.motion.X(7) + (d(2) - now.motion.X(8) * d(0)) / d(1);
    const double share = (zmp - x_r) / (x_f - x_r);
    if (share <= 0.01 || share >= 0.99)
      continue;
    ++both;
    CHECK_FALSE(found.clamped);
    CHECK(mismatch(pressure(now, found, leading), x_f, 1e-9) == "");
    CHECK(mismatch(pressure(now, found, trailing), x_r, 1e-9) == "");
    CHECK(mismatch(foot(now, found, leading).wrench.fz, share * d(1), 1e-9) == "");
    const Wrench force = foot(now, found, trailing).wrench;
    const double slope = (centre_of_mass_x(now) - x_r) / centre_of_mass_z(now);
    steep += std::abs(slope) > now.biped.friction ? 1 : 0;
    CHECK(mismatch(force.fx, force.fz * std::clamp(slope, -now.biped.friction, now.biped.friction), 1e-9) == "");
  }
  CAPTURE(both, steep);
  CHECK(both > 3 * kCases);
  CHECK(steep > kCases / 10);
}

TEST_CASE("the time that has passed has its weight in a human transition's vertical share", "[human_transition]")
{
  oracle::Random random(602);
  for (int i = 0; i < kCases; ++i)
  {
    CAPTURE(i);
    const double s = oracle::uniform(random, 0.1, 0.9), weight = oracle::uniform(random, 0.0, 1.0);
    const Case now = stance(random, i, Contact::sole, Contact::sole, oracle::uniform(random, -0.2, 1.2), s, s);
    const auto share = [&](double time_weight)
    {
      const TorqueSolution found = now.solution(Method::human_transition, with({.time_weight = time_weight}));
      return foot(now, found, now.support().leading).wrench.fz / now.d()(1);
    };
    CHECK(mismatch(share(1.0), s, 1e-9) == "");
    CHECK(mismatch(share(weight), (1.0 - weight) * share(0.0) + weight * s, 1e-9) == "");
  }
}

TEST_CASE("a human transition starts and ends in single support, whatever its shape and the motion",
          "[human_transition]")
{
  oracle::Random random(603);
  for (int i = 0; i < 2 * kCases; ++i)
  {
    CAPTURE(i);
    const bool first = i % 8 < 4;
    const double end = first ? 0.0 : 1.0;
    Case now = stance(random, i, Contact::sole, Contact::sole, oracle::uniform(random, -1.0, 2.0), end, end);
    const HumanTransition shape{.trailing_cop = oracle::uniform(random, 0.0, 1.0),
                                .leading_cop = oracle::uniform(random, 0.0, 1.0),
                                .time_weight = oracle::uniform(random, 0.0, 1.0),
                                .fade = oracle::uniform(random, 0.01, 0.5)};
    const VectorJ both = now.solution(Method::human_transition, with(shape)).torque;
    const Side lifted = first ? now.support().leading : other(now.support().leading);
    DesiredState alone = now.desired;
    alone.support.contact[static_cast<std::size_t>(lifted)] = Contact::none;
    const auto equations = std::get<SupportEquations>(support_equations(now.robot, alone));
    const auto solved = solve_torques(now.robot, equations, alone.support, Method::none, {}, 1e-3);
    CHECK(mismatch(both, std::get<TorqueSolution>(solved).torque, 1e-9) == "");

    // and comes there without a step: a thousandth of the fade away, ease is 3e-6
    now.desired.support.load_transfer = first ? 1e-3 * shape.fade : 1.0 - 1e-3 * shape.fade;
    const VectorJ near = now.solution(Method::human_transition, with(shape)).torque;
    const double size = now.robot.weight() * now.robot.leg_length;
    CHECK((near - both).cwiseAbs().maxCoeff() < 1e-4 * size);
  }
}

TEST_CASE("a human transition knows no left and right, and no past", "[human_transition]")
{
  oracle::Random random(604);
  constexpr std::pair<Contact, Contact> pairs[] = {{Contact::sole, Contact::sole},
                                                   {Contact::heel, Contact::sole},
                                                   {Contact::sole, Contact::toe},
                                                   {Contact::heel, Contact::toe}};
  for (int i = 0; i < 2 * kCases; ++i)
  {
    CAPTURE(i);
    const auto [leading, trailing] = pairs[i / 4 % 4];
    const double s = oracle::uniform(random, 0.0, 1.0), p = oracle::uniform(random, 0.0, 1.0);
    const Case now = stance(random, i, leading, trailing, oracle::uniform(random, -0.3, 1.3), s, p);
    const TorqueSolution found = now.solution(Method::human_transition);
    // absolute angles of left foot, shin, thigh; right thigh, shin, foot
    oracle::Motion mirrored = now.motion;
    for (oracle::Vector9* vector : {&mirrored.X, &mirrored.V, &mirrored.A})
      vector->head<6>().reverseInPlace();
    const Case other_way(now.biped, mirrored, now.support().contact[1], now.support().contact[0],
                         other(now.support().leading), s, p);
    const TorqueSolution again = other_way.solution(Method::human_transition);
    CHECK(mismatch(again.torque, found.torque.reverse(), 1e-9) == "");
    CHECK(found.method == Method::human_transition);
    // all of the motion's force is on the feet
    CHECK(mismatch(now.G() * found.w, now.d(), 1e-9) == "");
  }
}

TEST_CASE("on two points a human transition is the zmp transition", "[human_transition]")
{
  oracle::Random random(605);
  for (int i = 0; i < kCases; ++i)
  {
    CAPTURE(i);
    const Case now = stance(random, i, Contact::heel, Contact::toe, oracle::uniform(random, -0.3, 1.3), 0.4, 0.6);
    CHECK(now.solution(Method::human_transition).torque == now.solution(Method::zmp_transition).torque);
  }
}

TEST_CASE("where a human transition's lever is nothing it says so, and a robot on the ground gets no horizontal push",
          "[human_transition]")
{
  oracle::Random random(606);
  Case now = stance(random, 0, Contact::sole, Contact::sole, 0.5, 0.5, 0.5);
  const SupportEquations good = now.equations;
  const auto leading = static_cast<std::size_t>(now.support().leading);
  const auto solve = [&](const HumanTransition& shape)
  {
    return std::get<Reactions>(human_transition(now.robot, now.equations, now.support(), shape));
  };
  const auto leading_share = [&](const Reactions& found)
  {
    return found.w(now.support().row(now.support().leading) + 1) / now.equations.d(1);
  };
  CHECK_FALSE(solve({}).clamped);
  // no load
  now.equations.d(1) = 1e-9 * now.robot.weight();
  CHECK(solve({}).clamped);
  CHECK(mismatch(leading_share(solve({.time_weight = 0.0})), 0.5, 1e-9) == "");
  // leading heel on the trailing toe
  now.equations = good;
  now.equations.feet[leading].heel = now.equations.feet[1 - leading].toe;
  const HumanTransition ends{.trailing_cop = 1.0, .leading_cop = 0.0, .time_weight = 0.0};
  CHECK(solve(ends).clamped);
  CHECK(mismatch(leading_share(solve(ends)), 0.5, 1e-9) == "");
  CHECK(solve(ends).w.allFinite());
  // the base point, and with it the centre of mass, below the feet
  now.equations = good;
  now.equations.now.base.y() -= 5.0;
  CHECK(solve({}).w(now.support().row(other(now.support().leading))) == 0.0);
}

} // namespace human_transition_test
