/// A robot: a mechanism with names, actuators and feet, and the constants that follow from them.
#pragma once

#include "planar/mechanism.h"
#include "robot/joint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// What a root that is fixed stands on, and what an actuator may push against; no link's name.
inline constexpr std::string_view kWorld = "world";
/// The most links.
inline constexpr int kMaxLinks = 24;
/// The most actuators: one for each member of θ.
inline constexpr int kMaxJoints = kMaxCoordinates;
/// The most characters of a name.
inline constexpr std::size_t kLongestName = 64;
/// Whether a text can be a name: letters, digits, _ and -, because names stand in CSV headers and in messages.
bool is_name(std::string_view text);
/// One number per actuator.
using VectorJ = BoundedVector<kMaxJoints>;
/// So many are computed at once, because a number of rows known to the compiler is what makes small products fast.
inline constexpr int kJointBlock = 8;
using JointBlock = Eigen::Matrix<double, kJointBlock, 1>;
static_assert(kMaxJoints % kJointBlock == 0);

enum class Side : std::int8_t
{
  left = 0,
  right = 1
};
inline Side other(Side side)
{
  return side == Side::left ? Side::right : Side::left;
}
inline constexpr std::array<Side, 2> kSides{Side::left, Side::right};
/// "left" or "right".
std::string_view name_of(Side side);

/// A stroke that draws a link: from, to in the link's frame, width; m.
struct Segment
{
  Eigen::Vector2d from, to;
  double width;
};

/// A rigid link; all vectors are in link frames, m. Its frame's origin is at the joint to its parent; for a rolling
/// joint, at the centre of its own circle.
struct Link
{
  std::string name;
  int parent = -1; ///< index of the parent link; −1 for the root
  JointKind joint = JointKind::revolute;
  Eigen::Vector2d at = Eigen::Vector2d::Zero(); ///< the joint in the parent's frame; rolling: centre of its circle
  double angle = 0.0; ///< fixed: against the parent; parallel: against the world; rolling: of the bar when parent and
                      ///< link are at angle 0, from straight down; rad
  double parent_radius = 0.0, child_radius = 0.0; ///< rolling, m
  double mass = 0.0;                              ///< kg
  Eigen::Vector2d com = Eigen::Vector2d::Zero();
  double inertia = 0.0; ///< about the centre of mass, kg m²
  std::vector<Segment> drawing;

  int coordinate = -1; ///< its member of θ: an angle; slide: a displacement, m; −1 if it has none of its own
  int direction = -1;  ///< the mechanism's direction that turns it
  double direction_angle = 0.0;                       ///< its angle against that direction, rad
  Eigen::Vector2d heading = Eigen::Vector2d::UnitX(); ///< cosine and sine of that
  Point origin;                                       ///< its frame's origin
  std::vector<int> slides;                            ///< members of θ that add up to its displacement sideways

  const JointType& type() const { return type_of(joint); }
  /// A bar's angle γ: circles that roll have one velocity where they touch.
  ///
  ///   (r_p + r_c) γ̇ = r_p φ̇_parent + r_c φ̇
  AngleShares bar_shares() const
  {
    const double length = parent_radius + child_radius;
    return {child_radius / length, parent_radius / length, 0.0};
  }
};

/// Between which bodies the actuator of a rolling joint acts; numbered in the order of the file's words.
enum class Placement : std::int8_t
{
  links = 0,      ///< parent and child
  bar_parent = 1, ///< the bar and the parent
  bar_child = 2   ///< the bar and the child
};
/// "links", "bar-parent", "bar-child".
std::string_view name_of(Placement placement);

/// A motor between two links: a positive torque turns `on` counter-clockwise and `against`
/// clockwise. On a slide it is a force, N, and every N m here an N, every rad a metre.
///
/// Its angle is κ times the angle of `on` minus that of `against`. The torque that it must give, τ, is more than what
/// the links need of it, τ_out, by what its rotor and its friction take (joint_friction.h).
struct Actuator
{
  std::string name;
  int on = -1, against = -1; ///< links; the world is the fixed root
  Placement placement = Placement::links;
  double kappa = 1.0; ///< κ: 1, or for a rolling joint with a bar the share of its angle that the motor turns
  double torque_limit = std::numeric_limits<double>::infinity(); ///< N m; infinite if there is none
  double rate_limit = std::numeric_limits<double>::infinity();   ///< N m/s; infinite if there is none
  double rotor_inertia = 0.0;     ///< I, reflected to the joint (gear ratio² × the rotor's), kg m²
  double coulomb = 0.0;           ///< κ_c, N m
  double viscous = 0.0;           ///< κ_v, N m s/rad
  double stribeck = 0.0;          ///< κ_s, N m
  double stribeck_velocity = 1.0; ///< η_s, rad/s; positive
  double friction_offset = 0.0;   ///< κ_o, N m
  double stick_velocity = 0.0;    ///< half the width of the window in which sgn is a straight line, rad/s; 0: none
  double offset = 0.0;            ///< what its coordinate adds to its angle, rad
};

