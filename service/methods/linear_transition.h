/// Double support by handing the load over in proportion to time.
#pragma once

#include "methods/method.h"

#include <optional>

namespace torqued
{

/// Hands the load from the trailing to the leading foot in proportion to load_transfer, s.
///
/// Each foot takes its share of the total ground force F, horizontal part too: leading s F, trailing (1 − s) F.
/// Source: [Al-Shuka 2014, (28), (29)], with t_s and t_d the instants at which double support begins and ends. They
/// give forces and no moments, which leaves to each contact pair:
///
/// - sole and point: the point's share acts at the point; the sole's wrench follows from (2).
/// - point and point: s splits the horizontal force; (2) determines the normal forces. Refused as numerical when the
///   points stand above one another.
/// - sole and sole: one moment is free. By default each foot's centre of pressure follows the total zero-moment point
///   as far as its sole allows; or the leading foot's stays at `leading_cop`, a fraction of its sole (0 = heel, 1 =
///   toe).
struct LinearTransition
{
  static constexpr Method kMethod = Method::linear_transition;
  std::optional<double> leading_cop; ///< empty: follow the zero-moment point
};

/// Refuses: numerical.
Result<Reactions> linear_transition(const Robot& robot, const SupportEquations& equations, const Support& support,
                                    const LinearTransition& settings);

} // namespace torqued
