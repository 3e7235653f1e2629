/// Comparing vectors and matrices, with the worst entry named.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <fmt/format.h>
#include <string>

namespace torqued
{

/// "" if both have the same shape and no entry differs by more than tolerance × max(1, largest |expected|); else what
/// differs most. NaN equals nothing.
template <typename A, typename B>
std::string mismatch(const Eigen::MatrixBase<A>& found_expression, const Eigen::MatrixBase<B>& expected_expression,
                     double tolerance)
{
  const Eigen::MatrixXd found = found_expression;
  const Eigen::MatrixXd expected = expected_expression;
  if (found.rows() != expected.rows() || found.cols() != expected.cols())
    return fmt::format("shape {} x {}, expected {} x {}", found.rows(), found.cols(), expected.rows(), expected.cols());
  if (expected.size() == 0)
    return "";
  if (!found.allFinite() || !expected.allFinite())
    return "an entry is not finite";
  const double scale = std::max(1.0, expected.cwiseAbs().maxCoeff());
  Eigen::Index row = 0, col = 0;
  const double worst = (found - expected).cwiseAbs().maxCoeff(&row, &col);
  if (worst <= tolerance * scale)
    return "";
  return fmt::format("({}, {}) is {:.17g}, expected {:.17g}: off by {:.3g}, allowed {:.3g}", row, col, found(row, col),
                     expected(row, col), worst, tolerance * scale);
}

inline std::string mismatch(double found, double expected, double tolerance)
{
  return mismatch(Eigen::Matrix<double, 1, 1>(found), Eigen::Matrix<double, 1, 1>(expected), tolerance);
}

} // namespace torqued
