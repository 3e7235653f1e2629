#include "robot/printable.h"
#include "robot/robot.h"
#include "robot/strict_toml.h"
#include "robot/strict_xml.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <optional>

namespace torqued
{

namespace
{

std::string name(StrictElement& element, std::string_view key)
{
  const std::string text = element.text(key);
  if (!is_name(text))
    element.fail(key, fmt::format("found \"{}\"; expected 1 to {} letters, digits, _ or -",
                                  printable(text, kLongestName), kLongestName));
  return text;
}

// Turns about fixed axes, x first, then y, then z.
Eigen::Matrix3d rotation(const Eigen::Vector3d& rpy)
{
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(rpy.z(), Vector3d::UnitZ()).toRotationMatrix() *
          AngleAxisd(rpy.y(), Vector3d::UnitY()).toRotationMatrix()) *
         AngleAxisd(rpy.x(), Vector3d::UnitX()).toRotationMatrix();
}

Eigen::Vector2d in_plane(const Eigen::Vector3d& r)
{
  return {r.x(), r.z()};
}

struct Origin
{
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
};

struct Joint
{
  enum class Type
  {
    revolute,
    fixed,
    prismatic,
    floating
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
  Origin origin; // in the parent's frame; from align_frames() on, along the root's
  std::optional<Eigen::Vector3d> axis;
  std::optional<Mimic> mimic;
  int parent = -1, child = -1;
  double sense = 1.0; // +1: its axis is +y, −1: it is −y
  bool rolls = false; // together with the joint before or after it
};

// The bar before a link that rolls, and the parent's share of the bar's angle.
struct Rolling
{
  int bar;
  double parent_share;
};

struct UrdfLink
{
  std::string name;
  int line = 0;
  bool has_inertial = false;
  double mass = 0.0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero(); // about com, along the link's frame
  int inertia_line = 0;
  int joint = -1;                                  // to its parent
  std::vector<int> joints;                         // to its children
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity(); // its frame, seen from the root's, when all joints are at 0
  std::optional<Rolling> rolling;
  int bar_to = -1; // the link that rolls at its other end, if this is a bar
};

// Reads a URDF step by step; each step may complain about a line of the file.
class UrdfReader
{
public:
  explicit UrdfReader(const std::string& file) : file_(file) {}

  RobotDescription read(std::string_view text)
  {
    read_elements(text);
    find_root();
    align_frames();
    for (Joint& joint : joints_)
      if (joint.mimic)
        pair_rolling(joint);
    return description();
  }

private:
  [[noreturn]] void fail(int line, const std::string& message) const
  {
    throw FileError(fmt::format("{}:{}: {}", file_, line, message));
  }
  [[noreturn]] void fail(const Joint& joint, const std::string& message) const
  {
    fail(joint.line, fmt::format("joint '{}': {}", joint.name, message));
  }
  [[noreturn]] void fail(const UrdfLink& link, const std::string& message) const
  {
    fail(link.line, fmt::format("link '{}': {}", link.name, message));
  }

  UrdfLink& link(int index) { return links_[static_cast<std::size_t>(index)]; }
  const UrdfLink& link(int index) const { return links_[static_cast<std::size_t>(index)]; }
  Joint& joint(int index) { return joints_[static_cast<std::size_t>(index)]; }
  const Joint& joint(int index) const { return joints_[static_cast<std::size_t>(index)]; }

  void read_elements(std::string_view text)
  {
    tinyxml2::XMLDocument document;
    parse_xml(text, file_, document);
    const tinyxml2::XMLElement* element = nullptr;
    for (const auto* node = document.FirstChild(); node; node = node->NextSibling())
    {
      if (node->ToComment() || node->ToDeclaration())
        continue;
      if (element || !node->ToElement())
        fail(node->GetLineNum(), "expected one element <robot>, and nothing else");
      element = node->ToElement();
    }
    if (!element)
      fail(1, "there is no element <robot>");
    StrictElement robot(*element, file_);
    if (std::string_view(element->Value()) != "robot")
      robot.fail({}, fmt::format("found <{}>; expected <robot>", printable(element->Value(), kLongestName)));
    robot.skip_namespaces();
    robot.skip({"version", "material", "transmission", "gazebo", "sensor", "ros2_control", "model_state"});
    name_ = torqued::name(robot, "name");
    for (StrictElement& child : robot.children("link"))
      read_link(child);
    for (StrictElement& child : robot.children("joint"))
      read_joint(child);
    robot.finish();
  }

