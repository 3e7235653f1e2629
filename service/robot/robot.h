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
#include <tuple>
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
/// W of ½ τᵀ W τ, joints × joints, symmetric and positive definite; empty: the unit matrix.
using JointWeights = Bounded<kMaxJoints, kMaxJoints>;
/// A SIMD block of joints: small products are fast where the compiler knows the number of rows.
inline constexpr int kJointBlock = 8;
using JointBlock = Eigen::Matrix<double, kJointBlock, 1>;
static_assert(kMaxJoints % kJointBlock == 0);
/// One number per actuator, 0 beyond the last.
using PaddedJoints = Eigen::Matrix<double, kMaxJoints, 1>;

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

/// One thing for each side.
template <typename T> struct PerSide : std::array<T, 2>
{
  using std::array<T, 2>::operator[];
  T& operator[](Side side) { return (*this)[static_cast<std::size_t>(side)]; }
  const T& operator[](Side side) const { return (*this)[static_cast<std::size_t>(side)]; }
};

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

  /// What the model_id is made of, in this order.
  auto facts() const
  {
    return std::tie(name, parent, joint, at, angle, parent_radius, child_radius, mass, com, inertia);
  }

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

/// A number of an actuator, as files name it; what they do not say is as in Actuator().
struct ActuatorNumber
{
  enum class Range
  {
    any,
    not_negative,
    positive
  };
  std::string_view key;
  double Actuator::*value;
  Range range;
};
/// All of them but κ and the offset, in the order of files and of the model_id.
inline constexpr std::array<ActuatorNumber, 9> kActuatorNumbers{{
    {"torque_limit", &Actuator::torque_limit, ActuatorNumber::Range::not_negative},
    {"rate_limit", &Actuator::rate_limit, ActuatorNumber::Range::not_negative},
    {"rotor_inertia", &Actuator::rotor_inertia, ActuatorNumber::Range::not_negative},
    {"coulomb", &Actuator::coulomb, ActuatorNumber::Range::not_negative},
    {"viscous", &Actuator::viscous, ActuatorNumber::Range::not_negative},
    {"stribeck", &Actuator::stribeck, ActuatorNumber::Range::not_negative},
    {"stribeck_velocity", &Actuator::stribeck_velocity, ActuatorNumber::Range::positive},
    {"friction_offset", &Actuator::friction_offset, ActuatorNumber::Range::any},
    {"stick_velocity", &Actuator::stick_velocity, ActuatorNumber::Range::not_negative},
}};

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

  /// What the model_id is made of besides the link, in this order.
  auto facts() const { return std::tie(ankle_at, heel_at, toe_at, friction, f_min); }

  bool exists() const { return link >= 0; }
  bool has_extent() const { return heel_at != toe_at; }
  /// Height of the ankle above the sole, h_p.
  double ankle_height() const { return ankle_at.y() - heel_at.y(); }
  /// Heel and toe along the sole, measured from below the ankle, forward positive: −l_p and l_p1.
  double heel_x() const { return heel_at.x() - ankle_at.x(); }
  double toe_x() const { return toe_at.x() - ankle_at.x(); }
};

/// A robot as computed with; built by assemble() (assembly.h) from a description, constant from then on.
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
  PerSide<Foot> feet = {};
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
  double leg_length = 0.0;     ///< a length of the robot's size, m: assembly.h
  /// The link in the middle of the way from foot to foot, the nearer one to the right foot of two; −1 without two feet.
  /// Both legs carry it, and what hangs on it. A leg is what is left on the way to a foot, with all that hangs there.
  int trunk = -1;
  std::vector<std::optional<Side>> leg = {}; ///< of each link: whose leg it is part of
  std::int64_t model_id = 0;                 ///< model_id_of()
  /// What the user should know about how the robot's file was read: a line each, which begins with the file's name.
  std::vector<std::string> notes = {};

  int num_joints() const { return static_cast<int>(actuators.size()); }
  /// Coordinates, the base point and a fixed root not among them.
  int num_coordinates() const { return static_cast<int>(absolute_names.size()); }
  int root() const { return order.front(); }
  bool fixed_root() const { return !link(root()).type().floats(); }
  double weight() const { return mechanism.mass() * mechanism.gravity(); }
  const Foot& foot(Side side) const { return feet[side]; }
  const Link& link(int index) const { return links[static_cast<std::size_t>(index)]; }
  /// Whether this foot is the fixed root.
  bool is_root(const Foot& foot) const { return fixed_root() && foot.link == root(); }
};

/// The link that hangs on the other one by the joint at which an actuator acts; null if there is no joint between its
/// two links.
const Link* child_of_joint(const std::vector<Link>& links, const Actuator& actuator);

/// Whether a motor is linear, along the slide between its two links: its torque is a force, N.
bool is_force(const Robot& robot, const Actuator& actuator);

/// FNV-1a of all that a description says, names among it, but comments and drawings; never 0.
std::int64_t model_id_of(const Robot& robot);

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
/// on. torque: kMaxJoints long; written in whole blocks of joints, with 0 beyond the last.
template <typename Force, typename Torque>
void write_joint_torques(const Robot& robot, const Force& force, Torque& torque)
{
  for (int j = 0; j < robot.num_joints(); j += kJointBlock)
  {
    JointBlock sum = JointBlock::Zero();
    for (int c = 0; c < robot.mechanism.num_theta(); ++c)
      sum += force(c) * robot.B_inverse.block<kJointBlock, 1>(j, c);
    torque.template segment<kJointBlock>(j) = sum;
  }
}
/// The same, as many as there are joints.
template <typename Force> VectorJ joint_torques(const Robot& robot, const Force& force)
{
  VectorJ torque(kMaxJoints);
  write_joint_torques(robot, force, torque);
  torque.conservativeResize(robot.num_joints());
  return torque;
}

/// B: the whole matrix, num_q() × num_joints(); the rows of the base point are zero.
Bounded<kMaxCoordinates, kMaxJoints> input_matrix(const Robot& robot);

} // namespace torqued
