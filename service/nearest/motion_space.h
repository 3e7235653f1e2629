/// The accelerations that keep the contacts, by their distance from the desired one.
#pragma once

#include "nearest/nearest_settings.h"
#include "stance/reactions.h"

namespace torqued
{

/// All changes δ = a − a_d of a motion after which the contacts rest, or accelerate as desired, and the ground can
/// supply what the rows without motors ask, by a distance ½ δᵀ W δ:
///
///   E δ = −e,   δ = δ0 + F ζ,   E F = 0,   Fᵀ W F = 1,   δ0ᵀ W F = 0,   so   ½ δᵀ W δ = ½ |ζ|² + a constant
///
/// Rows of E: those of G w = d that no reactions meet (three in flight, the moment about the point on one heel or toe,
/// or on two at one place), N_Bᵀ M̂; and J. M̂ = M + B diag(I_j) Bᵀ, with the rotors' inertias. Where rows of J depend on
/// others and contradict them, they are met in least squares, in metres, and of a sole's angle × its length.
///
/// Only the first three of ζ move what the ground must supply: N_Bᵀ M̂ F ζ = Dᵀ (ζ_1, ζ_2, ζ_3).
///
/// With W = Uᵀ U, by Householder's reflections of the columns U⁻ᵀ [Eᵀ, M̂ N_B]: Q of the first spans U δ0, the rest U F.
class MotionSpace
{
public:
  /// equations: of the desired motion. all: its reactions, of which the rows that are not met are taken.
  /// contact_error: e of the rows of J, m/s², rad/s². If singular(), nothing else is set.
  MotionSpace(const Robot& robot, const SupportEquations& equations, const Support& support,
              const AdmissibleReactions& all, const WrenchVector& contact_error, NearestMetric metric);

  /// Whether a link can move without mass or inertia, so that the metric does not tell accelerations apart.
  bool singular() const { return singular_; }
  /// Whether contacts contradict one another, so that they are met in least squares alone.
  bool contradictory() const { return contradictory_; }
  int size() const { return n_ - rank_; }       ///< of ζ
  const MatrixQ& mass() const { return mass_; } ///< M̂
  /// δ0.
  VectorQ least_change() const { return from_reflected(least_, rank_); }

  /// Finds F, and returns D, whose rows beyond ζ are 0. What follows asks for it.
  Eigen::Matrix3d span();
  /// δ of the first of ζ, the others 0.
  VectorQ change(const VectorQ& zeta) const;
  /// F, num_q() × size().
  MatrixQ basis() const;

private:
  static constexpr int kColumns = 12; // at most six of E and three of M̂ N_B, filled up with zeros
  using Columns = Eigen::Matrix<double, kMaxCoordinates, kColumns, Eigen::RowMajor>;
  using Square = Eigen::Matrix<double, kMaxCoordinates, kMaxCoordinates, Eigen::RowMajor>;
  using Vector = Eigen::Matrix<double, kMaxCoordinates, 1>; // 0 beyond n

  void fill_columns(const Robot& robot, const SupportEquations& equations, const Support& support,
                    const AdmissibleReactions& all, const WrenchVector& contact_error);
  void set_metric(const Robot& robot, NearestMetric metric);
  void divide_by_root();
  void reflect(int from, int to);
  void find_least_change();
  // U⁻¹ Q u, u being 0 but for its first entries
  VectorQ from_reflected(Vector u, int entries) const;

  int n_;             // of δ
  int hard_ = 0;      // rows of E that are not of J; they come first
  int rows_ = 0;      // of E
  int rank_ = 0;      // of E: as many reflections
  int reflected_ = 0; // all reflections, those of M̂ N_B among them
  bool singular_ = false, contradictory_ = false;
  MatrixQ mass_;
  Square root_;                                              // W, then U with W = Uᵀ U
  Vector per_pivot_;                                         // one over U's diagonal
  Columns columns_;                                          // [Eᵀ, M̂ N_B], then U⁻ᵀ of them, then Qᵀ of that
  Eigen::Matrix<double, kMaxCoordinates, kColumns> normals_; // v of each reflection 1 − β v vᵀ
  std::array<double, kColumns> beta_;
  std::array<double, kColumns> error_; // of the rows of E
  Vector least_;                       // Qᵀ U δ0: beyond the rank 0
};

} // namespace torqued
