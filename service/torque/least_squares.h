/// Least squares of up to three variables.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace torqued
{

/// |A y + b|², to be least. Rows are added in whole blocks, filled up with zeros.
struct SumOfSquares
{
  static constexpr int kBlock = 8; ///< known to the compiler, which is what makes sums over few rows fast
  static constexpr int kMaxRows = 24;

  Eigen::Matrix<double, kMaxRows, 3> A;
  Eigen::Matrix<double, kMaxRows, 1> b;
  int rows = 0;      ///< a multiple of kBlock; what follows is not set
  int variables = 0; ///< columns of A; what follows is not set

  /// Entries of ½ its gradient at 0, Aᵀ b, and of ½ its curvature, Aᵀ A.
  double gradient(int k) const { return dot(A.col(k).data(), b.data()); }
  double curvature(int j, int k) const { return dot(A.col(j).data(), A.col(k).data()); }

  /// The product of two columns.
  double dot(const double* x, const double* y) const
  {
    using Block = Eigen::Map<const Eigen::Matrix<double, kBlock, 1>>;
    double sum = 0.0;
    for (int i = 0; i < rows; i += kBlock)
      sum += Block(x + i).dot(Block(y + i));
    return sum;
  }
};

/// The y of the least sum; nothing if a column of A is a sum of those before it, but for a rest no longer than
/// `rounding`. Entries beyond the variables are 0.
///
/// By modified Gram-Schmidt on [A b], which is as exact as reflections, and for three columns shorter.
/// Source: A. Björck, "Solving linear least squares problems by Gram-Schmidt orthogonalization", BIT 7, 1967.
/// sum: overwritten, because a copy of what was just written waits for it.
inline std::optional<Eigen::Vector3d> least_squares(SumOfSquares& sum, double rounding)
{
  using Block = Eigen::Matrix<double, SumOfSquares::kBlock, 1>;
  const auto block = [](double* column, int i) -> Eigen::Map<Block>
  {
    return Eigen::Map<Block>(column + i);
  };
  // takes from a column what it shares with q, and returns how often that is in it
  const auto take = [&](double* q, double per_squared, double* column)
  {
    const double share = sum.dot(q, column) * per_squared;
    for (int i = 0; i < sum.rows; i += SumOfSquares::kBlock)
      block(column, i) -= share * block(q, i);
    return share;
  };

  // A = Q U, the columns of Q orthogonal and U unit upper triangular; y = −U⁻¹ of b's shares in them
  const int n = sum.variables;
  Eigen::Matrix3d U;
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  for (int k = 0; k < n; ++k)
  {
    double* const q = sum.A.col(k).data();
    const double squared = sum.dot(q, q);
    if (squared <= rounding * rounding) // not so if it is not a number: then neither is y
      return {};
    const double per_squared = 1.0 / squared;
    for (int j = k + 1; j < n; ++j)
      U(k, j) = take(q, per_squared, sum.A.col(j).data());
    y(k) = -take(q, per_squared, sum.b.data());
  }
  for (int k = n - 2; k >= 0; --k)
    for (int j = k + 1; j < n; ++j)
      y(k) -= U(k, j) * y(j);
  return y;
}

} // namespace torqued
