#include "oracles.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

namespace torqued::oracle
{

namespace
{

// positions of a leg's coordinates in X: foot, shin, thigh
struct Leg
{
  int f, k, t;
};
Leg leg(Side side)
{
  return side == Side::left ? Leg{0, 1, 2} : Leg{5, 4, 3};
}

Eigen::Vector2d u(double a)
{
  return {std::sin(a), -std::cos(a)};
}

} // namespace

Matrix9 Ck::D(const Vector9& X) const
{
  const double mA = m0 + m1;
  const double mu1 = m0 * l1 + m1 * s1;
  const double mu2 = mA * l2 + m2 * s2;
  const double mu3 = m3 * s3;
  Matrix9 D = Matrix9::Zero();
  for (const Side side : kSides)
  {
    const auto [f, k, t] = leg(side);
    const auto T = [&](double x)
    {
      return s_x * std::sin(x) + s_z * std::cos(x);
    };
    D(f, f) = I0 + m0 * (s_x * s_x + s_z * s_z);
    D(k, k) = I1 + m0 * l1 * l1 + m1 * s1 * s1;
    D(t, t) = I2 + m2 * s2 * s2 + mA * l2 * l2;
    D(f, k) = m0 * l1 * T(X(k) - X(f));
    D(f, t) = m0 * l2 * T(X(t) - X(f));
    D(k, t) = mu1 * l2 * std::cos(X(k) - X(t));
    D(f, 7) = m0 * (s_z * std::cos(X(f)) - s_x * std::sin(X(f)));
    D(f, 8) = m0 * (s_x * std::cos(X(f)) + s_z * std::sin(X(f)));
    D(k, 7) = mu1 * std::cos(X(k));
    D(k, 8) = mu1 * std::sin(X(k));
    D(t, 7) = mu2 * std::cos(X(t));
    D(t, 8) = mu2 * std::sin(X(t));
  }
  D(6, 6) = I3 + m3 * s3 * s3;
  D(6, 7) = -mu3 * std::cos(X(6));
  D(6, 8) = -mu3 * std::sin(X(6));
  D(7, 7) = D(8, 8) = mass();
  for (int i = 0; i < 9; ++i)
    for (int j = i + 1; j < 9; ++j)
      D(i, j) = D(j, i) = D(i, j) + D(j, i);
  return D;
}

Vector9 Ck::H(const Vector9& X, const Vector9& V) const
{
  const double mA = m0 + m1;
  const double mu1 = m0 * l1 + m1 * s1;
  const double mu2 = mA * l2 + m2 * s2;
  const double mu3 = m3 * s3;
  Vector9 H = Vector9::Zero();
  for (const Side side : kSides)
  {
    const auto [f, k, t] = leg(side);
    const auto S = [&](double x)
    {
      return s_x * std::cos(x) - s_z * std::sin(x);
    };
    const double fdot2 = V(f) * V(f);
    const double kdot2 = V(k) * V(k);
    const double tdot2 = V(t) * V(t);
    H(f) = m0 * (l1 * kdot2 * S(X(k) - X(f)) + l2 * tdot2 * S(X(t) - X(f)));
    H(k) = -m0 * fdot2 * l1 * S(X(k) - X(f)) + mu1 * l2 * tdot2 * std::sin(X(k) - X(t));
    H(t) = -m0 * fdot2 * l2 * S(X(t) - X(f)) + mu1 * l2 * kdot2 * std::sin(X(t) - X(k));
    H(7) += -m0 * (s_x * std::cos(X(f)) + s_z * std::sin(X(f))) * fdot2 - mu1 * std::sin(X(k)) * kdot2 -
            mu2 * std::sin(X(t)) * tdot2;
    H(8) += m0 * (s_z * std::cos(X(f)) - s_x * std::sin(X(f))) * fdot2 + mu1 * std::cos(X(k)) * kdot2 +
            mu2 * std::cos(X(t)) * tdot2;
  }
  H(7) += mu3 * std::sin(X(6)) * V(6) * V(6);
  H(8) += -mu3 * std::cos(X(6)) * V(6) * V(6);
  return H;
}

Vector9 Ck::Q(const Vector9& X) const
{
  Vector9 Q = gravity * D(X).col(8);
  Q(7) = 0.0;
  return Q;
}

Eigen::Matrix<double, 9, 6> Ck::B()
{
  Eigen::Matrix<double, 9, 6> B = Eigen::Matrix<double, 9, 6>::Zero();
  const int plus[] = {1, 2, 6, 6, 3, 4};
  const int minus[] = {0, 1, 2, 3, 4, 5};
  for (int j = 0; j < 6; ++j)
  {
    B(plus[j], j) = 1.0;
    B(minus[j], j) = -1.0;
  }
  return B;
}

Eigen::Vector2d Ck::ankle(Side side, const Vector9& X) const
{
  const auto [f, k, t] = leg(side);
  return X.tail<2>() + l2 * u(X(t)) + l1 * u(X(k));
}

Eigen::Vector2d Ck::contact_point(Side side, Contact contact, const Vector9& X) const
{
  const double q = X(leg(side).f);
  const Eigen::Vector2d p = ankle(side, X);
  if (contact == Contact::heel)
    return p + Eigen::Vector2d(-l_p * std::cos(q) + h_p * std::sin(q), -l_p * std::sin(q) - h_p * std::cos(q));
  if (contact == Contact::toe)
    return p + Eigen::Vector2d(l_p1 * std::cos(q) + h_p * std::sin(q), l_p1 * std::sin(q) - h_p * std::cos(q));
  return p;
}

Eigen::MatrixXd Ck::J(Side side, Contact contact, const Vector9& X) const
{
  const auto [f, k, t] = leg(side);
  if (contact == Contact::none)
    return Eigen::MatrixXd(0, 9);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(contact == Contact::sole ? 3 : 2, 9);
  J(0, k) = l1 * std::cos(X(k));
  J(1, k) = l1 * std::sin(X(k));
  J(0, t) = l2 * std::cos(X(t));
  J(1, t) = l2 * std::sin(X(t));
  J(0, 7) = J(1, 8) = 1.0;
  if (contact == Contact::sole)
    J(2, f) = 1.0;
  if (contact == Contact::heel)
  {
    J(0, f) = h_p * std::cos(X(f)) + l_p * std::sin(X(f));
    J(1, f) = h_p * std::sin(X(f)) - l_p * std::cos(X(f));
  }
  if (contact == Contact::toe)
  {
    J(0, f) = h_p * std::cos(X(f)) - l_p1 * std::sin(X(f));
    J(1, f) = h_p * std::sin(X(f)) + l_p1 * std::cos(X(f));
  }
  return J;
}

Eigen::VectorXd Ck::Jdot_V(Side side, Contact contact, const Vector9& X, const Vector9& V) const
{
  const auto [f, k, t] = leg(side);
  if (contact == Contact::none)
    return Eigen::VectorXd(0);
  Eigen::VectorXd result = Eigen::VectorXd::Zero(contact == Contact::sole ? 3 : 2);
  result.head<2>() = -l1 * u(X(k)) * V(k) * V(k) - l2 * u(X(t)) * V(t) * V(t) -
                     (contact_point(side, contact, X) - ankle(side, X)) * V(f) * V(f);
  return result;
}

double Ck::energy(const Vector9& X, const Vector9& V) const
{
  double energy = 0.0;
  // one body whose centre of mass is the hip plus arms, each turning with a coordinate
  struct Swing
  {
    int coordinate;
    Eigen::Vector2d r; // in the link's frame: x forward, z up, at angle 0
  };
  const auto add = [&](double m, double I, int link, const std::vector<Swing>& arms)
  {
    Eigen::Vector2d p = X.tail<2>();
    Eigen::Vector2d v = V.tail<2>();
    for (const auto& [c, r] : arms)
    {
      const Eigen::Vector2d turned = Eigen::Rotation2Dd(X(c)) * r;
      p += turned;
      v += V(c) * Eigen::Vector2d(-turned.y(), turned.x());
    }
    energy += 0.5 * m * v.squaredNorm() + 0.5 * I * V(link) * V(link) + m * gravity * p.y();
  };
  for (const Side side : kSides)
  {
    const auto [f, k, t] = leg(side);
    add(m2, I2, t, {{t, {0.0, -s2}}});
    add(m1, I1, k, {{t, {0.0, -l2}}, {k, {0.0, -s1}}});
    add(m0, I0, f, {{t, {0.0, -l2}}, {k, {0.0, -l1}}, {f, {s_x, -s_z}}});
  }
  add(m3, I3, 6, {{6, {0.0, s3}}});
  return energy;
}

Robot Ck::robot() const
{
  RobotDescription description;
  description.file = "oracle";
  description.name = "oracle";
  description.gravity = gravity;
  description.base_names = {"xH", "zH"};
  const auto link = [&](const char* name, const char* parent, Eigen::Vector2d at, const char* coordinate, double m,
                        Eigen::Vector2d com, double I)
  {
    RobotDescription::LinkEntry entry;
    entry.link.name = name;
    entry.link.joint = *parent ? JointKind::revolute : JointKind::floating;
    entry.link.at = at;
    entry.link.mass = m;
    entry.link.com = com;
    entry.link.inertia = I;
    entry.parent = parent;
    entry.coordinate = coordinate;
    entry.line = 1;
    description.links.push_back(entry);
  };
  link("left_foot", "left_shin", {0.0, -l1}, "q0", m0, {s_x, -s_z}, I0);
  link("left_shin", "left_thigh", {0.0, -l2}, "q1", m1, {0.0, -s1}, I1);
  link("left_thigh", "trunk", {0.0, 0.0}, "q2", m2, {0.0, -s2}, I2);
  link("right_thigh", "trunk", {0.0, 0.0}, "q3", m2, {0.0, -s2}, I2);
  link("right_shin", "right_thigh", {0.0, -l2}, "q4", m1, {0.0, -s1}, I1);
  link("right_foot", "right_shin", {0.0, -l1}, "q5", m0, {s_x, -s_z}, I0);
  link("trunk", "", {0.0, 0.0}, "q6", m3, {0.0, s3}, I3);

  const auto actuator = [&](const char* name, const char* on, const char* against)
  {
    Actuator entry;
    entry.name = name;
    entry.torque_limit = entry.rate_limit = std::numeric_limits<double>::infinity();
    description.actuators.push_back({entry, on, against, name, 0.0, 1});
  };
  actuator("left_ankle", "left_shin", "left_foot");
  actuator("left_knee", "left_thigh", "left_shin");
  actuator("left_hip", "trunk", "left_thigh");
  actuator("right_hip", "trunk", "right_thigh");
  actuator("right_knee", "right_thigh", "right_shin");
  actuator("right_ankle", "right_shin", "right_foot");
  for (const Side side : kSides)
  {
    Foot foot{side, -1, {0.0, 0.0}, {-l_p, -h_p}, {l_p1, -h_p}, friction, {}, {}, {}};
    description.feet.push_back({foot, side == Side::left ? "left_foot" : "right_foot", 1});
  }
  return assemble(description);
}

double uniform(Random& random, double from, double to)
{
  return std::uniform_real_distribution<double>(from, to)(random);
}

Ck random_ck(Random& random)
{
  Ck ck;
  for (double* value : {&ck.m0, &ck.m1, &ck.m2, &ck.m3, &ck.I0, &ck.I1, &ck.I2, &ck.I3, &ck.l1, &ck.l2, &ck.s1, &ck.s2,
                        &ck.s3, &ck.s_x, &ck.s_z, &ck.h_p, &ck.l_p, &ck.l_p1})
    *value *= uniform(random, 0.7, 1.4);
  return ck;
}

Motion random_motion(Random& random)
{
  Motion motion;
  for (int i = 0; i < 7; ++i)
  {
    motion.X(i) = uniform(random, -0.8, 0.8);
    motion.V(i) = uniform(random, -4.0, 4.0);
    motion.A(i) = uniform(random, -30.0, 30.0);
  }
  for (int i = 7; i < 9; ++i)
  {
    motion.X(i) = uniform(random, -1.0, 1.0);
    motion.V(i) = uniform(random, -2.0, 2.0);
    motion.A(i) = uniform(random, -5.0, 5.0);
  }
  return motion;
}

Motion random_consistent_motion(Random& random, const Ck& ck, Contact left, Contact right)
{
  Motion motion = random_motion(random);
  const Contact contact[] = {left, right};
  for (const Side side : kSides)
    if (contact[static_cast<int>(side)] == Contact::sole)
      motion.X(leg(side).f) = 0.0;

  Eigen::MatrixXd J(0, 9);
  Eigen::VectorXd Jdot_V(0);
  for (const Side side : kSides)
  {
    const Eigen::MatrixXd rows = ck.J(side, contact[static_cast<int>(side)], motion.X);
    J.conservativeResize(J.rows() + rows.rows(), 9);
    J.bottomRows(rows.rows()) = rows;
  }
  // the nearest rates, then the nearest accelerations, that keep the contacts
  const auto decomposition = J.completeOrthogonalDecomposition();
  motion.V -= decomposition.solve(J * motion.V);
  for (const Side side : kSides)
  {
    const Eigen::VectorXd rows = ck.Jdot_V(side, contact[static_cast<int>(side)], motion.X, motion.V);
    Jdot_V.conservativeResize(Jdot_V.size() + rows.size());
    Jdot_V.tail(rows.size()) = rows;
  }
  motion.A -= decomposition.solve(J * motion.A + Jdot_V);
  return motion;
}

DesiredState desired_state(const Motion& motion, Contact left, Contact right, Side leading, double load_transfer)
{
  DesiredState desired;
  desired.utime = 1;
  desired.stream_id = 1;
  desired.base_given = true;
  desired.method = Method::none;
  desired.support = {{left, right}, leading, load_transfer, 0.0};
  desired.q = motion.X;
  desired.v = motion.V;
  desired.a = motion.A;
  return desired;
}

} // namespace torqued::oracle
