#include "catch.h"
#include "matchers.h"
#include "states.h"

#include "bus/model_robot.h"
#include "motion/failure.h"
#include "planar/kinematics.h"
#include "robot/files/load.h"
#include "robot/files/strict_toml.h"
#include "wire/codec.h"

#include <cmath>

namespace model_robot_test
{

using namespace torqued;

namespace
{

model_info_t model_of(Robot robot)
{
  robot.name = "r"; // the robots made up here have names for people
  return model_info(robot, 0, 0, "");
}

std::string complaint(const model_info_t& model)
{
  try
  {
    robot_of_model(model, "walk.lcm");
    return "";
  }
  catch (const Failure& failure)
  {
    CHECK(failure.code() == ExitCode::bad_data);
    return failure.what();
  }
}

} // namespace

TEST_CASE("a model message draws the robot: every link and foot is where the robot itself has it", "[model_robot]")
{
  oracle::Random random(2501);
  for (const Robot& robot : all_kinds_of_robots())
  {
    CAPTURE(robot.name);
    const model_info_t model = model_of(robot);
    const Robot drawn = robot_of_model(model, "walk.lcm");
    CHECK(drawn.model_id == robot.model_id);
    CHECK(drawn.absolute_names == robot.absolute_names);
    CHECK(drawn.relative_names == robot.relative_names);
    CHECK(drawn.base_names == robot.base_names);
    CHECK(drawn.A == robot.A);
    CHECK(drawn.b.head(robot.num_coordinates()) == robot.b.head(robot.num_coordinates()));
    CHECK(drawn.leg == robot.leg);
    CHECK(mismatch(drawn.weight(), robot.weight(), 1e-12) == "");
    if (!robot.fixed_root() && robot.foot(Side::left).exists())
      CHECK(drawn.leg_length == robot.leg_length);
    REQUIRE(drawn.num_joints() == robot.num_joints());
    for (std::size_t i = 0; i < robot.actuators.size(); ++i)
    {
      const Actuator &found = drawn.actuators[i], &expected = robot.actuators[i];
      CHECK(found.name == expected.name);
      CHECK(found.torque_limit == expected.torque_limit);
      CHECK(found.rate_limit == expected.rate_limit);
      // where it rolls, the message does not say between which bodies
      CHECK((std::isnan(found.kappa) || found.kappa == expected.kappa));
    }
    for (int sample = 0; sample < 3; ++sample)
    {
      const State state = of_mechanism(robot, random_state(random, robot));
      const Kinematics expected = kinematics(robot.mechanism, state.q, state.v);
      const Kinematics found = kinematics(drawn.mechanism, state.q, state.v);
      for (std::size_t i = 0; i < robot.links.size(); ++i)
      {
        CHECK(position(found, drawn.links[i].origin) == position(expected, robot.links[i].origin));
        CHECK(heading(drawn.links[i], found) == heading(robot.links[i], expected));
      }
      for (const Side side : kSides)
        if (const Foot& foot = robot.foot(side), &other = drawn.foot(side); foot.exists())
        {
          CHECK(other.friction == foot.friction);
          CHECK(position(found, other.ankle) == position(expected, foot.ankle));
          CHECK(position(found, other.heel) == position(expected, foot.heel));
          CHECK(position(found, other.toe) == position(expected, foot.toe));
        }
    }
    // said again, it is the same message
    model_info_t again = model_of(drawn);
    CHECK(again.num_segments == model.num_segments);
    CHECK(again.segment_from == model.segment_from);
    CHECK(again.link_names == model.link_names);
    CHECK(again.link_coordinates == model.link_coordinates);
  }
}

TEST_CASE("a motor of a rolling joint has no work where only a message tells of it", "[model_robot]")
{
  const Robot drawn = robot_of_model(model_of(load_robot("rk")), "walk.lcm");
  for (const Actuator& actuator : drawn.actuators)
  {
    CAPTURE(actuator.name);
    CHECK(std::isnan(actuator.kappa) == (actuator.name.find("knee") != std::string::npos));
  }
}

TEST_CASE("a model message that describes no robot is refused in one sentence", "[model_robot]")
{
  const model_info_t good = model_of(load_robot("ck"));
  const std::string begin =
      fmt::format("walk.lcm: its model message (model_id {}) describes no robot: ", good.model_id);
  CHECK(complaint(good) == "");
  const auto refused = [&](auto change)
  {
    model_info_t bad = good;
    change(bad);
    const std::string text = complaint(bad);
    CHECK(text.starts_with(begin));
    return text.substr(std::min(begin.size(), text.size()));
  };
  CHECK(refused([](model_info_t& m) { m.name = "\x1b[2J"; }) == "the robot's name is \"?[2J\"");
  CHECK(refused([](model_info_t& m) { m.link_names[3] = "</script>"; }) == "a link's name is \"</script>\"");
  CHECK(refused([](model_info_t& m) { m.parents[2] = 99; }) == "a link's parent is number 99 of 7");
  CHECK(refused([](model_info_t& m) { m.joint_kinds[2] = 17; }) == "a link's joint kind is number 17 of 6");
  CHECK(refused([](model_info_t& m) { m.link_coordinates[2] = 7; }) == "a link's coordinate is number 7 of 7");
  CHECK(refused([](model_info_t& m) { m.segment_links[0] = -1; }) == "a segment's link is number -1 of 7");
  CHECK(refused([](model_info_t& m) { m.foot_links[1] = 7; }) == "a foot's link is number 7 of 7");
  CHECK(refused([](model_info_t& m) { m.foot_sides[1] = 2; }) == "a foot's side is number 2 of 2");
  CHECK(refused([](model_info_t& m) { m.A[1][2] = 0.5; }) == "its coordinates do not follow from its links and joints");
  CHECK(refused([](model_info_t& m) { m.relative_names.back() = "elsewhere"; }) != "");
  CHECK(refused([](model_info_t& m) { m.total_mass = 0.0; }) != "");
  CHECK(refused([](model_info_t& m) { m.total_mass = NAN; }) != "");
  CHECK(refused([](model_info_t& m) { m.gravity = -1.0; }) != "");
  CHECK(refused([](model_info_t& m) { m.joint_positions[2][0] = NAN; }) != "");
  CHECK(refused([](model_info_t& m) { m.parents[2] = -1; }) != ""); // a shin, which does not float
  CHECK(refused(
            [](model_info_t& m)
            {
              m.link_names.clear();
              m.parents.clear();
            }) != "");
}

} // namespace model_robot_test
