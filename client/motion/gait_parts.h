/// The parts of a walk that gait.cpp puts together: feet, the zero-moment point that they need, and legs.
#pragma once

#include "motion/gait.h"

namespace torqued
{

/// A function of time and its derivatives.
struct Course
{
  double x, v, a;
};

/// The ankle and the pitch of a foot.
struct FootMotion
{
  Eigen::Vector2d p, v, a; ///< m, m/s, m/s²
  Course pitch;            ///< rad, rad/s, rad/s²
};

/// The foot that carries in a step.
Side carrying_side(const GaitPhase& phase);

/// Where the foot stands that carries in a step, the ankle's x with the foot flat, m; side by side where the robot
/// stands.
double foothold(const GaitOptions& options, int step);

FootMotion carrying_foot(const Robot& robot, const GaitOptions& options, double t, const GaitPhase& phase);
/// The foot that swings, and then leads.
FootMotion other_foot(const Robot& robot, const GaitOptions& options, double t, const GaitPhase& phase);

/// Where the zero-moment point should be, world x in m: in single support along the middle part of the sole; in double
/// support on to where the trailing heel can lift, midway between its toe and the leading heel, and on to the leading
/// sole. Standing, from or to the middle of the sole.
double wished_zmp(const Robot& robot, const GaitOptions& options, double t, const GaitPhase& phase);

/// The links of a leg.
struct Leg
{
  int thigh, shin, foot;
};
/// Requires: a robot that Gait takes.
Leg leg_of(const Robot& robot, Side side);

/// Sets angles, rates and accelerations of a leg by which its ankle moves as asked, the trunk's and the base point's
/// being set. t: for complaints. Throws LegTooShort, Failure (usage): the ankle is out of reach.
void place_leg(const Robot& robot, Side side, const FootMotion& foot, double t, DesiredState& state);

} // namespace torqued
