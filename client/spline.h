/// Derivatives of sampled motions.
#pragma once

#include <Eigen/Core>

namespace torqued
{

/// The fewest samples that a quintic spline passes through.
inline constexpr int kFewestSplineSamples = 6;

/// Velocities and accelerations at the samples; one row per sample, one column per coordinate.
struct Derivatives
{
  Eigen::MatrixXd first, second;
};

/// Derivatives at the samples of the quintic splines that pass through them.
///
///   s(t) = Σ_j c_j B_j(t),   Σ_j c_j B_j(t_i) = x_i          B_j: B-splines of degree 5, i, j = 1 … n
///
/// The knots are the samples' times but for the three next to each end ("not-a-knot"), so the spline needs no end
/// conditions, and reproduces every polynomial of degree 5. Its acceleration is continuous, and so is its jerk.
///
/// times: s, any spacing. values: one row per sample, one column per coordinate.
/// Requires: at least kFewestSplineSamples samples; times strictly increasing; finite values.
/// Source: C. de Boor, "A Practical Guide to Splines", revised edition, 2001, chapter XIII.
Derivatives spline_derivatives(const Eigen::VectorXd& times, const Eigen::MatrixXd& values);

} // namespace torqued
