#include "oracles.h"

#include "decompositions.h"
#include "robot/assembly.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <fmt/format.h>
#include <limits>
#include <numbers>

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

// of a complex step: its square is lost in any sum, so that Im f(x + i h) / h is f'(x) to rounding
constexpr double kStep = 1e-30;

template <typename T> using Vector9Of = Eigen::Matrix<T, 9, 1>;
template <typename T> using Matrix9Of = Eigen::Matrix<T, 9, 9>;

// the bar's angle; of no use and without effect where nothing rolls
template <typename T> T gamma_of(const Biped& biped, const T& k, const T& t)
{
  return biped.rolls() ? T((biped.r1 * k + biped.r2 * t) / (biped.r1 + biped.r2)) : k;
}

template <typename T> Matrix9Of<T> closed_form_D(const Biped& biped, const Vector9Of<T>& X)
{
  using std::cos;
  using std::sin;
  const auto& [m0, m1, m2, m3, I0, I1, I2, I3, l1, l2, s1, s2, s3, s_x, s_z, h_p, l_p, l_p1, r1, r2, knee, gravity,
               friction] = biped;
  const double l1p = l1 - r1;
  const double l2p = l2 - r2;
  const double mA = m0 + m1;
  const double mu1 = m0 * l1p + m1 * (s1 - r1);
  const double mu2 = mA * l2p + m2 * s2;
  const double mu3 = m3 * s3;
  const double J0 = I0 + m0 * (s_x * s_x + s_z * s_z);
  const double J1 = I1 + m0 * l1p * l1p + m1 * (s1 - r1) * (s1 - r1);
  const double J2 = I2 + m2 * s2 * s2 + mA * l2p * l2p;
  const double J3 = I3 + m3 * s3 * s3;
  Matrix9Of<T> D = Matrix9Of<T>::Zero();
  const auto set = [&](int i, int j, const T& value)
  {
    D(i, j) = D(j, i) = value;
  };
  for (const Side side : kSides)
  {
    const auto [f_, k_, t_] = leg(side);
    const T f = X(f_);
    const T k = X(k_);
    const T t = X(t_);
    const T gamma = gamma_of(biped, k, t);
    const auto foot = [x = s_x, z = s_z](const T& angle) -> T
    {
      return x * sin(angle) + z * cos(angle);
    };
    set(f_, f_, J0);
    set(k_, k_, J1 + mA * r1 * r1 + 2.0 * r1 * mu1 * cos(k - gamma));
    set(t_, t_, J2 + mA * r2 * r2 + 2.0 * r2 * mA * l2p * cos(t - gamma));
    set(f_, k_, m0 * (l1p * foot(k - f) + r1 * foot(gamma - f)));
    set(f_, t_, m0 * (l2p * foot(t - f) + r2 * foot(gamma - f)));
    set(k_, t_, mu1 * l2p * cos(k - t) + mA * r1 * l2p * cos(gamma - t) + mu1 * r2 * cos(k - gamma) + mA * r1 * r2);
    set(f_, 7, m0 * (s_z * cos(f) - s_x * sin(f)));
    set(f_, 8, m0 * (s_x * cos(f) + s_z * sin(f)));
    set(k_, 7, mu1 * cos(k) + mA * r1 * cos(gamma));
    set(k_, 8, mu1 * sin(k) + mA * r1 * sin(gamma));
    set(t_, 7, mu2 * cos(t) + mA * r2 * cos(gamma));
    set(t_, 8, mu2 * sin(t) + mA * r2 * sin(gamma));
  }
  set(6, 6, J3);
  set(6, 7, -mu3 * cos(X(6)));
  set(6, 8, -mu3 * sin(X(6)));
  set(7, 7, biped.mass());
  set(8, 8, biped.mass());
  return D;
}

// columns of a leg's shin and thigh in the ankle's Jacobian
template <typename T> Eigen::Matrix<T, 2, 2> ankle_columns(const Biped& biped, const T& k, const T& t)
{
  using std::cos;
  using std::sin;
  const T gamma = gamma_of(biped, k, t);
  const double l1p = biped.l1 - biped.r1;
  const double l2p = biped.l2 - biped.r2;
  Eigen::Matrix<T, 2, 2> columns;
  columns << biped.r1 * cos(gamma) + l1p * cos(k), biped.r2 * cos(gamma) + l2p * cos(t),
      biped.r1 * sin(gamma) + l1p * sin(k), biped.r2 * sin(gamma) + l2p * sin(t);
  return columns;
}

// What a robot's file would say.
class Description
{
public:
  explicit Description(double gravity)
  {
    description_.file = description_.name = "oracle";
    description_.gravity = gravity;
    description_.base_names = {"xH", "zH"};
  }

