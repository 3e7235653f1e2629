/// A URDF on its way to a robot: its links and joints, and what each step finds out about them.
#pragma once

#include "robot/description.h"

#include <Eigen/Core>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace torqued::urdf
{

/// A frame in another one.
struct Origin
{
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero(); ///< R as the file says it, rad
};

struct Joint
{
  enum class Type
  {
    revolute,
    fixed,
    prismatic,
    floating,
    planar
  };
  struct Mimic
  {
    std::string joint;
    double multiplier, offset;
    int line;
  };

  std::string name;
  int line = 0;
  Type type = Type::fixed;
  Origin origin; ///< in the parent's frame; from align_frames() on, along the root's
  std::optional<Eigen::Vector3d> axis;
  std::optional<Mimic> mimic;
  int parent = -1, child = -1;
  std::vector<UnreadValue> unread = {}; ///< what it says of its motor
  bool has_range = false;               ///< whether it says how far it goes
  double sense = 1.0;                   ///< +1: its axis is +y, −1: it is −y
  bool rolls = false;                   ///< together with the joint before or after it
  bool carries_root = false;            ///< part of what lets the root float, and no joint of the robot
};

/// The bar before a link that rolls, and the parent's share of the bar's angle.
struct Rolling
{
  int bar;
  double parent_share;
};

struct Link
{
  std::string name;
  int line = 0;
  double mass = 0.0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero(); ///< about com, along its own frame
  Eigen::Matrix3d inertia_R =
      Eigen::Matrix3d::Identity(); ///< that frame, seen from the link's; from align_frames() on, from the root's
  int inertia_line = 0;
  int joint = -1;                                  ///< to its parent
  std::vector<int> joints = {};                    ///< to its children
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity(); ///< its frame, seen from the root's, all joints at 0
  std::optional<Rolling> rolling;
  int bar_to = -1;           ///< the link that rolls at its other end, if this is a bar
  bool of_the_world = false; ///< the world, what carries the root, and what stands around: no link of the robot
};

/// Elements that might be mechanics and are not read.
struct Unread
{
  int line = 0;           ///< of the first
  std::string first = {}; ///< "<gazebo reference=\"left_hip\">"
  int others = 0;
  std::vector<std::string> parts = {}; ///< what they say: "<springStiffness>"
};

struct Model
{
  std::string file;
  std::string name = {};
  std::vector<Link> links = {};
  std::vector<Joint> joints = {};
  std::map<std::string, int> link_index = {}, joint_index = {};
  std::vector<int> order = {};                 ///< the robot's links, parents before children
  int root = -1;                               ///< from find_root() on
  bool root_is_fixed = false;                  ///< to the world
  std::set<std::string> passed_over = {};      ///< what is there and moves nothing, as a note names it
  std::map<std::string, double> rounded = {};  ///< what is out of the plane as rounded angles are, and by how much, rad
  std::map<std::string, Unread> not_read = {}; ///< elements that say the same, by what they say
  std::vector<std::string> notes = {};         ///< what to know about how the file was read

  Link& link(int index) { return links[static_cast<std::size_t>(index)]; }
  const Link& link(int index) const { return links[static_cast<std::size_t>(index)]; }
  Joint& joint(int index) { return joints[static_cast<std::size_t>(index)]; }
  const Joint& joint(int index) const { return joints[static_cast<std::size_t>(index)]; }

  /// Complaints: FileError, with the line of what is wrong.
  [[noreturn]] void fail(int line, const std::string& message) const;
  [[noreturn]] void fail(const Joint& joint, const std::string& message) const;
  [[noreturn]] void fail(const Link& link, const std::string& message) const;
};

/// "(0, 1, 0)"
std::string shown(const Eigen::Vector3d& v);

/// Reads the file's elements, and nothing of how they hang together but names. urdf_elements.cpp
Model read_elements(std::string_view text, const std::string& file);

/// Finds the root, and whether it floats or is fixed; takes the world, links without mass that let the root float, and
/// what stands around off the robot; puts the root's links in order. The root's frame is set, as the world has it.
/// urdf_root.cpp
void find_root(Model& model);

/// Exporters round angles: a direction counts as ±y up to this far from it, rad.
inline constexpr double kRoundedAngle = 1e-4;

/// Sets every link's frame against the root's and where axes point. Refuses an axis that is not about ±y.
/// Frames and axes that are out of the plane by no more than kRoundedAngle are turned into it; a note says which.
/// urdf_frames.cpp
void align_frames(Model& model);

/// A frame of which one axis is within kRoundedAngle of ±y, turned by the smallest angle that makes it ±y, and
/// remembered as rounded by the name of what turned it; any other one as it is.
Eigen::Matrix3d level(Model& model, const Eigen::Matrix3d& R, const std::string& name);

/// Whether a joint's axis is ±y within kRoundedAngle; if not exactly, it is remembered as rounded.
bool is_about_y(Model& model, const Joint& joint, const Eigen::Vector3d& axis);

/// "joint 'left_hip'"
std::string name_of(const Joint& joint);

/// A unit vector along the joint's axis, seen from the root. R: the child's frame seen from there.
Eigen::Vector3d axis_of(const Model& model, const Joint& joint, const Eigen::Matrix3d& R);

/// Makes pairs of joints of which one mimics the other rolling ones, with the bar between them; refuses any other
/// mimic. urdf_rolling.cpp
void pair_rolling(Model& model);

/// The moment of inertia about y of the root's frame, from align_frames() on.
double moment_about_y(const Link& link);

/// Notes bodies that a joint moves and that have no mass, and tensors of inertia that no body has. urdf_bodies.cpp
void look_at_bodies(Model& model);

} // namespace torqued::urdf
