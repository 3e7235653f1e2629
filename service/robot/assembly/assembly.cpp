#include "robot/assembly.h"

#include "robot/assembly/steps.h"
#include "robot/files/urdf_unread.h"

#include <set>

namespace torqued
{

namespace
{

// A name, and where it stands.
struct Name
{
  std::string name, file;
  int line;
};

void check_distinct(const RobotDescription& description, const std::vector<Name>& names, std::string_view what,
                    const std::array<std::string, 2>& base_names)
{
  std::set<std::string> seen;
  for (const std::string& name : base_names)
    if (!name.empty() && !seen.insert(name).second)
      fail(description, 1, fmt::format("both base coordinates are called \"{}\"; names must differ", name));
  for (const Name& name : names)
    if (!seen.insert(name.name).second)
      fail(description, name, fmt::format("two {} are called \"{}\"; names must differ", what, name.name));
}

void check_names(const Robot& robot, const RobotDescription& description,
                 const std::vector<RobotDescription::ActuatorEntry>& actuators)
{
  std::vector<Name> joints, absolute, relative;
  for (const auto& entry : actuators)
  {
    joints.push_back({entry.actuator.name, entry.file, entry.line});
    relative.push_back({entry.coordinate, entry.file, entry.line});
  }
  for (std::size_t i = 0; i < robot.links.size(); ++i)
    if (robot.links[i].coordinate >= 0 && robot.links[i].coordinate < robot.num_coordinates())
      absolute.push_back({description.links[i].coordinate, description.links[i].file, description.links[i].line});
  if (const auto& root = description.links[static_cast<std::size_t>(robot.root())]; !robot.fixed_root())
    relative.push_back({root.coordinate, root.file, root.line});
  check_distinct(description, joints, "actuators", {});
  check_distinct(description, absolute, "absolute coordinates", robot.base_names);
  check_distinct(description, relative, "relative coordinates", robot.base_names);
}

// Numbers that are fine one by one can still be useless together.
void check_magnitudes(const Robot& robot, const RobotDescription& description)
{
  constexpr double least = 1e-9;
  constexpr double most = 1e9;
  const auto useful = [](double x)
  {
    return x >= least && x <= most;
  };
  const double inertia = robot.mechanism.inertia().cwiseAbs().maxCoeff();
  if (!useful(robot.weight()) || !useful(robot.leg_length) || !(inertia <= most))
    fail(description, 1,
         fmt::format("the robot weighs {:.3g} N, its legs are {:.3g} m long and its largest inertia is {:.3g} kg m^2; "
                     "each must lie between {:g} and {:g} to be computed with",
                     robot.weight(), robot.leg_length, inertia, least, most));
}

} // namespace

Robot assemble(const RobotDescription& description)
{
  Robot robot = assemble_links(description);
  const std::vector<RobotDescription::ActuatorEntry> actuators = actuator_entries(robot, description);
  add_actuators(robot, description, actuators);
  add_feet(robot, description);
  check_names(robot, description, actuators);
  check_magnitudes(robot, description);
  fold_motors(robot);
  robot.model_id = model_id_of(robot);
  robot.notes = description.notes;
  for (const RobotDescription::UnreadEntry& entry : description.unread)
    robot.notes.push_back(note_of(entry));
  if (const std::string note = note_of_signs(description); !note.empty())
    robot.notes.push_back(note);
  return robot;
}

} // namespace torqued
