/// Double support by optimisation under the conditions of contacts and motors.
#pragma once

#include "methods/method_settings.h"
#include "stance/support_equations.h"

#include <array>
#include <optional>

namespace torqued
{

struct AdmissibleReactions;
struct Reactions;

/// The least torque by which feet neither lift, slip nor tip and motors stay within their limits:
///
///   minimise ½ τᵀ W τ + ½ k Σ_feet (L² |f − f_ref|² + (M − M_ref)²)   over the admissible reactions
///   subject to, at each foot,  f_z ≥ f_min,  |f_x| ≤ μ f_z,
///     on its sole              x_heel f_z' ≤ M − h_p f_x' ≤ x_toe f_z'          (') in the foot's frame
///   and at each motor          |τ| ≤ its limit
///
/// τ includes what rotors and friction take. f_ref, M_ref: reactions of zmp_transition(); L: the leg length; k:
/// `reference_weight`. Solved for the one to three numbers that (2) leaves free (quadratic_program.h). Where they need
/// no torque, so that W does not tell them apart (both legs straight, parallel, and feet at one place), the smaller
/// reactions are taken.
///
/// With constant bounds torques jump where contacts change. `windows` close on both sides of a change on what both
/// sides can do, so that no torque jumps; p = phase, s = load_transfer, F_z the total normal force:
///
/// - trailing sole, leading point: leading f_z ≤ p F_z; trailing pressure not behind p of its sole (0 = heel, 1 = toe)
/// - trailing point, leading sole: trailing f_z ≤ (1 − p) F_z; leading pressure not before p of its sole
/// - two soles: leading f_z ≤ min(1, 2s) F_z; trailing f_z ≤ min(1, 2 (1 − s)) F_z; at s = 1/2, where both are free,
///   a posture that is not symmetric loads its feet unequally
/// - two points: none
///
/// f_min of the foot whose load a window bounds is no more than that bound.
///
/// Where not all conditions can be met, windows give way first, then torque limits, then contacts: each by the least
/// sum of squares of what is missing, forces over weight, moments over weight × sole length, torques over their limits;
/// and of what then remains, the least torque is taken (relaxed is set). Beyond that least, contacts get room of 1e-9,
/// torque limits and windows 1e-8.
struct Constrained
{
  static constexpr Method kMethod = Method::constrained;
  JointWeights weights;
  bool windows = true;
  double reference_weight = 0.0; ///< k
  std::optional<double> f_min;   ///< N; empty: each foot's own
};

/// One condition of a foot: c·w ≤ bound, w its own components of the reactions.
struct ContactCondition
{
  Side side;
  Eigen::Vector3d c;
  double bound;           ///< N; N m of a moment
  double factor;          ///< one over what is much of it: weight, or weight × sole length
  bool is_window = false; ///< it gives way before torque limits do
};

/// At most six for each foot.
class ContactConditions
{
public:
  static constexpr int kMost = 12;

  void push_back(const ContactCondition& condition) { all_[size_++] = condition; }
  int size() const { return static_cast<int>(size_); }
  const ContactCondition* begin() const { return all_.data(); }
  const ContactCondition* end() const { return all_.data() + size_; }

private:
  std::array<ContactCondition, kMost> all_;
  std::size_t size_ = 0;
};

/// What the contacts, and the windows if they are set, ask of the reactions. Requires: both feet in contact.
ContactConditions contact_conditions(const Robot& robot, const SupportEquations& equations, const Support& support,
                                     const Constrained& settings);

/// Chooses the reactions.
///
/// relax: whether conditions of contacts and motors may be violated when they cannot be met; windows always may.
/// Refuses: infeasible, if they cannot and may not; numerical.
Result<Reactions> constrained(const Robot& robot, const SupportEquations& equations, const Support& support,
                              const AdmissibleReactions& all, const Constrained& settings, bool relax);

} // namespace torqued
