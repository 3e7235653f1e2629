#include "catch.h"
#include "decompositions.h"
#include "matchers.h"
#include "states.h"

#include "planar/dynamics.h"
#include "stance/joint_friction.h"
#include "stance/support_equations.h"

#include <Eigen/Geometry>

namespace laws_test
{

using namespace torqued;

namespace
{

constexpr double kRounding = 1e-12; // of some 20 terms of like size

const std::vector<Robot>& robots()
{
  static const std::vector<Robot> all = all_kinds_of_robots();
  return all;
}

// some states of each robot, the same ones whatever else is computed
template <typename Check> void for_all(int states, const Check& check)
{
  for (const Robot& robot : robots())
  {
    CAPTURE(robot.name);
    oracle::Random random(201);
    for (int i = 0; i < states; ++i)
    {
      CAPTURE(i);
      check(robot, random_state(random, robot), random);
    }
  }
}

MatrixQ mass_matrix_at(const Robot& robot, const VectorQ& q)
{
  return mass_matrix(robot.mechanism, kinematics(robot.mechanism, q, q));
}

double potential_energy_at(const Robot& robot, const VectorQ& q)
{
  return potential_energy(robot.mechanism, kinematics(robot.mechanism, q, q));
}

// all coordinates of the mechanism move, those of a fixed root, too
State random_mechanism_state(oracle::Random& random, const Robot& robot)
{
  return random_state(random, robot.mechanism.num_q());
}

// of vᵀ f: its terms may cancel
double size(const Eigen::VectorXd& v, const Eigen::VectorXd& f)
{
  return std::max(1.0, v.cwiseProduct(f).cwiseAbs().sum());
}

constexpr Coordinates kBoth[] = {Coordinates::absolute, Coordinates::relative};

// v in the rows of EquationOfMotion: relative ones from the robot's own A
Eigen::VectorXd in(Coordinates coordinates, const Robot& robot, const Eigen::VectorXd& v)
{
  if (coordinates == Coordinates::absolute)
    return v;
  Eigen::VectorXd result = v;
  const int n = robot.num_coordinates();
  result.head(n) = robot.A.topLeftCorner(n, n) * v.head(n);
  return result;
}

// where a link's frame is and how it moves, told link by link from the root
struct Moving
{
  Eigen::Vector2d p, v, a;
  double angle, rate, acceleration;
  double side_rate, side_acceleration;

