/// Closed forms written by hand, random robots and random motions. Shares no mathematics with service/.
#pragma once

#include "robot/robot.h"
#include "torque/desired_state.h"

#include <Eigen/Core>
#include <random>

namespace torqued::oracle
{

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// The seven-link biped with pin knees: m0 I0 foot, m1 I1 shin, m2 I2 thigh, m3 I3 trunk (about their own centres of
/// mass), l1 shin, l2 thigh, s1 knee to shin CoM, s2 hip to thigh CoM, s3 hip to trunk CoM, s_x forward and s_z
/// downward offset of the foot's CoM from the ankle, h_p ankle above the sole, l_p heel behind and l_p1 toe before it.
struct Ck
{
  double m0 = 0.7, m1 = 2.2, m2 = 5.0, m3 = 29.2;
  double I0 = 0.0025, I1 = 0.028, I2 = 0.066, I3 = 0.81;
  double l1 = 0.39, l2 = 0.40, s1 = 0.16, s2 = 0.17, s3 = 0.19, s_x = 0.03, s_z = 0.04;
  double h_p = 0.065, l_p = 0.07, l_p1 = 0.15;
  double gravity = 9.81, friction = 0.6;

  double mass() const { return 2.0 * (m0 + m1 + m2) + m3; }

  /// D, H and Q of D(X) Ẍ + H(X, Ẋ) + Q(X) = B Γ + Jᵀ w, with
  /// X = (left foot, left shin, left thigh, right thigh, right shin, right foot, trunk, x_hip, z_hip).
  /// Source: M. Hobon, N. Lakbakbi El Yaaqoubi, G. Abba, technical report RR6/2013-AG, signs restored.
  Matrix9 D(const Vector9& X) const;
  Vector9 H(const Vector9& X, const Vector9& V) const;
  Vector9 Q(const Vector9& X) const;
  /// Columns: left ankle, knee, hip, right hip, knee, ankle.
  static Eigen::Matrix<double, 9, 6> B();
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

using Random = std::mt19937_64;
double uniform(Random& random, double from, double to);

/// A robot whose lengths, masses and offsets all differ from each other.
Ck random_ck(Random& random);

/// A walking-like pose, and rates and accelerations of a few rad/s and rad/s².
struct Motion
{
  Vector9 X, V, A;
};
Motion random_motion(Random& random);

/// A motion that keeps its contacts: soles level, and J V = 0 and J A + J̇ V = 0 to rounding.
Motion random_consistent_motion(Random& random, const Ck& ck, Contact left, Contact right);

/// A desired state with this motion; base given.
DesiredState desired_state(const Motion& motion, Contact left, Contact right, Side leading = Side::left,
                           double load_transfer = 0.0);

} // namespace torqued::oracle
