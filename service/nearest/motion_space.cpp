#include "nearest/motion_space.h"

#include "planar/dynamics.h"
#include "planar/processors.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

constexpr int kBlock = 4; // of SIMD
// A pivot of W less than this share of its diagonal is none.
constexpr double kPivot = 1e-13;
// Least squares leave no more than this, over the size of the errors, where contacts do not contradict one another.
constexpr double kContradiction = 1e-9;

// M̂
MatrixQ mass_with_rotors(const Robot& robot, const Kinematics& now)
{
  MatrixQ mass = mass_matrix(robot.mechanism, now);
  if (robot.joint_friction)
    for (const auto& [row, joint, share] : robot.B)
      for (const auto& [column, other_joint, other_share] : robot.B)
        if (joint == other_joint)
          mass(row, column) += share * other_share * robot.actuators[static_cast<std::size_t>(joint)].rotor_inertia;
  return mass;
}

} // namespace

MotionSpace::MotionSpace(const Robot& robot, const SupportEquations& equations, const Support& support,
                         const AdmissibleReactions& all, const WrenchVector& contact_error, NearestMetric metric)
    : n_(robot.mechanism.num_q()), mass_(mass_with_rotors(robot, equations.now))
{
  fill_columns(robot, equations, support, all, contact_error);
  set_metric(robot, metric);
  divide_by_root();
  if (singular_)
    return;
  reflect(0, rows_);
  rank_ = reflected_;
  find_least_change();
}

Eigen::Matrix3d MotionSpace::span()
{
  if (reflected_ == rank_)
    reflect(rows_, rows_ + 3);
  Eigen::Matrix3d D = Eigen::Matrix3d::Zero();
  for (int i = 0; i < std::min(3, size()); ++i)
    D.row(i) = columns_.block<1, 3>(rank_ + i, rows_);
  return D;
}

void MotionSpace::fill_columns(const Robot& robot, const SupportEquations& equations, const Support& support,
                               const AdmissibleReactions& all, const WrenchVector& contact_error)
{
  const Mechanism& mechanism = robot.mechanism;
  columns_.topRows(n_).setZero();

  // M̂ N_B: the base point's columns, and the sum of those of all angles
  Eigen::Matrix<double, kMaxCoordinates, 3> M_N = M_N.Zero();
  VectorQ turn = VectorQ::Ones(mechanism.num_theta());
  for (const auto& [row, column, mass] : mechanism.sliding())
    turn(row) = 0.0;
  M_N.topLeftCorner(n_, 2) = mass_.rightCols<2>();
  for (int k = 0; k < mechanism.num_theta(); ++k)
    M_N.col(2).head(n_) += turn(k) * mass_.col(k);

  // what no reactions meet
  if (all.components == 0)
  {
    hard_ = rows_ = 3;
    columns_.topLeftCorner(n_, 3) = M_N.topRows(n_);
    std::copy_n(all.unmet.data(), 3, error_.begin());
  }
  else if (all.rank() == 2)
  {
    // the moment about a contact point at l from the base point, d_3 − l_x d_2 + l_z d_1
    const Side side = support.redundancy() > 0                  ? support.trailing()
                      : support.of(Side::left) != Contact::none ? Side::left
                                                                : Side::right;
    const Eigen::Vector2d& l = equations.standing[side].point;
    hard_ = rows_ = 1;
    columns_.col(0).head(n_) = (M_N.col(2) - l.x() * M_N.col(1) + l.y() * M_N.col(0)).head(n_);
    error_[0] = all.unmet(2);
  }

  // J
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    const Foot& foot = robot.foot(side);
    const StandingFoot& standing = equations.standing[side];
    const auto add = [&](int direction, const Eigen::Vector2d& r)
    {
      mechanism.for_each_share(direction,
                               [&](int coordinate, double share)
                               {
                                 columns_(coordinate, rows_) -= share * r.y();
                                 columns_(coordinate, rows_ + 1) += share * r.x();
                               });
    };
    for (std::size_t i = 0; i < foot.ankle.size(); ++i)
      add(foot.ankle[i].direction, standing.arms.col(static_cast<int>(i)));
    if (contact != Contact::sole)
      add(foot.direction, standing.point - standing.ankle);
    columns_(n_ - 2, rows_) = columns_(n_ - 1, rows_ + 1) = 1.0;
    const int row = support.row(side);
    const auto at = static_cast<std::size_t>(rows_);
    error_[at] = contact_error(row);
    error_[at + 1] = contact_error(row + 1);
    rows_ += 2;
    if (contact == Contact::sole)
    {
      const double length = std::max(foot.toe_x() - foot.heel_x(), kCoincident * robot.leg_length);
      mechanism.for_each_share(foot.direction,
                               [&](int coordinate, double share) { columns_(coordinate, rows_) += share * length; });
      error_[at + 2] = length * contact_error(row + 2);
      ++rows_;
    }
  }
  columns_.block(0, rows_, n_, 3) = M_N.topRows(n_);
}

void MotionSpace::set_metric(const Robot& robot, NearestMetric metric)
{
  root_.topRows(n_).setZero();
  if (metric == NearestMetric::mass)
    for (int k = 0; k < n_; ++k) // symmetric
      root_.row(k).head(n_) = mass_.col(k);
  else
  {
    const double per_length = 1.0 / (robot.leg_length * robot.leg_length);
    root_.diagonal().head(n_ - 2).setOnes();
    for (const auto& [row, column, mass] : robot.mechanism.sliding())
      root_(row, row) = per_length;
    root_(n_ - 2, n_ - 2) = root_(n_ - 1, n_ - 1) = per_length;
  }
  // the contact of a fixed root holds its angle and the base point, whatever moving them would cost; its link may be
  // without mass
  if (robot.fixed_root())
    for (const int k : {n_ - 3, n_ - 2, n_ - 1})
      root_(k, k) += 1.0;
}

