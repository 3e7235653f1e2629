#include "planar/mechanism.h"

#include <cassert>

namespace torqued
{

namespace
{

// those that are not 0, from a row on
std::vector<Mechanism::Entry> entries(const Eigen::MatrixXd& matrix, Eigen::Index from = 0)
{
  std::vector<Mechanism::Entry> found;
  for (Eigen::Index row = from; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      if (matrix(row, column) != 0.0)
        found.push_back({static_cast<int>(row), static_cast<int>(column), matrix(row, column)});
  return found;
}

// rows of zeros up to a whole number of blocks
Eigen::MatrixXd in_blocks(const Eigen::MatrixXd& W)
{
  const Eigen::Index rows = (W.rows() + kDirectionBlock - 1) / kDirectionBlock * kDirectionBlock;
  Eigen::MatrixXd filled = Eigen::MatrixXd::Zero(rows, W.cols());
  filled.topRows(W.rows()) = W;
  return filled;
}

} // namespace

Mechanism::Mechanism(const Eigen::MatrixXd& W, const std::vector<Body>& bodies, double gravity)
    : W_(in_blocks(W)), shares_of_bars_(entries(W, W.cols())), gravity_(gravity), inertias_(VectorD::Zero(W_.rows()))
{
  assert(W.rows() <= kMaxDirections && num_q() <= kMaxCoordinates && W.topRows(W.cols()).isIdentity(0.0));
  const int directions = num_directions();
  for (int row = 0; row < directions; row += kDirectionBlock)
    for (int column = 0; column < num_theta(); ++column)
    {
      DirectionBlock shares = W_.block<kDirectionBlock, 1>(row, column).transpose();
      for (int i = 0; i < kDirectionBlock && row + i < num_theta(); ++i)
        shares(i) = 0.0;
      if (!shares.isZero(0.0))
        blocks_of_bars_.push_back({row, column, shares});
    }
  moments_.setZero(2, directions);
  Eigen::MatrixXd sliding = Eigen::MatrixXd::Zero(num_theta(), num_theta());
  std::vector<Eigen::Vector2d> P(static_cast<std::size_t>(directions * directions), Eigen::Vector2d::Zero());
  // Σ m conj(r_j) r_k, kept for j < k, because P_kj = conj(P_jk); what belongs to one direction does not turn against
  // itself
  const auto add_pair = [&](int j, int k, const Eigen::Vector2d& r_j, const Eigen::Vector2d& m_r_k)
  {
    const double real = r_j.dot(m_r_k);
    const double imaginary = cross(r_j, m_r_k);
    if (j == k)
      inertias_(k) += real;
    else if (j < k)
      P[static_cast<std::size_t>(j * directions + k)] += Eigen::Vector2d(real, imaginary);
    else
      P[static_cast<std::size_t>(k * directions + j)] += Eigen::Vector2d(real, -imaginary);
  };

  for (const Body& body : bodies)
  {
    mass_ += body.mass;
    inertias_(body.direction) += body.inertia;
    moments_.col(body.direction) += body.moment;
    for (std::size_t i = 0; i < body.origin.size(); ++i)
    {
      const Arm& arm = body.origin[i];
      moments_.col(arm.direction) += body.mass * arm.r;
      inertias_(arm.direction) += body.mass * arm.r.squaredNorm();
      for (std::size_t j = i + 1; j < body.origin.size(); ++j)
        add_pair(arm.direction, body.origin[j].direction, arm.r, body.mass * body.origin[j].r);
      // where the origin lies along the body's own direction, both orders of the product count
      add_pair(arm.direction, body.direction, arm.r, (arm.direction == body.direction ? 2.0 : 1.0) * body.moment);
    }
    for (const int row : body.slides)
      for (const int column : body.slides)
        sliding(row, column) += body.mass;
  }

  for (int j = 0; j < directions; ++j)
    for (int k = j + 1; k < directions; ++k)
      if (const Eigen::Vector2d& pair = P[static_cast<std::size_t>(j * directions + k)]; !pair.isZero(0.0))
        pairs_.push_back({j, k, pair});

  // P_jk and, of its mirror image, conj(P_jk)
  Eigen::MatrixXd P_x = Eigen::MatrixXd::Zero(directions, directions), P_z = P_x;
  for (const auto& [j, k, pair] : pairs_)
  {
    P_x(j, k) = P_x(k, j) = pair.x();
    P_z(j, k) = pair.y();
    P_z(k, j) = -pair.y();
  }
  for (int row = 0; row < directions; row += kDirectionBlock)
    for (int column = 0; column < directions; ++column)
    {
      const DirectionBlock x = P_x.block<kDirectionBlock, 1>(row, column).transpose();
      const DirectionBlock z = P_z.block<kDirectionBlock, 1>(row, column).transpose();
      if (!x.isZero(0.0) || !z.isZero(0.0))
        pair_columns_.push_back({row, column, x, z});
    }

  turned_with_all_ = W_.rowwise().sum();
  sliding_ = entries(sliding);
  inertia_ = W_.transpose() * inertias_.asDiagonal() * W_ + sliding;
}

} // namespace torqued
