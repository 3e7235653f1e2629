/// What a motor's rotor and its joint's friction take of its torque.
#pragma once

#include "robot/robot.h"

namespace torqued
{

/// The torque, beyond the one that reaches the links, that a motor must give.
///
///   τ_f = I θ̈ + κ_c sgn_s θ̇ + κ_v θ̇ + κ_s sgn_s θ̇ exp(−(θ̇/η_s)²) + κ_o                                      (46)
///
///   sgn_s θ̇ = θ̇ / s   where |θ̇| < s, the motor's stick_velocity;   sgn θ̇ elsewhere
///
/// θ: the angle conjugate to the motor's torque, joint_rates(); rad/s, rad/s². N m. sgn 0 = 0: a joint at rest may be
/// held by friction, by anything up to κ_c + κ_s, and this says none of it. A rotor of inertia I does the same as
/// B diag(I) Bᵀ added to M.
///
/// s = 0 is the source's sgn, by which τ_f jumps by 2 (κ_c + κ_s) where a rate passes 0: a motion that ought to rest
/// but has rates of ±10⁻⁹ rad/s makes the motor chatter. With s > 0 friction is continuous, steepest at rest:
/// (κ_c + κ_s) / s; it is the less the slower the joint creeps, and the same as with s = 0 from |θ̇| = s on.
/// Source: [Al-Shuka 2014, (46)], where exp(−(θ̇/η_s)) stands; that grows without bound for θ̇ < 0.
double joint_friction(const Actuator& actuator, double rate, double acceleration);

/// The same for all of a robot's motors; v, a: the members of θ first.
VectorJ joint_friction(const Robot& robot, const VectorQ& v, const VectorQ& a);

} // namespace torqued
