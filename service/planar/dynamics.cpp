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
  const int size = mechanism.num_theta();
  const int directions = mechanism.num_directions();
  const auto& S = mechanism.moments();

  // acceleration of the base point, gravity included
  const Eigen::Vector2d a_base = a.tail<2>() + Eigen::Vector2d(0.0, mechanism.gravity());

  // acceleration of a unit arm of every direction
  const VectorD turn = mechanism.W() * a.head(size);
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

  VectorQ r(mechanism.num_q());
  r.head(size) = mechanism.W().transpose() * moment + mechanism.inertia() * a.head(size);
  Eigen::Vector2d force = mechanism.mass() * a_base;
  for (int k = 0; k < directions; ++k)
    force += rotate(S.col(k), arm.col(k));
  r.tail<2>() = force;
  return r;
}

MatrixQ mass_matrix(const Mechanism& mechanism, const Kinematics& now)
{
  const int size = mechanism.num_theta();
  const int directions = mechanism.num_directions();
  const auto& W = mechanism.W();

  MatrixD between = MatrixD::Zero(directions, directions);
  for (const Mechanism::Pair& pair : mechanism.pairs())
    between(pair.j, pair.k) = between(pair.k, pair.j) = now.e.col(pair.j).dot(rotate(pair.P, now.e.col(pair.k)));
  PlaneVectors base(2, directions);
  for (int k = 0; k < directions; ++k)
    base.col(k) = perp(rotate(now.e.col(k), mechanism.moments().col(k)));

  MatrixQ M(size + 2, size + 2);
  M.topLeftCorner(size, size) = W.transpose() * between * W + mechanism.inertia();
  M.bottomLeftCorner(2, size) = base * W;
  M.topRightCorner(size, 2) = M.bottomLeftCorner(2, size).transpose();
  M.bottomRightCorner<2, 2>() = mechanism.mass() * Eigen::Matrix2d::Identity();
  return M;
}

MatrixQ coriolis_matrix(const Mechanism& mechanism, const Kinematics& now)
{
  const int size = mechanism.num_theta();
  const int directions = mechanism.num_directions();
  const auto& W = mechanism.W();

  MatrixD between = MatrixD::Zero(directions, directions);
  for (const Mechanism::Pair& pair : mechanism.pairs())
  {
    const double sine = cross(now.e.col(pair.j), rotate(pair.P, now.e.col(pair.k)));
    between(pair.j, pair.k) = -sine * now.rate(pair.k);
    between(pair.k, pair.j) = sine * now.rate(pair.j);
  }
  PlaneVectors base(2, directions);
  for (int k = 0; k < directions; ++k)
    base.col(k) = -now.rate(k) * rotate(now.e.col(k), mechanism.moments().col(k));

  MatrixQ C = MatrixQ::Zero(size + 2, size + 2);
  C.topLeftCorner(size, size) = W.transpose() * between * W;
  C.bottomLeftCorner(2, size) = base * W;
  return C;
}

VectorQ gravity_force(const Mechanism& mechanism, const Kinematics& now)
{
  VectorD moment(mechanism.num_directions());
  for (int k = 0; k < mechanism.num_directions(); ++k)
    moment(k) = mechanism.gravity() * rotate(now.e.col(k), mechanism.moments().col(k)).x();
  VectorQ g(mechanism.num_q());
  g.head(mechanism.num_theta()) = mechanism.W().transpose() * moment;
  g.tail<2>() << 0.0, mechanism.mass() * mechanism.gravity();
  return g;
}

double kinetic_energy(const Mechanism& mechanism, const Kinematics& now, const VectorQ& v)
{
  return 0.5 * v.dot(mass_matrix(mechanism, now) * v);
}

Eigen::Vector2d centre_of_mass(const Mechanism& mechanism, const Kinematics& now)
{
  Eigen::Vector2d moment = mechanism.mass() * now.base;
  for (int k = 0; k < mechanism.num_directions(); ++k)
    moment += rotate(now.e.col(k), mechanism.moments().col(k));
  return moment / mechanism.mass();
}

double potential_energy(const Mechanism& mechanism, const Kinematics& now)
{
  return mechanism.gravity() * mechanism.mass() * centre_of_mass(mechanism, now).y();
}

} // namespace torqued