  // a point r of the frame; the same frame placed there
  Moving at(const Eigen::Vector2d& r) const { return at(r, angle, rate, acceleration); }
  Moving at(const Eigen::Vector2d& r, double phi, double phidot, double phiddot) const
  {
    const Eigen::Vector2d arm = Eigen::Rotation2Dd(phi) * r;
    const Eigen::Vector2d turned(-arm.y(), arm.x());
    Moving result = *this;
    result.p += arm;
    result.v += phidot * turned;
    result.a += phiddot * turned - phidot * phidot * arm;
    return result;
  }
};

// centres of mass; state: in the coordinates of the mechanism, a fixed root at rest
std::vector<Moving> centres_of_mass(const Robot& robot, const State& state)
{
  const Eigen::VectorXd &q = state.q, &v = state.v, &a = state.a;
  std::vector<Moving> frames(robot.links.size());
  std::vector<Moving> centres(robot.links.size());
  for (const int i : robot.order)
  {
    const Link& link = robot.link(i);
    Moving& frame = frames[static_cast<std::size_t>(i)];
    const int c = link.coordinate;
    const auto turn_with_coordinate = [&]
    {
      frame.angle = q(c);
      frame.rate = v(c);
      frame.acceleration = a(c);
    };
    if (link.parent >= 0)
    {
      const Moving& parent = frames[static_cast<std::size_t>(link.parent)];
      frame = parent.at(link.at);
    }
    else
    {
      frame = {q.tail<2>(), v.tail<2>(), a.tail<2>(), 0.0, 0.0, 0.0, 0.0, 0.0};
      if (link.joint == JointKind::floating)
        turn_with_coordinate();
    }
    switch (link.joint)
    {
    case JointKind::floating: break;
    case JointKind::revolute: turn_with_coordinate(); break;
    case JointKind::rolling:
    {
      // both circles have the same velocity where they touch
      const double r_p = link.parent_radius;
      const double r_c = link.child_radius;
      const auto bar = [&](double of_parent, double own)
      {
        return (r_p * of_parent + r_c * own) / (r_p + r_c);
      };
      frame = frame.at({0.0, -(r_p + r_c)}, bar(frame.angle, q(c)) + link.angle, bar(frame.rate, v(c)),
                       bar(frame.acceleration, a(c)));
      turn_with_coordinate();
      break;
    }
    case JointKind::parallel:
      frame.angle = link.angle;
      frame.rate = frame.acceleration = 0.0;
      break;
    case JointKind::slide:
      frame.side_rate += v(c);
      frame.side_acceleration += a(c);
      break;
    case JointKind::fixed: frame.angle += link.angle; break;
    }
    centres[static_cast<std::size_t>(i)] = frame.at(link.com);
  }
  return centres;
}

} // namespace

TEST_CASE("directions turn as W says, whatever stands beyond the angles", "[laws]")
{
  // a base point that is not given may be anything, and is stored right behind the angles
  oracle::Random random(91);
  for (const Robot& robot : all_kinds_of_robots())
  {
    CAPTURE(robot.name);
    const Mechanism& mechanism = robot.mechanism;
    CHECK(mechanism.num_directions() % kDirectionBlock == 0);
    VectorQ q(mechanism.num_q());
    for (double& number : q)
      number = oracle::uniform(random, -3.0, 3.0);
    q.tail<2>().setConstant(std::nan(""));
    CHECK(mismatch(mechanism.of_directions(q), mechanism.W() * q.head(mechanism.num_theta()), 1e-15) == "");
  }
}

TEST_CASE("the mass matrix is symmetric and positive definite", "[laws]")
{
  for_all(kStates,
          [](const Robot& robot, const State& state, oracle::Random&)
          {
            const Support contacts = support(robot, Contact::none, Contact::none);
            const Motion motion = motion_of(robot, state, contacts);
            for (const Coordinates coordinates : kBoth)
            {
              const MatrixQ M = equation_of_motion(robot, motion, contacts, coordinates).M;
              CHECK(mismatch(M, M.transpose(), 1e-15) == "");
              CHECK(oracle::eigenvalues(M)(0) > 0.0);
            }
          });
}

TEST_CASE("Ṁ − 2C is skew", "[laws]")
{
  for_all(kStates,
          [](const Robot& robot, const State&, oracle::Random& random)
          {
            const auto [q, v, a] = random_mechanism_state(random, robot);
            const MatrixQ C = coriolis_matrix(robot.mechanism, kinematics(robot.mechanism, q, v));
            // along q + v t an entry of M turns with up to twice the largest rate: the stencil's own error is 1e-14,
            // the rounding of entries of some 10 kg m², by h, 1e-12 of some 1 kg m²/s
            const double h = 0.02 / v.cwiseAbs().maxCoeff();
            const MatrixQ Mdot =
                oracle::slope([&, q = q, v = v](double t) { return mass_matrix_at(robot, q + t * v); }, h);
            CHECK(mismatch(Mdot, C + C.transpose(), 1e-11) == "");
            const double power = size(v, C * v);
            CHECK(mismatch(v.dot(Mdot * v) / power, 2.0 * v.dot(C * v) / power, 1e-11) == "");
          });
}

TEST_CASE("C is the matrix of Christoffel symbols of M", "[laws]")
{
  for_all(kStates / 10,
          [](const Robot& robot, const State&, oracle::Random& random)
          {
            const auto [q, v, a] = random_mechanism_state(random, robot);
            const int n = robot.mechanism.num_q();
            std::vector<MatrixQ> dM; // by each coordinate, in which M has frequencies up to 1
            for (int k = 0; k < n; ++k)
              dM.push_back(oracle::slope(
                  [&, q = q](double t)
                  {
                    VectorQ moved = q;
                    moved(k) += t;
                    return mass_matrix_at(robot, moved);
                  },
                  0.04));
            MatrixQ expected = MatrixQ::Zero(n, n);
            for (int i = 0; i < n; ++i)
              for (int j = 0; j < n; ++j)
                for (int k = 0; k < n; ++k)
                {
                  const auto d = [&](int by, int row, int column)
                  {
                    return dM[static_cast<std::size_t>(by)](row, column);
                  };
                  expected(i, j) += 0.5 * (d(k, i, j) + d(j, i, k) - d(i, j, k)) * v(k);
                }
            const Kinematics now = kinematics(robot.mechanism, q, v);
            CHECK(mismatch(coriolis_matrix(robot.mechanism, now), expected, 1e-12) == "");
          });
}

TEST_CASE("the generalized force is M a + h + g, and h is C v", "[laws]")
{
  for_all(kStates,
          [](const Robot& robot, const State& state, oracle::Random&)
          {
            const Support contacts = support(robot, Contact::none, Contact::none);
            const Motion motion = motion_of(robot, state, contacts);
            for (const Coordinates coordinates : kBoth)
            {
              const EquationOfMotion equation = equation_of_motion(robot, motion, contacts, coordinates);
              const Eigen::VectorXd v = in(coordinates, robot, state.v);
              const Eigen::VectorXd a = in(coordinates, robot, state.a);
              const double scale = std::max({1.0, (equation.M * a).cwiseAbs().maxCoeff(),
                                             equation.h.cwiseAbs().maxCoeff(), equation.g.cwiseAbs().maxCoeff()});
              CHECK(mismatch(equation.h / scale, equation.C * v / scale, kRounding) == "");
              CHECK(mismatch(equation.generalized_force / scale, (equation.M * a + equation.h + equation.g) / scale,
                             kRounding) == "");
              CHECK(
                  mismatch(equation.generalized_force,
                           in_coordinates(robot, inverse_dynamics(robot.mechanism, motion.now, motion.a), coordinates),
                           kRounding) == "");
            }
          });
}

TEST_CASE("gravity is the slope of the potential energy", "[laws]")
{
  for_all(kStates,
          [](const Robot& robot, const State&, oracle::Random& random)
          {
            const auto [q, v, a] = random_mechanism_state(random, robot);
            const VectorQ g = gravity_force(robot.mechanism, kinematics(robot.mechanism, q, v));
            const double h = 0.02 / v.cwiseAbs().maxCoeff();
            const double found =
                oracle::slope([&, q = q, v = v](double t) { return potential_energy_at(robot, q + t * v); }, h);
            // energies of a thousand J, rounded to 1e-13 J, by h: 1e-10 W of some hundred
            CHECK(mismatch(found / size(v, g), g.dot(v) / size(v, g), 1e-11) == "");
          });
}

TEST_CASE("energy changes at the rate of the power that is put in", "[laws]")
{
  for_all(kStates,
          [](const Robot& robot, const State& state, oracle::Random&)
          {
            const auto [q, v, a] = of_mechanism(robot, state);
            const Mechanism& mechanism = robot.mechanism;
            const auto energy = [&, q = q, v = v, a = a](double t)
            {
              const VectorQ rate = v + t * a;
              const Kinematics now = kinematics(mechanism, q + t * v + 0.5 * t * t * a, rate);
              return kinetic_energy(mechanism, now, rate) + potential_energy(mechanism, now);
            };
            const VectorQ force = inverse_dynamics(mechanism, kinematics(mechanism, q, v), a);
            const double power = v.dot(force);
            // energies of a thousand J, rounded to 1e-13 J, by h: 1e-9 W of some hundred. Frequencies are up to twice
            // 4 rad/s and grow by 60 rad/s²: the stencil's own error is less
            CHECK(mismatch(oracle::slope(energy, 2e-3) / size(v, force), power / size(v, force), 1e-10) == "");
          });
}

TEST_CASE("power and kinetic energy are the same in both kinds of coordinates", "[laws]")
{
  for_all(kStates,
          [](const Robot& robot, const State& state, oracle::Random&)
          {
            const Support contacts = support(robot, Contact::none, Contact::none);
            const Motion motion = motion_of(robot, state, contacts);
            const auto at_base = of_mechanism(robot, state);
            const VectorQ force = inverse_dynamics(robot.mechanism, motion.now, at_base.a);
            const double scale = size(at_base.v, force);
            const double power = at_base.v.dot(force);
            const double energy = kinetic_energy(robot.mechanism, motion.now, at_base.v);
            for (const Coordinates coordinates : kBoth)
            {
              const EquationOfMotion equation = equation_of_motion(robot, motion, contacts, coordinates);
              const Eigen::VectorXd v = in(coordinates, robot, state.v);
              CHECK(mismatch(v.dot(equation.generalized_force) / scale, power / scale, kRounding) == "");
              CHECK(mismatch(0.5 * v.dot(equation.M * v), energy, kRounding) == "");
            }
          });
}

TEST_CASE("the motors of a floating robot cannot turn it as a whole, nor push it", "[laws]")
{
  for (const Robot& robot : robots())
    if (!robot.fixed_root())
    {
      CAPTURE(robot.name);
      const auto B = input_matrix(robot);
      // the turn of the whole robot: every angle alike, and no slide
      Eigen::RowVectorXd turn = Eigen::RowVectorXd::Zero(robot.mechanism.num_q());
      for (const Link& link : robot.links)
        if (link.coordinate >= 0 && link.joint != JointKind::slide)
          turn(link.coordinate) = 1.0;
      CHECK(mismatch(turn * B, Eigen::RowVectorXd::Zero(robot.num_joints()), 1e-15) == "");
      CHECK(B.bottomRows<2>().isZero(0.0));
      CHECK(oracle::rank(B) == robot.num_joints());
    }
}

TEST_CASE("contact rows are the rates of what they hold", "[laws]")
{
  int states = 0, held = 0;
  for_all(kStates,
          [&](const Robot& robot, const State& state, oracle::Random& random)
          {
            const Mechanism& mechanism = robot.mechanism;
            const State moving = of_mechanism(robot, state);
            const auto& [q, v, a] = moving;
            const auto at = [&](double t)
            {
              return kinematics(mechanism, moving.q + t * moving.v + 0.5 * t * t * moving.a, moving.v + t * moving.a);
            };
            const Side side = kSides[random() % 2];
            const Contact contact = static_cast<Contact>(1 + random() % 3);
            const Foot& foot = robot.foot(side);
            Support contacts{{Contact::none, Contact::none}, Side::left, 0.0, 0.0};
            contacts.contact[static_cast<std::size_t>(side)] = contact;
            ++states;
            if (!foot.exists() || (contact == Contact::sole && !foot.has_extent() && !robot.is_root(foot)))
              return;
            ++held;
            CAPTURE(name_of(side), name_of(contact));
            const auto place = [&](double t)
            {
              return position(at(t), contact_point(foot, contact));
            };
            const auto rate = [&](double t) -> Eigen::VectorXd
            {
              return contact_rows(robot, at(t), contacts).J * (moving.v + t * moving.a);
            };
            const ContactRows rows = contact_rows(robot, at(0.0), contacts);
            const Eigen::VectorXd velocity = rows.J * v;
            // lengths of 1 m, rounded to 1e-16, by h; speeds are some m/s, accelerations some 10 m/s²
            CHECK(mismatch(oracle::slope(place, 1e-3), velocity.head<2>(), 1e-11) == "");
            CHECK(mismatch(oracle::slope(rate, 1e-3), rows.J * a + rows.Jdot_v, 1e-11) == "");
            if (contact == Contact::sole)
            {
              const auto angle = [&](double t)
              {
                const Eigen::Vector2d e = heading(robot.link(foot.link), at(t));
                const Eigen::Vector2d e_0 = heading(robot.link(foot.link), at(0.0));
                return std::atan2(cross(e_0, e), e_0.dot(e));
              };
              CHECK(mismatch(oracle::slope(angle, 1e-3), velocity(2), 1e-11) == "");
            }
          });
  CAPTURE(states, held);
  CHECK(held > states / 2);
}

TEST_CASE("generalized force is what Newton and Euler ask of every link", "[laws]")
{
  for_all(kStates,
          [](const Robot& robot, const State& state, oracle::Random& random)
          {
            const State moving = of_mechanism(robot, state);
            const Kinematics now = kinematics(robot.mechanism, moving.q, moving.v);
            const VectorQ r = inverse_dynamics(robot.mechanism, now, moving.a);
            const std::vector<Moving> centres = centres_of_mass(robot, moving);

            // against any rates w: Σ m (c̈ + g ẑ) · ċ_w + I φ̈ φ̇_w, slides likewise, is wᵀ r
            State other = of_mechanism(robot, random_state(random, robot));
            other.q = moving.q;
            const std::vector<Moving> virtually = centres_of_mass(robot, other);
            Eigen::Vector2d force = Eigen::Vector2d::Zero();
            double power = 0.0;
            double kinetic = 0.0;
            double potential = 0.0;
            for (std::size_t i = 0; i < centres.size(); ++i)
            {
              const double m = robot.links[i].mass;
              const double I = robot.links[i].inertia;
              const Moving& c = centres[i];
              const Moving& w = virtually[i];
              const Eigen::Vector2d needed = m * (c.a + Eigen::Vector2d(0.0, robot.mechanism.gravity()));
              force += needed;
              power += needed.dot(w.v) + I * c.acceleration * w.rate + m * c.side_acceleration * w.side_rate;
              kinetic += 0.5 * (m * (c.v.squaredNorm() + c.side_rate * c.side_rate) + I * c.rate * c.rate);
              potential += m * robot.mechanism.gravity() * c.p.y();
            }
            CHECK(mismatch(other.v.dot(r) / size(other.v, r), power / size(other.v, r), kRounding) == "");
            CHECK(mismatch(r.tail<2>(), force, kRounding) == "");
            CHECK(mismatch(kinetic_energy(robot.mechanism, now, moving.v), kinetic, kRounding) == "");
            CHECK(mismatch(potential_energy(robot.mechanism, now), potential, kRounding) == "");
          });
}

TEST_CASE("a rotor's inertia adds B diag(I) Bᵀ to the mass matrix", "[laws]")
{
  oracle::Random random(202);
  for (Robot robot : robots())
  {
    CAPTURE(robot.name);
    robot.joint_friction = true;
    const int joints = robot.num_joints();
    Eigen::VectorXd I(joints);
    for (int j = 0; j < joints; ++j)
      I(j) = robot.actuators[static_cast<std::size_t>(j)].rotor_inertia = oracle::uniform(random, 0.0, 2.0);
    for (int i = 0; i < kStates; ++i)
    {
      CAPTURE(i);
      const State state = random_state(random, robot);
      const DesiredState desired = desired_of(robot, state, support(robot, Contact::none, Contact::none));
      const auto equations = support_equations(robot, desired);
      const VectorQ found = in_coordinates(robot, std::get<SupportEquations>(equations).r, Coordinates::absolute);
      const EquationOfMotion equation =
          equation_of_motion(robot, motion_of(robot, state, desired.support), desired.support, Coordinates::absolute);
      const Eigen::MatrixXd M = equation.M + equation.B * I.asDiagonal() * equation.B.transpose();
      CHECK(mismatch(found, M * state.a + equation.h + equation.g, kRounding) == "");
    }
  }
}

TEST_CASE("joint friction is what its closed form says, at rates of either sign", "[laws]")
{
  Actuator actuator;
  actuator.coulomb = 2.0;
  actuator.viscous = 0.5;
  actuator.stribeck = 3.0;
  actuator.stribeck_velocity = 0.1;
  actuator.friction_offset = 0.25;
  actuator.rotor_inertia = 0.83;

  struct Row
  {
    double rate, acceleration, torque;
  };
  const double once = 3.0 * 0.36787944117144233;  // exp(−1)
  const double twice = 3.0 * 0.01831563888873418; // exp(−4)
  const Row rows[] = {{0.0, 0.0, 0.25},
                      {0.0, 10.0, 8.55},
                      {0.1, 0.0, 2.0 + 0.05 + once + 0.25},
                      {-0.1, 0.0, -2.0 - 0.05 - once + 0.25},
                      {0.2, -1.0, -0.83 + 2.0 + 0.1 + twice + 0.25},
                      {-0.2, 1.0, 0.83 - 2.0 - 0.1 - twice + 0.25},
                      {1e-300, 0.0, 5.25},
                      {-1e-300, 0.0, -4.75},
                      {10.0, 0.0, 7.25},
                      {-10.0, 0.0, -6.75},
                      {1e6, 0.0, 500002.25},
                      {-1e6, 0.0, -500001.75}};
  for (const auto& [rate, acceleration, torque] : rows)
  {
    CAPTURE(rate, acceleration);
    CHECK(mismatch(joint_friction(actuator, rate, acceleration), torque, 1e-15) == "");
  }

  // all but the offset changes sign with the motion, and takes power from it
  oracle::Random random(203);
  for (int i = 0; i < kStates; ++i)
  {
    const double rate = oracle::uniform(random, -20.0, 20.0);
    const double acceleration = oracle::uniform(random, -100.0, 100.0);
    CAPTURE(rate, acceleration);
    CHECK(mismatch(joint_friction(actuator, rate, acceleration) + joint_friction(actuator, -rate, -acceleration), 0.5,
                   1e-13) == "");
    CHECK((joint_friction(actuator, rate, 0.0) - 0.25) * rate > 0.0);
  }
}

TEST_CASE("within its stick velocity friction is continuous, and beyond it what it is without", "[laws]")
{
  oracle::Random random(205);
  for (int i = 0; i < kStates; ++i)
  {
    Actuator jumps;
    jumps.coulomb = oracle::uniform(random, 0.1, 5.0);
    jumps.stribeck = oracle::uniform(random, 0.1, 5.0);
    jumps.viscous = oracle::uniform(random, 0.0, 1.0);
    jumps.stribeck_velocity = oracle::uniform(random, 0.01, 1.0);
    jumps.friction_offset = oracle::uniform(random, -1.0, 1.0);
    Actuator sticks = jumps;
    sticks.stick_velocity = std::pow(10.0, oracle::uniform(random, -6.0, 0.0));
    const double edge = sticks.stick_velocity;
    CAPTURE(edge, jumps.stribeck_velocity);
    const auto without = [&jumps](double rate)
    {
      return joint_friction(jumps, rate, 0.0);
    };
    const auto with = [&sticks](double rate)
    {
      return joint_friction(sticks, rate, 0.0);
    };

    // outside: the same, bit for bit, from the edge on
    const double outside = oracle::uniform(random, 1.0, 100.0) * edge;
    for (const double rate : {edge, -edge, outside, -outside})
      CHECK(with(rate) == without(rate));

    // inside: the sign's two terms are in the rate's proportion to the edge; all of it is odd but for the offset, and
    // takes power from the motion
    const double share = oracle::uniform(random, 0.0, 1.0);
    const double rate = share * edge;
    const double own = jumps.friction_offset + jumps.viscous * rate;
    CHECK(mismatch(with(rate) - own, share * (without(rate) - own), 1e-13) == "");
    CHECK(mismatch(with(rate) + with(-rate), 2.0 * jumps.friction_offset, 1e-13) == "");
    CHECK((with(rate) - jumps.friction_offset) * rate >= 0.0);
    CHECK(with(0.0) == jumps.friction_offset);

    // nowhere a jump: no steeper than at rest, where the slope is (κ_c + κ_s) / s + κ_v; nor than the viscous and
    // Stribeck terms are by themselves, 1 / η_s being more than the slope of exp(−x²)
    const double slope =
        (jumps.coulomb + jumps.stribeck) / edge + jumps.viscous + jumps.stribeck / jumps.stribeck_velocity;
    for (const double from : {-edge, 0.0, rate, edge})
      for (const double step : {1e-9 * edge, 1e-3 * edge})
        CHECK(std::abs(with(from + step) - with(from - step)) <= 2.0 * step * slope * (1.0 + 1e-6) + 1e-14);
  }
}

TEST_CASE("a robot's friction acts on the angles that its motors turn", "[laws]")
{
  oracle::Random random(204);
  for (int i = 0; i < kStates; ++i)
  {
    CAPTURE(i);
    const oracle::Biped biped = oracle::random_rk(random, static_cast<Placement>(i % 3));
    Robot robot = biped.robot();
    robot.joint_friction = true;
    for (Actuator& actuator : robot.actuators)
    {
      actuator.coulomb = oracle::uniform(random, 0.0, 5.0);
      actuator.viscous = oracle::uniform(random, 0.0, 1.0);
      actuator.stribeck = oracle::uniform(random, 0.0, 5.0);
      actuator.stribeck_velocity = oracle::uniform(random, 0.1, 1.0);
      actuator.friction_offset = oracle::uniform(random, -1.0, 1.0);
      actuator.rotor_inertia = oracle::uniform(random, 0.0, 1.0);
    }
    const auto [X, V, A] = oracle::random_motion(random);
    const oracle::Vector6 rate = biped.B().transpose() * V;
    const oracle::Vector6 acceleration = biped.B().transpose() * A;
    oracle::Vector6 expected;
    for (int j = 0; j < 6; ++j)
      expected(j) = joint_friction(robot.actuators[static_cast<std::size_t>(j)], rate(j), acceleration(j));
    CHECK(mismatch(joint_friction(robot, VectorQ(V), VectorQ(A)), expected, kRounding) == "");
  }
}

} // namespace laws_test
