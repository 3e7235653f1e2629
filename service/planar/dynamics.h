/// The equation of motion of a mechanism, in closed form from its pair constants.
///
///   M(q) a + C(q, v) v + g(q) = generalized force
///
/// In the order of q: N m for the angles (N for what slides sideways), N for the base point's x and z. The rows of the
/// base point are Newton's law of the whole mechanism, m (c̈ + g ẑ).
///
/// With eₖ = cos φₖ + i sin φₖ as complex numbers, and P_kj = conj(P_jk), an arm of direction k moves by i eₖ φ̇ₖ; so
///
///   M:  direction × direction  Re(conj(e_j) P_jk e_k), j ≠ k,       base × direction  i e_k S_k,          base  m
///   C:  direction × direction  Im(conj(e_j) P_jk e_k) · −φ̇_k,      base × direction  −φ̇_k e_k S_k,      base  0
///   g:  direction              Re(e_k S_k) · gravity,                                                     base  (0, m
///   gravity)
///
/// taken to the coordinates by φ̇ = W θ̇, with the constant inertia added to M.
#pragma once

#include "planar/kinematics.h"

namespace torqued
{

/// Inverse dynamics: writes the generalized force r = M a + C v + g that gives the mechanism the acceleration a.
///
/// With ẍₖ = (i φ̈ₖ − φ̇ₖ²) eₖ the acceleration of a unit arm:
///
///   r_base = m (a_base + i g) + Σ S_k ẍ_k
///   r_j    = Re[ conj(i e_j) ( conj(S_j) (a_base + i g) + Σ_{k≠j} P_jk ẍ_k ) ] + I_j φ̈_j
///   r_θ    = Wᵀ (r_j) + sliding · θ̈
///
/// which is Newton's law for each body, projected on what each direction moves; no matrix is formed.
/// direction_acceleration: φ̈ = W θ̈ of every direction, rad/s²; base: acceleration of the base point, m/s²; r: given
/// length num_q(). Returns r_base and Σ r_j: the force, and the moment about the base point, that move the whole
/// mechanism as it should, (F_x, F_z, M), N and N m.
Eigen::Vector3d inverse_dynamics(const Mechanism& mechanism, const Kinematics& now,
                                 const VectorD& direction_acceleration, const Eigen::Vector2d& base, VectorQ& r);
/// The same. Requires: a of length num_q().
inline VectorQ inverse_dynamics(const Mechanism& mechanism, const Kinematics& now, const VectorQ& a)
{
  VectorQ r;
  inverse_dynamics(mechanism, now, mechanism.of_directions(a), a.tail<2>(), r);
  return r;
}

/// M(q), symmetric and, for bodies that all have mass and inertia, positive definite.
MatrixQ mass_matrix(const Mechanism& mechanism, const Kinematics& now);

/// The matrix C(q, v) of Christoffel symbols: h = C v, and Ṁ − 2C is skew.
///
/// For a system of particles Σ m Jᵀ J̇ is that matrix; for unit arms J̇ = −φ̇ e.
MatrixQ coriolis_matrix(const Mechanism& mechanism, const Kinematics& now);

/// g(q), the gradient of potential_energy().
VectorQ gravity_force(const Mechanism& mechanism, const Kinematics& now);

/// ½ vᵀ M v, J.
double kinetic_energy(const Mechanism& mechanism, const Kinematics& now, const VectorQ& v);

/// Σ m p / m, of all bodies, in W, m. Requires: mass.
Eigen::Vector2d centre_of_mass(const Mechanism& mechanism, const Kinematics& now);

/// gravity · Σ m z, zero on the ground, J.
double potential_energy(const Mechanism& mechanism, const Kinematics& now);

} // namespace torqued
