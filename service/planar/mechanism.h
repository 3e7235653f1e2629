/// A planar mechanism whose every angle is linear in its coordinates, so that all its dynamics is closed-form.
///
/// Frames, signs and units, said once for the whole program:
///
///          z                          W, the world: x forward, z up, the ground is z = 0.
///          ^   ⟲ +                    Angles, angular rates and moments are positive counter-clockwise in this
///          |                          picture (x to the right, z up). SI units and radians.
///          +-----> x                  The moment of a force F at r is r_x F_z − r_z F_x.
///
/// Every link that turns, and every massless bar between rolling circles, is a *direction*: a frame turned by
///
///   φ = W θ                                                                            (W constant)
///
/// against the world. The first of them are the members of θ; bars follow, and directions that never turn and carry
/// nothing, up to a whole number of blocks. A *point* of the mechanism is the base point plus arms, each constant in
/// its direction's frame:
///
///   p = p_base + Σₖ R(φₖ) rₖ
///
/// The generalized coordinates are q = (θ, x_base, z_base); v = q̇ and a = q̈. θ holds angles, and displacements of
/// bodies that slide sideways, out of the plane: these turn no direction.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace torqued
{

/// The most coordinates of a mechanism, those of the base point included.
inline constexpr int kMaxCoordinates = 16;
/// The most directions: what the angles turn, a bar for each of them but the root's, and the world.
inline constexpr int kMaxDirections = 2 * (kMaxCoordinates - 2);
/// A SIMD block of directions; a mechanism has them in whole blocks.
inline constexpr int kDirectionBlock = 4;
static_assert(kMaxDirections % kDirectionBlock == 0);

template <int MaxRows, int MaxCols>
using Bounded = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, MaxRows, MaxCols>;
template <int MaxRows> using BoundedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, MaxRows, 1>;

/// One number per coordinate; sized at run time, stored in place.
using VectorQ = BoundedVector<kMaxCoordinates>;
using MatrixQ = Bounded<kMaxCoordinates, kMaxCoordinates>;
/// One number per direction.
using VectorD = BoundedVector<kMaxDirections>;
/// One plane vector per direction, as columns; all x, then all z, in SIMD blocks of directions.
using PlaneVectors = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor, 2, kMaxDirections>;
/// A number of each direction of a block.
using DirectionBlock = Eigen::Array<double, 1, kDirectionBlock>;

/// r turned by +90°: (−r_z, r_x).
inline Eigen::Vector2d perp(const Eigen::Vector2d& r)
{
  return r.reverse().cwiseProduct(Eigen::Vector2d(-1.0, 1.0));
}

/// R(φ) r, with e = (cos φ, sin φ).
inline Eigen::Vector2d rotate(const Eigen::Vector2d& e, const Eigen::Vector2d& r)
{
  return e.x() * r + e.y() * perp(r);
}

/// The moment of F at r, counter-clockwise positive: r_x F_z − r_z F_x.
inline double cross(const Eigen::Vector2d& r, const Eigen::Vector2d& F)
{
  return r.x() * F.y() - r.y() * F.x();
}

/// A vector r (m) that is constant in the frame of a direction.
struct Arm
{
  int direction;
  Eigen::Vector2d r;
};

/// A point of the mechanism, as the arms that lead to it from the base point; no direction occurs twice.
using Point = std::vector<Arm>;

/// A rigid body, as the parameters in which the equation of motion is linear; about a point of the mechanism that is
/// fixed in the body, its origin.
struct Body
{
  Point origin;
  int direction;           ///< of its frame
  double mass;             ///< kg
  Eigen::Vector2d moment;  ///< mass × centre of mass, in its frame, kg m
  double inertia;          ///< about the origin: that about the centre of mass, and m |c|², kg m²
  std::vector<int> slides; ///< members of θ that add up to its displacement sideways
};

/// The constants of a mechanism, folded once from its bodies; immutable.
///
/// With rₖ the arm of direction k to a particle of mass m, as a complex number x + iz, and conj its conjugate:
///
///   mass      m   = Σ m
///   moments   S_k = Σ m r_k             kg m, in direction k's frame
///   pairs     P_jk = Σ m conj(r_j) r_k, j < k and not zero, kg m²
///   inertias  I_k = Σ m |r_k|²          kg m²
///   sliding   the masses that each two slides move together, kg
///
/// The equation of motion needs nothing else (dynamics.h).
class Mechanism
{
public:
  /// The constants that couple two directions.
  struct Pair
  {
    int j, k;
    Eigen::Vector2d P;
  };
  /// The constants that couple the directions of a block, from `row` on, with one other: P_jk of all of them, 0 of k
  /// itself.
  struct PairColumn
  {
    int row, column;
    DirectionBlock P_x, P_z;
  };
  /// An entry of a matrix that has few.
  struct Entry
  {
    int row, column;
    double value;
  };

  /// W: directions × length of θ, begins with the unit matrix, and is filled up with zeros to whole blocks; gravity:
  /// m/s², downward.
  ///
  /// Requires: sizes that stay within kMaxCoordinates and kMaxDirections; arms and bodies that name existing
  /// directions and members of θ.
  Mechanism(const Eigen::MatrixXd& W, const std::vector<Body>& bodies, double gravity);

  /// Length of θ.
  int num_theta() const { return static_cast<int>(W_.cols()); }
  /// Length of q, v and a: θ, and the base point's two coordinates.
  int num_q() const { return num_theta() + 2; }
  int num_directions() const { return static_cast<int>(W_.rows()); }

  const Bounded<kMaxDirections, kMaxCoordinates>& W() const { return W_; }
  /// W θ; `theta`: θ, or a vector that begins with it, as q, v and a do.
  VectorD of_directions(const VectorQ& theta) const;
  /// Calls a function with each member of θ that turns a direction, and its share in W.
  template <typename Function> void for_each_share(int direction, const Function& function) const;
  /// Adds Wᵀ x to the head of `theta`, x being 0 but at one direction.
  void add_from_direction(int direction, double x, VectorQ& theta) const;
  /// W below the unit matrix.
  const std::vector<Entry>& shares_of_bars() const { return shares_of_bars_; }
  /// How fast each direction turns when all of θ turns at rate 1: W times ones.
  const VectorD& turned_with_all() const { return turned_with_all_; }
  double gravity() const { return gravity_; }                                   ///< m/s², downward
  double mass() const { return mass_; }                                         ///< m, kg
  const PlaneVectors& moments() const { return moments_; }                      ///< S, kg m, one column per direction
  const std::vector<Pair>& pairs() const { return pairs_; }                     ///< P, kg m², those that are not zero
  const std::vector<PairColumn>& pair_columns() const { return pair_columns_; } ///< the same, block by block
  const VectorD& inertias() const { return inertias_; }                         ///< I, kg m²
  const std::vector<Entry>& sliding() const { return sliding_; }                ///< kg; rows and columns of θ
  /// Wᵀ diag(I) W, and sliding: the part of M(q) that is the same in every pose, θ × θ.
  const MatrixQ& inertia() const { return inertia_; }

private:
  Bounded<kMaxDirections, kMaxCoordinates> W_;
  std::vector<Entry> shares_of_bars_;
  // the same by whole blocks of rows
  struct BlockOfBars
  {
    int row, column;
    DirectionBlock shares;
  };
  std::vector<BlockOfBars> blocks_of_bars_;
  VectorD turned_with_all_;
  double gravity_;
  double mass_ = 0.0;
  PlaneVectors moments_;
  std::vector<Pair> pairs_;
  std::vector<PairColumn> pair_columns_;
  VectorD inertias_;
  std::vector<Entry> sliding_;
  MatrixQ inertia_;
};

inline VectorD Mechanism::of_directions(const VectorQ& theta) const
{
  // the unit matrix
  const int size = num_theta();
  VectorD x(num_directions());
  int k = 0;
  for (; k + kDirectionBlock <= size; k += kDirectionBlock)
    x.segment<kDirectionBlock>(k) = theta.segment<kDirectionBlock>(k);
  if (k < size)
  {
    // a block at once, because a part of it written apart would make its reader wait
    const auto rest = [&](int i)
    {
      return k + i < size ? theta(k + i) : 0.0;
    };
    x.segment<kDirectionBlock>(k) << rest(0), rest(1), rest(2), rest(3);
    k += kDirectionBlock;
  }
  for (; k < num_directions(); k += kDirectionBlock)
    x.segment<kDirectionBlock>(k).setZero();

  // bars
  for (auto bars = blocks_of_bars_.begin(); bars != blocks_of_bars_.end();)
  {
    const int row = bars->row;
    DirectionBlock sum = x.segment<kDirectionBlock>(row).transpose();
    for (; bars != blocks_of_bars_.end() && bars->row == row; ++bars)
      sum += theta(bars->column) * bars->shares;
    x.segment<kDirectionBlock>(row) = sum.transpose();
  }
  return x;
}

template <typename Function> void Mechanism::for_each_share(int direction, const Function& function) const
{
  if (direction < num_theta())
    function(direction, 1.0);
  else
    for (const Entry& share : shares_of_bars_)
      if (share.row == direction)
        function(share.column, share.value);
}

inline void Mechanism::add_from_direction(int direction, double x, VectorQ& theta) const
{
  for_each_share(direction, [&](int member, double share) { theta(member) += share * x; });
}

} // namespace torqued
