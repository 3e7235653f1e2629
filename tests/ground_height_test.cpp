#include "catch.h"
#include "matchers.h"
#include "methods/constrained.h"
#include "methods/linear_transition.h"
#include "methods/method.h"
#include "oracles.h"
#include "states.h"

#include "answer/answer.h"
#include "motion/files.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"
#include "stance/projection.h"

#include <memory>
#include <string>

namespace ground_height_test
{

using namespace torqued;

// Where the ground is: no torque depends on the world's zero, and a contact that carries lies on z = 0.

namespace
{

constexpr Contact kLoaded[] = {Contact::heel, Contact::sole, Contact::toe};

std::variant<Answer, std::string> answer_of(const Robot& robot, const AnswerSettings& settings,
                                            const DesiredState& desired)
{
  StreamMemory memory;
  const Result<Answer> result = answer(robot, settings, desired, memory);
  if (const Refusal* refusal = std::get_if<Refusal>(&result))
    return std::string(refusal->detail());
  return std::get<Answer>(result);
}

// upright on both soles, at rest, the base given
DesiredState standing(const Robot& robot)
{
  DesiredState desired{};
  desired.base_given = true;
  desired.support = {{Contact::sole, Contact::sole}, Side::left, 0.5, 0.5};
  desired.q = desired.v = desired.a = VectorQ::Zero(robot.mechanism.num_q());
  desired.q(robot.mechanism.num_q() - 1) = robot.leg_length + robot.foot(Side::left).ankle_height();
  return desired;
}

// flags by default; "" or the sentence with consistency = "refuse"
struct Found
{
  std::int32_t flags;
  std::string refused;
};
Found consistency(const Robot& robot, const DesiredState& desired, AnswerSettings settings = {})
{
  const auto flagged = answer_of(robot, settings, desired);
  REQUIRE(std::holds_alternative<Answer>(flagged));
  settings.consistency = OnExcess::refuse;
  const auto refused = answer_of(robot, settings, desired);
  return {std::get<Answer>(flagged).flags & (flag::inconsistent | flag::contact_acceleration),
          std::holds_alternative<Answer>(refused) ? "" : std::get<std::string>(refused)};
}

void check_on_ground(const Robot& robot, const DesiredState& desired, const AnswerSettings& settings = {})
{
  const Found found = consistency(robot, desired, settings);
  CHECK(found.flags == 0);
  CHECK(found.refused == "");
}

void check_off_ground(const Robot& robot, const DesiredState& desired, const std::string& sentence,
                      const AnswerSettings& settings = {})
{
  const Found found = consistency(robot, desired, settings);
  CHECK(found.flags == flag::inconsistent);
  CHECK(found.refused == sentence);
}

} // namespace

TEST_CASE("no method's torques depend on where the world's zero is; the zero-moment point stays on the ground",
          "[ground_height][slow]")
{
  AnswerSettings plain, other;
  other.methods.of<LinearTransition>().leading_cop = 0.3;
  other.methods.of<Constrained>().reference_weight = 1.0;
  other.methods.of<Constrained>().windows = false;
  oracle::Random random(901);
  int answered = 0, loaded = 0;
  for (const char* name : {"ck", "rk", "human-subject01"})
  {
    const Robot robot = load_robot(name);
    for (const Contact left : kLoaded)
      for (const Contact right : kLoaded)
        for (int i = 0; i < kStates / 4; ++i)
        {
          CAPTURE(name, name_of(left), name_of(right), i);
          const Support contacts{{left, right},
                                 i % 2 == 0 ? Side::left : Side::right,
                                 oracle::uniform(random, 0.0, 1.0),
                                 oracle::uniform(random, 0.0, 1.0)};
          DesiredState desired = desired_of(robot, random_state(random, robot), contacts);
          for (const MethodRow& known : methods())
            for (const AnswerSettings* settings : {&plain, &other})
            {
              CAPTURE(known.name);
              desired.method = known.method;
              const auto here = answer_of(robot, *settings, desired);
              for (const double up : {-0.85, 0.1, 10.0})
              {
                CAPTURE(up);
                DesiredState moved = desired;
                moved.q(robot.mechanism.num_q() - 1) += up;
                const auto there = answer_of(robot, *settings, moved);
                REQUIRE(here.index() == there.index());
                const Answer* a = std::get_if<Answer>(&here);
                if (!a)
                  continue;
                const Answer& b = std::get<Answer>(there);
                ++answered;
                // rounding of 10 m grows with the reactions; near a zero lever, with one over it
                const double largest = std::max({a->ground[0].wrench.fz, a->ground[1].wrench.fz, robot.weight(),
                                                 -a->ground[0].wrench.fz, -a->ground[1].wrench.fz});
                CHECK((a->torque - b.torque).cwiseAbs().maxCoeff() < 1e-9 * largest / robot.weight());
                // height is INCONSISTENT's; relaxed torques end within rounding of OVER_TORQUE's bound
                constexpr std::int32_t aside = flag::inconsistent | flag::over_torque;
                CHECK((a->flags | aside) == (b.flags | aside));
                const double F_x = a->ground[0].wrench.fx + a->ground[1].wrench.fx;
                const double F_z = a->ground[0].wrench.fz + a->ground[1].wrench.fz;
                if (std::abs(F_z) <= 0.01 * robot.weight())
                  continue;
                ++loaded;
                CHECK(std::abs(b.zmp - (a->zmp - up * F_x / F_z)) < 1e-8 * (1.0 + std::abs(F_x / F_z)));
              }
            }
        }
  }
  CHECK(answered > 1000);
  CHECK(loaded > answered / 2);
}

TEST_CASE("on two soles no method's answer depends on phase, and on a sole and a point three do", "[ground_height]")
{
  oracle::Random random(902);
  const Robot robot = load_robot("ck");
  std::vector<int> follows(methods().size());
  for (int i = 0; i < kStates; ++i)
    for (std::size_t k = 0; k < methods().size(); ++k)
    {
      const MethodRow& known = methods()[k];
      CAPTURE(i, known.name);
      DesiredState desired = standing(robot);
      desired.q.head<7>() += 0.2 * random_state(random, 7).q;
      desired.support.load_transfer = oracle::uniform(random, 0.0, 1.0);
      desired.method = known.method;
      const auto torque = [&](double phase)
      {
        desired.support.phase = phase;
        return std::get<Answer>(answer_of(robot, {}, desired)).torque;
      };
      CHECK(torque(0.0) == torque(1.0));
      CHECK(torque(0.0) == torque(0.4));

      desired.support.contact[1] = Contact::heel;
      follows[k] += torque(0.0) != torque(0.4) ? 1 : 0;
    }
  for (std::size_t k = 0; k < methods().size(); ++k)
  {
    CAPTURE(methods()[k].name, follows[k]);
    const Method method = methods()[k].method;
    if (method == Method::zmp_transition || method == Method::constrained || method == Method::human_transition)
      CHECK(follows[k] > kStates / 2);
    else
      CHECK(follows[k] == 0);
  }
}

TEST_CASE("a contact that carries and is above or below the ground is flagged, or refused with foot, height and bound",
          "[ground_height]")
{
  const Robot robot = load_robot("ck");
  const int z = robot.mechanism.num_q() - 1;
  DesiredState desired = standing(robot);
  const auto raised = [&](double by)
  {
    DesiredState moved = desired;
    moved.q(z) += by;
    return moved;
  };
  for (const Contact left : {Contact::none, Contact::heel, Contact::sole, Contact::toe})
    for (const Contact right : {Contact::none, Contact::heel, Contact::sole, Contact::toe})
    {
      desired.support.contact = {left, right};
      // a heel or toe alone would need a motion that falls over it, as would two at one place
      AnswerSettings settings;
      settings.residual_tolerance = 1e3;
      if (desired.support.wrench_components() == 0)
        continue;
      CAPTURE(name_of(left), name_of(right));
      for (const double height : {0.0, 0.029, -0.029})
        check_on_ground(robot, raised(height), settings);
      const std::string who = left != Contact::none ? "the left foot's " + std::string(name_of(left))
                                                    : "the right foot's " + std::string(name_of(right));
      check_off_ground(robot, raised(0.031),
                       who + " carries, and is 0.031 m above the ground z = 0, more than contact_height_tolerance, "
                             "0.03 m",
                       settings);
      check_off_ground(robot, raised(-0.031),
                       who + " carries, and is 0.031 m below the ground z = 0, more than contact_height_tolerance, "
                             "0.03 m",
                       settings);
      CHECK(consistency(robot, raised(10.0), settings).flags == flag::inconsistent);
      CHECK(consistency(robot, raised(-desired.q(z)), settings).flags == flag::inconsistent);
      settings.contact_height_tolerance = 0.5;
      check_on_ground(robot, raised(0.4), settings);
      settings.contact_height_tolerance = 0.0;
      check_off_ground(robot, raised(0.001),
                       who + " carries, and is 0.001 m above the ground z = 0, more than contact_height_tolerance, 0 m",
                       settings);
    }
}

TEST_CASE("of two feet the one farther off counts, and where a foot places the base, the other one", "[ground_height]")
{
  const Robot robot = load_robot("ck");
  const double leg = robot.leg_length;
  for (const bool given : {true, false})
    for (const Side side : kSides)
      for (const Contact contact : kLoaded)
      {
        CAPTURE(given, name_of(side), name_of(contact));
        // a bent knee under a hip of constant height lifts this foot
        const auto lifted = [&](double by)
        {
          DesiredState desired = standing(robot);
          desired.base_given = given;
          desired.support.contact[static_cast<std::size_t>(side)] = contact;
          desired.support.leading = side; // the other one rests
          const double bend = std::acos(1.0 - by / leg);
          desired.q(side == Side::left ? 1 : 4) = -bend;
          desired.q(side == Side::left ? 2 : 3) = bend;
          return desired;
        };
        check_on_ground(robot, lifted(0.029));
        check_off_ground(robot, lifted(0.031),
                         fmt::format("the {} foot's {} carries, and is 0.031 m above the ground z = 0, more than "
                                     "contact_height_tolerance, 0.03 m",
                                     name_of(side), name_of(contact)));
        CHECK(consistency(robot, lifted(0.28)).flags == flag::inconsistent);
      }
}

TEST_CASE("a sole is as high as its nearest point, and 0 where it crosses the ground", "[ground_height]")
{
  const FootPose pose{{0.0, 0.1}, {-0.1, 0.05}, {0.2, 0.02}, {1.0, 0.0}};
  CHECK(pose.height(Contact::sole) == 0.02);
  CHECK(pose.height(Contact::heel) == 0.05);
  CHECK(pose.height(Contact::toe) == 0.02);
  FootPose below = pose, across = pose;
  below.heel.y() = -0.04;
  below.toe.y() = -0.07;
  CHECK(below.height(Contact::sole) == -0.04);
  across.toe.y() = -0.01;
  CHECK(across.height(Contact::sole) == 0.0);
  CHECK(across.height(Contact::toe) == -0.01);
}

TEST_CASE("in flight no contact carries, at any height", "[ground_height]")
{
  const Robot robot = load_robot("ck");
  DesiredState desired = standing(robot);
  desired.support.contact = {Contact::none, Contact::none};
  desired.a(robot.mechanism.num_q() - 1) = -robot.mechanism.gravity();
  for (const double height : {0.0, 0.5, 10.0})
  {
    desired.q(robot.mechanism.num_q() - 1) = height;
    check_on_ground(robot, desired);
  }
}

TEST_CASE("a foot that is fixed to the world is on the ground, and the other one is seen from there", "[ground_height]")
{
  oracle::Random random(903);
  for (const char* name : {"compass", "bip-itlag", "six-link"})
  {
    const Robot robot = load_robot(name);
    for (int i = 0; i < 20; ++i)
    {
      CAPTURE(name, i);
      const DesiredState desired =
          desired_of(robot, random_state(random, robot), support(robot, Contact::none, Contact::none));
      const auto equations = std::get<SupportEquations>(support_equations(robot, desired));
      CHECK(std::abs(equations.contact_height) < 1e-12);
    }
  }
  const Robot robot = load_robot("six-link");
  DesiredState desired =
      desired_of(robot, {Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6)},
                 support(robot, Contact::none, Contact::sole));
  check_on_ground(robot, desired);
  const Link& shin = robot.link(robot.link(robot.foot(Side::right).link).parent);
  desired.q(shin.coordinate) = -0.6;
  const Found found = consistency(robot, desired);
  CHECK((found.flags & flag::inconsistent) != 0);
  CHECK(found.refused.starts_with("the right foot's sole carries, and is 0.0"));
}

