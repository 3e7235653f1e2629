#include "catch.h"
#include "double_support.h"
#include "matchers.h"
#include "methods/constrained.h"
#include "methods/torque_solution.h"
#include "methods/zmp_transition.h"

#include "stance/checks.h"

#include <functional>

namespace continuity_test
{

using namespace torqued;
using oracle::Vector9;

// Along single support → trailing sole and leading heel → trailing toe and leading sole → single support, contacts
// change where the foot concerned rests. There position, rate and acceleration are those of one instant, so a torque
// jumps by the difference of two answers to the same motion.

namespace
{

// a pose that has room for every torque, at a switch; limits are a little more than what zmp_transition needs
Robot with_limits(oracle::Random& random, const Case& before, const Case& after, Method instead)
{
  Robot robot = before.robot;
  const VectorJ one = before.solution(instead).torque.cwiseAbs(), two = after.solution(instead).torque.cwiseAbs();
  for (std::size_t j = 0; j < robot.actuators.size(); ++j)
    robot.actuators[j].torque_limit = oracle::uniform(random, 0.0, 1.0) < 0.5
                                          ? 1.001 * std::max(one(static_cast<int>(j)), two(static_cast<int>(j))) + 0.1
                                          : std::numeric_limits<double>::infinity();
  return robot;
}

struct Switch
{
  Case before, after;
  double jump(Method method, const MethodSettings& settings = {}) const
  {
    return (before.solution(method, settings).torque - after.solution(method, settings).torque).cwiseAbs().maxCoeff();
  }
};

Support contacts(Side leading, Contact leading_contact, Contact trailing_contact)
{
  Support support{{trailing_contact, trailing_contact}, leading, 0.0, 0.0};
  support.contact[static_cast<std::size_t>(leading)] = leading_contact;
  return support;
}

// One instant seen from both sides of a change of contacts; step: how much higher the leading foot stands.
Switch change(oracle::Random& random, int i, const Support& rests, double x_from, double x_to, Support before,
              Support after, double step = 0.0)
{
  const Stance stance{rests.contact[0], rests.contact[1], rests.leading, step};
  auto [biped, motion] = posed(random, i, stance);
  const Side leading = rests.leading;
  // 0: heel, 1: toe of the foot that then carries; the switch between both double supports, from the trailing toe to
  // the leading heel
  const bool both = rests.of(Side::left) == Contact::sole && rests.of(Side::right) == Contact::sole &&
                    before.redundancy() > 0 && after.redundancy() > 0;
  const Side carries = rests.of(leading) == Contact::sole ? leading : other(leading);
  const double from = both ? biped.contact_point(other(leading), Contact::toe, motion.X).x()
                           : biped.contact_point(carries, Contact::heel, motion.X).x();
  const double to = both ? biped.contact_point(leading, Contact::heel, motion.X).x()
                         : biped.contact_point(carries, Contact::toe, motion.X).x();
  ask_of_ground(random, biped, stance, from + oracle::uniform(random, x_from, x_to) * (to - from), motion);
  // named, because Clang captures structured bindings by themselves only from version 16
  const auto seen = [&, &biped = biped, &motion = motion](const Support& support, const Robot& robot)
  {
    Case now(biped, robot, motion, support.contact[0], support.contact[1], leading, support.load_transfer,
             support.phase);
    return now;
  };
  const Robot robot = biped.robot();
  const Switch without{seen(before, robot), seen(after, robot)};
  const Robot limited = with_limits(random, without.before, without.after, Method::zmp_transition);
  return {seen(before, limited), seen(after, limited)};
}

Support at(Support support, double load_transfer, double phase)
{
  support.load_transfer = load_transfer;
  support.phase = phase;
  return support;
}

constexpr double kContinuous = 1e-6; // N m
constexpr double kJump = 1e-2;       // N m

MethodSettings without_windows()
{
  MethodSettings settings;
  settings.of<Constrained>().windows = false;
  return settings;
}

// Checks a column of the table: which methods jump at this change of contacts. linear: whether the linear transition
// and what equals it is continuous.
void check_column(const std::function<Switch(int)>& draw, bool linear)
{
  int cases = 0, jumps_linear = 0, jumps_inverse = 0, jumps_least = 0, jumps_plain = 0;
  for (int i = 0; i < 2 * kCases; ++i)
  {
    CAPTURE(i);
    const Switch now = draw(i);
    ++cases;
    jumps_inverse += now.jump(Method::pseudo_inverse) > kJump ? 1 : 0;
    jumps_least += now.jump(Method::internal_wrench) > kJump ? 1 : 0;
    CHECK((now.jump(Method::torso_wrench) > kJump) == (now.jump(Method::internal_wrench) > kJump));
    jumps_plain += now.jump(Method::constrained, without_windows()) > kJump ? 1 : 0;
    for (const Method method : {Method::linear_transition, Method::tracked_reaction, Method::tracked_internal})
      if (linear)
        CHECK(now.jump(method) < kContinuous);
      else
        jumps_linear += now.jump(method) > kJump ? 1 : 0;
    CHECK(now.jump(Method::zmp_transition) < kContinuous);
    CHECK(now.jump(Method::human_transition) < kContinuous);
    if (!linear)
    {
      CHECK_FALSE(now.before.solution(Method::zmp_transition).clamped);
      CHECK_FALSE(now.after.solution(Method::zmp_transition).clamped);
    }
    CHECK(now.jump(Method::constrained) < kContinuous);
    CHECK_FALSE(now.before.solution(Method::constrained).relaxed);
    CHECK_FALSE(now.after.solution(Method::constrained).relaxed);
  }
  CHECK(jumps_inverse > 98 * cases / 100);
  CHECK(jumps_least > 98 * cases / 100);
  CHECK(jumps_plain > 9 * cases / 10);
  CHECK((linear || jumps_linear > 3 * 98 * cases / 100));
}

} // namespace

TEST_CASE("where the leading heel lands, methods that hand the load over are continuous, least torque jumps",
          "[continuity]")
{
  oracle::Random random(501);
  for (const Side leading : kSides)
    check_column(
        [&](int i)
        {
          const Support both = contacts(leading, Contact::heel, Contact::sole);
          return change(random, i, both, 0.02, 0.98, contacts(leading, Contact::none, Contact::sole),
                        at(both, 0.0, 0.0));
        },
        true);
}

TEST_CASE("where the leading foot is flat and the trailing heel lifts, only a share through s* is continuous",
          "[continuity]")
{
  oracle::Random random(502);
  for (const Side leading : kSides)
    check_column(
        [&](int i)
        {
          const double s = oracle::uniform(random, 0.0, 1.0);
          return change(random, i, contacts(leading, Contact::sole, Contact::sole), 0.02, 0.98,
                        at(contacts(leading, Contact::heel, Contact::sole), s, 1.0),
                        at(contacts(leading, Contact::sole, Contact::toe), s, 0.0));
        },
        false);
}

TEST_CASE("where the trailing heel lifts, the share through s* is continuous however high the leading foot stands",
          "[continuity]")
{
  oracle::Random random(508);
  for (int i = 0; i < 2 * kCases; ++i)
  {
    const Side leading = i % 4 < 2 ? Side::left : Side::right;
    const double s = oracle::uniform(random, 0.0, 1.0), step = oracle::uniform(random, -0.02, 0.02);
    CAPTURE(i, step);
    // s* is the zero-moment point's share on the ground, but for step × F_x / F_z over a lever of 5 cm at the least
    const Switch now = change(random, i, contacts(leading, Contact::sole, Contact::sole), 0.25, 0.75,
                              at(contacts(leading, Contact::heel, Contact::sole), s, 1.0),
                              at(contacts(leading, Contact::sole, Contact::toe), s, 0.0), step);
    for (const Method method : {Method::zmp_transition, Method::human_transition, Method::constrained})
    {
      CAPTURE(std::string(name_of(method)));
      CHECK(now.jump(method) < kContinuous);
      CHECK_FALSE(now.before.solution(method).clamped);
      CHECK_FALSE(now.before.solution(method).relaxed);
    }
  }
}

TEST_CASE("where the trailing toe lifts, methods that hand the load over are continuous, least torque jumps",
          "[continuity]")
{
  oracle::Random random(503);
  for (const Side leading : kSides)
    check_column(
        [&](int i)
        {
          const Support both = contacts(leading, Contact::sole, Contact::toe);
          return change(random, i, both, 0.02, 0.98, at(both, 1.0, 1.0),
                        contacts(leading, Contact::sole, Contact::none));
        },
        true);
}

TEST_CASE("a linear transition whose share passes through s* where the trailing heel lifts is continuous",
          "[continuity]")
{
  oracle::Random random(504);
  for (int i = 0; i < 2 * kCases; ++i)
  {
    CAPTURE(i);
    const Side leading = i % 4 < 2 ? Side::left : Side::right;
    Switch now = change(random, i, contacts(leading, Contact::sole, Contact::sole), 0.02, 0.98,
                        at(contacts(leading, Contact::heel, Contact::sole), 0.0, 1.0),
                        at(contacts(leading, Contact::sole, Contact::toe), 0.0, 0.0));
    const Vector9& X = now.before.motion.X;
    const double toe = now.before.biped.contact_point(other(leading), Contact::toe, X).x();
    const double heel = now.before.biped.contact_point(leading, Contact::heel, X).x();
    const Eigen::Vector3d d = now.before.d();
    const double zmp = X(7) + (d(2) - X(8) * d(0)) / d(1);
    const double s = (zmp - toe) / (heel - toe);
    now.before.desired.support.load_transfer = now.after.desired.support.load_transfer = s;
    for (const Method method : {Method::linear_transition, Method::tracked_reaction, Method::tracked_internal})
      CHECK(now.jump(method) < kContinuous);
    // it is what zmp_transition does there
    for (const Case* side : {&now.before, &now.after})
      CHECK((side->solution(Method::linear_transition).torque - side->solution(Method::zmp_transition).torque)
                .cwiseAbs()
                .maxCoeff() < kContinuous);
    // and off it, the jump is as large as the share is wrong
    now.before.desired.support.load_transfer = now.after.desired.support.load_transfer = s + 0.1;
    CHECK(now.jump(Method::linear_transition) > kJump);
  }
}

TEST_CASE("from one sole over two to the other, torques are continuous at both ends", "[continuity]")
{
  oracle::Random random(505);
  for (int i = 0; i < 4 * kCases; ++i)
  {
    CAPTURE(i);
    const Side leading = i % 4 < 2 ? Side::left : Side::right;
    const Support both = contacts(leading, Contact::sole, Contact::sole);
    const bool first = i % 8 < 4;
    // the zero-moment point in the sole that carries alone
    const Stance stance{Contact::sole, Contact::sole, leading};
    auto [biped, motion] = posed(random, i, stance);
    const Side carries = first ? other(leading) : leading;
    const double heel = biped.contact_point(carries, Contact::heel, motion.X).x();
    ask_of_ground(random, biped, stance, heel + oracle::uniform(random, 0.02, 0.98) * (biped.l_p + biped.l_p1), motion);
    const double end = first ? 0.0 : 1.0;
    const Support alone =
        first ? contacts(leading, Contact::none, Contact::sole) : contacts(leading, Contact::sole, Contact::none);
    const double any = oracle::uniform(random, 0.0, 1.0); // on two soles phase means nothing
    const Switch now{Case(biped, motion, alone.contact[0], alone.contact[1], leading, end, any),
                     Case(biped, motion, both.contact[0], both.contact[1], leading, end, any)};
    for (const Method method : {Method::linear_transition, Method::tracked_reaction, Method::tracked_internal,
                                Method::zmp_transition, Method::human_transition, Method::constrained})
    {
      CAPTURE(std::string(name_of(method)));
      CHECK(now.jump(method) < kContinuous);
      CHECK_FALSE(now.after.solution(method).relaxed);
    }
    CHECK(now.jump(Method::internal_wrench) > kJump);
  }
}

TEST_CASE("on two points no method but least torque and pseudo-inverse has more than a horizontal force to choose",
          "[continuity]")
{
  oracle::Random random(506);
  for (int i = 0; i < 2 * kCases; ++i)
  {
    CAPTURE(i);
    const Side leading = i % 4 < 2 ? Side::left : Side::right;
    const Stance stance{leading == Side::left ? Contact::heel : Contact::toe,
                        leading == Side::left ? Contact::toe : Contact::heel, leading};
    auto [biped, motion] = posed(random, i, stance);
    const double toe = biped.contact_point(other(leading), Contact::toe, motion.X).x();
    const double heel = biped.contact_point(leading, Contact::heel, motion.X).x();
    const double share = oracle::uniform(random, -0.2, 1.2);
    ask_of_ground(random, biped, stance, toe + share * (heel - toe), motion);
    const Case now(biped, motion, stance.left, stance.right, leading, 0.3, 0.3);
    const Eigen::Vector3d d = now.d();
    for (const MethodRow& known : methods())
    {
      CAPTURE(known.name);
      const TorqueSolution found = now.solution(known.method);
      CHECK(mismatch(found.ground[static_cast<std::size_t>(leading)].fz / d(1), share, 1e-9) == "");
    }
    const TorqueSolution zmp = now.solution(Method::zmp_transition);
    CHECK(zmp.clamped == (share < 0.0 || share > 1.0));
    CHECK(mismatch(zmp.ground[static_cast<std::size_t>(leading)].fx, std::clamp(share, 0.0, 1.0) * d(0), 1e-9) == "");
  }
}

TEST_CASE("without load, or where toe and heel stand above one another, s* is undefined and said to be clamped",
          "[continuity]")
{
  oracle::Random random(507);
  const oracle::Biped ck;
  const Stance stance{Contact::sole, Contact::heel, Side::right};
  oracle::Motion motion = pose(random, ck, stance).value();
  ask_of_ground(random, ck, stance, 0.0, motion);
  Case now(ck, motion, stance.left, stance.right, stance.leading, 0.3, 0.4);
  const auto share = [&]
  {
    const auto found = std::get<Reactions>(zmp_transition(now.robot, now.equations, now.support()));
    CHECK(found.clamped);
    return found.w(3) / now.equations.d(0);
  };
  const SupportEquations loaded = now.equations;
  now.equations.d(1) = 1e-9 * now.robot.weight();
  CHECK(mismatch(share(), 0.4 * 0.5, 1e-12) == "");
  now.equations = loaded;
  now.equations.feet[1].heel.x() = now.equations.feet[0].toe.x();
  CHECK(mismatch(share(), 0.4 * 0.5, 1e-12) == "");
  // beyond the points: all on the one, or on the other
  const auto with_zmp = [&](double x)
  {
    now.equations = loaded;
    now.equations.d(2) = cross(Eigen::Vector2d(x, 0.0) - now.equations.base(), now.equations.force());
  };
  with_zmp(loaded.feet[0].toe.x() - 0.1);
  CHECK(share() == 0.0);
  with_zmp(loaded.feet[1].heel.x() + 0.1);
  CHECK(mismatch(share(), 0.4, 1e-12) == "");
}

} // namespace continuity_test
