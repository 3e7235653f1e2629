/// Moves a motion that nearly keeps its contacts onto them.
#pragma once

#include "stance/contacts.h"

namespace torqued
{

/// How far a motion is from its contacts; all 0 if it keeps them.
struct ContactErrors
{
  double position = 0.0;      ///< largest distance of a contact point from its place, m
  double height = 0.0;        ///< FootPose::height() of the contact farthest from the ground, m
  Side farthest = Side::left; ///< that contact's foot
  double tilt = 0.0;          ///< largest angle of a foot that stands on its sole, rad
  double speed = 0.0;         ///< largest |J v|, m/s or rad/s
  double acceleration = 0.0;  ///< largest |J a + J̇ v|, m/s² or rad/s²
};

/// World x of each foot's heel as it is, or was, or will be when the foot is flat at its place: while a foot rolls from
/// heel over sole to toe without slipping, all its contacts belong to one foothold. Empty: where the foot happens to
/// be.
using Footholds = PerSide<std::optional<double>>;

/// The foothold that a foot's contact point speaks of, m. Requires: a contact on that side.
double foothold(const Robot& robot, const Kinematics& now, Side side, Contact contact);

/// A motion on its contacts.
struct Projection
{
  DesiredState state;   ///< with the base point set, and given unless the root is fixed
  ContactErrors before; ///< of the motion as it was
};

/// A motion nearly keeps its contacts within this share of the leg length, and this angle of a sole (rad).
inline constexpr double kNearPosition = 0.05;
inline constexpr double kNearTilt = 0.1;

/// The nearest motion that keeps the contacts: heel, toe or sole on the ground z = 0 at its foothold, the sole level,
///
///   φ(q) = 0,   J v = 0,   J a + J̇ v = 0
///
/// Nearest: in least squares of the coordinates' changes, angles × leg length. With S the scales, J̃ = J S and F an
/// orthonormal basis of its null space, J̃ F = 0,
///
///   q ← q − S J̃⁺ φ until φ = 0,   v ← S F Fᵀ S⁻¹ v = v − S J̃⁺ J v,   a ← a − S J̃⁺ (J a + J̇ v)
///
/// so rates and accelerations are those of a motion that keeps the contacts, though not exactly the derivatives of the
/// poses: the difference is as small as the change of q times the curvature of the contacts.
/// Source: [Al-Shuka 2014, (14) to (16)], F Fᵀ = 1 − J̃⁺ J̃.
///
/// A motion without base point is completed first (complete_motion), so that the resting foot is at x = 0.
/// Refuses: what complete_motion() refuses; inconsistent: farther away than kNearPosition and kNearTilt, or no pose
/// nearby that keeps the contacts.
Result<Projection> project(const Robot& robot, const DesiredState& desired, const Footholds& footholds = {});

} // namespace torqued
