#include "bus/model_robot.h"

#include "motion/failure.h"
#include "robot/assembly.h"
#include "robot/files/strict_toml.h"
#include "text/printable.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace torqued
{

namespace
{

Eigen::Vector2d vector(const double* xz)
{
  return {xz[0], xz[1]};
}
Eigen::Vector2d vector(const std::vector<double>& xz)
{
  return vector(xz.data());
}

// Reads a model message as a robot's file would have said it; its complaints are FileErrors, as a file's are.
class ModelReader
{
public:
  explicit ModelReader(const model_info_t& model) : model_(model) {}

  Robot robot() const
  {
    RobotDescription description;
    description.file = "model_info_t";
    description.name = name(model_.name, "the robot's name");
    description.gravity = model_.gravity;
    if (!model_.base_names[0].empty())
      for (const std::size_t i : {0U, 1U})
        description.base_names[i] = name(model_.base_names[i], "a base coordinate");
    for (std::size_t i = 0; i < model_.link_names.size(); ++i)
      description.links.push_back(link(i));
    add_drawing(description);
    for (std::size_t i = 0; i < model_.joint_names.size(); ++i)
      description.actuators.push_back(actuator(i));
    add_feet(description);

    Robot robot = assemble(description);
    check_coordinates(robot);
    for (int i = 0; i < robot.num_coordinates(); ++i)
      robot.b(i) = model_.b[static_cast<std::size_t>(i)];
    for (int i = 0; i < robot.num_joints(); ++i)
      if (const Link* child = child_of_joint(robot.links, robot.actuators[static_cast<std::size_t>(i)]);
          child && child->type().bar)
        robot.kappa(i) = robot.actuators[static_cast<std::size_t>(i)].kappa = std::numeric_limits<double>::quiet_NaN();
    robot.model_id = model_.model_id;
    return robot;
  }

private:
  [[noreturn]] static void fail(const std::string& what) { throw FileError(what); }

  static std::string name(const std::string& text, std::string_view whose)
  {
    if (!is_name(text))
      fail(fmt::format("{} is \"{}\"", whose, printable(text)));
    return text;
  }

  template <typename Index> static std::size_t index(Index i, std::size_t size, std::string_view what)
  {
    if (i < 0 || static_cast<std::size_t>(i) >= size)
      fail(fmt::format("{} is number {} of {}", what, i, size));
    return static_cast<std::size_t>(i);
  }

  RobotDescription::LinkEntry link(std::size_t i) const
  {
    RobotDescription::LinkEntry entry{{}, {}, {}, static_cast<int>(i) + 1};
    Link& link = entry.link;
    link.name = name(model_.link_names[i], "a link's name");
    link.joint = static_cast<JointKind>(index(model_.joint_kinds[i], kJointTypes.size(), "a link's joint kind"));
    const std::int32_t parent = model_.parents[i];
    if (parent >= 0)
      entry.parent = model_.link_names[index(parent, model_.link_names.size(), "a link's parent")];
    else if (link.type().carrier == JointType::Carrier::parent_or_world)
      entry.parent = kWorld;
    link.at = vector(model_.joint_positions[i]);
    link.angle = model_.joint_angles[i];
    link.parent_radius = model_.parent_radii[i];
    link.child_radius = model_.child_radii[i];
    if (const std::int32_t coordinate = model_.link_coordinates[i]; coordinate >= 0)
      entry.coordinate =
          name(model_.absolute_names[index(coordinate, model_.absolute_names.size(), "a link's coordinate")],
               "a coordinate");
    if (parent < 0)
      link.mass = model_.total_mass;
    return entry;
  }

  void add_drawing(RobotDescription& description) const
  {
    for (std::size_t i = 0; i < model_.segment_links.size(); ++i)
      description.links[index(model_.segment_links[i], description.links.size(), "a segment's link")]
          .link.drawing.push_back(
              {vector(model_.segment_from[i]), vector(model_.segment_to[i]), model_.segment_widths[i]});
  }

  // Which links the rows of A say that it turns: +1 is the angle of `on`, −1 that of `against`; on a slide, whose
  // coordinate is a displacement, +1 alone.
  RobotDescription::ActuatorEntry actuator(std::size_t i) const
  {
    RobotDescription::ActuatorEntry entry{{}, {}, std::string(kWorld), {}, 0.0, 1};
    entry.actuator.name = name(model_.joint_names[i], "a joint's name");
    entry.actuator.torque_limit = model_.torque_limits[i];
    entry.actuator.rate_limit = model_.rate_limits[i];
    entry.coordinate = name(model_.relative_names[index(i, model_.relative_names.size(), "a joint")], "a coordinate");
    for (std::size_t k = 0; k < model_.link_names.size(); ++k)
    {
      const std::int32_t coordinate = model_.link_coordinates[k];
      const double share = coordinate < 0 ? 0.0 : model_.A[i][static_cast<std::size_t>(coordinate)];
      if (share > 0.0)
      {
        entry.on = model_.link_names[k];
        if (type_of(static_cast<JointKind>(model_.joint_kinds[k])).slides() && model_.parents[k] >= 0)
          entry.against = model_.link_names[static_cast<std::size_t>(model_.parents[k])];
      }
      else if (share < 0.0)
        entry.against = model_.link_names[k];
    }
    return entry;
  }

  void add_feet(RobotDescription& description) const
  {
    for (std::size_t i = 0; i < model_.foot_sides.size(); ++i)
    {
      RobotDescription::FootEntry entry{{}, {}, 1};
      entry.foot.side = kSides[index(model_.foot_sides[i], kSides.size(), "a foot's side")];
      entry.link = model_.link_names[index(model_.foot_links[i], model_.link_names.size(), "a foot's link")];
      entry.foot.ankle_at = vector(model_.foot_ankles[i]);
      entry.foot.heel_at = vector(model_.foot_heels[i]);
      entry.foot.toe_at = vector(model_.foot_toes[i]);
      entry.foot.friction = model_.foot_friction[i];
      description.feet.push_back(entry);
    }
  }

  void check_coordinates(const Robot& robot) const
  {
    const std::string otherwise = "its coordinates do not follow from its links and joints";
    if (robot.absolute_names != model_.absolute_names || robot.relative_names != model_.relative_names)
      fail(otherwise);
    for (int i = 0; i < robot.num_coordinates(); ++i)
      for (int k = 0; k < robot.num_coordinates(); ++k)
        if (robot.A(i, k) != model_.A[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)])
          fail(otherwise);
  }

  const model_info_t& model_;
};

} // namespace

Robot robot_of_model(const model_info_t& model, const std::string& where)
try
{
  return ModelReader(model).robot();
}
catch (const FileError& error)
{
  throw Failure(ExitCode::bad_data, "{}: its model message (model_id {}) describes no robot: {}", where, model.model_id,
                error.what());
}

} // namespace torqued