/// A foot: where it can touch the ground. A foot without extent has heel = toe = ankle and no sole.
struct Foot
{
  /// The torque of a motor for each N m about a direction, an entry of B⁺ Wᵀ.
  struct TorqueShare
  {
    int joint;
    int moment; ///< whose direction it is: the index of an arm of the ankle; after the last, the foot
    double size;
  };

  Side side = Side::left;
  int link = -1; ///< −1: the robot has no foot on this side
  /// In the link's frame, m; heel and toe lie equally high.
  Eigen::Vector2d ankle_at = Eigen::Vector2d::Zero(), heel_at = ankle_at, toe_at = ankle_at;
  double friction = 0.0;  ///< coefficient μ
  double f_min = 0.0;     ///< least normal force that a method should give it, N
  Point ankle, heel, toe; ///< the same points of the mechanism
  int direction = -1;     ///< the link's
  /// Heel and toe from the ankle, in the frame of the direction, m.
  Eigen::Vector2d to_heel = Eigen::Vector2d::Zero(), to_toe = to_heel;
  std::vector<TorqueShare> torque_shares = {}; ///< all that are not 0, joint by joint

  bool exists() const { return link >= 0; }
  bool has_extent() const { return heel_at != toe_at; }
  /// Height of the ankle above the sole, h_p.
  double ankle_height() const { return ankle_at.y() - heel_at.y(); }
  /// Heel and toe along the sole, measured from below the ankle, forward positive: −l_p and l_p1.
  double heel_x() const { return heel_at.x() - ankle_at.x(); }
  double toe_x() const { return toe_at.x() - ankle_at.x(); }
};

/// A robot as computed with; built by assemble() from a description, constant from then on.
///
/// Coordinates ABSOLUTE are the angles of the links against the world (and displacements of slides) in the file's
/// order. Coordinates RELATIVE are the actuators' angles, without κ, in their order, then that of a floating root:
///
///   q_relative = A q_absolute + b          A square, invertible; the base point is not part of it
///
/// Generalized forces go the other way: f_absolute = Aᵀ f_relative. Source: [De-León-Gómez 2017, (19) to (27)].
///
/// A root that is fixed to the world is computed as a floating one at rest: θ then ends with its angle, 0, which is no
/// coordinate. It stands for the world: what is parallel to the world is so to the root, and what pushes against the
/// world pushes against the root; so the ground reaction at its foot is that of the whole robot.
struct Robot
{
  std::string name;
  std::string source; ///< where its numbers come from
  std::vector<Link> links;
  std::vector<int> order; ///< links' indices, parents before children
  std::vector<Actuator> actuators = {};
  std::array<Foot, 2> feet = {}; ///< indexed by Side
  std::vector<std::string> absolute_names, relative_names = {};
  std::array<std::string, 2> base_names = {}; ///< empty for a fixed root
  Mechanism mechanism;
  MatrixQ A = {}, A_inverse = {}; ///< with a fixed root's angle as last row and column; so is b
  VectorQ b = {};
  VectorJ kappa = {};                   ///< of every actuator
  std::vector<Mechanism::Entry> B = {}; ///< of joint_forces(): all that are not 0, row by row of θ
  /// B⁺ of joint_torques(): rows of joints, columns of θ; the rest 0.
  Eigen::Matrix<double, kMaxJoints, kMaxCoordinates> B_inverse = B_inverse.Zero();
  bool joint_friction = false; ///< whether any motor has a rotor or friction, joint_friction.h
  double leg_length = 0.0;     ///< a length of the robot's size, m: see assemble()
  /// The link in the middle of the way from foot to foot, the nearer one to the right foot of two; −1 without two feet.
  /// Both legs carry it, and what hangs on it. A leg is what is left on the way to a foot, with all that hangs there.
  int trunk = -1;
  std::vector<std::optional<Side>> leg = {}; ///< of each link: whose leg it is part of
  std::int64_t model_id = 0; ///< FNV-1a of everything above that is more than a comment or a drawing; never 0
  /// What the user should know about how the robot's file was read: a line each, which begins with the file's name.
  std::vector<std::string> notes = {};

  int num_joints() const { return static_cast<int>(actuators.size()); }
  /// Coordinates, the base point and a fixed root not among them.
  int num_coordinates() const { return static_cast<int>(absolute_names.size()); }
  int root() const { return order.front(); }
  bool fixed_root() const { return !link(root()).type().floats(); }
  double weight() const { return mechanism.mass() * mechanism.gravity(); }
  const Foot& foot(Side side) const { return feet[static_cast<std::size_t>(side)]; }
  const Link& link(int index) const { return links[static_cast<std::size_t>(index)]; }
  /// Whether this foot is the fixed root.
  bool is_root(const Foot& foot) const { return fixed_root() && foot.link == root(); }
};

/// The link that hangs on the other one by the joint at which an actuator acts; null if there is no joint between its
/// two links.
const Link* child_of_joint(const std::vector<Link>& links, const Actuator& actuator);

/// Whether a motor is linear, along the slide between its two links: its torque is a force, N.
bool is_force(const Robot& robot, const Actuator& actuator);

