#include "robot/assembly/steps.h"

#include "planar/inverse.h"

namespace torqued
{

namespace
{

double kappa_of(const Robot& robot, const Actuator& actuator, const RobotDescription& description,
                const RobotDescription::ActuatorEntry& entry)
{
  if (actuator.placement == Placement::links)
    return 1.0;
  const Link* child = child_of_joint(robot.links, actuator);
  if (!child || !child->type().bar)
    fail(description, entry,
         fmt::format("actuator '{}': between = \"{}\", but there is no rolling joint between its links", actuator.name,
                     name_of(actuator.placement)));
  const AngleShares shares = child->bar_shares();
  const double kappa = actuator.placement == Placement::bar_parent ? shares.own : shares.parent;
  if (!(kappa > 0.0))
    fail(description, entry,
         fmt::format("actuator '{}': between = \"{}\", but these two do not turn against each other, because a "
                     "radius of the joint of '{}' is 0",
                     actuator.name, name_of(actuator.placement), child->name));
  return kappa;
}

// Resolves an entry's links, and writes its row of A and b.
Actuator assemble_actuator(Robot& robot, int row, const RobotDescription& description,
                           const RobotDescription::ActuatorEntry& entry)
{
  Actuator actuator = entry.actuator;
  const std::string role = fmt::format("actuator '{}'", actuator.name);
  actuator.on = link_index(description, entry.on, entry, role + ": on");
  if (entry.against == kWorld && !robot.fixed_root())
    fail(description, entry,
         fmt::format("{}: against the world, but the root floats: a robot that nothing holds can push against its own "
                     "links only",
                     role));
  actuator.against =
      entry.against == kWorld ? robot.root() : link_index(description, entry.against, entry, role + ": against");
  const Link& on = robot.link(actuator.on);
  const Link& against = robot.link(actuator.against);
  if (is_force(robot, actuator))
    robot.A(row, on.coordinate) = 1.0;
  else
  {
    const auto& W = robot.mechanism.W();
    robot.A.row(row) = W.row(on.direction) - W.row(against.direction);
    robot.b(row) = on.direction_angle - against.direction_angle;
  }
  if (robot.A.row(row).isZero(0.0))
    fail(description, entry,
         fmt::format("{}: '{}' and '{}' do not turn against each other", role, entry.on, entry.against));
  robot.b(row) += entry.offset;
  actuator.offset = entry.offset;
  actuator.kappa = kappa_of(robot, actuator, description, entry);
  return actuator;
}

} // namespace

std::vector<RobotDescription::ActuatorEntry> actuator_entries(const Robot& robot, const RobotDescription& description)
{
  if (!description.actuators.empty())
    return description.actuators;
  std::vector<RobotDescription::ActuatorEntry> entries;
  for (std::size_t i = 0; i < robot.links.size(); ++i)
    if (const Link& link = robot.links[i]; link.parent >= 0 && link.coordinate >= 0)
    {
      Actuator actuator;
      actuator.name = link.name;
      entries.push_back({actuator, link.name, robot.link(link.parent).name, link.name, 0.0, description.links[i].line,
                         description.links[i].file});
    }
  return entries;
}

void add_actuators(Robot& robot, const RobotDescription& description,
                   const std::vector<RobotDescription::ActuatorEntry>& entries)
{
  const int size = robot.mechanism.num_theta();
  const auto fail_at_last = [&](const std::string& message)
  {
    if (entries.empty())
      fail(description, description.links.front(), message);
    fail(description, entries.back(), message);
  };
  if (static_cast<int>(entries.size()) != size - 1)
    fail_at_last(
        fmt::format("there are {} actuators; a robot needs one for each link that moves against the others, {}",
                    entries.size(), size - 1));
  robot.A = MatrixQ::Zero(size, size);
  robot.b = VectorQ::Zero(size);
  robot.kappa.resize(size - 1);
  for (const auto& entry : entries)
  {
    const int row = robot.num_joints();
    robot.actuators.push_back(assemble_actuator(robot, row, description, entry));
    robot.kappa(row) = robot.actuators.back().kappa;
    robot.relative_names.push_back(entry.coordinate);
  }
  const Link& root = robot.link(robot.root());
  robot.A(size - 1, root.coordinate) = 1.0;
  if (!robot.fixed_root())
    robot.relative_names.push_back(robot.absolute_names[static_cast<std::size_t>(root.coordinate)]);

  const std::optional<Eigen::MatrixXd> A_inverse = inverse_of(robot.A);
  if (!A_inverse)
    fail_at_last("the actuators do not reach every link that moves: some push between the same links");
  robot.A_inverse = *A_inverse;
}

void fold_motors(Robot& robot)
{
  const int n = robot.num_joints();
  const int size = robot.mechanism.num_theta();
  for (int c = 0; c < size; ++c)
    for (int joint = 0; joint < n; ++joint)
    {
      if (const double entry = robot.A(joint, c) * robot.kappa(joint); entry != 0.0)
        robot.B.push_back({c, joint, entry});
      robot.B_inverse(joint, c) = robot.A_inverse(c, joint) / robot.kappa(joint);
    }
  const Bounded<kMaxJoints, kMaxDirections> torques_of_moments =
      robot.B_inverse.topLeftCorner(n, size) * robot.mechanism.W().transpose();
  for (Foot& foot : robot.feet)
    for (int joint = 0; joint < n && foot.exists(); ++joint)
    {
      const auto share = [&](std::size_t moment, int direction)
      {
        if (const double entry = torques_of_moments(joint, direction); entry != 0.0)
          foot.torque_shares.push_back({joint, static_cast<int>(moment), entry});
      };
      for (std::size_t i = 0; i < foot.ankle.size(); ++i)
        share(i, foot.ankle[i].direction);
      share(foot.ankle.size(), foot.direction);
    }
  for (const Actuator& motor : robot.actuators)
    for (const double number :
         {motor.rotor_inertia, motor.coulomb, motor.viscous, motor.stribeck, motor.friction_offset})
      robot.joint_friction = robot.joint_friction || number != 0.0;
}

} // namespace torqued
