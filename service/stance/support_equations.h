/// The equation of motion on its contacts, split into the rows that motors serve and those that only the ground can.
///
///   M(q) a + h(q, v) + g(q) = B τ + J(q)ᵀ w                 (1)    τ: motors; w: ground on robot
///   G w = d,   G = N_Bᵀ Jᵀ,   d = N_Bᵀ r                    (2)    the rows without motors
///   τ = B⁺ (r − Jᵀ w)                                       (3)    the rows with motors
///   r = M a + h + g + B τ_f                                        τ_f: what rotors and friction take
///
/// N_B spans the null space of Bᵀ: the base point's x and z, and the turn of the whole robot about its base point. So
/// the three rows of (2) are Newton's and Euler's equations of the whole robot, moments about the base point, and d
/// depends on the motion alone. Every method of double support is a rule for choosing w among the solutions of (2).
#pragma once

#include "stance/contacts.h"

namespace torqued
{

/// Equations (1) and (2) of one desired state, and what the rules need to know of the pose.
struct SupportEquations
{
  SupportEquations() {} // sets nothing: zeros would cost as much as the equations
  /// Begins with the pose, its rates, and φ̈.
  SupportEquations(const Mechanism& mechanism, const DesiredState& desired)
      : now(kinematics(mechanism, desired.q, desired.v)), direction_acceleration(mechanism.of_directions(desired.a))
  {
  }

  VectorQ r;         ///< the generalized force that the motion needs
  Eigen::Vector3d d; ///< (F_x, F_z, M about the base point) that the ground must supply, N and N m
  Kinematics now;
  VectorD direction_acceleration;    ///< φ̈, rad/s²
  Eigen::Vector2d base_velocity;     ///< m/s
  Eigen::Vector2d base_acceleration; ///< m/s²
  PerSide<FootPose> feet;            ///< not set without contact
  StandingFeet standing;             ///< the same feet, as seen from the base point

  double contact_speed;    ///< largest |J v|: what should be at rest, m/s or rad/s
  double contact_residual; ///< largest |J a + J̇ v|, m/s² or rad/s²
  double sole_tilt;        ///< largest angle of a foot that stands on its sole, rad
  double contact_height;   ///< FootPose::height() of the contact farthest from the ground, m
  Side farthest;           ///< that contact's foot

  const Eigen::Vector2d& base() const { return now.base; }
  const FootPose& foot(Side side) const { return feet[side]; }
  /// The total ground force (F_x, F_z), and its moment about the world's origin.
  Eigen::Vector2d force() const { return d.head<2>(); }
  double moment_about_origin() const { return d(2) + cross(base(), force()); }
};

/// Jᵀ w: what the ground supplies of r, length num_q(). In the base point's rows it is r if w meets (2).
///
/// ground: w about the ankles.
VectorQ supported(const Robot& robot, const SupportEquations& equations, const Support& support,
                  const PerSide<Wrench>& ground);

/// Builds the equations of a desired state. Refuses what complete_motion() refuses.
Result<SupportEquations> support_equations(const Robot& robot, const DesiredState& desired);

} // namespace torqued
