#include "planar/dynamics.h"

#include "planar/processors.h"

namespace torqued
{

TORQUED_FOR_PROCESSORS
Eigen::Vector3d inverse_dynamics(const Mechanism& mechanism, const Kinematics& now,
                                 const VectorD& direction_acceleration, const Eigen::Vector2d& base, VectorQ& r)
{
  using Numbers = Eigen::Array<double, 1, kMaxDirections>;
  const int size = mechanism.num_theta();
  const int directions = mechanism.num_directions();
  const auto block = [](const auto& numbers, int k) -> DirectionBlock
  {
    return Eigen::Map<const DirectionBlock>(numbers.data() + k);
  };

  // ẍ of every direction, S in the world, and Σ S ẍ; blocks of directions at a time
  Numbers arm_x, arm_z, moment_x, moment_z;
  DirectionBlock force_x = DirectionBlock::Zero(), force_z = force_x;
  for (int k = 0; k < directions; k += kDirectionBlock)
  {
    const DirectionBlock cosine = block(now.e.row(0), k), sine = block(now.e.row(1), k);
    const DirectionBlock S_x = block(mechanism.moments().row(0), k), S_z = block(mechanism.moments().row(1), k);
    const DirectionBlock turning = block(direction_acceleration, k), inwards = block(now.rate, k).square();
    const DirectionBlock m_x = S_x * cosine - S_z * sine, m_z = S_x * sine + S_z * cosine;
    arm_x.segment<kDirectionBlock>(k) = -turning * sine - inwards * cosine;
    arm_z.segment<kDirectionBlock>(k) = turning * cosine - inwards * sine;
    moment_x.segment<kDirectionBlock>(k) = m_x;
    moment_z.segment<kDirectionBlock>(k) = m_z;
    force_x -= turning * m_z + inwards * m_x;
    force_z += turning * m_x - inwards * m_z;
  }

  // the moment about every direction; the acceleration of the base point, gravity included, is used last, because it is
  // known last
  const double a_x = base.x(), a_z = base.y() + mechanism.gravity();
  Numbers moment;
  DirectionBlock total = DirectionBlock::Zero();
  auto pair = mechanism.pair_columns().begin();
  for (int j = 0; j < directions; j += kDirectionBlock)
  {
    // Σ P_jk ẍ_k
    DirectionBlock arms_x = DirectionBlock::Zero(), arms_z = arms_x;
    for (; pair != mechanism.pair_columns().end() && pair->row == j; ++pair)
    {
      const double x = arm_x(pair->column), z = arm_z(pair->column);
      arms_x += pair->P_x * x - pair->P_z * z;
      arms_z += pair->P_x * z + pair->P_z * x;
    }
    const DirectionBlock about = block(now.e.row(0), j) * arms_z - block(now.e.row(1), j) * arms_x +
                                 block(mechanism.inertias(), j) * block(direction_acceleration, j) +
                                 (block(moment_x, j) * a_z - block(moment_z, j) * a_x);
    moment.segment<kDirectionBlock>(j) = about;
    total += block(mechanism.turned_with_all(), j) * about;
  }

  r.resize(kMaxCoordinates);
  for (int k = 0; k < size; k += kDirectionBlock)
    r.segment<kDirectionBlock>(k) = block(moment, k).transpose();
  r.conservativeResize(size + 2);
  for (const auto& [bar, column, share] : mechanism.shares_of_bars())
    r(column) += share * moment(bar);
  for (const auto& [row, column, mass] : mechanism.sliding())
    r(row) += mass * direction_acceleration(column);
  const Eigen::Vector3d whole(force_x.sum() + mechanism.mass() * a_x, force_z.sum() + mechanism.mass() * a_z,
                              total.sum());
  r.tail<2>() = whole.head<2>();
  return whole;
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