  // by default at its parent's origin, without mass
  Link& link(const char* name, JointKind joint, const char* parent, const char* coordinate)
  {
    RobotDescription::LinkEntry entry;
    entry.link.name = name;
    entry.link.joint = joint;
    entry.parent = parent;
    entry.coordinate = coordinate;
    entry.line = 1;
    description_.links.push_back(entry);
    return description_.links.back().link;
  }

  void actuator(const char* name, const char* on, const char* against, double offset = 0.0,
                Placement placement = Placement::links)
  {
    Actuator entry;
    entry.name = name;
    entry.placement = placement;
    entry.torque_limit = entry.rate_limit = std::numeric_limits<double>::infinity();
    description_.actuators.push_back({entry, on, against, name, offset, 1});
  }

  void foot(Side side, const char* link, double heel_x, double toe_x, double sole_z, double friction)
  {
    Foot foot;
    foot.side = side;
    foot.heel_at = {heel_x, sole_z};
    foot.toe_at = {toe_x, sole_z};
    foot.friction = friction;
    description_.feet.push_back({foot, link, 1});
  }

  Robot robot() const { return assemble(description_); }

private:
  RobotDescription description_;
};

void set_body(Link& link, double mass, const Eigen::Vector2d& com, double inertia)
{
  link.mass = mass;
  link.com = com;
  link.inertia = inertia;
}

struct LegNames
{
  const char *foot, *shin, *thigh, *ankle_joint, *knee_joint, *hip_joint;
  const char *foot_angle, *shin_angle, *thigh_angle;
};
constexpr LegNames kLegNames[] = {
    {"left_foot", "left_shin", "left_thigh", "left_ankle", "left_knee", "left_hip", "q0", "q1", "q2"},
    {"right_foot", "right_shin", "right_thigh", "right_ankle", "right_knee", "right_hip", "q5", "q4", "q3"}};
const LegNames& names_of(Side side)
{
  return kLegNames[static_cast<std::size_t>(side)];
}

// a leg that hangs on the trunk, link by link, so that the file's order can be chosen
void hang_thigh(Description& description, const Biped& biped, Side side)
{
  const LegNames& names = names_of(side);
  Link& thigh = description.link(names.thigh, JointKind::revolute, "trunk", names.thigh_angle);
  set_body(thigh, biped.m2, {0.0, -biped.s2}, biped.I2);
}
void hang_shin(Description& description, const Biped& biped, Side side)
{
  const LegNames& names = names_of(side);
  const JointKind joint = biped.rolls() ? JointKind::rolling : JointKind::revolute;
  Link& shin = description.link(names.shin, joint, names.thigh, names.shin_angle);
  shin.at = {0.0, -(biped.l2 - biped.r2)};
  shin.parent_radius = biped.r2;
  shin.child_radius = biped.r1;
  set_body(shin, biped.m1, {0.0, -(biped.s1 - biped.r1)}, biped.I1);
}
void hang_foot(Description& description, const Biped& biped, Side side)
{
  const LegNames& names = names_of(side);
  Link& foot = description.link(names.foot, JointKind::revolute, names.shin, names.foot_angle);
  foot.at = {0.0, -(biped.l1 - biped.r1)};
  set_body(foot, biped.m0, {biped.s_x, -biped.s_z}, biped.I0);
}

// from the foot up; knee: where the thigh's motor stands, seen from a thigh that is the parent
void add_actuators(Description& description, Side side, Placement knee, bool foot_first)
{
  const LegNames& names = names_of(side);
  if (foot_first)
    description.actuator(names.ankle_joint, names.shin, names.foot);
  else
    description.actuator(names.hip_joint, "trunk", names.thigh);
  description.actuator(names.knee_joint, names.thigh, names.shin, 0.0, knee);
  if (foot_first)
    description.actuator(names.hip_joint, "trunk", names.thigh);
  else
    description.actuator(names.ankle_joint, names.shin, names.foot);
}

void add_foot(Description& description, const Biped& biped, Side side)
{
  description.foot(side, names_of(side).foot, -biped.l_p, biped.l_p1, -biped.h_p, biped.friction);
}

} // namespace

Matrix9 Biped::D(const Vector9& X) const
{
  return closed_form_D<double>(*this, X);
}

