#include "motion/spline.h"

#include <Eigen/SparseLU>
#include <array>
#include <cassert>
#include <unsupported/Eigen/Splines>
#include <vector>

namespace torqued
{

namespace
{

constexpr Eigen::Index kQuintic = 5;
using Spline = Eigen::Spline<double, 1, kQuintic>;

// both ends six times, and of the times between them all but those next to the ends
Spline::KnotVectorType not_a_knot(const Eigen::VectorXd& times)
{
  const Eigen::Index n = times.size();
  Spline::KnotVectorType knots(n + kQuintic + 1);
  knots.head(kQuintic + 1).setConstant(times(0));
  knots.segment(kQuintic + 1, n - kQuintic - 1) = times.segment(3, n - kQuintic - 1).transpose().array();
  knots.tail(kQuintic + 1).setConstant(times(n - 1));
  return knots;
}

// Of each order up to one, the derivative of the j-th B-spline at the i-th instant: B(i, j).
std::array<Eigen::SparseMatrix<double>, 3> bases(const Eigen::VectorXd& instants, const Spline::KnotVectorType& knots,
                                                 Eigen::Index order)
{
  std::array<Eigen::SparseMatrix<double>, 3> B;
  std::array<std::vector<Eigen::Triplet<double>>, 3> entries;
  for (Eigen::Index i = 0; i < instants.size(); ++i)
  {
    const Eigen::Index first = Spline::Span(instants(i), kQuintic, knots) - kQuintic;
    const auto basis = Spline::BasisFunctionDerivatives(instants(i), order, kQuintic, knots);
    for (Eigen::Index k = 0; k <= order; ++k)
      for (Eigen::Index j = 0; j <= kQuintic; ++j)
        entries[static_cast<std::size_t>(k)].emplace_back(i, first + j, basis(k, j));
  }
  for (std::size_t k = 0; k <= static_cast<std::size_t>(order); ++k)
  {
    B[k].resize(instants.size(), knots.size() - kQuintic - 1);
    B[k].setFromTriplets(entries[k].begin(), entries[k].end());
  }
  return B;
}

} // namespace

SampledMotion spline(const Eigen::VectorXd& times, const Eigen::MatrixXd& samples, const Eigen::VectorXd& instants)
{
  assert(times.size() >= kFewestSplineSamples && samples.rows() == times.size());
  const Spline::KnotVectorType knots = not_a_knot(times);

  // B c = x
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> B_lu(bases(times, knots, 0)[0]);
  const Eigen::MatrixXd c = B_lu.solve(samples);
  const auto B = bases(instants, knots, 2);
  return {B[0] * c, B[1] * c, B[2] * c};
}

} // namespace torqued
