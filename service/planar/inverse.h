/// The inverse of a matrix, compiled once.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace torqued
{

/// A⁻¹ by complete pivoting, A square; nothing if A is singular.
std::optional<Eigen::MatrixXd> inverse_of(const Eigen::MatrixXd& A);

} // namespace torqued
