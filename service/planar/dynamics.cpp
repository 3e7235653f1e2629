#include "planar/dynamics.h"

namespace torqued
{

VectorQ inverse_dynamics(const Mechanism& mechanism, const Kinematics& now, const VectorD& turn,
                         const Eigen::Vector2d& base)
{
  const int size = mechanism.num_theta();
  const int directions = mechanism.num_directions();
  const PlaneVectors& S = mechanism.moments();

  // acceleration of the base point, gravity included
  const Eigen::Vector2d a_base = base + Eigen::Vector2d(0.0, mechanism.gravity());

  // ẍ of every direction and i ẍ; what it feels of the base point, and in the end of every other direction
  PlaneVectors arm(2, directions), turned(2, directions), felt(2, directions);
  const Eigen::Vector2d turned_base = perp(a_base);
  Eigen::Vector2d force = mechanism.mass() * a_base;
  for (int k = 0; k < directions; ++k)
  {
    const Eigen::Vector2d e = now.e.col(k), i_e = perp(e);
    const double squared = now.rate(k) * now.rate(k);
    const Eigen::Vector2d x = turn(k) * i_e - squared * e;
    const Eigen::Vector2d i_x = perp(x);
    const Eigen::Vector2d S_k = S.col(k);
    arm.col(k) = x;
    turned.col(k) = i_x;
    felt.col(k) = S_k.x() * a_base - S_k.y() * turned_base;
    force += S_k.x() * x + S_k.y() * i_x;
  }
  for (const auto& [j, k, P] : mechanism.pairs())
  {
    felt.col(j) += P.x() * arm.col(k) + P.y() * turned.col(k);
    felt.col(k) += P.x() * arm.col(j) - P.y() * turned.col(j);
  }
  const auto moment = [&](int k)
  {
    return cross(now.e.col(k), felt.col(k)) + mechanism.inertias()(k) * turn(k);
  };

  VectorQ r(size + 2);
  for (int k = 0; k < size; ++k)
    r(k) = moment(k);
  for (const auto& [bar, column, share] : mechanism.shares_of_bars())
    r(column) += share * moment(bar);
  for (const auto& [row, column, mass] : mechanism.sliding())
    r(row) += mass * turn(column);
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
