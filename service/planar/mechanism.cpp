#include "planar/mechanism.h"

#include <cassert>

namespace torqued
{

Mechanism::Mechanism(const Eigen::MatrixXd& W, const std::vector<Body>& bodies, double gravity)
    : W_(W), gravity_(gravity)
{
  assert(W.rows() <= kMaxDirections && num_q() <= kMaxCoordinates);
  const int directions = num_directions();
  moments_.setZero(2, directions);
  VectorD turning = VectorD::Zero(directions); // Σ m |r_k|²
  Eigen::MatrixXd sliding = Eigen::MatrixXd::Zero(num_theta(), num_theta());
  std::vector<Eigen::Vector2d> P(static_cast<std::size_t>(directions * directions), Eigen::Vector2d::Zero());
  // Σ m conj(r_j) r_k, kept for j < k, because P_kj = conj(P_jk); what belongs to one direction does not turn against
  // itself
  const auto add_pair = [&](int j, int k, const Eigen::Vector2d& r_j, const Eigen::Vector2d& m_r_k)
  {
    const double real = r_j.dot(m_r_k);
    const double imaginary = cross(r_j, m_r_k);
    if (j == k)
      turning(k) += real;
    else if (j < k)
      P[static_cast<std::size_t>(j * directions + k)] += Eigen::Vector2d(real, imaginary);
    else
      P[static_cast<std::size_t>(k * directions + j)] += Eigen::Vector2d(real, -imaginary);
  };

  for (const Body& body : bodies)
  {
    mass_ += body.mass;
    turning(body.direction) += body.inertia;
    moments_.col(body.direction) += body.moment;
    for (std::size_t i = 0; i < body.origin.size(); ++i)
    {
      const Arm& arm = body.origin[i];
      moments_.col(arm.direction) += body.mass * arm.r;
      turning(arm.direction) += body.mass * arm.r.squaredNorm();
      for (std::size_t j = i + 1; j < body.origin.size(); ++j)
        add_pair(arm.direction, body.origin[j].direction, arm.r, body.mass * body.origin[j].r);
      // where the origin lies along the body's own direction, both orders of the product count
      add_pair(arm.direction, body.direction, arm.r, (arm.direction == body.direction ? 2.0 : 1.0) * body.moment);
    }
    for (const int row : body.slides)
      for (const int column : body.slides)
        sliding(row, column) += body.mass;
  }

  for (int j = 0; j < directions; ++j)
    for (int k = j + 1; k < directions; ++k)
      if (const Eigen::Vector2d& pair = P[static_cast<std::size_t>(j * directions + k)]; !pair.isZero(0.0))
        pairs_.push_back({j, k, pair});

  inertia_ = W_.transpose() * turning.asDiagonal() * W_ + sliding;
}

} // namespace torqued
