/// A robot: a mechanism with names, actuators and feet, and the constants that follow from them.
#pragma once

#include "planar/mechanism.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// The most actuators: one for each coordinate that is not the base's.
inline constexpr int kMaxJoints = kMaxCoordinates;
/// One number per actuator.
using VectorJ = BoundedVector<kMaxJoints>;

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

/// How a link moves with its parent; numbered as in model_info_t.
enum class JointKind : std::int8_t
{
  floating = 0, ///< x, z and an angle against the world: the root
  revolute = 1, ///< turns about a point of the parent
  fixed = 5     ///< rides on the parent at a constant angle
};

/// A stroke that draws a link: from, to in the link's frame, width; m.
struct Segment
{
  Eigen::Vector2d from, to;
  double width;
};

/// A rigid link. Its frame has its origin at the joint to its parent; all vectors are in link frames, m.
struct Link
{
  std::string name;
  int parent = -1; ///< index of the parent link; −1 for the root
  JointKind joint = JointKind::revolute;
  Eigen::Vector2d at = Eigen::Vector2d::Zero(); ///< the joint in the parent's frame
  double angle = 0.0;                           ///< fixed: against the parent, rad
  int coordinate = -1;                          ///< index of its angle in θ; −1 if it has none of its own
  double mass = 0.0;                            ///< kg
  Eigen::Vector2d com = Eigen::Vector2d::Zero();
  double inertia = 0.0; ///< about the centre of mass, kg m²
  std::vector<Segment> drawing;

  int direction = -1;           ///< the mechanism's direction that turns it
  double direction_angle = 0.0; ///< its angle against that direction, rad
  Point origin;                 ///< its frame's origin
};

/// A motor between two links: a positive torque turns `on` counter-clockwise and `against` clockwise.
struct Actuator
{
  std::string name;
  int on = -1, against = -1;
  double torque_limit; ///< N m; infinite if there is none
  double rate_limit;   ///< N m/s; infinite if there is none
};

/// A foot: where it can touch the ground. A foot without extent has heel = toe = ankle and no sole.
struct Foot
{
  Side side;
  int link;
  Eigen::Vector2d ankle_at, heel_at, toe_at; ///< in the link's frame, m; heel and toe lie equally high
  double friction;                           ///< coefficient μ
  Point ankle, heel, toe;                    ///< the same points of the mechanism

  bool has_sole() const { return heel_at != toe_at; }
  /// Height of the ankle above the sole, h_p.
  double ankle_height() const { return ankle_at.y() - heel_at.y(); }
  /// Heel and toe along the sole, measured from below the ankle, forward positive: −l_p and l_p1.
  double heel_x() const { return heel_at.x() - ankle_at.x(); }
  double toe_x() const { return toe_at.x() - ankle_at.x(); }
};

/// A robot as computed with; built by assemble() from a description, constant from then on.
///
/// Coordinates ABSOLUTE are θ, the angles of the links against the world, in the file's order. Coordinates RELATIVE
/// are the actuators' angles in their order, then the angle of the floating root:
///
///   q_relative = A q_absolute + b          A square, invertible; the base point is not part of it
///
/// Generalized forces go the other way: f_absolute = Aᵀ f_relative.
struct Robot
{
  std::string name;
  std::string source; ///< where its numbers come from
  std::vector<Link> links;
  std::vector<Actuator> actuators;
  std::array<Foot, 2> feet; ///< indexed by Side
  std::vector<std::string> absolute_names, relative_names;
  std::array<std::string, 2> base_names;
  Mechanism mechanism;
  MatrixQ A, A_inverse;
  VectorQ b;
  double leg_length;     ///< from the base point to the ankle of the straight robot (all angles 0), the longer leg's, m
  std::int64_t model_id; ///< FNV-1a of everything above that is more than a comment or a drawing; never 0

  int num_joints() const { return static_cast<int>(actuators.size()); }
  int num_angles() const { return mechanism.num_angles(); }
  double weight() const { return mechanism.mass() * mechanism.gravity(); }
  const Foot& foot(Side side) const { return feet[static_cast<std::size_t>(side)]; }
};

/// What a robot file says, names not yet resolved. Lines are those of the file, for complaints.
struct RobotDescription
{
  struct LinkEntry
  {
    Link link;
    std::string parent, coordinate;
    int line;
  };
  struct ActuatorEntry
  {
    std::string name, on, against, coordinate;
    double offset, torque_limit, rate_limit;
    int line;
  };
  struct FootEntry
  {
    Foot foot;
    std::string link;
    int line;
  };

  std::string file;
  std::string name, source;
  double gravity;
  std::array<std::string, 2> base_names;
  std::vector<LinkEntry> links;
  std::vector<ActuatorEntry> actuators; ///< if empty: one for each revolute joint, turning the child against its parent
  std::vector<FootEntry> feet;
};

/// Builds a robot. Throws FileError (strict_toml.h) with file, line and what would be right.
Robot assemble(const RobotDescription& description);

/// Reads a robot from TOML text; file is the name used in complaints. Throws FileError.
Robot read_toml_robot(std::string_view text, const std::string& file);

/// The robots that ship: names, and a shipped robot's TOML; empty if there is none of that name.
std::vector<std::string_view> shipped_robot_names();
std::string_view shipped_robot_toml(std::string_view name);

/// Loads a robot that ships, by its name, or a .toml file, by its path. Throws FileError.
Robot load_robot(const std::string& name_or_path);

} // namespace torqued
