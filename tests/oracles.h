/// Closed forms written by hand, random robots and random motions. Shares no mathematics with service/.
#pragma once

#include "robot/robot.h"
#include "stance/desired_state.h"

#include <Eigen/Core>
#include <random>

namespace torqued::oracle
{

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// The seven-link biped, CK with pin knees (r1 = r2 = 0) and RK with rolling ones: m0 I0 foot, m1 I1 shin, m2 I2 thigh,
/// m3 I3 trunk (about their own centres of mass), l1 shin, l2 thigh, s1 knee to shin CoM, s2 hip to thigh CoM, s3 hip
/// to trunk CoM, s_x forward and s_z downward offset of the foot's CoM from the ankle, h_p ankle above the sole, l_p
/// heel behind and l_p1 toe before it; r1 radius of the shin's circle, r2 of the thigh's. By default the robot `ck`.
struct Biped
{
  double m0 = 0.7, m1 = 2.2, m2 = 5.0, m3 = 29.2;
  double I0 = 0.0025, I1 = 0.028, I2 = 0.066, I3 = 0.81;
  double l1 = 0.39, l2 = 0.40, s1 = 0.16, s2 = 0.17, s3 = 0.19, s_x = 0.03, s_z = 0.04;
  double h_p = 0.065, l_p = 0.07, l_p1 = 0.15;
  double r1 = 0.0, r2 = 0.0;
  Placement knee = Placement::links; ///< of the knees' actuators: parent is the thigh, child the shin
  double gravity = 9.81, friction = 0.6;

  double mass() const { return 2.0 * (m0 + m1 + m2) + m3; }
  bool rolls() const { return r1 + r2 > 0.0; }
  /// Share of its angle that a knee's actuator turns.
  double kappa() const
  {
    return knee == Placement::links ? 1.0 : (knee == Placement::bar_parent ? r1 : r2) / (r1 + r2);
  }

  /// D, H and Q of D(X) Ẍ + H(X, Ẋ) + Q(X) = B Γ + Jᵀ w, with
  /// X = (left foot, left shin, left thigh, right thigh, right shin, right foot, trunk, x_hip, z_hip).
  /// Source: [Hobon 2013], signs and what the print lost restored.
  Matrix9 D(const Vector9& X) const;
  Vector9 H(const Vector9& X, const Vector9& V) const;
  Vector9 Q(const Vector9& X) const;
  /// The Christoffel symbols of D, D differentiated by a complex step: exact to rounding.
  Matrix9 C(const Vector9& X, const Vector9& V) const;
  /// Columns: left ankle, knee, hip, right hip, knee, ankle.
  Eigen::Matrix<double, 9, 6> B() const;
  /// S of X = S (joint angles in the order of the columns of B, trunk, x_hip, z_hip).
  static Matrix9 from_joint_angles();
  /// Rows x and z of a contact point (the ankle for a sole), and the foot's angle for a sole; none for no contact.
  Eigen::MatrixXd J(Side side, Contact contact, const Vector9& X) const;
  /// J̇ Ẋ of the same rows.
  Eigen::VectorXd Jdot_V(Side side, Contact contact, const Vector9& X, const Vector9& V) const;
  Eigen::Vector2d ankle(Side side, const Vector9& X) const;
  Eigen::Vector2d contact_point(Side side, Contact contact, const Vector9& X) const;
  /// Kinetic plus potential energy, summed over the links' own positions and velocities, J.
  double energy(const Vector9& X, const Vector9& V) const;

  /// The same robot as a file would describe it.
  Robot robot() const;
};

/// The biped with one foot flat on the ground for good, by reduction of the above: Ẋ = F q̇ with the stance ankle at the
/// origin. q = (stance shank, stance thigh, trunk, swing thigh, swing shank, swing foot). Source: [Al-Shuka 2014],
/// which prints no closed form.
struct SixLink
{
  Biped biped;
  Side stance = Side::left;

  Vector9 X(const Vector6& q) const;
  Eigen::Matrix<double, 9, 6> F(const Vector6& q) const;
  Eigen::Matrix<double, 9, 6> Fdot(const Vector6& q, const Vector6& v) const;
  Matrix6 M(const Vector6& q) const;
  Matrix6 C(const Vector6& q, const Vector6& v) const;
  Vector6 g(const Vector6& q) const;
  /// Columns: stance ankle, knee, hip, swing hip, knee, ankle; A of A τ.
  Matrix6 A() const;
  /// Contact of the swing foot.
  Eigen::MatrixXd J(Contact contact, const Vector6& q) const;
  Eigen::VectorXd Jdot_v(Contact contact, const Vector6& q, const Vector6& v) const;
  /// (F_x, F_z) of the ground, and in the third entry its moment about the stance ankle less the ankle's torque.
  Eigen::Vector3d ground(const Vector6& q, const Vector6& v, const Vector6& a) const;

