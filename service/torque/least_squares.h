/// Least squares of up to three variables.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <type_traits>

namespace torqued
{

/// |A y + b|², to be least.
struct SumOfSquares
{
  static constexpr int kMaxRows = 20;

  Eigen::Matrix<double, kMaxRows, 3> A;
  Eigen::Matrix<double, kMaxRows, 1> b;
  int rows = 0;      ///< filled up with zeros to 8, 12, 16 or 20; what follows is not set
  int variables = 0; ///< columns of A; what follows is not set

  /// Calls a function with the number of rows as a constant: that the compiler knows it is what makes sums over few
  /// rows fast.
  template <typename Function> auto with_rows(const Function& function) const
  {
    switch (rows)
    {
    case 8: return function(std::integral_constant<int, 8>());
    case 12: return function(std::integral_constant<int, 12>());
    case 16: return function(std::integral_constant<int, 16>());
    default: return function(std::integral_constant<int, kMaxRows>());
    }
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
  const auto of_rows = [&](auto rows) -> std::optional<Eigen::Vector3d>
  {
    auto b = sum.b.head<rows>();
    const auto column = [&](int k)
    {
      return sum.A.col(k).template head<rows>();
    };
    // takes from a column what it shares with q, and returns how often that is in it
    const auto take = [](const auto& q, double per_squared, auto&& from)
    {
      const double share = q.dot(from) * per_squared;
      from -= share * q;
      return share;
    };

    // A = Q U, the columns of Q orthogonal and U unit upper triangular; y = −U⁻¹ of b's shares in them
    const int n = sum.variables;
    Eigen::Matrix3d U;
    Eigen::Vector3d y = Eigen::Vector3d::Zero();
    for (int k = 0; k < n; ++k)
    {
      const auto q = column(k);
      const double squared = q.squaredNorm();
      if (squared <= rounding * rounding) // not so if it is not a number: then neither is y
        return {};
      const double per_squared = 1.0 / squared;
      for (int j = k + 1; j < n; ++j)
        U(k, j) = take(q, per_squared, column(j));
      y(k) = -take(q, per_squared, b);
    }
    for (int k = n - 2; k >= 0; --k)
      for (int j = k + 1; j < n; ++j)
        y(k) -= U(k, j) * y(j);
    return y;
  };
  return sum.with_rows(of_rows);
}

} // namespace torqued
