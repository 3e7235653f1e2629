#include "page/drawing.h"

#include <algorithm>

namespace torqued
{

namespace
{

Json pair(const Eigen::Vector2d& point)
{
  return {point.x(), point.y()};
}

// The strokes that draw a link: its own; of a robot without any, as URDFs are, from its joint to the next ones, along
// its foot, or else to twice its centre of mass.
std::vector<Segment> strokes(const Robot& robot, int index)
{
  if (std::ranges::any_of(robot.links, [](const Link& link) { return !link.drawing.empty(); }))
    return robot.link(index).drawing;
  const double width = 0.03 * robot.leg_length;
  std::vector<Segment> found;
  const auto add = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to)
  {
    if (!from.isApprox(to))
      found.push_back({from, to, width});
  };
  for (const Link& link : robot.links)
    if (link.parent == index)
      add(Eigen::Vector2d::Zero(), link.at);
  for (const Foot& foot : robot.feet)
    if (foot.link == index)
    {
      add(Eigen::Vector2d::Zero(), foot.ankle_at);
      add(foot.heel_at, foot.toe_at);
    }
  if (found.empty())
    add(Eigen::Vector2d::Zero(), 2.0 * robot.link(index).com);
  return found;
}

// the link whose frame begins at the joint
int child_of(const Robot& robot, const Actuator& actuator)
{
  const Link* child = child_of_joint(robot.links, actuator);
  return child ? static_cast<int>(child - robot.links.data()) : actuator.on;
}

} // namespace

Json drawing_of(const Robot& robot)
{
  Json links = Json::array();
  for (const Link& link : robot.links)
  {
    Json segments = Json::array();
    for (const Segment& segment : strokes(robot, static_cast<int>(&link - robot.links.data())))
      segments.push_back({segment.from.x(), segment.from.y(), segment.to.x(), segment.to.y(), segment.width});
    const std::optional<Side>& leg = robot.leg[static_cast<std::size_t>(&link - robot.links.data())];
    links.push_back({{"name", link.name},
                     {"parent", link.parent},
                     {"at", pair(link.at)},
                     {"rolling", link.type().bar},
                     {"parent_radius", link.parent_radius},
                     {"radius", link.child_radius},
                     {"side", leg ? Json(name_of(*leg)) : Json()},
                     {"segments", std::move(segments)}});
  }
  Json joints = Json::array();
  for (const Actuator& actuator : robot.actuators)
    joints.push_back({{"name", actuator.name}, {"child", child_of(robot, actuator)}});
  Json feet = Json::array();
  for (const Foot& foot : robot.feet)
    if (foot.exists())
      feet.push_back({{"side", name_of(foot.side)},
                      {"link", foot.link},
                      {"ankle", pair(foot.ankle_at)},
                      {"heel", pair(foot.heel_at)},
                      {"toe", pair(foot.toe_at)},
                      {"friction", foot.friction}});
  return {{"name", robot.name},        {"weight", robot.weight()},    {"leg_length", robot.leg_length},
          {"links", std::move(links)}, {"joints", std::move(joints)}, {"feet", std::move(feet)}};
}

} // namespace torqued
