#include "planar/kinematics.h"

#include <cmath>

namespace torqued
{

Kinematics kinematics(const Mechanism& mechanism, const VectorQ& q, const VectorQ& v)
{
  const int size = mechanism.num_theta();
  Kinematics now;
  const VectorD phi = mechanism.W() * q.head(size);
  now.rate = mechanism.W() * v.head(size);
  now.e.resize(2, phi.size());
  for (int k = 0; k < phi.size(); ++k)
    now.e.col(k) << std::cos(phi(k)), std::sin(phi(k));
  now.base = q.tail<2>();
  return now;
}

Eigen::Vector2d from_base(const Kinematics& now, const Point& point)
{
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  for (const Arm& arm : point)
    p += rotate(now.e.col(arm.direction), arm.r);
  return p;
}

Eigen::Vector2d position(const Kinematics& now, const Point& point)
{
  return now.base + from_base(now, point);
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

Eigen::Vector2d acceleration(const Kinematics& now, const Point& point, const VectorD& acceleration,
                             const Eigen::Vector2d& base)
{
  Eigen::Vector2d result = base + jacobian_rate_times_v(now, point);
  for (const Arm& arm : point)
    result += acceleration(arm.direction) * perp(rotate(now.e.col(arm.direction), arm.r));
  return result;
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
