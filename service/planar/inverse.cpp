#include "planar/inverse.h"

#include <Eigen/LU>

namespace torqued
{

std::optional<Eigen::MatrixXd> inverse_of(const Eigen::MatrixXd& A)
{
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(A);
  return lu.isInvertible() ? std::optional<Eigen::MatrixXd>(lu.inverse()) : std::nullopt;
}

} // namespace torqued