Vector9 Biped::H(const Vector9& X, const Vector9& V) const
{
  const double l1p = l1 - r1;
  const double l2p = l2 - r2;
  const double mA = m0 + m1;
  const double mu1 = m0 * l1p + m1 * (s1 - r1);
  const double mu2 = mA * l2p + m2 * s2;
  const double mu3 = m3 * s3;
  Vector9 H = Vector9::Zero();
  for (const Side side : kSides)
  {
    const auto [f_, k_, t_] = leg(side);
    const double f = X(f_);
    const double k = X(k_);
    const double t = X(t_);
    const double gamma = gamma_of(*this, k, t);
    const double gammadot = gamma_of(*this, V(k_), V(t_));
    const auto S = [&](double x)
    {
      return s_x * std::cos(x) - s_z * std::sin(x);
    };
    const double fdot2 = V(f_) * V(f_);
    const double kdot2 = V(k_) * V(k_);
    const double tdot2 = V(t_) * V(t_);
    const double bar = (r1 + r2) * gammadot * gammadot;
    H(f_) = m0 * (l1p * kdot2 * S(k - f) + l2p * tdot2 * S(t - f) + bar * S(gamma - f));
    H(k_) = -m0 * fdot2 * (l1p * S(k - f) + r1 * S(gamma - f)) + mu1 * (bar - r1 * kdot2) * std::sin(k - gamma) +
            mA * r1 * l2p * tdot2 * std::sin(gamma - t) + mu1 * l2p * tdot2 * std::sin(k - t);
    H(t_) = -m0 * fdot2 * (l2p * S(t - f) + r2 * S(gamma - f)) + mA * l2p * (bar - r2 * tdot2) * std::sin(t - gamma) +
            mu1 * r2 * kdot2 * std::sin(gamma - k) + mu1 * l2p * kdot2 * std::sin(t - k);
    H(7) += -m0 * (s_x * std::cos(f) + s_z * std::sin(f)) * fdot2 - mu1 * std::sin(k) * kdot2 -
            mu2 * std::sin(t) * tdot2 - mA * bar * std::sin(gamma);
    H(8) += m0 * (s_z * std::cos(f) - s_x * std::sin(f)) * fdot2 + mu1 * std::cos(k) * kdot2 +
            mu2 * std::cos(t) * tdot2 + mA * bar * std::cos(gamma);
  }
  H(7) += mu3 * std::sin(X(6)) * V(6) * V(6);
  H(8) += -mu3 * std::cos(X(6)) * V(6) * V(6);
  return H;
}

Vector9 Biped::Q(const Vector9& X) const
{
  Vector9 Q = gravity * D(X).col(8);
  Q(7) = 0.0;
  return Q;
}

Matrix9 Biped::C(const Vector9& X, const Vector9& V) const
{
  // ∂D/∂X_k; D does not depend on where the hip is
  std::array<Matrix9, 9> slope;
  slope.fill(Matrix9::Zero());
  for (int k = 0; k < 7; ++k)
  {
    Vector9Of<std::complex<double>> shifted = X.cast<std::complex<double>>();
    shifted(k) += std::complex<double>(0.0, kStep);
    slope[static_cast<std::size_t>(k)] = closed_form_D<std::complex<double>>(*this, shifted).imag() / kStep;
  }
  const auto d = [&](int k, int i, int j)
  {
    return slope[static_cast<std::size_t>(k)](i, j);
  };
  Matrix9 C = Matrix9::Zero();
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j)
      for (int k = 0; k < 9; ++k)
        C(i, j) += 0.5 * (d(k, i, j) + d(j, i, k) - d(i, j, k)) * V(k);
  return C;
}

Eigen::Matrix<double, 9, 6> Biped::B() const
{
  Eigen::Matrix<double, 9, 6> B = Eigen::Matrix<double, 9, 6>::Zero();
  const int plus[] = {1, 2, 6, 6, 3, 4};
  const int minus[] = {0, 1, 2, 3, 4, 5};
  for (int j = 0; j < 6; ++j)
  {
    const double share = j == 1 || j == 4 ? kappa() : 1.0;
    B(plus[j], j) = share;
    B(minus[j], j) = -share;
  }
  return B;
}

Matrix9 Biped::from_joint_angles()
{
  // each link's angle is the trunk's less the joint angles between the two
  Matrix9 S = Matrix9::Zero();
  S.col(6).head<7>().setOnes();
  for (int link = 0; link < 3; ++link)
    S.row(link).segment(link, 3 - link).setConstant(-1.0);
  for (int link = 3; link < 6; ++link)
    S.row(link).segment(3, link - 2).setConstant(-1.0);
  S(7, 7) = S(8, 8) = 1.0;
  return S;
}

Eigen::Vector2d Biped::ankle(Side side, const Vector9& X) const
{
  const auto [f, k, t] = leg(side);
  return X.tail<2>() + (l2 - r2) * u(X(t)) + (r1 + r2) * u(gamma_of(*this, X(k), X(t))) + (l1 - r1) * u(X(k));
}