// W = Uᵀ U by elimination, which takes the columns along; roots come last, because each step would wait for its own
TORQUED_FOR_PROCESSORS
void MotionSpace::divide_by_root()
{
  const Vector diagonal = root_.diagonal();
  for (int k = 0; k < n_; ++k)
  {
    const double pivot = root_(k, k);
    if (!(pivot > kPivot * diagonal(k)))
    {
      singular_ = true;
      return;
    }
    const double per_pivot = 1.0 / pivot;
    per_pivot_(k) = per_pivot;
    for (int i = k + 1; i < n_; ++i)
    {
      const double share = root_(k, i) * per_pivot;
      for (int c = k / kBlock * kBlock; c < n_; c += kBlock)
        root_.row(i).segment<kBlock>(c) -= share * root_.row(k).segment<kBlock>(c);
      columns_.row(i) -= share * columns_.row(k);
    }
  }
  per_pivot_.head(n_) = per_pivot_.head(n_).cwiseSqrt();
  for (int k = 0; k < n_; ++k)
  {
    root_.row(k) *= per_pivot_(k);
    columns_.row(k) *= per_pivot_(k);
  }
}

// Reflects columns from one up to another, and all that follow along with them; what depends on those before it is left
// out.
TORQUED_FOR_PROCESSORS
void MotionSpace::reflect(int from, int to)
{
  using Row = Eigen::Matrix<double, 1, kColumns>;
  const auto& columns = columns_;
  const auto products = [&](int column, int top) // of all columns with one, from a row on
  {
    Row even = Row::Zero(), odd = Row::Zero();
    int i = top;
    for (; i + 1 < n_; i += 2)
    {
      even += columns(i, column) * columns.row(i);
      odd += columns(i + 1, column) * columns.row(i + 1);
    }
    if (i < n_)
      even += columns(i, column) * columns.row(i);
    return Row(even + odd);
  };
  const Row squares = columns.topRows(n_).colwise().squaredNorm();
  for (int j = from; j < to && reflected_ < n_; ++j)
  {
    const int r = reflected_;
    Row sum = products(j, r);
    const double below = sum(j);
    if (below <= kCoincident * kCoincident * squares(j))
      continue;
    const double norm = std::sqrt(below), first = columns(r, j), more = std::copysign(norm, first);
    const double beta = 1.0 / (below + std::abs(first) * norm);
    auto normal = normals_.col(r);
    normal.setZero();
    for (int i = r; i < n_; ++i)
      normal(i) = columns(i, j);
    normal(r) += more;
    sum = beta * (sum + more * columns.row(r));
    for (int i = r; i < n_; ++i)
      columns_.row(i) -= normal(i) * sum;
    beta_[static_cast<std::size_t>(r)] = beta;
    ++reflected_;
  }
}

// Rᵀ x = −e, R being the columns of E
void MotionSpace::find_least_change()
{
  least_.setZero();
  const int exact = rank_ == rows_ ? rows_ : hard_;
  for (int j = 0; j < exact; ++j)
  {
    double left = -error_[static_cast<std::size_t>(j)];
    for (int i = 0; i < j; ++i)
      left -= columns_(i, j) * least_(i);
    least_(j) = left / columns_(j, j);
  }
  if (exact == rows_)
    return;

  // dependent contacts, in least squares
  const int rows = rows_ - hard_, rank = rank_ - hard_;
  const Bounded<6, 6> A = columns_.block(hard_, hard_, rank, rows).transpose();
  BoundedVector<6> b(rows);
  for (int j = 0; j < rows; ++j)
  {
    b(j) = -error_[static_cast<std::size_t>(hard_ + j)];
    for (int i = 0; i < hard_; ++i)
      b(j) -= columns_(i, hard_ + j) * least_(i);
  }
  const Eigen::ColPivHouseholderQR<Bounded<6, 6>> decomposition(A);
  const BoundedVector<6> x = decomposition.solve(b);
  least_.segment(hard_, rank) = x;
  contradictory_ = (A * x - b).cwiseAbs().maxCoeff() > kContradiction * std::max(1.0, b.cwiseAbs().maxCoeff());
}

TORQUED_FOR_PROCESSORS
VectorQ MotionSpace::from_reflected(Vector u, int entries) const
{
  for (int r = std::min(reflected_, entries) - 1; r >= 0; --r)
    u -= beta_[static_cast<std::size_t>(r)] * normals_.col(r).dot(u) * normals_.col(r);
  Vector delta = Vector::Zero();
  for (int i = n_ - 1; i >= 0; --i)
    delta(i) = (u(i) - root_.row(i).dot(delta)) * per_pivot_(i);
  return delta.head(n_);
}

VectorQ MotionSpace::change(const VectorQ& zeta) const
{
  Vector u = least_;
  u.segment(rank_, zeta.size()) = zeta;
  return from_reflected(u, rank_ + static_cast<int>(zeta.size()));
}

MatrixQ MotionSpace::basis() const
{
  MatrixQ F(n_, size());
  for (int k = 0; k < size(); ++k)
    F.col(k) = from_reflected(Vector::Unit(rank_ + k), rank_ + k + 1);
  return F;
}

} // namespace torqued
