#include "catch.h"
#include "matchers.h"

#include "motion/gait.h"
#include "robot/files/load.h"
#include "study/world_path.h"

namespace world_path_test
{

using namespace torqued;

namespace
{

// a walk over heels, soles and toes; samples, eight to a phase, both ends of each phase among them
std::vector<DesiredState> walk(const Robot& robot)
{
  const Gait gait(robot, default_gait(robot));
  std::vector<DesiredState> states;
  for (const GaitPhase& phase : gait.phases())
    for (int i = 0; i <= 8; ++i)
      states.push_back(gait.at(phase.begin + (phase.end - phase.begin) * i / 8, phase));
  return states;
}

} // namespace

TEST_CASE("a walk that does not say where its base is goes where the walk that does goes", "[world_path]")
{
  for (const char* name : {"ck", "rk"})
  {
    CAPTURE(name);
    const Robot robot = load_robot(name);
    WorldPath given(robot), followed(robot);
    std::optional<double> offset;
    for (DesiredState state : walk(robot))
    {
      state.q.tail<2>().x() += 0.3;
      const auto expected = given.next(state);
      REQUIRE(expected);
      CHECK(expected->base == state.q.tail<2>());
      state.base_given = false;
      state.q.tail<2>().setConstant(NAN);
      const auto found = followed.next(state);
      REQUIRE(found);
      offset = offset.value_or(expected->base.x() - found->base.x());
      const Eigen::Vector2d shifted = found->base + Eigen::Vector2d(*offset, 0.0);
      CHECK(mismatch(shifted, expected->base, 1e-9) == ""); // the gait's own legs are solved to about that
    }
    CHECK(mismatch(*offset, 0.3, 1e-9) == ""); // the left foot starts at 0
  }
}

TEST_CASE("a robot that stands on a fixed root stays where it is", "[world_path]")
{
  const Robot robot = load_robot("six-link");
  DesiredState state{};
  state.q = state.v = state.a = VectorQ::Zero(robot.mechanism.num_q());
  state.support = {{Contact::sole, Contact::none}, Side::left, 0.0, 0.0};
  WorldPath path(robot);
  const auto before = path.next(state);
  state.q(0) = 0.2;
  const auto after = path.next(state);
  REQUIRE((before && after));
  CHECK(before->base == after->base);
}

TEST_CASE("flight that does not say where it is has no place", "[world_path]")
{
  const Robot robot = load_robot("ck");
  DesiredState state{};
  state.q = state.v = state.a = VectorQ::Zero(robot.mechanism.num_q());
  state.support = {{Contact::none, Contact::none}, Side::left, 0.0, 0.0};
  CHECK_FALSE(WorldPath(robot).next(state));
}

} // namespace world_path_test