Eigen::Vector2d Biped::contact_point(Side side, Contact contact, const Vector9& X) const
{
  const double q = X(leg(side).f);
  const Eigen::Vector2d p = ankle(side, X);
  if (contact == Contact::heel)
    return p + Eigen::Vector2d(-l_p * std::cos(q) + h_p * std::sin(q), -l_p * std::sin(q) - h_p * std::cos(q));
  if (contact == Contact::toe)
    return p + Eigen::Vector2d(l_p1 * std::cos(q) + h_p * std::sin(q), l_p1 * std::sin(q) - h_p * std::cos(q));
  return p;
}

Eigen::MatrixXd Biped::J(Side side, Contact contact, const Vector9& X) const
{
  const auto [f, k, t] = leg(side);
  if (contact == Contact::none)
    return Eigen::MatrixXd(0, 9);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(contact == Contact::sole ? 3 : 2, 9);
  const Eigen::Matrix2d columns = ankle_columns(*this, X(k), X(t));
  J.col(k).head<2>() = columns.col(0);
  J.col(t).head<2>() = columns.col(1);
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

Eigen::VectorXd Biped::Jdot_V(Side side, Contact contact, const Vector9& X, const Vector9& V) const
{
  const auto [f, k, t] = leg(side);
  if (contact == Contact::none)
    return Eigen::VectorXd(0);
  const double gammadot = gamma_of(*this, V(k), V(t));
  Eigen::VectorXd result = Eigen::VectorXd::Zero(contact == Contact::sole ? 3 : 2);
  result.head<2>() = -(l1 - r1) * u(X(k)) * V(k) * V(k) - (l2 - r2) * u(X(t)) * V(t) * V(t) -
                     (r1 + r2) * u(gamma_of(*this, X(k), X(t))) * gammadot * gammadot -
                     (contact_point(side, contact, X) - ankle(side, X)) * V(f) * V(f);
  return result;
}

double Biped::energy(const Vector9& X, const Vector9& V) const
{
  double energy = 0.0;
  // one body whose centre of mass is the hip plus arms, each turning with an angle
  struct Swing
  {
    double angle, rate;
    Eigen::Vector2d r; // in the arm's frame: x forward, z up, at angle 0
  };
  const auto add = [&](double m, double I, const std::vector<Swing>& arms)
  {
    Eigen::Vector2d p = X.tail<2>();
    Eigen::Vector2d v = V.tail<2>();
    for (const auto& [angle, rate, r] : arms)
    {
      const Eigen::Vector2d turned = Eigen::Rotation2Dd(angle) * r;
      p += turned;
      v += rate * Eigen::Vector2d(-turned.y(), turned.x());
    }
    const double spin = arms.back().rate;
    energy += 0.5 * m * v.squaredNorm() + 0.5 * I * spin * spin + m * gravity * p.y();
  };
  for (const Side side : kSides)
  {
    const auto [f, k, t] = leg(side);
    const auto down = [&](int i, double length)
    {
      return Swing{X(i), V(i), {0.0, -length}};
    };
    const Swing bar{gamma_of(*this, X(k), X(t)), gamma_of(*this, V(k), V(t)), {0.0, -(r1 + r2)}};
    add(m2, I2, {down(t, s2)});
    add(m1, I1, {down(t, l2 - r2), bar, down(k, s1 - r1)});
    add(m0, I0, {down(t, l2 - r2), bar, down(k, l1 - r1), {X(f), V(f), {s_x, -s_z}}});
  }
  add(m3, I3, {{X(6), V(6), {0.0, s3}}});
  return energy;
}

Robot Biped::robot() const
{
  Description description(gravity);
  hang_foot(description, *this, Side::left);
  hang_shin(description, *this, Side::left);
  hang_thigh(description, *this, Side::left);
  hang_thigh(description, *this, Side::right);
  hang_shin(description, *this, Side::right);
  hang_foot(description, *this, Side::right);
  set_body(description.link("trunk", JointKind::floating, "", "q6"), m3, {0.0, s3}, I3);
  add_actuators(description, Side::left, knee, true);
  add_actuators(description, Side::right, knee, false);
  for (const Side side : kSides)
    add_foot(description, *this, side);
  return description.robot();
}

namespace
{

// positions in X of q
std::array<int, 6> links_of(Side stance)
{
  return stance == Side::left ? std::array{1, 2, 6, 3, 4, 5} : std::array{4, 3, 6, 2, 1, 0};
}

} // namespace

Vector9 SixLink::X(const Vector6& q) const
{
  Vector9 X = Vector9::Zero();
  const auto links = links_of(stance);
  for (int i = 0; i < 6; ++i)
    X(links[static_cast<std::size_t>(i)]) = q(i);
  X.tail<2>() = -biped.ankle(stance, X);
  return X;
}

Eigen::Matrix<double, 9, 6> SixLink::F(const Vector6& q) const
{
  Eigen::Matrix<double, 9, 6> F = Eigen::Matrix<double, 9, 6>::Zero();
  const auto links = links_of(stance);
  for (int i = 0; i < 6; ++i)
    F(links[static_cast<std::size_t>(i)], i) = 1.0;
  F.bottomLeftCorner<2, 2>() = -ankle_columns(biped, q(0), q(1));
  return F;
}

Eigen::Matrix<double, 9, 6> SixLink::Fdot(const Vector6& q, const Vector6& v) const
{
  Eigen::Matrix<double, 9, 6> Fdot = Eigen::Matrix<double, 9, 6>::Zero();
  const std::complex<double> k(q(0), kStep * v(0));
  const std::complex<double> t(q(1), kStep * v(1));
  Fdot.bottomLeftCorner<2, 2>() = -ankle_columns(biped, k, t).imag() / kStep;
  return Fdot;
}

Matrix6 SixLink::M(const Vector6& q) const
{
  return F(q).transpose() * biped.D(X(q)) * F(q);
}

Matrix6 SixLink::C(const Vector6& q, const Vector6& v) const
{
  return F(q).transpose() * (biped.D(X(q)) * Fdot(q, v) + biped.C(X(q), F(q) * v) * F(q));
}

Vector6 SixLink::g(const Vector6& q) const
{
  return F(q).transpose() * biped.Q(X(q));
}

Matrix6 SixLink::A() const
{
  const double kappa = biped.kappa();
  Matrix6 A;
  A << 1.0, -kappa, 0.0, 0.0, 0.0, 0.0, //
      0.0, kappa, -1.0, 0.0, 0.0, 0.0,  //
      0.0, 0.0, 1.0, 1.0, 0.0, 0.0,     //
      0.0, 0.0, 0.0, -1.0, kappa, 0.0,  //
      0.0, 0.0, 0.0, 0.0, -kappa, 1.0,  //
      0.0, 0.0, 0.0, 0.0, 0.0, -1.0;
  return A;
}

Eigen::MatrixXd SixLink::J(Contact contact, const Vector6& q) const
{
  return biped.J(other(stance), contact, X(q)) * F(q);
}

Eigen::VectorXd SixLink::Jdot_v(Contact contact, const Vector6& q, const Vector6& v) const
{
  const Side swing = other(stance);
  return biped.J(swing, contact, X(q)) * (Fdot(q, v) * v) + biped.Jdot_V(swing, contact, X(q), F(q) * v);
}

Eigen::Vector3d SixLink::ground(const Vector6& q, const Vector6& v, const Vector6& a) const
{
  const Vector9 V = F(q) * v;
  const Vector9 r = biped.D(X(q)) * (F(q) * a + Fdot(q, v) * v) + biped.H(X(q), V) + biped.Q(X(q));
  return {r(7), r(8), r(leg(stance).f)};
}

Robot SixLink::robot() const
{
  const Side swing = other(stance);
  const LegNames& names = names_of(stance);
  Description description(biped.gravity);
  // the stance leg stands on its foot: frames at the ankle, at the knee (of a rolling one: at the centre of the
  // thigh's circle, the bar pointing up) and at the hip
  set_body(description.link(names.foot, JointKind::fixed, "world", ""), biped.m0, {biped.s_x, -biped.s_z}, biped.I0);
  set_body(description.link(names.shin, JointKind::revolute, names.foot, names.shin_angle), biped.m1,
           {0.0, biped.l1 - biped.s1}, biped.I1);
  Link& thigh = description.link(names.thigh, biped.rolls() ? JointKind::rolling : JointKind::revolute, names.shin,
                                 names.thigh_angle);
  thigh.at = {0.0, biped.l1 - biped.r1};
  if (biped.rolls())
    thigh.angle = std::numbers::pi;
  thigh.parent_radius = biped.r1;
  thigh.child_radius = biped.r2;
  set_body(thigh, biped.m2, {0.0, biped.l2 - biped.r2 - biped.s2}, biped.I2);
  Link& trunk = description.link("trunk", JointKind::revolute, names.thigh, "q6");
  trunk.at = {0.0, biped.l2 - biped.r2};
  set_body(trunk, biped.m3, {0.0, biped.s3}, biped.I3);
  hang_thigh(description, biped, swing);
  hang_shin(description, biped, swing);
  hang_foot(description, biped, swing);

  // the stance knee's parent is the shin
  const Placement turned_over = biped.knee == Placement::bar_parent  ? Placement::bar_child
                                : biped.knee == Placement::bar_child ? Placement::bar_parent
                                                                     : Placement::links;
  add_actuators(description, stance, turned_over, true);
  add_actuators(description, swing, biped.knee, false);
  for (const Side side : kSides)
    add_foot(description, biped, side);
  return description.robot();
}

Eigen::Matrix2d Compass::M(const Eigen::Vector2d& q) const
{
  const double coupling = m * l() * b * std::cos(q(1));
  Eigen::Matrix2d M;
  M << m_H * l() * l() + m * (l() * l() + a * a + b * b) + 2.0 * coupling, m * b * b + coupling, m * b * b + coupling,
      m * b * b;
  return M;
}

Eigen::Matrix2d Compass::C(const Eigen::Vector2d& q, const Eigen::Vector2d& v) const
{
  const double sine = m * l() * b * std::sin(q(1));
  Eigen::Matrix2d C;
  C << -sine * v(1), -sine * (v(0) + v(1)), sine * v(0), 0.0;
  return C;
}

Eigen::Vector2d Compass::g(const Eigen::Vector2d& q) const
{
  const double swing = m * b * std::cos(q(0) + q(1));
  return gravity * Eigen::Vector2d((m_H * l() + m * a + m * l()) * std::cos(q(0)) + swing, swing);
}

Eigen::Matrix2d Compass::M_bar(const Eigen::Vector2d& theta) const
{
  const double coupling = -m * l() * b * std::cos(theta(0) - theta(1));
  Eigen::Matrix2d M;
  M << m_H * l() * l() + m * (l() * l() + a * a), coupling, coupling, m * b * b;
  return M;
}

Eigen::Matrix2d Compass::C_bar(const Eigen::Vector2d& theta, const Eigen::Vector2d& v) const
{
  const double sine = m * l() * b * std::sin(theta(0) - theta(1));
  Eigen::Matrix2d C;
  C << 0.0, -sine * v(1), sine * v(0), 0.0;
  return C;
}

Eigen::Vector2d Compass::g_bar(const Eigen::Vector2d& theta) const
{
  return gravity * Eigen::Vector2d(-(m_H * l() + m * a + m * l()) * std::sin(theta(0)), m * b * std::sin(theta(1)));
}

Eigen::Matrix2d Compass::A()
{
  Eigen::Matrix2d A;
  A << 1.0, 0.0, -1.0, 1.0;
  return A;
}

Eigen::Vector2d Compass::offset()
{
  return {std::numbers::pi / 2.0, -std::numbers::pi};
}

Robot Compass::robot() const
{
  Description description(gravity);
  description.link("stance_foot", JointKind::fixed, "world", "");
  set_body(description.link("stance_leg", JointKind::revolute, "stance_foot", "theta_s"), m, {0.0, a}, 0.0);
  Link& hip = description.link("hip", JointKind::fixed, "stance_leg", "");
  hip.at = {0.0, l()};
  hip.mass = m_H;
  set_body(description.link("swing_leg", JointKind::revolute, "hip", "theta_ns"), m, {0.0, -b}, 0.0);
  description.actuator("q1", "stance_leg", "stance_foot", offset()(0));
  description.actuator("q2", "swing_leg", "stance_leg", offset()(1));
  description.foot(Side::left, "stance_foot", 0.0, 0.0, 0.0, 0.6);
  return description.robot();
}

Itlag::Constants Itlag::K() const
{
  const double above_knee = m_s + m_c + m3 + m4 + m_I; // what the stance thigh carries
  return {l_c1 * l_c1 * m1 + l * l * (m2 + above_knee) + I1,
          l_c2 * l_c2 * m2 + l * l * above_knee + I2,
          (l - l_c3) * (l - l_c3) * m3 + l * l * (m4 + m_I) + I3,
          (l - l_c4) * (l - l_c4) * m4 + l * l * m_I + I4,
          l * l_c2 * m2 + l * l * above_knee,
          -l * (l - l_c3) * m3 - l * l * (m4 + m_I),
          -l * (l - l_c4) * m4 - l * l * m_I,
          m1 * l_c1 + l * (m2 + above_knee),
          m2 * l_c2 + l * above_knee,
          -m3 * (l - l_c3) - l * (m4 + m_I),
          -m4 * (l - l_c4) - l * m_I};
}

Matrix5 Itlag::amplitudes() const
{
  const Constants k = K();
  Matrix5 result = Matrix5::Zero();
  result(0, 1) = k.F;
  result(0, 2) = result(1, 2) = k.G;
  result(0, 3) = result(1, 3) = k.H;
  result(2, 3) = -k.H;
  return result;
}

Matrix5 Itlag::M_bar(const Vector5& theta) const
{
  const Constants k = K();
  const Matrix5 amplitude = amplitudes();
  Matrix5 M = Matrix5::Zero();
  M.diagonal() << k.A, k.B, k.C, k.D, m_c;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j)
      M(i, j) = M(j, i) = amplitude(i, j) * std::cos(theta(i) - theta(j));
  return M;
}

