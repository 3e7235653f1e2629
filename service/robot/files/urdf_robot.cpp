#include "robot/files/urdf_robot.h"

#include "robot/assembly.h"
#include "robot/files/text_file.h"
#include "robot/files/urdf_model.h"
#include "text/printable.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued
{

namespace
{

using urdf::Joint;
using urdf::Model;

Eigen::Vector2d in_plane(const Eigen::Vector3d& r)
{
  return {r.x(), r.z()};
}

double pitch_inertia(const Model& model, const urdf::Link& from)
{
  const double inertia = moment_about_y(from);
  // what turning leaves of a zero
  const double rounding = 1e-14 * from.inertia.cwiseAbs().maxCoeff();
  if (inertia < -rounding)
    model.fail(
        from.inertia_line,
        fmt::format("link '{}': inertia: is {} about y of the root's frame; expected a number that is not negative",
                    from.name, inertia));
  return std::max(0.0, inertia);
}

// the joint on the parent: for a link that rolls, that of the bar
const Joint& carrying(const Model& model, const urdf::Link& child)
{
  return model.joint(child.rolling ? model.link(child.rolling->bar).joint : child.joint);
}

RobotDescription::LinkEntry link_entry(const Model& model, int index)
{
  const urdf::Link& from = model.link(index);
  RobotDescription::LinkEntry entry{{}, {}, from.name, from.line};
  Link& to = entry.link;
  to.name = from.name;
  to.mass = from.mass;
  to.com = in_plane(from.R * from.com);
  to.inertia = pitch_inertia(model, from);
  if (index == model.root)
  {
    to.joint = model.root_is_fixed ? JointKind::fixed : JointKind::floating;
    entry.parent = model.root_is_fixed ? kWorld : std::string_view();
    return entry;
  }
  const Joint& own = carrying(model, from);
  entry.parent = model.link(own.parent).name;
  to.at = in_plane(own.origin.at);
  to.joint = own.type == Joint::Type::fixed       ? JointKind::fixed
             : own.type == Joint::Type::prismatic ? JointKind::slide
                                                  : JointKind::revolute;
  if (from.rolling)
  {
    const Eigen::Vector2d bar = in_plane(model.joint(from.joint).origin.at);
    const double length = bar.stableNorm();
    to.joint = JointKind::rolling;
    to.angle = std::atan2(bar.x(), -bar.y());
    to.parent_radius = length * from.rolling->parent_share;
    to.child_radius = length - to.parent_radius;
  }
  return entry;
}

// an actuator for each joint that moves, and what the URDF says of it; of a rolling joint's two, one
void add_actuators(const Model& model, RobotDescription& description)
{
  for (const Joint& joint : model.joints)
  {
    if (joint.type == Joint::Type::fixed || joint.carries_root || model.link(joint.child).of_the_world)
      continue;
    const urdf::Link& end = model.link(joint.child);
    const urdf::Link& child = end.bar_to >= 0 ? model.link(end.bar_to) : end;
    const std::string& against = model.link(carrying(model, child).parent).name;
    if (!joint.unread.empty())
      description.unread.push_back({joint.name, child.name, against, joint.unread, model.file, joint.line});
    if (joint.mimic)
      continue;
    RobotDescription::ActuatorEntry entry;
    entry.on = child.name;
    entry.against = against;
    entry.coordinate = joint.name;
    entry.offset = 0.0;
    entry.line = joint.line;
    entry.actuator.name = joint.name;
    description.actuators.push_back(entry);
    const bool slides = joint.type == Joint::Type::prismatic;
    if ((joint.sense > 0.0) != slides) // here angles count about -y, displacements along +y
      description.opposite.push_back({joint.name, entry.on, against, slides, model.file});
  }
}

std::string note_of_passed_over(const Model& model)
{
  constexpr std::size_t most = 12;
  std::vector<std::string> names(model.passed_over.begin(), model.passed_over.end());
  const std::size_t others = names.size() > most ? names.size() - most : 0;
  names.resize(names.size() - others);
  return fmt::format("{}: passed over, because it moves nothing: {}{}", model.file, fmt::join(names, ", "),
                     others > 0 ? fmt::format(" and {} more", others) : "");
}

std::string note_of_not_read(const Model& model, const urdf::Unread& unread)
{
  const bool one = unread.others == 0;
  return fmt::format("{}:{}: {}{} {} not read: what {} {} say{} has no effect here", model.file, unread.line,
                     unread.first, one ? "" : fmt::format(" and {} more like it", unread.others), one ? "is" : "are",
                     one ? "its" : "their", fmt::join(unread.parts, ", "), unread.parts.size() == 1 ? "s" : "");
}

} // namespace

RobotDescription read_urdf(std::string_view text, const std::string& file)
{
  Model model = urdf::read_elements(text, file);
  urdf::find_root(model);
  urdf::align_frames(model);
  urdf::pair_rolling(model);
  urdf::look_at_bodies(model);

  RobotDescription description;
  description.file = file;
  description.name = model.name;
  description.gravity = 9.81;
  for (int i = 0; i < static_cast<int>(model.links.size()); ++i)
    if (!model.link(i).of_the_world && model.link(i).bar_to < 0)
      description.links.push_back(link_entry(model, i));
  add_actuators(model, description);
  description.notes = model.notes;
  for (const auto& [says, unread] : model.not_read)
    description.notes.push_back(note_of_not_read(model, unread));
  if (!model.passed_over.empty())
    description.notes.push_back(note_of_passed_over(model));
  return description;
}

Robot read_urdf_robot(std::string_view text, const std::string& file)
{
  const RobotDescription description = read_urdf(text, file);
  for (const auto& entry : description.links)
    if (entry.parent == kWorld)
      throw FileError(fmt::format("{}:{}: link '{}' is fixed to the world and stands for a foot; a TOML file with urdf "
                                  "= \"{}\" must say which, in a [[foot]]",
                                  file, entry.line, entry.link.name,
                                  printable(std::filesystem::path(file).filename().string())));
  return assemble(description);
}

} // namespace torqued
