#include "client/spline.h"

#include <Eigen/SparseLU>
#include <array>
#include <cassert>
#include <unsupported/Eigen/Splines>
#include <vector>

namespace torqued
{

namespace
{

constexpr Eigen::Index kDegree = 5;
using Spline = Eigen::Spline<double, 1, kDegree>;

// both ends six times, and of the times between them all but those next to the ends
Spline::KnotVectorType not_a_knot(const Eigen::VectorXd& times)
{
  const Eigen::Index n = times.size();
  Spline::KnotVectorType knots(n + kDegree + 1);
  knots.head(kDegree + 1).setConstant(times(0));
  knots.segment(kDegree + 1, n - kDegree - 1) = times.segment(3, n - kDegree - 1).transpose().array();
  knots.tail(kDegree + 1).setConstant(times(n - 1));
  return knots;
}

} // namespace

Derivatives spline_derivatives(const Eigen::VectorXd& times, const Eigen::MatrixXd& values)
{
  const Eigen::Index n = times.size();
  assert(n >= kFewestSplineSamples && values.rows() == n);
  const Spline::KnotVectorType knots = not_a_knot(times);

  // B(i, j) and its derivatives: value, velocity and acceleration of the j-th B-spline at the i-th sample
  std::array<std::vector<Eigen::Triplet<double>>, 3> entries;
  for (Eigen::Index i = 0; i < n; ++i)
  {
    const Eigen::Index first = Spline::Span(times(i), kDegree, knots) - kDegree;
    const auto basis = Spline::BasisFunctionDerivatives(times(i), 2, kDegree, knots);
    for (Eigen::Index order = 0; order < 3; ++order)
      for (Eigen::Index j = 0; j <= kDegree; ++j)
        entries[static_cast<std::size_t>(order)].emplace_back(i, first + j, basis(order, j));
  }
  std::array<Eigen::SparseMatrix<double>, 3> B;
  for (std::size_t order = 0; order < 3; ++order)
  {
    B[order].resize(n, n);
    B[order].setFromTriplets(entries[order].begin(), entries[order].end());
  }

  // B c = x
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> B_lu(B[0]);
  const Eigen::MatrixXd c = B_lu.solve(values);
  return {B[1] * c, B[2] * c};
}

} // namespace torqued