  Robot robot() const;
};

/// The compass-gait biped: point masses m in the legs, a from the foot and b from the hip, and m_H at the hip.
/// Relative: q1 from the horizontal to the stance leg, q2 from its extension to the swing leg. Absolute: (θ_s, θ_ns)
/// from the vertical, legs pointing from foot to hip. q = A θ + b. Source: [De-León-Gómez 2017, section 4].
struct Compass
{
  double m = 5.0, m_H = 10.0, a = 0.5, b = 0.5, gravity = 9.81;

  double l() const { return a + b; }
  Eigen::Matrix2d M(const Eigen::Vector2d& q) const;
  Eigen::Matrix2d C(const Eigen::Vector2d& q, const Eigen::Vector2d& v) const;
  Eigen::Vector2d g(const Eigen::Vector2d& q) const;
  Eigen::Matrix2d M_bar(const Eigen::Vector2d& theta) const;
  Eigen::Matrix2d C_bar(const Eigen::Vector2d& theta, const Eigen::Vector2d& v) const;
  Eigen::Vector2d g_bar(const Eigen::Vector2d& theta) const;
  static Eigen::Matrix2d A();
  static Eigen::Vector2d offset(); ///< b of q = A θ + b

  Robot robot() const;
};

/// Bip-ITLag in single support: legs of shank and thigh, each l long, l_c its centre of mass from its lower end in the
/// stance leg (1 shank, 2 thigh) and in the swing leg (3 thigh, 4 shank); pelvis m_s and feet that do not turn (swing
/// foot m_I), and the counterweight m_c that slides sideways. Absolute: (θ1 … θ4, r); relative: (q1, q2, q4, q5, r).
/// Source: [De-León-Gómez 2017, (47) to (51)], K_F corrected.
struct Itlag
{
  double l = 0.4, l_c1 = 0.22, l_c2 = 0.24, l_c3 = 0.23, l_c4 = 0.25;
  double m1 = 2.4, m2 = 3.6, m3 = 3.4, m4 = 2.2, m_s = 4.0, m_c = 3.0, m_I = 0.9;
  double I1 = 0.03, I2 = 0.05, I3 = 0.045, I4 = 0.025, gravity = 9.81;

  Matrix5 M(const Vector5& q) const;
  Matrix5 C(const Vector5& q, const Vector5& v) const;
  Vector5 g(const Vector5& q) const;
  Matrix5 M_bar(const Vector5& theta) const;
  Matrix5 C_bar(const Vector5& theta, const Vector5& v) const;
  Vector5 g_bar(const Vector5& theta) const;
  static Matrix5 A();
  static Matrix5 A_inverse();
  static Vector5 offset();

  Robot robot() const;

private:
  struct Constants
  {
    double A, B, C, D, F, G, H, L, M, N, O;
  };
  Constants K() const;
  Matrix5 amplitudes() const; // of the cosines in M̄, row < column
};

using Random = std::mt19937_64;
double uniform(Random& random, double from, double to);

/// f'(0) by the stencil of eighth order. For a part of frequency ω its error is ω (ω h)⁸ / 630 of that part, and the
/// rounding of f over h.
template <typename F> auto slope(const F& f, double h)
{
  using Value = std::decay_t<decltype(f(h))>;
  const Value one = f(h) - f(-h);
  const Value two = f(2.0 * h) - f(-2.0 * h);
  const Value three = f(3.0 * h) - f(-3.0 * h);
  const Value four = f(4.0 * h) - f(-4.0 * h);
  const Value result = (4.0 / 5.0 * one - 1.0 / 5.0 * two + 4.0 / 105.0 * three - 1.0 / 280.0 * four) / h;
  return result;
}

/// A robot whose lengths, masses and offsets all differ from each other.
Biped random_ck(Random& random);
/// The same with rolling knees, of radii that differ.
Biped random_rk(Random& random, Placement knee = Placement::bar_parent);
Compass random_compass(Random& random);
Itlag random_itlag(Random& random);
/// The robot `rk`.
Biped shipped_rk();

/// A mechanism of no use, with every kind of joint that its root allows: links on turned and shifted links, bars that
/// stand at an angle, slides on slides; feet at its last links, and at a fixed root.
Robot random_tree(Random& random, bool fixed_root);

/// A walking-like pose, and rates and accelerations of a few rad/s and rad/s².
struct Motion
{
  Vector9 X, V, A;
};
Motion random_motion(Random& random);

/// A motion that keeps its contacts: soles level, and J V = 0 and J A + J̇ V = 0 to rounding.
Motion random_consistent_motion(Random& random, const Biped& biped, Contact left, Contact right);

/// A desired state with this motion; base given.
DesiredState desired_state(const Motion& motion, Contact left, Contact right, Side leading = Side::left,
                           double load_transfer = 0.0);

} // namespace torqued::oracle
