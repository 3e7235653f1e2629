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

namespace
{

// Adds Wᵀ X W to the corner of θ, X being value at (j, k) and transposed at (k, j), else 0. Few directions are bars,
// which more than one of θ turn.
void add_pair(const Mechanism& mechanism, int j, int k, double value, double transposed, MatrixQ& matrix)
{
  const int size = mechanism.num_theta();
  if (j < size && k < size)
  {
    matrix(j, k) += value;
    matrix(k, j) += transposed;
    return;
  }
  mechanism.for_each_share(j,
                           [&](int row, double row_share)
                           {
                             mechanism.for_each_share(k,
                                                      [&](int column, double column_share)
                                                      {
                                                        matrix(row, column) += row_share * column_share * value;
                                                        matrix(column, row) += row_share * column_share * transposed;
                                                      });
                           });
}

// Writes X W into the rows of the base point, column k of X being of_direction(k).
template <typename Column> void set_base_rows(const Mechanism& mechanism, const Column& of_direction, MatrixQ& matrix)
{
  const int size = mechanism.num_theta();
  auto rows = matrix.bottomRows(2);
  for (int k = 0; k < size; ++k)
    rows.col(k) = of_direction(k);
  for (const auto& [bar, column, share] : mechanism.shares_of_bars())
    rows.col(column) += share * of_direction(bar);
}

} // namespace

MatrixQ mass_matrix(const Mechanism& mechanism, const Kinematics& now)
{
  const int size = mechanism.num_theta();
  MatrixQ M(size + 2, size + 2);
  M.topLeftCorner(size, size) = mechanism.inertia();
  for (const auto& [j, k, P] : mechanism.pairs())
  {
    const double value = now.e.col(j).dot(rotate(P, now.e.col(k)));
    add_pair(mechanism, j, k, value, value, M);
  }
  set_base_rows(
      mechanism, [&](int k) -> Eigen::Vector2d { return perp(rotate(now.e.col(k), mechanism.moments().col(k))); }, M);
  M.topRightCorner(size, 2) = M.bottomLeftCorner(2, size).transpose();
  M.bottomRightCorner<2, 2>() = mechanism.mass() * Eigen::Matrix2d::Identity();
  return M;
}

MatrixQ coriolis_matrix(const Mechanism& mechanism, const Kinematics& now)
{
  const int size = mechanism.num_theta();
  MatrixQ C = MatrixQ::Zero(size + 2, size + 2);
  for (const auto& [j, k, P] : mechanism.pairs())
  {
    const double sine = cross(now.e.col(j), rotate(P, now.e.col(k)));
    add_pair(mechanism, j, k, -sine * now.rate(k), sine * now.rate(j), C);
  }
  set_base_rows(
      mechanism,
      [&](int k) -> Eigen::Vector2d { return -now.rate(k) * rotate(now.e.col(k), mechanism.moments().col(k)); }, C);
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
