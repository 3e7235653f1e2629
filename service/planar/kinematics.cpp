#include "planar/kinematics.h"

#include "planar/cosine_sine.h"

namespace torqued
{

Kinematics kinematics(const Mechanism& mechanism, const VectorQ& q, const VectorQ& v)
{
  return {.e = cosines_and_sines(mechanism.of_directions(q)), .rate = mechanism.of_directions(v), .base = q.tail<2>()};
}

void point_jacobian(const Mechanism& mechanism, const Kinematics& now, const Point& point, int row, Jacobian& J)
{
  const int size = mechanism.num_theta();
  auto rows = J.middleRows<2>(row);
  rows.setZero();
  for (const Arm& arm : point)
    rows.leftCols(size) += perp(rotate(now.e.col(arm.direction), arm.r)) * mechanism.W().row(arm.direction);
  rows.rightCols<2>().setIdentity();
}

void point_jacobian_rate(const Mechanism& mechanism, const Kinematics& now, const Point& point, int row, Jacobian& Jdot)
{
  auto rows = Jdot.middleRows<2>(row);
  rows.setZero();
  for (const Arm& arm : point)
    rows.leftCols(mechanism.num_theta()) -=
        now.rate(arm.direction) * rotate(now.e.col(arm.direction), arm.r) * mechanism.W().row(arm.direction);
}

Eigen::Vector2d jacobian_rate_times_v(const Kinematics& now, const Point& point)
{
  Eigen::Vector2d acceleration = Eigen::Vector2d::Zero();
  for (const Arm& arm : point)
  {
    const double rate = now.rate(arm.direction);
    acceleration -= rate * rate * rotate(now.e.col(arm.direction), arm.r);
  }
  return acceleration;
}

} // namespace torqued
