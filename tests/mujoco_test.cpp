// Every robot once more, told to MuJoCo link by link: an engine in three dimensions that shares nothing with ours.

#include "catch.h"
#include "matchers.h"
#include "mujoco_model.h"
#include "states.h"

#include "robot/files/load.h"
#include "stance/support_equations.h"

namespace mujoco_test
{

using namespace torqued;

namespace
{

// Both sum the same terms in another order, and MuJoCo turns 3 × 3 inertias about the robot's centre of mass: rounding,
// and the least masses and inertias that it takes, 1e-12 of 1.
constexpr double kTolerance = 1e-9;

struct Named
{
  std::string name;
  Robot robot;
  int states;
};

std::vector<Named> robots()
{
  std::vector<Named> result;
  for (const std::string_view name : shipped_robot_names())
    result.push_back({std::string(name), load_robot(std::string(name)), kStates});
  oracle::Random random(300);
  for (int i = 0; i < 4; ++i)
  {
    result.push_back({"random ck", oracle::random_ck(random).robot(), kStates / 4});
    result.push_back({"random rk", oracle::random_rk(random).robot(), kStates / 4});
    result.push_back({"random six-link with rolling knees",
                      oracle::SixLink{oracle::random_rk(random), Side::right}.robot(), kStates / 4});
  }
  for (int i = 0; i < 20; ++i)
    result.push_back({fmt::format("tree {}", i), oracle::random_tree(random, i % 2 == 0), kStates / 20});
  return result;
}

template <typename Check> void for_all(const Check& check)
{
  oracle::Random random(301);
  for (const auto& [name, robot, states] : robots())
  {
    CAPTURE(name);
    MujocoModel model(robot, {.feet = true});
    for (int i = 0; i < states; ++i)
    {
      CAPTURE(i);
      check(robot, model, random_state(random, robot));
    }
  }
}

} // namespace

TEST_CASE("MuJoCo moves every robot as we do", "[mujoco]")
{
  for_all(
      [](const Robot& robot, MujocoModel& model, const State& state)
      {
        const Support contacts = support(robot, Contact::none, Contact::none);
        const EquationOfMotion ours =
            equation_of_motion(robot, motion_of(robot, state, contacts), contacts, Coordinates::absolute);
        const Eigen::VectorXd zero = Eigen::VectorXd::Zero(state.v.size());
        model.inverse(model.tree().motion(state.q, zero, zero));
        CHECK(mismatch(ours.g, model.ours(model.data().qfrc_bias), kTolerance) == "");
        model.inverse(model.tree().motion(state.q, state.v, state.a));
        CHECK(mismatch(ours.M, model.mass_matrix(), kTolerance) == "");
        CHECK(mismatch(ours.C * state.v + ours.g, model.ours(model.data().qfrc_bias), kTolerance) == "");
        CHECK(mismatch(ours.h + ours.g, model.ours(model.data().qfrc_bias), kTolerance) == "");
        CHECK(mismatch(ours.generalized_force, model.ours(model.data().qfrc_inverse), kTolerance) == "");
      });
}

TEST_CASE("MuJoCo has every foot where we have it, and moves it alike", "[mujoco]")
{
  int held = 0;
  for_all(
      [&held](const Robot& robot, MujocoModel& model, const State& state)
      {
        model.inverse(model.tree().motion(state.q, state.v, state.a));
        mj_rnePostConstraint(&model.model(), &model.data());
        for (const Side side : kSides)
          for (const auto& [contact, name] :
               {std::pair(Contact::sole, "ankle"), std::pair(Contact::heel, "heel"), std::pair(Contact::toe, "toe")})
          {
            const Foot& foot = robot.foot(side);
            if (!foot.exists() || robot.is_root(foot) || (contact == Contact::sole && !foot.has_extent()))
              continue;
            ++held;
            CAPTURE(name_of(side), name);
            const Support contacts = support(robot, side == Side::left ? contact : Contact::none,
                                             side == Side::right ? contact : Contact::none);
            const Motion motion = motion_of(robot, state, contacts);
            const EquationOfMotion ours = equation_of_motion(robot, motion, contacts, Coordinates::absolute);

            const int site = model.id(mjOBJ_SITE, fmt::format("{}_{}", name_of(side), name));
            REQUIRE(site >= 0);
            const mjtNum* p = model.data().site_xpos + 3 * site;
            Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> moving(3, model.model().nv);
            Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> turning(3, model.model().nv);
            mj_jac(&model.model(), &model.data(), moving.data(), turning.data(), p,
                   model.id(mjOBJ_BODY, robot.link(foot.link).name));
            Eigen::MatrixXd J(ours.J.rows(), moving.cols());
            J.row(0) = moving.row(0);
            J.row(1) = moving.row(2);
            if (contact == Contact::sole)
              J.row(2) = -turning.row(1);
            CHECK(mismatch(ours.J, J * model.tree().T, kTolerance) == "");

            // of a fixed root, MuJoCo's world is at its frame and ours below its sole
            const Eigen::Vector2d origin = robot.fixed_root() ? motion.now.base : Eigen::Vector2d::Zero();
            CHECK(mismatch(position(motion.now, contact_point(foot, contact)) - origin, Eigen::Vector2d(p[0], p[2]),
                           kTolerance) == "");

            // turn and travel of the site; MuJoCo lifts the world by gravity
            mjtNum acceleration[6];
            mj_objectAcceleration(&model.model(), &model.data(), mjOBJ_SITE, site, acceleration, 0);
            const Eigen::VectorXd needed = ours.J * state.a + ours.Jdot_v;
            CHECK(mismatch(needed.head<2>(),
                           Eigen::Vector2d(acceleration[3], acceleration[5] - robot.mechanism.gravity()),
                           kTolerance) == "");
            if (contact == Contact::sole)
              CHECK(mismatch(needed(2), -acceleration[1], kTolerance) == "");
          }
      });
  CHECK(held > 5 * kStates); // at both feet of two robots, and more
}

TEST_CASE("MuJoCo's armature is our rotor inertia", "[mujoco]")
{
  const Robot robot = load_robot("rabbit");
  REQUIRE(robot.actuators[0].rotor_inertia > 0.0);
  MujocoModel model(robot, {.rotors = true});
  oracle::Random random(302);
  for (int i = 0; i < kStates; ++i)
  {
    CAPTURE(i);
    const State state = random_state(random, robot);
    model.inverse(model.tree().motion(state.q, state.v, state.a));
    const auto equations =
        support_equations(robot, desired_of(robot, state, support(robot, Contact::none, Contact::none)));
    CHECK(mismatch(std::get<SupportEquations>(equations).r, model.ours(model.data().qfrc_inverse), kTolerance) == "");
  }
}

} // namespace mujoco_test