  void read_link(StrictElement& element)
  {
    UrdfLink link;
    link.name = torqued::name(element, "name");
    link.line = element.line();
    element.set_context(fmt::format("link '{}'", link.name));
    element.skip({"visual", "collision"});
    if (std::optional<StrictElement> inertial = element.child("inertial"))
    {
      link.has_inertial = true;
      read_inertial(*inertial, link);
    }
    element.finish();
    if (!link_index_.emplace(link.name, static_cast<int>(links_.size())).second)
      fail(link, "there is a second link of this name; names must differ");
    links_.push_back(link);
  }

  static Origin read_origin(StrictElement& element)
  {
    Origin origin;
    if (std::optional<StrictElement> child = element.child("origin"))
    {
      origin.at = child->vector("xyz", Eigen::Vector3d::Zero());
      origin.R = rotation(child->vector("rpy", Eigen::Vector3d::Zero()));
      child->finish();
    }
    return origin;
  }

  static void read_inertial(StrictElement& inertial, UrdfLink& link)
  {
    const auto needed = [&inertial](std::string_view name)
    {
      std::optional<StrictElement> child = inertial.child(name);
      if (!child)
        inertial.fail({}, fmt::format("<{}> is missing; a link without mass has no <inertial>", name));
      return *child;
    };
    const Origin origin = read_origin(inertial);
    StrictElement mass = needed("mass");
    link.mass = mass.magnitude("value");
    mass.finish();
    StrictElement inertia = needed("inertia");
    link.inertia_line = inertia.line();
    Eigen::Matrix3d I;
    constexpr std::string_view keys[3][3] = {{"ixx", "ixy", "ixz"}, {"ixy", "iyy", "iyz"}, {"ixz", "iyz", "izz"}};
    for (int row = 0; row < 3; ++row)
      for (int column = row; column < 3; ++column)
        I(row, column) = I(column, row) = inertia.number(keys[row][column]);
    for (int axis = 0; axis < 3; ++axis)
      if (I(axis, axis) < 0.0)
        inertia.fail(keys[axis][axis], fmt::format("found {}; expected a number that is not negative", I(axis, axis)));
    inertia.finish();
    inertial.finish();
    link.com = origin.at;
    link.inertia = origin.R * I * origin.R.transpose();
  }

  void read_joint(StrictElement& element)
  {
    Joint joint;
    joint.name = torqued::name(element, "name");
    joint.line = element.line();
    element.set_context(fmt::format("joint '{}'", joint.name));
    joint.type = read_type(element);
    element.skip({"limit", "dynamics", "safety_controller", "calibration"});
    joint.origin = read_origin(element);
    joint.parent = read_end(element, "parent");
    joint.child = read_end(element, "child");
    if (std::optional<StrictElement> axis = element.child("axis"))
    {
      joint.axis = axis->vector("xyz", Eigen::Vector3d::UnitX());
      axis->finish();
    }
    if (std::optional<StrictElement> mimic = element.child("mimic"))
    {
      joint.mimic = {mimic->text("joint"), mimic->number("multiplier", 1.0), mimic->number("offset", 0.0),
                     mimic->line()};
      mimic->finish();
    }
    element.finish();

    const int index = static_cast<int>(joints_.size());
    if (!joint_index_.emplace(joint.name, index).second)
      fail(joint, "there is a second joint of this name; names must differ");
    UrdfLink& child = link(joint.child);
    if (child.joint >= 0)
      fail(joint, fmt::format("its child \"{}\" is the child of joint '{}', too; a link has one parent", child.name,
                              this->joint(child.joint).name));
    child.joint = index;
    link(joint.parent).joints.push_back(index);
    joints_.push_back(joint);
  }

