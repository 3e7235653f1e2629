/// Sampled motions as splines.
#pragma once

#include <Eigen/Core>

namespace torqued
{

/// The fewest samples that a quintic spline passes through.
inline constexpr int kFewestSplineSamples = 6;

/// Positions, velocities and accelerations; one row per instant, one column per coordinate.
struct SampledMotion
{
  Eigen::MatrixXd position, velocity, acceleration;
};

/// The quintic splines that pass through samples, at other instants or the same.
///
///   s(t) = Σ_j c_j B_j(t),   Σ_j c_j B_j(t_i) = x_i          B_j: B-splines of degree 5, i, j = 1 … n
///
/// The knots are the samples' times but for the three next to each end ("not-a-knot"), so the spline needs no end
/// conditions, and reproduces every polynomial of degree 5. Its acceleration is continuous, and so is its jerk. Beyond
/// the ends its outermost polynomials go on.
///
/// times: s, any spacing. samples: one row per time, one column per coordinate. instants: s, in any order.
/// Requires: at least kFewestSplineSamples samples; times strictly increasing; finite values.
/// Source: C. de Boor, "A Practical Guide to Splines", revised edition, 2001, chapter XIII.
SampledMotion spline(const Eigen::VectorXd& times, const Eigen::MatrixXd& samples, const Eigen::VectorXd& instants);

} // namespace torqued
