/// The equation of motion as matrices, in either kind of coordinates.
#pragma once

#include "stance/contacts.h"

namespace torqued
{

/// Numbered as in desired_state_t.
enum class Coordinates : std::int8_t
{
  absolute = 0,
  relative = 1
};

/// The matrices of
///
///   M a + C v + g = B τ_out + J_cᵀ w                                                                        (1)
///
/// Their rows and columns: the robot's coordinates in their order, then, for a floating root, the base point's x and z;
/// n in all. With q_relative = A q_absolute + b constant:
///
///   M_abs = Aᵀ M_rel A,   C_abs = Aᵀ C_rel A,   g_abs = Aᵀ g_rel,   B_abs = Aᵀ B_rel,   J_abs = J_rel A
///
/// B_rel is diag(κ) above zero rows: where every coordinate has an actuator and κ = 1, B_abs = Aᵀ. Powers are equal,
/// v_relᵀ f_rel = v_absᵀ f_abs. Source: [De-León-Gómez 2017, (19) to (27)], base point and κ added.
struct EquationOfMotion
{
  int n;
  MatrixQ M;                              ///< n × n, kg m²
  MatrixQ C;                              ///< n × n, Christoffel: Ṁ − 2C is skew
  VectorQ h;                              ///< C v, N m
  VectorQ g;                              ///< N m
  Bounded<kMaxCoordinates, kMaxJoints> B; ///< n × joints
  Jacobian J;                             ///< wrench components × n; a fixed root's own contact has no rows
  Jacobian Jdot;                          ///< J̇, in the same coordinates
  WrenchVector Jdot_v;                    ///< J̇ v, m/s², rad/s²
  VectorQ generalized_force;              ///< M a + h + g, N m; without what rotors and friction take
};

/// The equation of motion of a state. Requires: check_contacts() of the support.
EquationOfMotion equation_of_motion(const Robot& robot, const Motion& motion, const Support& support,
                                    Coordinates coordinates);

/// The generalized force f, length num_q() as everywhere inside, in the rows of EquationOfMotion.
VectorQ in_coordinates(const Robot& robot, const VectorQ& force, Coordinates coordinates);

} // namespace torqued
