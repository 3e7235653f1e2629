/// The equation of motion of a mechanism, in closed form from its pair constants.
#pragma once

#include "planar/kinematics.h"

namespace torqued
{

/// Computes inverse dynamics: the generalized force that gives the mechanism the acceleration a.
///
///   r = M(q) a + h(q, v) + g(q)
///
/// Returned in the order of q: N m for the angles, N for the base point's x and z (the total force that the motion
/// needs, m (c̈ + g ẑ)). Actuators and contacts must supply r together.
///
/// With eₖ = cos φₖ + i sin φₖ and ẍₖ = (i φ̈ₖ − φ̇ₖ²) eₖ the acceleration of a unit arm, as complex numbers:
///
///   r_base = m (a_base + i g) + Σ S_k ẍ_k
///   r_j    = Re[ conj(i e_j) ( conj(S_j) (a_base + i g) + Σ_{k≠j} P_jk ẍ_k ) ],  P_kj = conj(P_jk)
///   r_θ    = Wᵀ (r_j) + inertia · θ̈
///
/// which is Newton's law for each body, projected on what each direction moves. Requires: a of length
/// num_coordinates(), `now` of the same state.
VectorQ inverse_dynamics(const Mechanism& mechanism, const Kinematics& now, const VectorQ& a);

} // namespace torqued
