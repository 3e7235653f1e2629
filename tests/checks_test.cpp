#include "catch.h"
#include "matchers.h"
#include "oracles.h"

#include "robot/files/load.h"
#include "stance/checks.h"

namespace checks_test
{

using namespace torqued;

namespace
{

// A foot at the origin, on which force f acts at x along the sole.
struct Loaded
{
  FootPose pose;
  Wrench wrench;
};

Loaded load_at(const Robot& robot, double x, Eigen::Vector2d f, double tilt = 0.0)
{
  Loaded loaded;
  loaded.pose.e = {std::cos(tilt), std::sin(tilt)};
  const Eigen::Vector2d r = rotate(loaded.pose.e, {x, -robot.foot(Side::left).ankle_height()});
  loaded.wrench = {f.x(), f.y(), cross(r, f)};
  return loaded;
}

GroundReaction reaction_at(const Robot& robot, double x, Eigen::Vector2d f, double tilt = 0.0)
{
  const Loaded loaded = load_at(robot, x, f, tilt);
  return ground_reaction(robot, robot.foot(Side::left), loaded.pose, loaded.wrench);
}

std::int32_t flags_at(const Robot& robot, Contact contact, double x, Eigen::Vector2d f, double tilt = 0.0)
{
  const Loaded loaded = load_at(robot, x, f, tilt);
  return contact_flags(robot, robot.foot(Side::left), loaded.pose, contact, loaded.wrench);
}

} // namespace

TEST_CASE("the centre of pressure is where the force acts along the sole, level or tilted", "[checks]")
{
  const Robot robot = load_robot("ck");
  oracle::Random random(31);
  for (int i = 0; i < 200; ++i)
  {
    const double x = oracle::uniform(random, -0.2, 0.3);
    const Eigen::Vector2d f(oracle::uniform(random, -50.0, 50.0), oracle::uniform(random, 100.0, 800.0));
    const double tilt = i % 2 == 0 ? 0.0 : oracle::uniform(random, -1.0, 1.0);
    const GroundReaction reaction = reaction_at(robot, x, f, tilt);
    CHECK(mismatch(reaction.cop, x, 1e-12) == "");
    CHECK(mismatch(reaction.friction_ratio, std::abs(f.x()) / f.y(), 1e-14) == "");
  }
}

TEST_CASE("a foot without load has no centre of pressure and no friction ratio", "[checks]")
{
  const Robot robot = load_robot("ck");
  const GroundReaction reaction = reaction_at(robot, 0.1, {1e-4, 4e-4}); // weight 441 N
  CHECK(reaction.cop == 0.0);
  CHECK(reaction.friction_ratio == 0.0);
  CHECK(flags_at(robot, Contact::sole, 0.1, {1e-4, 4e-4}) == 0);
}

TEST_CASE("each contact condition has its flag, on the right side of its boundary", "[checks]")
{
  const Robot robot = load_robot("ck"); // friction 0.6, sole from −0.07 to 0.15
  const auto flags = [&](Contact contact, double x, Eigen::Vector2d f, double tilt = 0.0)
  {
    return flags_at(robot, contact, x, f, tilt);
  };
  CHECK(flags(Contact::sole, 0.0, {0.0, 400.0}) == 0);
  CHECK(flags(Contact::sole, 0.0, {239.9, 400.0}) == 0);
  CHECK(flags(Contact::sole, 0.0, {240.1, 400.0}) == flag::slips);
  CHECK(flags(Contact::sole, 0.0, {-240.1, 400.0}) == flag::slips);
  CHECK(flags(Contact::sole, 0.0, {0.0, -1.0}) == flag::lifts);
  CHECK(flags(Contact::sole, 0.149, {0.0, 400.0}) == 0);
  CHECK(flags(Contact::sole, 0.15, {0.0, 400.0}) == 0);
  CHECK(flags(Contact::sole, 0.151, {0.0, 400.0}) == flag::tips);
  CHECK(flags(Contact::sole, -0.071, {0.0, 400.0}) == flag::tips);
  CHECK(flags(Contact::sole, -0.07, {0.0, 400.0}) == 0);
  CHECK(flags(Contact::toe, 0.151, {0.0, 400.0}) == 0);
  CHECK(flags(Contact::none, 0.151, {500.0, -400.0}) == 0);
  CHECK(flags(Contact::sole, 0.149, {0.0, 400.0}, 0.5) == 0);
  CHECK(flags(Contact::sole, 0.151, {0.0, 400.0}, 0.5) == flag::tips);

  // a moment without a force tips, too
  FootPose level;
  level.e = {1.0, 0.0};
  CHECK(contact_flags(robot, robot.foot(Side::left), level, Contact::sole, {0.0, 0.0, 1.0}) == flag::tips);
  CHECK(contact_flags(robot, robot.foot(Side::left), level, Contact::sole, {0.0, 0.0, -1.0}) == flag::tips);
}

TEST_CASE("a sole that stands upright has no centre of pressure to speak of", "[checks]")
{
  // the force runs along the sole: their lines do not meet
  const Robot robot = load_robot("ck");
  FootPose upright;
  upright.e = {0.0, 1.0};
  const GroundReaction reaction = ground_reaction(robot, robot.foot(Side::left), upright, {0.0, 400.0, 10.0});
  CHECK(reaction.cop == 0.0);
}

TEST_CASE("the zero-moment point is where the total force crosses the ground", "[checks]")
{
  const Robot robot = load_robot("ck");
  SupportEquations equations;
  equations.now.base = {0.3, 0.8};
  const Eigen::Vector2d F(60.0, 500.0);
  const double x = 0.42;
  equations.d << F, cross(Eigen::Vector2d(x, 0.0) - equations.base(), F);
  CHECK(mismatch(zero_moment_point(robot, equations), x, 1e-14) == "");
  equations.d << 0.0, 0.0, 5.0;
  CHECK(zero_moment_point(robot, equations) == 0.0);
}

} // namespace checks_test
