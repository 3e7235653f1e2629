/// What a motor's rotor and its joint's friction take of its torque.
#pragma once

#include "robot/robot.h"

namespace torqued
{

/// The torque, beyond the one that reaches the links, that a motor must give.
///
///   τ_f = I θ̈ + κ_c sgn θ̇ + κ_v θ̇ + κ_s sgn θ̇ exp(−(θ̇/η_s)²) + κ_o                                          (46)
///
/// θ: the angle conjugate to the motor's torque, joint_rates(); rad/s, rad/s². N m. sgn 0 = 0: a joint at rest may be
/// held by friction, by anything up to κ_c + κ_s, and this says none of it. A rotor of inertia I does the same as
/// B diag(I) Bᵀ added to M.
/// Source: [Al-Shuka 2014, (46)], where exp(−(θ̇/η_s)) stands; that grows without bound for θ̇ < 0.
double joint_friction(const Actuator& actuator, double rate, double acceleration);

/// The same for all of a robot's motors; v, a: the members of θ first.
VectorJ joint_friction(const Robot& robot, const VectorQ& v, const VectorQ& a);

} // namespace torqued
