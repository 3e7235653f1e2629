/// Robots in URDF.
#pragma once

#include "robot/description.h"

#include <string>
#include <string_view>

namespace torqued
{

/// Reads the links and joints of a URDF, and an actuator for each joint that moves, named like the joint and in the
/// file's order; gravity is 9.81. Throws FileError.
///
/// A revolute, continuous, prismatic or fixed joint is read as what it is. All turning axes must be parallel to ±y of
/// the root when all joints are at 0, and so must those along which something slides. Exporters round angles: a frame
/// or an axis within 10⁻⁴ rad of the plane is turned into it by the smallest angle, and a note says how far.
///
/// Root: a link that is no child floats. If it is called "world", which need not be declared, it stands for the world
/// and has one child, the root, by a joint that is floating, planar about y, or fixed. The root floats, too, at the end
/// of two prismatic joints in the plane and one that turns about y, in any order, from the world or another link that
/// is no child; like a link that carries the root by a floating or planar joint, all links there must have no mass, and
/// are none of the robot's. What is fixed to the world and moves nothing is passed over.
///
/// Frames: all are turned so that they are aligned with the world's (without one, with the root's) when all joints are
/// at 0, and projected on the x-z plane; no constant angles remain. What lies sideways does not enter planar dynamics
/// and is dropped. Of an inertia tensor only the moment about y enters.
///
/// Signs: URDF turns by the right hand about an axis; about +y that is clockwise in our picture. An actuator's angle
/// here is that of child − parent, counter-clockwise, whatever the sign of the joint's axis; so it equals the URDF's
/// joint angle where the axis is −y, and is its negative where it is +y. A displacement is along +y, whatever the sign
/// of the axis. A note names the joints whose sign is turned.
///
/// Masses: a note names a body that a joint moves and that has none, all links fixed to it included, and a tensor of
/// inertia that no body has; both are read as they are.
///
/// Rolling joints: two revolute joints A, B with a link without mass and other children between them, of which one
/// mimics the other by a positive multiplier (turning in the same sense) without offset, roll: that link is the bar
/// from A to B. By the bar's angle (Link::bar_shares()), A turns by r_c / (r_p + r_c) of the angle between parent and
/// child, and B by r_p / (r_p + r_c); so if B mimics A the multiplier is r_p / r_c, else it is r_c / r_p. The bar is no
/// link, and the actuator is named after the joint that mimics nothing. Any other mimic is refused.
///
/// Limits and friction of a URDF's joints (<limit>, <dynamics>, <safety_controller>), and gears and rotors of its
/// <transmission>, are not read: limits, friction, rotors and feet come from a TOML file that names the URDF, and are
/// otherwise none. A note names what is there and would change torques, unless the TOML says it: friction (coulomb) and
/// damping (viscous), effort (torque_limit), and N and I of a gear (rotor_inertia, N² I).
///
/// What is only seen or touched (<visual>, <collision>, <material>) is passed over, and so are elements and attributes
/// that URDF does not have (<mujoco>, <gazebo>, <drake:…>, …), which one note lists. What might be mechanics in them
/// (<gazebo><springStiffness>) has a note that it has no effect. Elements of URDF's own level whose name speaks of
/// mechanics (<loop_joint>, <force_element>, …) or looks like a slip of the pen (<inertail>) are refused.
RobotDescription read_urdf(std::string_view text, const std::string& file);

/// Reads a robot without feet from a URDF as such. Throws FileError; a fixed root, too, needs a TOML file, which says
/// which foot it is.
Robot read_urdf_robot(std::string_view text, const std::string& file);

} // namespace torqued