Matrix5 Itlag::C_bar(const Vector5& theta, const Vector5& v) const
{
  const Matrix5 amplitude = amplitudes();
  Matrix5 C = Matrix5::Zero();
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j)
    {
      C(i, j) = amplitude(i, j) * std::sin(theta(i) - theta(j)) * v(j);
      C(j, i) = -amplitude(i, j) * std::sin(theta(i) - theta(j)) * v(i);
    }
  return C;
}

Vector5 Itlag::g_bar(const Vector5& theta) const
{
  const Constants k = K();
  Vector5 g;
  g << k.L * std::cos(theta(0)), k.M * std::cos(theta(1)), k.N * std::cos(theta(2)), k.O * std::cos(theta(3)), 0.0;
  return gravity * g;
}

Matrix5 Itlag::M(const Vector5& q) const
{
  const Constants k = K();
  const double s1 = std::sin(q(0) - q(2));
  const double s12 = std::sin(q(0) + q(1) - q(2));
  const double s15 = std::sin(q(0) - q(2) - q(3));
  const double s125 = std::sin(q(0) + q(1) - q(2) - q(3));
  Matrix5 M = Matrix5::Zero();
  const auto set = [&](int i, int j, double value)
  {
    M(i, j) = M(j, i) = value;
  };
  set(0, 0, k.A + k.B + 2.0 * k.F * std::cos(q(1)));
  set(0, 1, k.B + k.F * std::cos(q(1)));
  set(0, 2, -k.G * (s1 + s12) - k.H * (s15 + s125));
  set(0, 3, -k.H * (s15 + s125));
  set(1, 1, k.B);
  set(1, 2, -k.G * s12 - k.H * s125);
  set(1, 3, -k.H * s125);
  set(2, 2, k.C + k.D - 2.0 * k.H * std::cos(q(3)));
  set(2, 3, k.D - k.H * std::cos(q(3)));
  set(3, 3, k.D);
  set(4, 4, m_c);
  return M;
}

