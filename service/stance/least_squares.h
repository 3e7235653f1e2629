/// Least squares of up to three variables.
#pragma once

#include <Eigen/Core>
#include <array>
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

/// H = L D Lᵀ of three variables, H symmetric and positive definite, L unit lower triangular: without roots, because
/// one would wait for the other.
struct Ldlt3
{
  double L10, L20, L21;
  std::array<double, 3> D, per_D; ///< D and one over it

  /// False if some pivot is no larger than this share of its entry of H's diagonal.
  bool factorize(const Eigen::Matrix3d& H, double least_share)
  {
    D[0] = H(0, 0);
    per_D[0] = 1.0 / D[0];
    L10 = H(1, 0) * per_D[0];
    L20 = H(2, 0) * per_D[0];
    D[1] = H(1, 1) - L10 * H(1, 0);
    per_D[1] = 1.0 / D[1];
    const double rest = H(2, 1) - L20 * H(1, 0);
    L21 = rest * per_D[1];
    D[2] = H(2, 2) - L20 * H(2, 0) - L21 * rest;
    per_D[2] = 1.0 / D[2];
    return D[0] > 0.0 && D[1] > least_share * H(1, 1) && D[2] > least_share * H(2, 2);
  }
  /// L⁻¹ x.
  std::array<double, 3> from_left(const Eigen::Vector3d& x) const
  {
    const double z1 = x(1) - L10 * x(0);
    return {x(0), z1, x(2) - L20 * x(0) - L21 * z1};
  }
  /// H⁻¹ x.
  Eigen::Vector3d solve(const Eigen::Vector3d& x) const
  {
    const auto z = from_left(x);
    const double y2 = z[2] * per_D[2];
    const double y1 = z[1] * per_D[1] - L21 * y2;
    return {z[0] * per_D[0] - L10 * y1 - L20 * y2, y1, y2};
  }
};

/// H y = −g, of which the solution makes |A y + b|² least: H = AᵀA and g = Aᵀb.
struct NormalEquations
{
  int variables;
  Eigen::Matrix3d H = Eigen::Matrix3d::Identity(); ///< a variable that is not there has 1 of its own
  Eigen::Vector3d g = Eigen::Vector3d::Zero();

  /// Of no rows. n: variables, up to three.
  explicit NormalEquations(int n) : variables(n) { H.diagonal().head(n).setZero(); }

  /// Adds so many rows of A and b, from the first on.
  template <int rows, typename Columns, typename Column> void add(const Columns& A, const Column& b)
  {
    for (int k = 0; k < variables; ++k)
    {
      const auto column = A.col(k).template head<rows>();
      g(k) += column.dot(b.template head<rows>());
      for (int j = 0; j <= k; ++j)
        H(j, k) = H(k, j) += column.dot(A.col(j).template head<rows>());
    }
  }

  /// y; nothing where that would cost more than some three digits, because a column of A is nearly a sum of those
  /// before it, or no longer than `rounding` apart from them: least_squares() loses none. Entries beyond the variables
  /// are 0.
  std::optional<Eigen::Vector3d> solution(double rounding) const
  {
    Ldlt3 factors;
    if (!factors.factorize(H, 1e-3))
      return {};
    for (const double pivot : factors.D)
      if (!(pivot > rounding * rounding))
        return {};
    return factors.solve(-g);
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
