/// The points on which a robot stands, and how they tie a motion to the ground.
#pragma once

#include "stance/desired_state.h"
#include "stance/ground_reaction.h"
#include "stance/refusal.h"

#include "planar/kinematics.h"

#include <algorithm>
#include <optional>

namespace torqued
{

/// Contact wrenches of both feet, in the order of the rows of J: the left foot's, then the right foot's; each
/// (fx, fz) at the heel or toe, or (fx, fz, moment about the ankle) for a sole. Ground on robot, world frame, N and N
/// m.
using WrenchVector = BoundedVector<6>;

/// A foot, or the whole robot, is without load when |f_z| is below this share of the robot's weight.
inline constexpr double kNoLoad = 1e-6;
/// Two contact points are one, or stand above one another, when less than this share of the leg length is between them.
inline constexpr double kCoincident = 1e-6;

/// Where a contact's force acts: heel or toe; the ankle for a sole.
const Point& contact_point(const Foot& foot, Contact contact);

/// (cos, sin) of a link's angle against the world.
Eigen::Vector2d heading(const Link& link, const Kinematics& now);

/// Whether the robot can stand like that. Refuses, not_supported: a contact of a foot that the robot has not; a sole
/// where a foot has no extent, unless it is the fixed root; anything but the sole of a fixed root.
std::optional<Refusal> check_contacts(const Robot& robot, const Support& support);

/// What the contacts ask of a motion: J v = 0 and J a + J̇ v = 0.
struct ContactRows
{
  Jacobian J;          ///< wrench_components() × num_q(): rows x and z of a contact point, and a sole's angle
  WrenchVector Jdot_v; ///< m/s², rad/s²
};

/// Requires: check_contacts().
ContactRows contact_rows(const Robot& robot, const Kinematics& now, const Support& support);

/// J̇ of contact_rows(), 1/s of its entries. Requires: check_contacts().
Jacobian contact_rows_rate(const Robot& robot, const Kinematics& now, const Support& support);

/// Where a foot is, in the world.
struct FootPose
{
  Eigen::Vector2d ankle, heel, toe; ///< m
  Eigen::Vector2d e;                ///< (cos, sin) of the foot's angle; (1, 0) with the sole level

  /// Where a contact's force acts: heel or toe; the ankle for a sole.
  const Eigen::Vector2d& point(Contact contact) const
  {
    return contact == Contact::heel ? heel : contact == Contact::toe ? toe : ankle;
  }
  /// Height above the ground z = 0 of the contact's nearest point, m: the heel, the toe; of a sole, 0 where the line
  /// from heel to toe crosses the ground. Requires: a contact.
  double height(Contact contact) const
  {
    if (contact != Contact::sole)
      return point(contact).y();
    const auto [low, high] = std::minmax({heel.y(), toe.y()});
    return low > 0.0 ? low : std::min(high, 0.0);
  }
};

/// Requires: the foot exists. ankle: where it is in W, m.
inline FootPose foot_pose(const Robot& robot, const Kinematics& now, const Foot& foot, const Eigen::Vector2d& ankle)
{
  const Eigen::Vector2d e = now.e.col(foot.direction);
  return {ankle, ankle + rotate(e, foot.to_heel), ankle + rotate(e, foot.to_toe),
          rotate(robot.link(foot.link).heading, e)};
}
inline FootPose foot_pose(const Robot& robot, const Kinematics& now, const Foot& foot)
{
  return foot_pose(robot, now, foot, position(now, foot.ankle));
}

/// A foot in contact, as seen from the base point: all that its leg's arms are turned into W for.
struct StandingFoot
{
  StandingFoot() {} // sets no numbers, because zeros are not free

  PlaneVectors arms;     ///< R(φ) r of foot.ankle's arms, in their order, m
  Eigen::Vector2d ankle; ///< from the base point, m
  /// Of where the contact's force acts, from the base point and against it: m, m/s, m/s².
  Eigen::Vector2d point, velocity, acceleration;
};

/// Not set where there is no contact.
using StandingFeet = PerSide<StandingFoot>;

/// direction_acceleration: φ̈ of every direction, rad/s². Requires: check_contacts().
void stand(const Robot& robot, const Kinematics& now, const VectorD& direction_acceleration, const Support& support,
           StandingFeet& feet);

/// How the base point moves.
struct BaseMotion
{
  Eigen::Vector2d velocity, acceleration; ///< m/s, m/s²
};

/// Completes a desired state whose kinematics are computed: sets now.base.
///
/// Without a given base the resting point stays at its place: that of a fixed root; a lone foot's ankle (sole), heel or
/// toe; in double support the ankle of the foot on its sole, or of the trailing foot when both or neither are on their
/// soles (there its contact point). It is put at x = 0, with the sole or the contact point at z = 0.
///
/// direction_acceleration: φ̈ of every direction, rad/s². feet: set as by stand().
/// Refuses, not_supported: what check_contacts() does; flight without a given base; a given base of a fixed root.
Result<BaseMotion> base_motion(const Robot& robot, const DesiredState& desired, const VectorD& direction_acceleration,
                               Kinematics& now, StandingFeet& feet);

/// A desired state whose base is known.
struct Motion
{
  Kinematics now;
  VectorQ v, a; ///< length num_q()
};

/// Completes a desired state. Refuses what base_motion() does.
Result<Motion> complete_motion(const Robot& robot, const DesiredState& desired);

} // namespace torqued