/// A link as a body of the mechanism.
Body body_of(const Link& link);

/// Bᵀ θ̇: the rates of the angles conjugate to the torques, κ in them; of θ̈ likewise.
VectorJ joint_rates(const Robot& robot, const VectorQ& theta_rates);

/// B τ in the rows of θ: what torques τ do to the links, B = Aᵀ diag(κ).
VectorQ joint_forces(const Robot& robot, const VectorJ& torque);

/// The largest component of f − B τ; not a number if one is not. force: f by its row, num_q() of them.
template <typename Force> double largest_left(const Robot& robot, const Force& force, const VectorJ& torque)
{
  double largest = 0.0, total = 0.0;
  auto entry = robot.B.begin();
  for (int row = 0; row < robot.mechanism.num_q(); ++row)
  {
    double left = force(row);
    for (; entry != robot.B.end() && entry->row == row; ++entry)
      left -= entry->value * torque(entry->column);
    largest = std::max(largest, std::abs(left));
    total += left;
  }
  return largest + 0.0 * total; // no comparison sees what is not a number
}

/// B⁺ f: the torques that give f, if any do; else all rows but a floating root's are met. force: f by its row, from θ's
/// on. In the storage of what is returned zeros follow up to the end of the last block of joints; a copy has none.
template <typename Force> VectorJ joint_torques(const Robot& robot, const Force& force)
{
  VectorJ torque(robot.num_joints());
  for (int j = 0; j < robot.num_joints(); j += kJointBlock)
  {
    JointBlock sum = JointBlock::Zero();
    for (int c = 0; c < robot.mechanism.num_theta(); ++c)
      sum += force(c) * robot.B_inverse.block<kJointBlock, 1>(j, c);
    Eigen::Map<JointBlock>(torque.data() + j) = sum; // the storage goes on to the end of the block
  }
  return torque;
}

/// B: the whole matrix, num_q() × num_joints(); the rows of the base point are zero.
Bounded<kMaxCoordinates, kMaxJoints> input_matrix(const Robot& robot);

/// A number of a URDF that would change torques and that no robot takes from there, because a TOML file says it.
struct UnreadValue
{
  std::string element, attribute; ///< attribute: empty if the element has none that says more
  std::string value;
  std::string_view key; ///< of an [[actuator]]; empty: nothing of ours says it
};

/// What a robot file says, names not yet resolved. Lines are those of the file, for complaints.
struct RobotDescription
{
  struct LinkEntry
  {
    Link link;
    std::string parent; ///< "world" for a fixed root
    std::string coordinate;
    int line;
    std::string file = {}; ///< whose line that is; empty: the description's
  };
  struct ActuatorEntry
  {
    Actuator actuator;
    std::string on, against, coordinate; ///< against: "world" for the world
    double offset;
    int line;
    std::string file = {}; ///< as a link's
  };
  struct FootEntry
  {
    Foot foot;
    std::string link;
    int line;
  };
  /// What a URDF says of a joint's motor.
  struct UnreadEntry
  {
    std::string joint, on, against; ///< the links between which the joint's actuator acts
    std::vector<UnreadValue> values;
    std::string file;
    int line;
  };

  /// A joint of a URDF whose coordinate, that of the link `on` against `against`, has the opposite sign here.
  struct OppositeEntry
  {
    std::string joint, on, against;
    bool slides;
    std::string file;
  };

  std::string file;
  std::string name, source;
  double gravity;
  std::array<std::string, 2> base_names{"x", "z"};
  std::vector<LinkEntry> links;
  std::vector<ActuatorEntry>
      actuators;               ///< if empty: one for each joint that moves, turning the child against its parent
  std::vector<FootEntry> feet; ///< two; one or two, one of them on the root, if that is fixed; or none
  std::vector<UnreadEntry> unread = {};
  std::vector<OppositeEntry> opposite = {};
  std::vector<std::string> notes = {}; ///< what to know about how the file was read, a line each
};

/// Builds a robot; its notes are the description's, one for each unread entry, and one of all opposite signs. Throws
/// FileError (strict_toml.h) with file, line and what would be right.
///
/// Its leg length is the distance from the base point to the ankle of the straight robot (all angles 0), the longer
/// leg's; with a fixed root, or without feet, the longest way along the links from the base point to a centre of mass,
/// or 1 m if there is none.
Robot assemble(const RobotDescription& description);

/// Reads a robot from TOML text; file is the name used in complaints. Throws FileError.
///
/// With the key `urdf`, the path of a URDF as seen from the file's folder, links and joints are those of the URDF. A
/// [[link]] then names one of them and may add a coordinate's name, the base point's names and a drawing.
Robot read_toml_robot(std::string_view text, const std::string& file);

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

/// The robots that ship: names, and a shipped robot's TOML; empty if there is none of that name.
std::vector<std::string_view> shipped_robot_names();
std::string_view shipped_robot_toml(std::string_view name);

/// Loads a robot that ships, by its name, or a .toml or .urdf file, by its path. Throws FileError.
Robot load_robot(const std::string& name_or_path);

} // namespace torqued
