/// What a user must know about an answer: centres of pressure, and whether feet and motors can do what it asks.
#pragma once

#include "stance/flags.h"
#include "stance/ground_reaction.h"
#include "stance/support_equations.h"

#include <cmath>

namespace torqued
{

/// A foot's force (f_x', f_z') in the foot's frame.
inline Eigen::Vector2d in_foot(const FootPose& pose, const Wrench& wrench)
{
  return {pose.e.x() * wrench.fx + pose.e.y() * wrench.fz, pose.e.x() * wrench.fz - pose.e.y() * wrench.fx};
}

/// Centre of pressure and friction of a foot.
///
/// The centre of pressure is where the force's line of action meets the line of the sole; with (f_x', f_z') the force
/// in the foot's frame, x_c = (M − h_p f_x') / f_z'.
inline GroundReaction ground_reaction(const Robot& robot, const Foot& foot, const FootPose& pose, const Wrench& wrench)
{
  const double no_load = kNoLoad * robot.weight();
  const bool loaded = std::abs(wrench.fz) >= no_load;
  const Eigen::Vector2d f = in_foot(pose, wrench);
  const double cop = loaded && std::abs(f.y()) >= no_load ? (wrench.moment - foot.ankle_height() * f.x()) / f.y() : 0.0;
  return {{wrench.fx, wrench.fz, wrench.moment}, cop, loaded ? std::abs(wrench.fx) / wrench.fz : 0.0};
}

/// Whether a foot in contact slips (|fx| > μ fz), lifts (fz < 0) or tips: flag bits.
///
/// A sole tips when the moment about the line of the sole is more than the pressure from heel to toe can give:
/// M − h_p f_x' must lie between x_heel f_z' and x_toe f_z', in the foot's frame; so a moment without load tips, too. A
/// fixed root without extent does not tip. Slack, for rounding: kNoLoad × weight on forces, and that × the sole's
/// length on the moment.
std::int32_t contact_flags(const Robot& robot, const Foot& foot, const FootPose& pose, Contact contact,
                           const Wrench& wrench);

/// World x of the total zero-moment point on the ground z = 0, m; 0 without load.
double zero_moment_point(const Robot& robot, const SupportEquations& equations);

} // namespace torqued