Matrix5 Itlag::C(const Vector5& q, const Vector5& v) const
{
  const Matrix5 back = A_inverse();
  return back.transpose() * C_bar(back * (q - offset()), back * v) * back;
}

Vector5 Itlag::g(const Vector5& q) const
{
  const Constants k = K();
  const double thigh = k.M * std::cos(q(0) + q(1));
  const double shank = k.O * std::sin(q(2) + q(3));
  Vector5 g;
  g << k.L * std::cos(q(0)) + thigh, thigh, k.N * std::sin(q(2)) + shank, shank, 0.0;
  return gravity * g;
}

Matrix5 Itlag::A()
{
  Matrix5 A = Matrix5::Identity();
  A(1, 0) = A(3, 2) = -1.0;
  return A;
}

Matrix5 Itlag::A_inverse()
{
  Matrix5 inverse = Matrix5::Identity();
  inverse(1, 0) = inverse(3, 2) = 1.0;
  return inverse;
}

Vector5 Itlag::offset()
{
  return std::numbers::pi / 2.0 * Vector5::Unit(2);
}

Robot Itlag::robot() const
{
  Description description(gravity);
  const auto link = [&](const char* name, JointKind joint, const char* parent, double at, const char* coordinate,
                        double mass, double com, double inertia)
  {
    Link& added = description.link(name, joint, parent, coordinate);
    added.at = {at, 0.0};
    set_body(added, mass, {com, 0.0}, inertia);
  };
  link("stance_foot", JointKind::fixed, "world", 0.0, "", m_I, 0.0, 0.0);
  link("stance_shank", JointKind::revolute, "stance_foot", 0.0, "theta1", m1, l_c1, I1);
  link("stance_thigh", JointKind::revolute, "stance_shank", l, "theta2", m2, l_c2, I2);
  link("pelvis", JointKind::parallel, "stance_thigh", l, "", m_s, 0.0, 0.0);
  link("swing_thigh", JointKind::revolute, "pelvis", 0.0, "theta3", m3, -(l - l_c3), I3);
  link("swing_shank", JointKind::revolute, "swing_thigh", -l, "theta4", m4, -(l - l_c4), I4);
  link("swing_foot", JointKind::parallel, "swing_shank", -l, "", m_I, 0.0, 0.0);
  link("counterweight", JointKind::slide, "pelvis", 0.0, "r", m_c, 0.0, 0.0);
  description.actuator("q1", "stance_shank", "stance_foot");
  description.actuator("q2", "stance_thigh", "stance_shank");
  description.actuator("q4", "swing_thigh", "pelvis", offset()(2));
  description.actuator("q5", "swing_shank", "swing_thigh");
  description.actuator("r", "counterweight", "pelvis");
  description.foot(Side::left, "stance_foot", -0.08, 0.12, -0.05, 0.6);
  return description.robot();
}

