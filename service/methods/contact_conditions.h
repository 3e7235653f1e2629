/// What the contacts ask of the ground reactions: feet neither lift, slip nor tip.
///
///   at each foot   f_z ≥ f_min,  |f_x| ≤ μ f_z
///   on its sole    x_heel f_z' ≤ M − h_p f_x' ≤ x_toe f_z'          (') in the foot's frame
///
/// With constant bounds the least torques jump where contacts change. Windows close on both sides of a change on what
/// both sides can do, so that no torque jumps; p = phase, s = load_transfer, F_z the total normal force:
///
/// - trailing sole, leading point: leading f_z ≤ p F_z; trailing pressure not behind p of its sole (0 = heel, 1 = toe)
/// - trailing point, leading sole: trailing f_z ≤ (1 − p) F_z; leading pressure not before p of its sole
/// - two soles: leading f_z ≤ min(1, 2s) F_z; trailing f_z ≤ min(1, 2 (1 − s)) F_z; at s = 1/2, where both are free,
///   a posture that is not symmetric loads its feet unequally
/// - two points: none
///
/// f_min of the foot whose load a window bounds is no more than that bound. A margin, m, is taken off both ends of a
/// sole, up to half of it; at the end towards which a window closes it shrinks with the window, so that the pressure
/// reaches that end when the contact changes there.
#pragma once

#include "methods/method_settings.h"
#include "stance/support_equations.h"

#include <algorithm>
#include <array>
#include <optional>

namespace torqued
{

/// What is asked.
struct ContactBounds
{
  bool windows = true;
  std::optional<double> f_min = {}; ///< N; empty: each foot's own
  double margin = 0.0;              ///< m
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
  ContactCondition* begin() { return all_.data(); }
  ContactCondition* end() { return all_.data() + size_; }
  const ContactCondition* begin() const { return all_.data(); }
  const ContactCondition* end() const { return all_.data() + size_; }

private:
  std::array<ContactCondition, kMost> all_;
  std::size_t size_ = 0;
};

/// All conditions and windows of the feet in contact, one after the other, by
///
///   add(side, bound, factor, is_window, form)    form(f_x, f_z, moment) ≤ bound, form linear; see ContactCondition
template <typename Add>
void for_each_condition(const Robot& robot, const SupportEquations& equations, const Support& support,
                        const ContactBounds& bounds, const Add& add)
{
  const double p = support.progress();
  const double F_z = equations.force().y();
  const double per_weight = 1.0 / robot.weight();
  const Contact leading_contact = support.of(support.leading), trailing_contact = support.of(support.trailing());
  const bool leading_sole = leading_contact == Contact::sole, trailing_sole = trailing_contact == Contact::sole;
  const bool windows = bounds.windows && leading_contact != Contact::none && trailing_contact != Contact::none;
  for (const Side side : kSides)
  {
    if (support.of(side) == Contact::none)
      continue;
    const bool leading = side == support.leading;
    const Foot& foot = robot.foot(side);
    const bool sole = support.of(side) == Contact::sole && foot.has_extent();

    // the most load that a window leaves this foot
    std::optional<double> most;
    if (windows && leading_sole && trailing_sole)
      most = std::min(1.0, 2.0 * (leading ? p : 1.0 - p)) * F_z;
    else if (windows && leading_sole != trailing_sole && support.of(side) != Contact::sole)
      most = (leading ? p : 1.0 - p) * F_z;
    double least = bounds.f_min.value_or(foot.f_min);
    if (most)
      least = std::min(least, std::max(*most, 0.0));

    add(side, -least, per_weight, false, [](const auto&, const auto& f_z, const auto&) { return -f_z; });
    const double mu = foot.friction;
    add(side, 0.0, per_weight, false, [mu](const auto& f_x, const auto& f_z, const auto&) { return f_x - mu * f_z; });
    add(side, 0.0, per_weight, false, [mu](const auto& f_x, const auto& f_z, const auto&) { return -f_x - mu * f_z; });
    if (sole)
    {
      // M − h_p f_x' − x f_z': the moment about the point of the sole at x from below the ankle, in the foot's frame
      const auto moment_at = [h = foot.ankle_height(), e = equations.foot(side).e](double x, double sign)
      {
        return [sign, of_x = sign * (x * e.y() - h * e.x()),
                of_z = -sign * (h * e.y() + x * e.x())](const auto& f_x, const auto& f_z, const auto& moment)
        {
          return of_x * f_x + of_z * f_z + sign * moment;
        };
      };
      const double heel = foot.heel_x(), toe = foot.toe_x();
      const double per_length = per_weight / (toe - heel);
      const bool closes = windows && leading_sole != trailing_sole;
      const double margin = std::min(bounds.margin, 0.5 * (toe - heel));
      add(side, 0.0, per_length, false, moment_at(heel + (closes && leading ? p : 1.0) * margin, -1.0));
      add(side, 0.0, per_length, false, moment_at(toe - (closes && !leading ? 1.0 - p : 1.0) * margin, 1.0));
      if (closes)
        add(side, 0.0, per_length, true, moment_at(heel + p * (toe - heel), leading ? 1.0 : -1.0));
    }
    if (most)
      add(side, *most, per_weight, true, [](const auto&, const auto& f_z, const auto&) { return f_z; });
  }
}

} // namespace torqued