  static Joint::Type read_type(StrictElement& element)
  {
    const std::string type = element.text("type");
    if (type == "revolute" || type == "continuous")
      return Joint::Type::revolute;
    if (type == "fixed")
      return Joint::Type::fixed;
    if (type == "prismatic")
      return Joint::Type::prismatic;
    if (type == "floating")
      return Joint::Type::floating;
    element.fail("type", fmt::format("found \"{}\"; expected revolute, continuous, prismatic, fixed or floating",
                                     printable(type, kLongestName)));
  }

  int read_end(StrictElement& element, std::string_view end) const
  {
    std::optional<StrictElement> child = element.child(end);
    if (!child)
      element.fail({}, fmt::format("<{}> is missing", end));
    const std::string name = child->text("link");
    child->finish();
    const auto found = link_index_.find(name);
    if (found == link_index_.end())
      child->fail("link", fmt::format("found \"{}\"; there is no link of that name", printable(name, kLongestName)));
    return found->second;
  }

  // the one link that is no child; if it is the world, its one child
  void find_root()
  {
    if (links_.empty())
      fail(1, "there is no <link>; a robot needs at least its root");
    int top = -1;
    for (int i = 0; i < static_cast<int>(links_.size()); ++i)
    {
      if (link(i).joint >= 0)
        continue;
      if (top >= 0)
        fail(link(i),
             fmt::format("is no joint's child, and neither is '{}'; one root carries all others", link(top).name));
      top = i;
    }
    if (top < 0)
      fail(links_.front(), "there is no root: every link is the child of a joint, so their parents form a circle");
    order_ = {top};
    for (std::size_t done = 0; done < order_.size(); ++done)
      for (const int i : link(order_[done]).joints)
        order_.push_back(joint(i).child);
    if (order_.size() != links_.size())
      fail_at_circle();

    root_ = top;
    for (const UrdfLink& other : links_)
      if (other.name == kWorld && &other != &link(top))
        fail(other, "is the child of a joint; \"world\" is what a root stands on");
    if (link(top).name == kWorld)
      step_off_world();
    for (const Joint& joint : joints_)
      if (joint.type == Joint::Type::floating && &joint != world_joint_)
        fail(joint, "is floating; only the child of a root link called \"world\" floats");
  }

  [[noreturn]] void fail_at_circle() const
  {
    std::vector<bool> reached(links_.size());
    for (const int i : order_)
      reached[static_cast<std::size_t>(i)] = true;
    const auto first = static_cast<std::size_t>(std::find(reached.begin(), reached.end(), false) - reached.begin());
    fail(links_[first], "does not hang on the root: its parents form a circle");
  }

  void step_off_world()
  {
    const UrdfLink& world = link(root_);
    if (world.has_inertial)
      fail(world, "has <inertial>; the world has no mass");
    if (world.joints.size() != 1)
      fail(world, fmt::format("has {} children; the world has one, the robot's root", world.joints.size()));
    world_joint_ = &joint(world.joints.front());
    if (world_joint_->type != Joint::Type::floating && world_joint_->type != Joint::Type::fixed)
      fail(*world_joint_, "its parent is the world; a root there is floating or fixed");
    root_ = world_joint_->child;
    link(root_).R = world_joint_->origin.R;
    order_.erase(order_.begin());
  }

  // every link's frame against the root's, and where the axes point
  void align_frames()
  {
    for (const int i : order_)
    {
      if (i == root_)
        continue;
      Joint& joint = this->joint(link(i).joint);
      link(i).R = link(joint.parent).R * joint.origin.R;
      joint.origin.at = link(joint.parent).R * joint.origin.at;
      if (joint.type != Joint::Type::fixed)
        align_axis(joint);
    }
  }