double uniform(Random& random, double from, double to)
{
  return std::uniform_real_distribution<double>(from, to)(random);
}

namespace
{

// each by a factor of its own
void vary(Random& random, std::initializer_list<double*> values)
{
  for (double* value : values)
    *value *= uniform(random, 0.7, 1.4);
}

} // namespace

Biped random_ck(Random& random)
{
  Biped ck;
  vary(random, {&ck.m0, &ck.m1, &ck.m2, &ck.m3, &ck.I0, &ck.I1, &ck.I2, &ck.I3, &ck.l1, &ck.l2, &ck.s1, &ck.s2, &ck.s3,
                &ck.s_x, &ck.s_z, &ck.h_p, &ck.l_p, &ck.l_p1});
  return ck;
}

Biped random_rk(Random& random, Placement knee)
{
  Biped rk = random_ck(random);
  rk.r1 = shipped_rk().r1;
  rk.r2 = shipped_rk().r2;
  vary(random, {&rk.r1, &rk.r2});
  rk.knee = knee;
  return rk;
}

Compass random_compass(Random& random)
{
  Compass compass;
  vary(random, {&compass.m, &compass.m_H, &compass.a, &compass.b});
  return compass;
}

Itlag random_itlag(Random& random)
{
  Itlag itlag;
  vary(random, {&itlag.l, &itlag.l_c1, &itlag.l_c2, &itlag.l_c3, &itlag.l_c4, &itlag.m1, &itlag.m2, &itlag.m3,
                &itlag.m4, &itlag.m_s, &itlag.m_c, &itlag.m_I, &itlag.I1, &itlag.I2, &itlag.I3, &itlag.I4});
  return itlag;
}

