#include "robot/assembly/steps.h"

#include "planar/kinematics.h"

#include <algorithm>

namespace torqued
{

namespace
{

void check_sole(const RobotDescription& description, const RobotDescription::FootEntry& entry)
{
  const Foot& foot = entry.foot;
  if (foot.has_extent() && (foot.heel_at.y() != foot.toe_at.y() || !(foot.heel_at.x() < foot.toe_at.x())))
    fail(description, entry,
         fmt::format("{} foot: heel is at ({}, {}) and toe at ({}, {}); the toe must lie before the heel and as high "
                     "as it, so that the sole is level when the foot's angle is 0",
                     name_of(foot.side), foot.heel_at.x(), foot.heel_at.y(), foot.toe_at.x(), foot.toe_at.y()));
}

void place(const Link& link, Foot& foot)
{
  foot.ankle = point_of(link, foot.ankle_at);
  foot.heel = point_of(link, foot.heel_at);
  foot.toe = point_of(link, foot.toe_at);
  foot.direction = link.direction;
  foot.to_heel = rotate(link.heading, foot.heel_at - foot.ankle_at);
  foot.to_toe = rotate(link.heading, foot.toe_at - foot.ankle_at);
}

// Whether the feet that there are make a biped.
void check_feet(const Robot& robot, const RobotDescription& description)
{
  const Foot& left = robot.foot(Side::left);
  const Foot& right = robot.foot(Side::right);
  if (left.exists() && left.link == right.link)
    fail(description, description.feet.back().line,
         fmt::format("both feet are on link '{}'; each needs a link of its own", robot.link(left.link).name));
  if (robot.fixed_root() && !robot.is_root(left) && !robot.is_root(right))
    fail(description, description.links[static_cast<std::size_t>(robot.root())],
         fmt::format("link '{}' is fixed to the world, but is no [[foot]]: a fixed root stands for a foot, and its "
                     "[[foot]] says which",
                     robot.link(robot.root()).name));
  if (!robot.fixed_root() && !description.feet.empty())
    for (const Side side : kSides)
      if (!robot.foot(side).exists())
        fail(description, 1,
             fmt::format("there is no [[foot]] with side = \"{}\"; a biped has one on each side", name_of(side)));
}

double leg_length(const Robot& robot)
{
  double length = 0.0;
  if (robot.fixed_root() || !robot.foot(Side::left).exists())
  {
    for (const Link& link : robot.links)
    {
      double way = link.com.norm();
      for (const Arm& arm : link.origin)
        way += arm.r.norm();
      length = std::max(length, way);
    }
    return length > 0.0 ? length : 1.0;
  }
  const VectorQ straight = VectorQ::Zero(robot.mechanism.num_q());
  const Kinematics pose = kinematics(robot.mechanism, straight, straight);
  for (const Foot& foot : robot.feet)
    length = std::max(length, from_base(pose, foot.ankle).norm());
  return length;
}

// The links from one to the root.
std::vector<int> way_to_root(const Robot& robot, int link)
{
  std::vector<int> way;
  for (int i = link; i >= 0; i = robot.link(i).parent)
    way.push_back(i);
  return way;
}

void find_legs(Robot& robot)
{
  robot.leg.resize(robot.links.size());
  if (!robot.foot(Side::left).exists() || !robot.foot(Side::right).exists())
    return;
  // both ways to the root without what they share, but for the link where they meet
  std::vector<int> way = way_to_root(robot, robot.foot(Side::left).link);
  std::vector<int> back = way_to_root(robot, robot.foot(Side::right).link);
  int meeting = robot.root();
  while (!way.empty() && !back.empty() && way.back() == back.back())
  {
    meeting = way.back();
    way.pop_back();
    back.pop_back();
  }
  way.push_back(meeting);
  way.insert(way.end(), back.rbegin(), back.rend());
  robot.trunk = way[way.size() / 2];

  // without the trunk the links fall into parts; each goes by its link nearest to the trunk, or by the root
  const auto part = [&](int link)
  {
    int name = link;
    for (const int i : way_to_root(robot, link))
    {
      if (i == robot.trunk)
        return name;
      name = i;
    }
    return robot.root();
  };
  for (int i = 0; i < static_cast<int>(robot.links.size()); ++i)
    for (const Side side : kSides)
      if (const int foot = robot.foot(side).link; i != robot.trunk && foot != robot.trunk && part(i) == part(foot))
        robot.leg[static_cast<std::size_t>(i)] = side;
}

} // namespace

void add_feet(Robot& robot, const RobotDescription& description)
{
  for (const auto& entry : description.feet)
  {
    Foot& foot = robot.feet[entry.foot.side];
    const std::string role = fmt::format("{} foot", name_of(entry.foot.side));
    if (foot.exists())
      fail(description, entry, fmt::format("there is a second {}; a biped has one on each side", role));
    foot = entry.foot;
    foot.link = link_index(description, entry.link, entry, role + ": link");
    place(robot.link(foot.link), foot);
    check_sole(description, entry);
  }
  check_feet(robot, description);
  robot.leg_length = leg_length(robot);
  find_legs(robot);
}

} // namespace torqued
