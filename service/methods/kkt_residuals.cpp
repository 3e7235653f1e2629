#include "methods/quadratic_program.h"

#include <algorithm>
#include <limits>

namespace torqued
{

double KktResiduals::largest() const
{
  return std::max({stationarity, violation, sign, complementarity});
}

KktResiduals kkt_residuals(const QuadraticProgram& program, const BoundedVector<kMaxVariables>& y,
                           const BoundedVector<kMaxRows>& lambda)
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (!y.allFinite() || !lambda.allFinite())
    return {infinity, infinity, infinity, infinity};
  const Rows& rows = program.rows;
  double force = std::max({program.H.norm() * y.norm(), program.g.norm(), 1.0}), largest = 1.0;
  for (int i = 0; i < rows.size(); ++i)
  {
    force = std::max(force, std::abs(lambda(i)) * rows.A.row(i).norm());
    largest = std::max(largest, std::abs(lambda(i)));
  }
  KktResiduals worst{(program.H * y + program.g + rows.A.transpose() * lambda).norm() / force, 0.0, 0.0, 0.0};
  for (int i = 0; i < rows.size(); ++i)
  {
    const double lacks =
        (rows.A.row(i).dot(y) - rows.b(i) - (rows.soft[static_cast<std::size_t>(i)] ? lambda(i) : 0.0)) /
        std::max({rows.A.row(i).norm() * y.norm(), std::abs(rows.b(i)), 1.0});
    worst.violation = std::max(worst.violation, lacks);
    worst.sign = std::max(worst.sign, -lambda(i) / largest);
    worst.complementarity = std::max(worst.complementarity, lambda(i) / largest * std::abs(lacks));
  }
  return worst;
}

} // namespace torqued