  void align_axis(Joint& joint) const
  {
    const bool turns = joint.type == Joint::Type::revolute;
    if (!joint.axis)
      fail(joint, "axis: is missing; URDF then takes x, and here it must be parallel to y");
    const Eigen::Vector3d axis = (link(joint.child).R * *joint.axis).stableNormalized();
    if (!(axis.norm() > 0.5))
      fail(joint, fmt::format("axis: found {}; expected a direction", shown(*joint.axis)));
    constexpr double aligned = 1e-9;
    if (!(std::hypot(axis.x(), axis.z()) <= aligned))
      fail(joint, fmt::format("axis: found {}, which is {} in the root's frame; expected one parallel to y: {}",
                              shown(*joint.axis), shown(axis),
                              turns ? "the robot moves in the x-z plane"
                                    : "what slides in the x-z plane is not a sum of constant rotated vectors"));
    joint.sense = axis.y() > 0.0 ? 1.0 : -1.0;
  }

  static std::string shown(const Eigen::Vector3d& v)
  {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x(), v.y(), v.z());
  }

  // makes the mimicking joint, the one it mimics and the bar between them one rolling joint
  void pair_rolling(Joint& mimicking)
  {
    const Joint::Mimic& mimic = *mimicking.mimic;
    const auto refuse = [&](const std::string& why)
    {
      fail(mimic.line, fmt::format("joint '{}': mimic: {}", mimicking.name, why));
    };
    const auto found = joint_index_.find(mimic.joint);
    if (found == joint_index_.end())
      refuse(fmt::format("found \"{}\"; there is no joint of that name", printable(mimic.joint, kLongestName)));
    Joint& mimicked = joint(found->second);
    const bool second_mimics = mimicked.child == mimicking.parent;
    if (!second_mimics && mimicking.child != mimicked.parent)
      refuse(
          fmt::format("does not follow joint '{}', nor the other way round; only two joints with a link between them "
                      "can roll",
                      mimicked.name));
    if (mimicking.type != Joint::Type::revolute || mimicked.type != Joint::Type::revolute)
      refuse("only two revolute joints can roll");
    if (mimicked.mimic)
      refuse(fmt::format("joint '{}' mimics a joint itself", mimicked.name));
    if (mimic.offset != 0.0)
      refuse(fmt::format("offset: found {}; expected 0, circles that roll turn together", mimic.offset));
    const double ratio = mimic.multiplier * mimicking.sense * mimicked.sense;
    if (!(ratio > 0.0))
      refuse(
          fmt::format("multiplier: found {}{}; expected one by which both turn in the same sense, as circles that roll "
                      "do",
                      mimic.multiplier, mimicking.sense * mimicked.sense < 0.0 ? " between opposite axes" : ""));
    if (mimicking.rolls || mimicked.rolls)
      refuse("one of the two joints rolls with another one, too");
    const Joint& first = second_mimics ? mimicked : mimicking;
    const Joint& second = second_mimics ? mimicking : mimicked;
    UrdfLink& bar = link(first.child);
    if (bar.mass != 0.0 || !bar.inertia.isZero(0.0))
      refuse(fmt::format("link '{}' between the joints has a mass; the bar of a rolling joint has none", bar.name));
    if (bar.joints.size() != 1)
      refuse(fmt::format("link '{}' between the joints has {} children; the bar of a rolling joint has one", bar.name,
                         bar.joints.size()));
    if (in_plane(second.origin.at).isZero(0.0))
      refuse(
          fmt::format("both joints are at the same place; the bar between them, '{}', must have a length", bar.name));
    // the ratio is r_p / r_c if the second joint mimics the first, r_c / r_p the other way round
    link(second.child).rolling = {first.child, second_mimics ? ratio / (1.0 + ratio) : 1.0 / (1.0 + ratio)};
    bar.bar_to = second.child;
    mimicking.rolls = mimicked.rolls = true;
  }

