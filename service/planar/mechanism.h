/// A planar mechanism whose every angle is linear in its coordinates, so that all its dynamics is closed-form.
///
/// Frames, signs and units, said once for the whole program:
///
///          z                          W, the world: x forward, z up, the ground is z = 0.
///          ^   ⟲ +                    Angles, angular rates and moments are positive counter-clockwise in this
///          |                          picture (x to the right, z up). SI units and radians.
///          +-----> x                  The moment of a force F at r is r_x F_z − r_z F_x.
///
/// Every link, and every massless bar between rolling circles, is a *direction*: a frame turned by
///
///   φ = W θ + φ₀                                                                       (W, φ₀ constant)
///
/// against the world. A *point* of the mechanism is the base point plus arms, each constant in its direction's frame:
///
///   p = p_base + Σₖ R(φₖ) rₖ
///
/// The generalized coordinates are q = (θ, x_base, z_base); v = q̇ and a = q̈.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace torqued
{

/// The most coordinates of a mechanism, those of the base point included.
inline constexpr int kMaxCoordinates = 16;
/// The most directions: links that turn and bars between rolling circles.
inline constexpr int kMaxDirections = 24;

template <int MaxRows, int MaxCols>
using Bounded = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, MaxRows, MaxCols>;
template <int MaxRows> using BoundedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, MaxRows, 1>;

/// One number per coordinate; sized at run time, stored in place.
using VectorQ = BoundedVector<kMaxCoordinates>;
using MatrixQ = Bounded<kMaxCoordinates, kMaxCoordinates>;
/// One number per direction.
using VectorD = BoundedVector<kMaxDirections>;
/// One plane vector per direction, as columns.
using PlaneVectors = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxDirections>;

/// r turned by +90°.
inline Eigen::Vector2d perp(const Eigen::Vector2d& r)
{
  return {-r.y(), r.x()};
}

/// R(φ) r, with e = (cos φ, sin φ).
inline Eigen::Vector2d rotate(const Eigen::Vector2d& e, const Eigen::Vector2d& r)
{
  return {e.x() * r.x() - e.y() * r.y(), e.y() * r.x() + e.x() * r.y()};
}

/// The moment of F at r, counter-clockwise positive: r_x F_z − r_z F_x.
inline double cross(const Eigen::Vector2d& r, const Eigen::Vector2d& F)
{
  return r.x() * F.y() - r.y() * F.x();
}

/// A vector r (m) that is constant in the frame of a direction.
struct Arm
{
  int direction;
  Eigen::Vector2d r;
};

/// A point of the mechanism, as the arms that lead to it from the base point; no direction occurs twice.
using Point = std::vector<Arm>;

/// A mass (kg) at a point, with a moment of inertia (kg m²) about it that turns with a direction.
struct Body
{
  double mass;
  double inertia;
  int direction;
  Point com;
};

/// The constants of a mechanism, folded once from its bodies; immutable.
///
/// With rₖ the arm of direction k to a body's centre of mass, as a complex number x + iz, and conj its conjugate:
///
///   mass      m   = Σ m_b
///   moments   S_k = Σ m_b r_k           kg m, in direction k's frame
///   pairs     P_jk = Σ m_b conj(r_j) r_k, j < k and not zero, kg m²
///   inertia   Wᵀ diag(I_k + P_kk) W     kg m², the part of M(q) that is the same in every pose
///
/// Inverse dynamics needs nothing else (dynamics.h).
class Mechanism
{
public:
  /// The constants that couple two directions.
  struct Pair
  {
    int j, k;
    Eigen::Vector2d P;
  };

  /// W: directions × angles; offset: φ₀, rad; gravity: m/s², downward.
  ///
  /// Requires: sizes that agree and stay within kMaxCoordinates and kMaxDirections; arms and bodies that name
  /// existing directions.
  Mechanism(const Eigen::MatrixXd& W, const Eigen::VectorXd& offset, const std::vector<Body>& bodies, double gravity);

  int num_angles() const { return static_cast<int>(W_.cols()); }
  int num_directions() const { return static_cast<int>(W_.rows()); }
  /// Length of q, v and a: the angles, and the base point's two coordinates.
  int num_coordinates() const { return num_angles() + 2; }

  const Bounded<kMaxDirections, kMaxCoordinates>& W() const { return W_; }
  const VectorD& offset() const { return offset_; }
  double gravity() const { return gravity_; }               ///< m/s², downward
  double mass() const { return mass_; }                     ///< m, kg
  const PlaneVectors& moments() const { return moments_; }  ///< S, kg m, one column per direction
  const std::vector<Pair>& pairs() const { return pairs_; } ///< P, kg m², those that are not zero
  const MatrixQ& inertia() const { return inertia_; }       ///< kg m², angles × angles

private:
  Bounded<kMaxDirections, kMaxCoordinates> W_;
  VectorD offset_;
  double gravity_;
  double mass_ = 0.0;
  PlaneVectors moments_;
  std::vector<Pair> pairs_;
  MatrixQ inertia_;
};

} // namespace torqued
