#include "catch.h"
#include "matchers.h"
#include "methods/torque_solution.h"
#include "states.h"

#include "robot/files/load.h"
#include "stance/checks.h"
#include "stance/contacts.h"

namespace contacts_test
{

using namespace torqued;

namespace
{

DesiredState standing(const Robot& robot, Contact left, Contact right)
{
  DesiredState desired{};
  desired.base_given = false;
  desired.support = {{left, right}, Side::right, 0.3, 0.0}; // two soles: the left foot places the base
  for (VectorQ* vector : {&desired.q, &desired.v, &desired.a})
    vector->setZero(robot.mechanism.num_q());
  return desired;
}

std::string refusal_of(const Robot& robot, const DesiredState& desired)
{
  const auto result = complete_motion(robot, desired);
  const Refusal* refusal = std::get_if<Refusal>(&result);
  if (!refusal)
    return "";
  CHECK(refusal->reason() == Reason::not_supported);
  return std::string(refusal->detail());
}

TorqueSolution solution_of(const Robot& robot, const DesiredState& desired)
{
  const auto equations = support_equations(robot, desired);
  REQUIRE(std::holds_alternative<SupportEquations>(equations));
  const auto solution =
      solve_torques(robot, std::get<SupportEquations>(equations), desired.support, Method::none, {}, 1e-3);
  REQUIRE(std::holds_alternative<TorqueSolution>(solution));
  return std::get<TorqueSolution>(solution);
}

} // namespace

TEST_CASE("a robot stands only on feet that it has, as they are", "[contacts]")
{
  constexpr Contact none = Contact::none, heel = Contact::heel, sole = Contact::sole, toe = Contact::toe;
  const Robot six = load_robot("six-link");
  CHECK(refusal_of(six, standing(six, sole, none)) == "");
  CHECK(refusal_of(six, standing(six, sole, heel)) == "");
  CHECK(refusal_of(six, standing(six, sole, sole)) == "");
  for (const Contact contact : {none, heel, toe})
    CHECK(refusal_of(six, standing(six, contact, sole)).find("is fixed to the world: it stands as SOLE (2)") !=
          std::string::npos);

  const Robot compass = load_robot("compass");
  CHECK(refusal_of(compass, standing(compass, sole, none)) == "");
  CHECK(refusal_of(compass, standing(compass, sole, toe)) ==
        "right_contact is 3, but compass has no foot there: it is NONE (0)");

  const Robot rabbit = load_robot("rabbit");
  CHECK(refusal_of(rabbit, standing(rabbit, toe, heel)) == "");
  CHECK(refusal_of(rabbit, standing(rabbit, toe, sole)) ==
        "right_contact is SOLE (2), but the right foot has no extent: it can stand as HEEL (1)");

  DesiredState given = standing(compass, sole, none);
  given.base_given = true;
  CHECK(refusal_of(compass, given) ==
        "base is GIVEN (1), but the root of compass is fixed to the world: it is FROM_CONTACT (0)");
  CHECK(refusal_of(rabbit, standing(rabbit, none, none)).find("in flight the base must be GIVEN (1)") !=
        std::string::npos);
}

TEST_CASE("six-link answers as ck does on its flat left foot, in single and in double support", "[contacts]")
{
  oracle::Random random(1);
  const Robot six = load_robot("six-link");
  const Robot ck = load_robot("ck");
  for (const Contact right : {Contact::none, Contact::heel, Contact::sole, Contact::toe})
    for (int i = 0; i < 250; ++i)
    {
      const State state = of_mechanism(six, random_state(random, six));
      DesiredState of_six = standing(six, Contact::sole, right);
      DesiredState of_ck = standing(ck, Contact::sole, right);
      of_six.q = state.q;
      of_six.v = state.v;
      of_six.a = state.a;
      const auto as_ck = [](const VectorQ& of)
      {
        VectorQ x(9);
        x << 0.0, of(0), of(1), of(3), of(4), of(5), of(2), 0.0, 0.0;
        return x;
      };
      of_ck.q = as_ck(state.q);
      of_ck.v = as_ck(state.v);
      of_ck.a = as_ck(state.a);
      const TorqueSolution found = solution_of(six, of_six);
      const TorqueSolution expected = solution_of(ck, of_ck);
      CAPTURE(i, static_cast<int>(right));
      CHECK(mismatch(found.torque, expected.torque, 1e-11) == "");
      CHECK(mismatch(found.w, expected.w, 1e-11) == "");
      const SupportEquations equations = std::get<SupportEquations>(support_equations(six, of_six));
      const double size = std::max(1.0, equations.r.cwiseAbs().maxCoeff());
      CHECK(dynamics_residual(six, equations, found) < 1e-10 * size);
    }
}

TEST_CASE("a fixed root rests, whatever the other foot does", "[contacts]")
{
  oracle::Random random(3);
  const Robot six = load_robot("six-link");
  for (const Contact right : {Contact::none, Contact::heel, Contact::sole, Contact::toe})
    for (const Side leading : kSides)
    {
      const State state = of_mechanism(six, random_state(random, six));
      DesiredState desired = standing(six, Contact::sole, right);
      desired.support.leading = leading;
      desired.q = state.q;
      desired.v = state.v;
      desired.a = state.a;
      const Motion motion = std::get<Motion>(complete_motion(six, desired));
      CHECK(motion.now.base == Eigen::Vector2d(0.0, 0.065)); // the ankle, its sole on the ground
      CHECK(motion.v.tail<3>().isZero(0.0));
      CHECK(motion.a.tail<3>().isZero(0.0));
    }
}

TEST_CASE("the ground holds a fixed root with the whole robot's force and moment", "[contacts]")
{
  oracle::Random random(2);
  for (const char* name : {"compass", "bip-itlag", "six-link"})
  {
    const Robot robot = load_robot(name);
    for (int i = 0; i < 300; ++i)
    {
      CAPTURE(name, i);
      const State state = of_mechanism(robot, random_state(random, robot));
      DesiredState desired = standing(robot, Contact::sole, Contact::none);
      desired.q = state.q;
      desired.v = state.v;
      desired.a = state.a;
      const TorqueSolution solution = solution_of(robot, desired);

      // Newton's and Euler's laws body by body, about the ankle, from second differences of where the bodies are; what
      // is parallel to the world does not turn
      Eigen::Vector3d needed = Eigen::Vector3d::Zero();
      const auto com = [&](const Link& link, double t)
      {
        const VectorQ q = state.q + t * state.v + 0.5 * t * t * state.a;
        const Kinematics now = kinematics(robot.mechanism, q, state.v);
        Point point = link.origin;
        Eigen::Vector2d p = from_base(now, point);
        return Eigen::Vector2d(p + rotate(heading(link, now), link.com));
      };
      for (const Link& link : robot.links)
      {
        constexpr double h = 1e-3;
        const Eigen::Vector2d acceleration = (-com(link, 2.0 * h) + 16.0 * com(link, h) - 30.0 * com(link, 0.0) +
                                              16.0 * com(link, -h) - com(link, -2.0 * h)) /
                                             (12.0 * h * h);
        const Eigen::Vector2d force = link.mass * (acceleration + Eigen::Vector2d(0.0, robot.mechanism.gravity()));
        const double turn = robot.mechanism.W().row(link.direction).dot(state.a.head(robot.mechanism.num_theta()));
        needed.head<2>() += force;
        needed(2) += link.inertia * turn + cross(com(link, 0.0), force);
      }
      // the ankle is the base point of all three; differences of fourth order, h = 1 ms
      const Wrench& ground = solution.ground[0];
      CHECK(mismatch(Eigen::Vector3d(ground.fx, ground.fz, ground.moment), needed, 1e-6) == "");
      CHECK(solution.ground[1].fz == 0.0);
      if (robot.name == std::string("compass")) // its foot has no mass: what the motor does to it, the ground bears
        CHECK(mismatch(ground.moment, solution.torque(0), 1e-11) == "");
    }
  }
}

TEST_CASE("a fixed root without extent does not tip", "[contacts]")
{
  const Robot compass = load_robot("compass");
  const FootPose pose{{0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}, {1.0, 0.0}};
  CHECK(contact_flags(compass, compass.foot(Side::left), pose, Contact::sole, {10.0, 200.0, 500.0}) == 0);
  CHECK(contact_flags(compass, compass.foot(Side::left), pose, Contact::sole, {150.0, 200.0, 500.0}) == flag::slips);
  const Robot itlag = load_robot("bip-itlag");
  CHECK(contact_flags(itlag, itlag.foot(Side::left), pose, Contact::sole, {10.0, 200.0, 500.0}) == flag::tips);
}

} // namespace contacts_test