TEST_CASE("points for feet have the height of their points", "[ground_height]")
{
  const Robot robot = load_robot("rabbit");
  DesiredState desired = standing(robot);
  desired.support.contact = {Contact::heel, Contact::toe};
  AnswerSettings settings;
  settings.residual_tolerance = 1e3; // both are at one place
  check_on_ground(robot, desired, settings);
  desired.q(robot.mechanism.num_q() - 1) += 0.1;
  check_off_ground(robot, desired,
                   "the left foot's heel carries, and is 0.1 m above the ground z = 0, more than "
                   "contact_height_tolerance, 0.03 m",
                   settings);
}

TEST_CASE("a projected motion is judged by where its contacts were before", "[ground_height]")
{
  const Robot robot = load_robot("ck");
  AnswerSettings settings;
  settings.project = true;
  DesiredState desired = standing(robot);
  // knees a little bent, so that both feet can come down or up
  desired.q.head<7>() << 0.0, -0.2, 0.2, 0.2, -0.2, 0.0, 0.0;
  const double crouched = robot.foot(Side::left).ankle_height() + robot.leg_length * std::cos(0.2);
  for (const double up : {-0.035, -0.02, 0.0, 0.02, 0.035})
  {
    CAPTURE(up);
    desired.q(robot.mechanism.num_q() - 1) = crouched + up;
    const auto projected = project(robot, desired);
    REQUIRE(std::holds_alternative<Projection>(projected));
    CHECK_THAT(std::get<Projection>(projected).before.height, Catch::Matchers::WithinAbs(up, 1e-12));
    const Found found = consistency(robot, desired, settings);
    CHECK((found.flags == flag::inconsistent) == (std::abs(up) > 0.03));
    CHECK(found.refused.empty() == (std::abs(up) < 0.03));
  }
}

TEST_CASE("measured soles lie a little under the ground, and are not told to be off it", "[ground_height]")
{
  const Robot robot = load_robot("human-subject01");
  const std::string file = TRAJECTORIES "/subject01-walk/walk.csv";
  const DesiredMessages walk =
      read_messages(std::make_shared<const InputFile>(file), file, coordinate_names(robot), {}, Channels());
  AnswerSettings settings;
  settings.contact_speed_tolerance = settings.contact_tolerance = settings.sole_tilt_tolerance = 1e9;
  int below = 0;
  for (const Bytes message : walk.messages)
  {
    const DesiredState state = std::get<DesiredState>(decode_desired_state(message, robot));
    check_on_ground(robot, state, settings);
    below += std::get<SupportEquations>(support_equations(robot, state)).contact_height < -1e-3 ? 1 : 0;
  }
  CHECK(below > 100);
}

} // namespace ground_height_test
