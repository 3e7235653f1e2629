/// Where the points of a mechanism are and how they move.
#pragma once

#include "planar/mechanism.h"

namespace torqued
{

/// The pose of a mechanism and its rates: what every other computation of a sample starts from.
struct Kinematics
{
  PlaneVectors e;       ///< (cos φ, sin φ) of every direction
  VectorD rate;         ///< φ̇ = W θ̇, rad/s
  Eigen::Vector2d base; ///< base point in W, m
};

/// Computes sines, cosines and rates of all directions, once.
///
/// q, v: length mechanism.num_q().
Kinematics kinematics(const Mechanism& mechanism, const VectorQ& q, const VectorQ& v);

/// p − p_base = Σ R(φ) r, in W, m.
inline Eigen::Vector2d from_base(const Kinematics& now, const Point& point)
{
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  for (const Arm& arm : point)
    p += rotate(now.e.col(arm.direction), arm.r);
  return p;
}

/// p = p_base + Σ R(φ) r, in W, m.
inline Eigen::Vector2d position(const Kinematics& now, const Point& point)
{
  return now.base + from_base(now, point);
}

/// A contact's rows of J: at most x, z and an angle for each of two feet.
using Jacobian = Bounded<6, kMaxCoordinates>;

/// Writes J of a point into rows `row` (x) and `row + 1` (z) of J: ṗ = J v.
///
///   column of θ_c: Σ W_kc R(φ_k) r_k⊥;   columns of the base point: the unit matrix
///
/// Requires: J has num_q() columns and those rows; they are overwritten.
void point_jacobian(const Mechanism& mechanism, const Kinematics& now, const Point& point, int row, Jacobian& J);

/// Writes J̇ of a point into the same rows of Jdot; J̇ v is jacobian_rate_times_v().
///
///   column of θ_c: −Σ W_kc φ̇_k R(φ_k) r_k;   columns of the base point: 0
///
/// Requires: Jdot has num_q() columns and those rows; they are overwritten.
void point_jacobian_rate(const Mechanism& mechanism, const Kinematics& now, const Point& point, int row,
                         Jacobian& Jdot);

/// J̇ v of a point, m/s²: −Σ φ̇² R(φ) r.
Eigen::Vector2d jacobian_rate_times_v(const Kinematics& now, const Point& point);

} // namespace torqued
