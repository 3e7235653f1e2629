#include "robot/robot.h"

#include "robot/fnv.h"

#include <algorithm>

namespace torqued
{

bool is_name(std::string_view text)
{
  const auto plain = [](char c)
  {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !text.empty() && text.size() <= kLongestName && std::all_of(text.begin(), text.end(), plain);
}

std::string_view name_of(Side side)
{
  return side == Side::left ? "left" : "right";
}

std::string_view name_of(Placement placement)
{
  constexpr std::string_view names[] = {"links", "bar-parent", "bar-child"};
  return names[static_cast<std::size_t>(placement)];
}

const Link* child_of_joint(const std::vector<Link>& links, const Actuator& actuator)
{
  const Link& on = links[static_cast<std::size_t>(actuator.on)];
  const Link& against = links[static_cast<std::size_t>(actuator.against)];
  return on.parent == actuator.against ? &on : against.parent == actuator.on ? &against : nullptr;
}

bool is_force(const Robot& robot, const Actuator& actuator)
{
  const Link& on = robot.link(actuator.on);
  return on.type().slides() && on.parent == actuator.against;
}

std::int64_t model_id_of(const Robot& robot)
{
  Fnv1a hash;
  const auto add = [&hash](const auto&... facts)
  {
    (hash.add(facts), ...);
  };
  add(robot.mechanism.gravity(), robot.base_names[0], robot.base_names[1]);
  for (const Link& link : robot.links)
    std::apply(add, link.facts());
  for (const Actuator& actuator : robot.actuators)
  {
    add(actuator.name, actuator.on, actuator.against, actuator.kappa);
    for (const ActuatorNumber& number : kActuatorNumbers)
      // a robot without stick_velocity has the id that it had before there was one
      if (number.value != &Actuator::stick_velocity || actuator.stick_velocity != 0.0)
        add(actuator.*number.value);
  }
  for (const Foot& foot : robot.feet)
  {
    add(foot.link);
    if (foot.exists())
      std::apply(add, foot.facts());
  }
  for (int i = 0; i < robot.num_coordinates(); ++i)
    add(robot.absolute_names[static_cast<std::size_t>(i)], robot.relative_names[static_cast<std::size_t>(i)],
        robot.b(i));
  return hash.id();
}

Body body_of(const Link& link)
{
  const Eigen::Vector2d com = rotate(link.heading, link.com);
  return {link.origin, link.direction, link.mass, link.mass * com, link.inertia + link.mass * com.squaredNorm(),
          link.slides};
}

VectorJ joint_rates(const Robot& robot, const VectorQ& theta_rates)
{
  return robot.kappa.cwiseProduct(robot.A.topRows(robot.num_joints()) * theta_rates);
}

VectorQ joint_forces(const Robot& robot, const VectorJ& torque)
{
  VectorQ force = VectorQ::Zero(robot.mechanism.num_theta());
  for (const auto& [row, joint, share] : robot.B)
    force(row) += share * torque(joint);
  return force;
}

Bounded<kMaxCoordinates, kMaxJoints> input_matrix(const Robot& robot)
{
  Bounded<kMaxCoordinates, kMaxJoints> B =
      Bounded<kMaxCoordinates, kMaxJoints>::Zero(robot.mechanism.num_q(), robot.num_joints());
  B.topRows(robot.mechanism.num_theta()) = robot.A.topRows(robot.num_joints()).transpose() * robot.kappa.asDiagonal();
  return B;
}

} // namespace torqued
