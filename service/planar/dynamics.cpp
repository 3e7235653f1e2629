#include "planar/dynamics.h"

namespace torqued
{

double inverse_dynamics(const Mechanism& mechanism, const Kinematics& now, const VectorD& turn,
                        const Eigen::Vector2d& base, VectorQ& r)
{
  const int size = mechanism.num_theta();
  const int directions = mechanism.num_directions();

  // ẍ of every direction; S in the world; what a direction feels in the ends of all others
  PlaneVectors arm(2, directions), moments(2, directions), felt(2, directions);
  Eigen::Vector2d force = Eigen::Vector2d::Zero();
  for (int k = 0; k < directions; ++k)
  {
    const Eigen::Vector2d e = now.e.col(k);
    const Eigen::Vector2d x = turn(k) * perp(e) - now.rate(k) * now.rate(k) * e;
    const Eigen::Vector2d S_k = mechanism.moments().col(k);
    arm.col(k) = x;
    moments.col(k) = rotate(e, S_k);
    felt.col(k).setZero();
    force += rotate(x, S_k);
  }
  for (const auto& [j, k, P] : mechanism.pairs())
  {
    const Eigen::Vector2d x_j = arm.col(j), x_k = arm.col(k);
    felt.col(j) += P.x() * x_k + P.y() * perp(x_k);
    felt.col(k) += P.x() * x_j - P.y() * perp(x_j);
  }

  // acceleration of the base point, gravity included; used last, because it is known last
  const Eigen::Vector2d a_base = base + Eigen::Vector2d(0.0, mechanism.gravity());
  const auto moment = [&](int k)
  {
    return cross(now.e.col(k), felt.col(k)) + mechanism.inertias()(k) * turn(k) + cross(moments.col(k), a_base);
  };
  double total = 0.0;
  r.resize(size + 2);
  for (int k = 0; k < size; ++k)
    total += r(k) = moment(k);
  for (const auto& [bar, column, share] : mechanism.shares_of_bars())
  {
    const double x = share * moment(bar);
    r(column) += x;
    total += x;
  }
  for (const auto& [row, column, mass] : mechanism.sliding())
    r(row) += mass * turn(column);
  r.tail<2>() = force + mechanism.mass() * a_base;
  return total;
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