Biped shipped_rk()
{
  Biped rk;
  rk.r1 = 0.05;
  rk.r2 = 0.035;
  rk.knee = Placement::bar_parent;
  return rk;
}

Robot random_tree(Random& random, bool fixed_root)
{
  Description description(uniform(random, 1.0, 20.0));
  const auto place = [&]
  {
    return Eigen::Vector2d(uniform(random, -0.4, 0.4), uniform(random, -0.4, 0.4));
  };
  const auto body = [&](Link& link)
  {
    set_body(link, uniform(random, 0.5, 5.0), place(), uniform(random, 0.01, 0.5));
  };
  // each kind once, then any
  std::vector<JointKind> kinds{JointKind::fixed, JointKind::rolling, JointKind::slide, JointKind::revolute};
  if (fixed_root)
    kinds.push_back(JointKind::parallel);
  std::shuffle(kinds.begin(), kinds.end(), random);
  constexpr std::size_t kLinks = 9;
  while (kinds.size() < kLinks)
    kinds.push_back(kinds[random() % 4]);

  body(
      description.link("root", fixed_root ? JointKind::fixed : JointKind::floating, fixed_root ? "world" : "", "root"));
  std::vector<std::string> names{"root"};
  for (const JointKind kind : kinds)
  {
    const std::string parent = names[random() % names.size()];
    names.push_back(fmt::format("link{}", names.size()));
    Link& link = description.link(names.back().c_str(), kind, parent.c_str(), names.back().c_str());
    link.at = place();
    body(link);
    if (kind == JointKind::rolling || kind == JointKind::fixed || kind == JointKind::parallel)
      link.angle = uniform(random, -2.0, 2.0);
    if (kind == JointKind::rolling)
    {
      link.parent_radius = uniform(random, 0.02, 0.1);
      link.child_radius = uniform(random, 0.02, 0.1);
    }
  }
  description.foot(Side::left, fixed_root ? "root" : names[kLinks - 1].c_str(), -0.1, 0.2, -0.05, 0.6);
  description.foot(Side::right, names[kLinks].c_str(), -0.1, 0.2, -0.05, 0.6);
  return description.robot();
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

Motion random_consistent_motion(Random& random, const Biped& biped, Contact left, Contact right)
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
    const Eigen::MatrixXd rows = biped.J(side, contact[static_cast<int>(side)], motion.X);
    J.conservativeResize(J.rows() + rows.rows(), 9);
    J.bottomRows(rows.rows()) = rows;
  }
  // the nearest rates, then the nearest accelerations, that keep the contacts
  motion.V -= solve(J, J * motion.V);
  for (const Side side : kSides)
  {
    const Eigen::VectorXd rows = biped.Jdot_V(side, contact[static_cast<int>(side)], motion.X, motion.V);
    Jdot_V.conservativeResize(Jdot_V.size() + rows.size());
    Jdot_V.tail(rows.size()) = rows;
  }
  motion.A -= solve(J, J * motion.A + Jdot_V);
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
