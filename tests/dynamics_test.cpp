#include "catch.h"
#include "matchers.h"
#include "oracles.h"

#include "planar/dynamics.h"
#include "robot/files/load.h"
#include "robot/files/toml_robot.h"

namespace dynamics_test
{

using namespace torqued;

namespace
{

constexpr int kStates = 1000;

Kinematics kinematics_of(const Robot& robot, const oracle::Motion& motion)
{
  return kinematics(robot.mechanism, motion.X, motion.V);
}

const Point& contact_point(const Foot& foot, Contact contact)
{
  return contact == Contact::heel ? foot.heel : contact == Contact::toe ? foot.toe : foot.ankle;
}

} // namespace

TEST_CASE("inverse dynamics equals the closed form of the seven-link biped", "[dynamics]")
{
  oracle::Random random(1);
  for (int i = 0; i < kStates; ++i)
  {
    CAPTURE(i);
    const oracle::Biped ck = oracle::random_ck(random);
    const Robot robot = ck.robot();
    const oracle::Motion motion = oracle::random_motion(random);
    const VectorQ r = inverse_dynamics(robot.mechanism, kinematics_of(robot, motion), motion.A);
    const oracle::Vector9 expected = ck.D(motion.X) * motion.A + ck.H(motion.X, motion.V) + ck.Q(motion.X);
    // both sum some 20 terms of like size: rounding only
    CHECK(mismatch(r, expected, 1e-12) == "");
  }
}

TEST_CASE("a body cut in two that ride on each other moves as one", "[dynamics]")
{
  // the trunk of ck, as a part that turns and a part fixed to it at an angle
  oracle::Random random(2);
  const std::string whole(shipped_robot_toml("ck"));
  const std::string trunk = "mass = 29.2\ncom = [0.0, 0.19]\ninertia = 0.81\n";
  REQUIRE(whole.find(trunk) != std::string::npos);

  // two masses whose common centre and inertia are the trunk's: 10 kg at (0.06, 0.3) and 19.2 kg where it must be
  const double m_a = 10.0;
  const double m_b = 29.2 - m_a;
  const Eigen::Vector2d com(0.0, 0.19);
  const Eigen::Vector2d c_a(0.06, 0.3);
  const Eigen::Vector2d c_b = (29.2 * com - m_a * c_a) / m_b;
  const double I_b = 0.81 - 0.1 - m_a * (c_a - com).squaredNorm() - m_b * (c_b - com).squaredNorm();
  REQUIRE(I_b > 0.0);
  const double angle = 0.7;
  const Eigen::Vector2d at(0.02, -0.05);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const Eigen::Vector2d local(c * (c_b - at).x() + s * (c_b - at).y(), c * (c_b - at).y() - s * (c_b - at).x());

  std::string cut = whole;
  cut.replace(cut.find(trunk), trunk.size(),
              fmt::format("mass = {}\ncom = [{}, {}]\ninertia = 0.1\n", m_a, c_a.x(), c_a.y()));
  cut += fmt::format("\n[[link]]\nname = \"pack\"\njoint = \"fixed\"\nparent = \"trunk\"\nat = [{}, {}]\nangle = {}\n"
                     "mass = {}\ncom = [{}, {}]\ninertia = {}\n",
                     at.x(), at.y(), angle, m_b, local.x(), local.y(), I_b);
  const Robot one = read_toml_robot(whole, "ck.toml");
  const Robot two = read_toml_robot(cut, "cut.toml");
  REQUIRE(two.num_coordinates() == one.num_coordinates());
  for (int i = 0; i < 100; ++i)
  {
    const oracle::Motion motion = oracle::random_motion(random);
    CHECK(mismatch(inverse_dynamics(two.mechanism, kinematics_of(two, motion), motion.A),
                   inverse_dynamics(one.mechanism, kinematics_of(one, motion), motion.A), 1e-12) == "");
  }
}

TEST_CASE("contact points, J and J̇ v equal their closed forms", "[dynamics]")
{
  oracle::Random random(3);
  for (int i = 0; i < 300; ++i)
  {
    const oracle::Biped ck = oracle::random_ck(random);
    const Robot robot = ck.robot();
    const oracle::Motion motion = oracle::random_motion(random);
    const Kinematics now = kinematics_of(robot, motion);
    for (const Side side : kSides)
      for (const Contact contact : {Contact::heel, Contact::sole, Contact::toe})
      {
        CAPTURE(i, name_of(side), name_of(contact));
        const Point& point = contact_point(robot.foot(side), contact);
        Jacobian J(2, 9);
        point_jacobian(robot.mechanism, now, point, 0, J);
        CHECK(mismatch(position(now, point), ck.contact_point(side, contact, motion.X), 1e-14) == "");
        CHECK(mismatch(J, ck.J(side, contact, motion.X).topRows(2), 1e-14) == "");
        CHECK(mismatch(jacobian_rate_times_v(now, point), ck.Jdot_V(side, contact, motion.X, motion.V).head(2),
                       1e-14) == "");
      }
  }
}

TEST_CASE("a point's velocity and acceleration are the time derivatives of its position", "[dynamics]")
{
  oracle::Random random(4);
  const Robot robot = load_robot("human-subject01");
  const double h = 1e-4;
  for (int i = 0; i < 100; ++i)
  {
    const oracle::Motion motion = oracle::random_motion(random);
    const auto at = [&](double t)
    {
      const VectorQ q = motion.X + t * motion.V + 0.5 * t * t * motion.A;
      return position(kinematics(robot.mechanism, q, motion.V), robot.foot(Side::right).toe);
    };
    const Kinematics now = kinematics_of(robot, motion);
    Jacobian J(2, 9);
    point_jacobian(robot.mechanism, now, robot.foot(Side::right).toe, 0, J);
    const Eigen::Vector2d velocity = J * motion.V;
    const Eigen::Vector2d acceleration = J * motion.A + jacobian_rate_times_v(now, robot.foot(Side::right).toe);
    // central differences: errors h²/6 × third derivative (some 10³ m/s³) and h²/12 × fourth (some 10⁴ m/s⁴)
    CHECK(mismatch((at(h) - at(-h)) / (2.0 * h), velocity, 1e-5) == "");
    CHECK(mismatch((at(h) - 2.0 * at(0.0) + at(-h)) / (h * h), acceleration, 1e-5) == "");
  }
}

} // namespace dynamics_test
