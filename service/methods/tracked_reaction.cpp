/// Procedure 3 of [Al-Shuka 2014], of two legs that carry the trunk (least_torque.h): the wrench y of one foot is that
/// of linear_transition(): of the one on heel or toe, about that point; where both or none are on their soles, of the
/// leading one,
///
///   B2 f_T1 + b3 = y                                                                                         (71)
///
/// and B2 is rigid: the one solution is that the trailing leg carries what linear_transition() gives its foot, so that
/// the reactions are linear_transition()'s, with its settings.
#include "methods/linear_transition.h"

namespace torqued
{

MethodRow tracked_reaction_row()
{
  return {Method::tracked_reaction, "tracked-reaction",
          [](const DoubleSupport& now)
          {
            return linear_transition(now.robot, now.equations, now.support, now.settings.of<LinearTransition>());
          }};
}

} // namespace torqued
