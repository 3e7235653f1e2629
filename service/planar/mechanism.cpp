#include "planar/mechanism.h"

#include <cassert>

namespace torqued
{

Mechanism::Mechanism(const Eigen::MatrixXd& W, const Eigen::VectorXd& offset, const std::vector<Body>& bodies,
                     double gravity)
    : W_(W), offset_(offset), gravity_(gravity)
{
  assert(W.rows() == offset.size() && W.rows() <= kMaxDirections && num_coordinates() <= kMaxCoordinates);
  const int directions = num_directions();
  moments_.setZero(2, directions);
  VectorD turning = VectorD::Zero(directions);
  std::vector<Eigen::Vector2d> P(static_cast<std::size_t>(directions * directions), Eigen::Vector2d::Zero());

  for (const Body& body : bodies)
  {
    mass_ += body.mass;
    turning(body.direction) += body.inertia;
    for (const Arm& arm : body.com)
    {
      moments_.col(arm.direction) += body.mass * arm.r;
      turning(arm.direction) += body.mass * arm.r.squaredNorm();
      for (const Arm& other : body.com)
        if (arm.direction < other.direction)
          P[static_cast<std::size_t>(arm.direction * directions + other.direction)] +=
              body.mass * Eigen::Vector2d(arm.r.dot(other.r), cross(arm.r, other.r));
    }
  }

  for (int j = 0; j < directions; ++j)
    for (int k = j + 1; k < directions; ++k)
      if (const Eigen::Vector2d& pair = P[static_cast<std::size_t>(j * directions + k)]; !pair.isZero(0.0))
        pairs_.push_back({j, k, pair});

  inertia_ = W_.transpose() * turning.asDiagonal() * W_;
}

} // namespace torqued
