/// The equation of motion without the ground reactions: of what is left to move while the contacts rest.
///
///   v = F ż,   J F = 0                                                                              (14), (15)
///   a = F z̈ + Ḟ ż                                                                                         (16)
///   FᵀMF z̈ + Fᵀ(MḞ + CF) ż + Fᵀg = FᵀB τ                                                                  (21)
///   λ = F̄ᵀ(M a + C v + g − B τ),   J F̄ = 1                                                                (20)
///
/// n is that of EquationOfMotion, n_c the number of rows of J; the n − n_c numbers ż are free.
/// Source: [Al-Shuka 2014, (8) to (25)]. τ is what reaches the links, friction taken off; λ is the ground's on the
/// robot. (23) needs 2 FᵀCF where FᵀCF is printed.
#pragma once

#include "questions/equation_of_motion.h"

#include <array>
#include <string_view>

namespace torqued
{

/// A way to F. All span the same space, so that accelerations and multipliers do not depend on it.
enum class EliminationMethod
{
  partitioning,    ///< ż are some of the robot's own rates
  qr,              ///< the last columns of Q in Jᵀ = Q R
  svd,             ///< the right singular vectors that belong to no singular value
  zero_eigenvalue, ///< the eigenvectors of JᵀJ to the eigenvalue 0
  schur,           ///< the Schur vectors of JᵀJ to the same
  putd             ///< pseudo-upper-triangular decomposition: reflections that clear J row by row
};

/// The methods by name.
struct NamedElimination
{
  EliminationMethod method;
  std::string_view name;
};
inline constexpr std::array<NamedElimination, 6> kEliminations{{
    {EliminationMethod::partitioning, "partitioning"},
    {EliminationMethod::qr, "qr"},
    {EliminationMethod::svd, "svd"},
    {EliminationMethod::zero_eigenvalue, "zero-eigenvalue"},
    {EliminationMethod::schur, "schur"},
    {EliminationMethod::putd, "putd"},
}};

/// Contacts are independent when the smallest singular value of J is at least this share of its largest: F̄ and Ḟ then
/// have some nine exact digits. Feet at one place are, as long as the legs can move them apart; two soles side by side
/// under straight legs are not.
inline constexpr double kIndependentContacts = 1e-6;

/// Matrices that eliminate the multipliers.
///
/// By partitioning, ż are the rates of the coordinates `independent`, in their order: these rows of F are those of the
/// unit matrix, and of Ḟ and F̄ they are 0. Pivoting chooses the others, so that their columns of J are far from
/// dependent; another pose may have others.
/// By all other methods FᵀF = 1, F̄ = J⁺, and ż are nobody's rates. Ḟ is that of an F which moves on from this one
/// without turning in its own space, FᵀḞ = 0; an F that is computed anew at the next instant is turned against it.
struct Elimination
{
  MatrixQ F;                         ///< n × (n − n_c)
  MatrixQ Fdot;                      ///< n × (n − n_c), −F̄ J̇ F
  Bounded<kMaxCoordinates, 6> F_bar; ///< n × n_c
  /// By partitioning n − n_c coordinates, ascending; else none.
  Eigen::Matrix<int, Eigen::Dynamic, 1, 0, kMaxCoordinates, 1> independent;
};

/// Requires: J and Jdot of one shape, finite; J may have no rows, then F = 1.
/// Refuses, numerical: contacts that are not independent (kIndependentContacts), the same ones by every method.
/// Source: [Al-Shuka 2014, (13) to (16)], which prints no Ḟ; d/dt (J F) = 0 gives it.
Result<Elimination> eliminate(const Jacobian& J, const Jacobian& Jdot, EliminationMethod method);

/// The matrices of (21).
struct ReducedForm
{
  MatrixQ mass;                               ///< FᵀMF, positive definite
  MatrixQ coriolis;                           ///< Fᵀ(MḞ + CF); d/dt (FᵀMF) less twice this is skew
  VectorQ gravity;                            ///< Fᵀg
  Bounded<kMaxCoordinates, kMaxJoints> input; ///< FᵀB
};

ReducedForm reduced_form(const EquationOfMotion& equation, const Elimination& elimination);

/// λ of (20), in the order of the rows of J: what the ground does if the torques, N m, make the equation's motion.
WrenchVector multipliers(const EquationOfMotion& equation, const Elimination& elimination, const VectorJ& torque);

} // namespace torqued
