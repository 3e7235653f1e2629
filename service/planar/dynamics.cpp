#include "planar/dynamics.h"

namespace torqued
{

namespace
{

// conj(a) b of two plane vectors read as complex numbers
Eigen::Vector2d conjugate_product(const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
  return {a.dot(b), cross(a, b)};
}

} // namespace

VectorQ inverse_dynamics(const Mechanism& mechanism, const Kinematics& now, const VectorQ& a)
{
  const int angles = mechanism.num_angles();
  const int directions = mechanism.num_directions();
  const auto& S = mechanism.moments();

  // acceleration of the base point, gravity included
  const Eigen::Vector2d a_base = a.tail<2>() + Eigen::Vector2d(0.0, mechanism.gravity());

  // acceleration of a unit arm of every direction
  const VectorD turn = mechanism.W() * a.head(angles);
  PlaneVectors arm(2, directions);
  for (int k = 0; k < directions; ++k)
    arm.col(k) = turn(k) * perp(now.e.col(k)) - now.rate(k) * now.rate(k) * now.e.col(k);

  // what each direction feels of the base point and of every other direction
  PlaneVectors felt(2, directions);
  for (int k = 0; k < directions; ++k)
    felt.col(k) = conjugate_product(S.col(k), a_base);
  for (const Mechanism::Pair& pair : mechanism.pairs())
  {
    felt.col(pair.j) += rotate(pair.P, arm.col(pair.k));
    felt.col(pair.k) += conjugate_product(pair.P, arm.col(pair.j));
  }
  VectorD moment(directions);
  for (int k = 0; k < directions; ++k)
    moment(k) = perp(now.e.col(k)).dot(felt.col(k));

  VectorQ r(mechanism.num_coordinates());
  r.head(angles) = mechanism.W().transpose() * moment + mechanism.inertia() * a.head(angles);
  Eigen::Vector2d force = mechanism.mass() * a_base;
  for (int k = 0; k < directions; ++k)
    force += rotate(S.col(k), arm.col(k));
  r.tail<2>() = force;
  return r;
}

} // namespace torqued