  RobotDescription description() const
  {
    RobotDescription description;
    description.file = file_;
    description.name = name_;
    description.gravity = 9.81;
    for (int i = 0; i < static_cast<int>(links_.size()); ++i)
      if (link(i).name != kWorld && link(i).bar_to < 0)
        description.links.push_back(link_entry(i));
    for (const Joint& joint : joints_)
    {
      if (joint.type == Joint::Type::fixed || joint.type == Joint::Type::floating || joint.mimic)
        continue;
      const UrdfLink& end = link(joint.child);
      const UrdfLink& child = end.bar_to >= 0 ? link(end.bar_to) : end;
      RobotDescription::ActuatorEntry entry;
      entry.on = child.name;
      entry.against = link(carrying(child).parent).name;
      entry.coordinate = joint.name;
      entry.offset = 0.0;
      entry.line = joint.line;
      entry.actuator.name = joint.name;
      description.actuators.push_back(entry);
    }
    return description;
  }

  // the joint on the parent: for a link that rolls, that of the bar
  const Joint& carrying(const UrdfLink& child) const
  {
    return joint(child.rolling ? link(child.rolling->bar).joint : child.joint);
  }

  RobotDescription::LinkEntry link_entry(int index) const
  {
    const UrdfLink& from = link(index);
    RobotDescription::LinkEntry entry{{}, {}, from.name, from.line};
    Link& to = entry.link;
    to.name = from.name;
    to.mass = from.mass;
    to.com = in_plane(from.R * from.com);
    to.inertia = pitch_inertia(from);
    if (index == root_)
    {
      to.joint = world_joint_ && world_joint_->type == Joint::Type::fixed ? JointKind::fixed : JointKind::floating;
      entry.parent = to.joint == JointKind::fixed ? kWorld : std::string_view();
      return entry;
    }
    const Joint& own = carrying(from);
    entry.parent = link(own.parent).name;
    to.at = in_plane(own.origin.at);
    to.joint = own.type == Joint::Type::fixed       ? JointKind::fixed
               : own.type == Joint::Type::prismatic ? JointKind::slide
                                                    : JointKind::revolute;
    if (from.rolling)
    {
      const Eigen::Vector2d bar = in_plane(joint(from.joint).origin.at);
      const double length = bar.stableNorm();
      to.joint = JointKind::rolling;
      to.angle = std::atan2(bar.x(), -bar.y());
      to.parent_radius = length * from.rolling->parent_share;
      to.child_radius = length - to.parent_radius;
    }
    return entry;
  }

  double pitch_inertia(const UrdfLink& from) const
  {
    const double inertia = (from.R * from.inertia * from.R.transpose())(1, 1);
    // what turning leaves of a zero
    const double rounding = 1e-14 * from.inertia.cwiseAbs().maxCoeff();
    if (inertia < -rounding)
      fail(from.inertia_line,
           fmt::format("link '{}': inertia: is {} about y of the root's frame; expected a number that "
                       "is not negative",
                       from.name, inertia));
    return std::max(0.0, inertia);
  }

  const std::string& file_;
  std::string name_;
  std::vector<UrdfLink> links_;
  std::vector<Joint> joints_;
  std::map<std::string, int> link_index_, joint_index_;
  std::vector<int> order_; // parents before children, without the world
  int root_ = -1;
  const Joint* world_joint_ = nullptr;
};

} // namespace

RobotDescription read_urdf(std::string_view text, const std::string& file)
{
  return UrdfReader(file).read(text);
}

Robot read_urdf_robot(std::string_view text, const std::string& file)
{
  const RobotDescription description = read_urdf(text, file);
  for (const auto& entry : description.links)
    if (entry.parent == kWorld)
      throw FileError(
          fmt::format("{}:{}: link '{}' is fixed to the world and stands for a foot; a TOML file with urdf = "
                      "\"{}\" must say which, in a [[foot]]",
                      file, entry.line, entry.link.name, printable(std::filesystem::path(file).filename().string())));
  return assemble(description);
}

} // namespace torqued
