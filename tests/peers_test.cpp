// Other engines compute what we do, so that their times compare with ours.

#include "catch.h"
#include "matchers.h"
#include "states.h"

#include "bench/peers.h"
#include "planar/dynamics.h"
#include "robot/files/load.h"

#include <array>

namespace peers_test
{

using namespace torqued;

namespace
{

// All sum the same terms in another order: rounding, and the least masses and inertias that they take, 1e-12 of 1.
constexpr double kTolerance = 1e-9;

constexpr std::array kEngines{bench::make_mujoco, bench::make_dart, bench::make_kdl};

} // namespace

TEST_CASE("Every engine gives the generalized force that we give", "[peers]")
{
  oracle::Random random(310);
  int robots = 0;
  for (const Robot& robot : all_kinds_of_robots())
  {
    if (robot.fixed_root())
      continue;
    ++robots;
    CAPTURE(robot.name);
    for (const auto& make : kEngines)
    {
      const std::unique_ptr<bench::Peer> peer = make(robot);
      CAPTURE(peer->name());
      std::vector<VectorQ> ours;
      for (int i = 0; i < kStates / 10; ++i)
      {
        const State state = random_state(random, robot);
        ours.push_back(inverse_dynamics(robot.mechanism, kinematics(robot.mechanism, state.q, state.v), state.a));
        REQUIRE(peer->remember(state.q, state.v, state.a) == i);
      }
      for (std::size_t i = 0; i < ours.size(); ++i)
      {
        CAPTURE(i);
        peer->compute(static_cast<int>(i));
        CHECK(mismatch(peer->generalized_force(), ours[i], kTolerance) == "");
      }
    }
  }
  CHECK(robots >= 4); // ck, rk, human-subject01, rabbit
}

TEST_CASE("No engine is told of a robot with a fixed root", "[peers]")
{
  const Robot robot = load_robot("bip-itlag");
  REQUIRE(robot.fixed_root());
  for (const auto& make : kEngines)
    CHECK_THROWS_WITH(make(robot), Catch::Matchers::StartsWith("bip-itlag has a fixed root"));
}

} // namespace peers_test
