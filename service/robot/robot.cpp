#include "robot/robot.h"

#include "planar/kinematics.h"
#include "robot/fnv.h"
#include "robot/strict_toml.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <set>

namespace torqued
{

namespace
{

Eigen::Vector2d unit(double angle)
{
  return {std::cos(angle), std::sin(angle)};
}

// Turns a description into a robot step by step; each step may complain about a line of the file.
class Assembly
{
public:
  explicit Assembly(const RobotDescription& description) : description_(description) {}

  Robot robot()
  {
    resolve_links();
    number_coordinates();
    place_links();
    Robot robot{description_.name,
                description_.source,
                links_,
                {},
                {},
                absolute_names_,
                {},
                description_.base_names,
                mechanism(),
                {},
                {},
                {},
                0.0,
                0};
    add_actuators(robot);
    add_feet(robot);
    check_names(robot);
    check_magnitudes(robot);
    robot.model_id = model_id(robot);
    return robot;
  }

private:
  [[noreturn]] void fail(int line, const std::string& message) const
  {
    throw FileError(fmt::format("{}:{}: {}", description_.file, line, message));
  }

  int link_index(const std::string& name, int line, std::string_view role) const
  {
    const auto found = index_.find(name);
    if (found == index_.end())
      fail(line, fmt::format("{} \"{}\" is not the name of a link", role, name));
    return found->second;
  }

  void resolve_links()
  {
    if (description_.links.empty())
      fail(1, "there is no [[link]]; a robot needs at least its root");
    if (description_.links.size() > kMaxDirections)
      fail(description_.links[kMaxDirections].line,
           fmt::format("there are {} links; at most {} are possible", description_.links.size(), kMaxDirections));
    for (const auto& entry : description_.links)
    {
      if (!index_.emplace(entry.link.name, static_cast<int>(links_.size())).second)
        fail(entry.line, fmt::format("two links are called \"{}\"; names must differ", entry.link.name));
      links_.push_back(entry.link);
    }
    for (std::size_t i = 0; i < links_.size(); ++i)
    {
      const auto& entry = description_.links[i];
      if (links_[i].joint != JointKind::floating)
        links_[i].parent = link_index(entry.parent, entry.line, fmt::format("link '{}': parent", links_[i].name));
      else if (root_ >= 0)
        fail(entry.line, fmt::format("links '{}' and '{}' both float; one root carries all others",
                                     links_[static_cast<std::size_t>(root_)].name, links_[i].name));
      else
        root_ = static_cast<int>(i);
    }
    if (root_ < 0)
      fail(description_.links.front().line, "no link has joint = \"floating\"; the root must float");
    order_from_root();
  }

  // parents before children, whatever the file's order
  void order_from_root()
  {
    order_ = {root_};
    for (std::size_t done = 0; done < order_.size(); ++done)
      for (std::size_t i = 0; i < links_.size(); ++i)
        if (links_[i].parent == order_[done])
          order_.push_back(static_cast<int>(i));
    for (std::size_t i = 0; i < links_.size(); ++i)
      if (std::find(order_.begin(), order_.end(), static_cast<int>(i)) == order_.end())
        fail(description_.links[i].line,
             fmt::format("link '{}' does not hang on the root: its parents form a circle", links_[i].name));
  }

  void number_coordinates()
  {
    for (std::size_t i = 0; i < links_.size(); ++i)
    {
      if (links_[i].joint == JointKind::fixed)
        continue;
      links_[i].coordinate = static_cast<int>(absolute_names_.size());
      absolute_names_.push_back(description_.links[i].coordinate);
      if (absolute_names_.size() + 2 > kMaxCoordinates)
        fail(description_.links[i].line, fmt::format("link '{}' is one angle too many; at most {} links may turn",
                                                     links_[i].name, kMaxCoordinates - 2));
    }
  }

  // Each link's direction and origin. A direction is the angle of a link that turns; a fixed link shares its parent's.
  void place_links()
  {
    for (const int i : order_)
    {
      Link& link = links_[static_cast<std::size_t>(i)];
      if (link.parent < 0)
      {
        link.direction = link.coordinate;
        continue;
      }
      const Link& parent = links_[static_cast<std::size_t>(link.parent)];
      link.origin = point_of(parent, link.at);
      link.direction = link.joint == JointKind::fixed ? parent.direction : link.coordinate;
      link.direction_angle = link.joint == JointKind::fixed ? parent.direction_angle + link.angle : 0.0;
    }
  }

  static Point point_of(const Link& link, const Eigen::Vector2d& r)
  {
    Point point = link.origin;
    const Eigen::Vector2d turned = rotate(unit(link.direction_angle), r);
    const auto same =
        std::find_if(point.begin(), point.end(), [&](const Arm& arm) { return arm.direction == link.direction; });
    if (same != point.end())
      same->r += turned;
    else
      point.push_back({link.direction, turned});
    return point;
  }

  Mechanism mechanism() const
  {
    std::vector<Body> bodies;
    double mass = 0.0;
    for (const Link& link : links_)
    {
      bodies.push_back({link.mass, link.inertia, link.direction, point_of(link, link.com)});
      mass += link.mass;
    }
    if (!(mass > 0.0))
      fail(description_.links.front().line, "all links are massless; the robot's mass must be positive");
    const auto angles = static_cast<Eigen::Index>(absolute_names_.size());
    return Mechanism(Eigen::MatrixXd::Identity(angles, angles), Eigen::VectorXd::Zero(angles), bodies,
                     description_.gravity);
  }

  // q_relative = A q_absolute + b
  void add_actuators(Robot& robot) const
  {
    std::vector<RobotDescription::ActuatorEntry> entries = description_.actuators;
    if (entries.empty())
      for (std::size_t i = 0; i < links_.size(); ++i)
        if (links_[i].joint == JointKind::revolute)
          entries.push_back({links_[i].name, links_[i].name, links_[static_cast<std::size_t>(links_[i].parent)].name,
                             links_[i].name, 0.0, INFINITY, INFINITY, description_.links[i].line});

    const int angles = robot.num_angles();
    const int last_line = entries.empty() ? description_.links.front().line : entries.back().line;
    if (static_cast<int>(entries.size()) != angles - 1)
      fail(last_line, fmt::format("there are {} actuators for {} links that turn; a floating robot needs one less than "
                                  "links that turn, that is {}",
                                  entries.size(), angles, angles - 1));
    robot.A = MatrixQ::Zero(angles, angles);
    robot.b = VectorQ::Zero(angles);
    for (const auto& entry : entries)
    {
      const int row = robot.num_joints();
      const std::string role = fmt::format("actuator '{}'", entry.name);
      const int on = link_index(entry.on, entry.line, role + ": on");
      const int against = link_index(entry.against, entry.line, role + ": against");
      const Link& turned = links_[static_cast<std::size_t>(on)];
      const Link& pushed = links_[static_cast<std::size_t>(against)];
      if (turned.direction == pushed.direction)
        fail(entry.line,
             fmt::format("{}: links '{}' and '{}' do not turn against each other", role, entry.on, entry.against));
      robot.A(row, turned.direction) += 1.0;
      robot.A(row, pushed.direction) -= 1.0;
      robot.b(row) = turned.direction_angle - pushed.direction_angle + entry.offset;
      robot.relative_names.push_back(entry.coordinate);
      robot.actuators.push_back({entry.name, on, against, entry.torque_limit, entry.rate_limit});
    }
    const Link& root = links_[static_cast<std::size_t>(root_)];
    robot.A(angles - 1, root.coordinate) = 1.0;
    robot.relative_names.push_back(absolute_names_[static_cast<std::size_t>(root.coordinate)]);

    const Eigen::FullPivLU<MatrixQ> lu(robot.A);
    if (!lu.isInvertible())
      fail(last_line, "the actuators do not reach every link that turns: some push between the same links");
    robot.A_inverse = lu.inverse();
  }

  void add_feet(Robot& robot) const
  {
    std::array<bool, 2> seen{};
    for (const auto& entry : description_.feet)
    {
      const auto side = static_cast<std::size_t>(entry.foot.side);
      const std::string role = fmt::format("{} foot", name_of(entry.foot.side));
      if (seen[side])
        fail(entry.line, fmt::format("there is a second {}; a biped has one on each side", role));
      seen[side] = true;
      Foot& foot = robot.feet[side] = entry.foot;
      foot.link = link_index(entry.link, entry.line, role + ": link");
      const Link& link = links_[static_cast<std::size_t>(foot.link)];
      foot.ankle = point_of(link, foot.ankle_at);
      foot.heel = point_of(link, foot.heel_at);
      foot.toe = point_of(link, foot.toe_at);
      if (foot.has_sole() && (foot.heel_at.y() != foot.toe_at.y() || !(foot.heel_at.x() < foot.toe_at.x())))
        fail(entry.line,
             fmt::format("{}: heel is at ({}, {}) and toe at ({}, {}); the toe must lie before the heel and "
                         "as high as it, so that the sole is level when the foot's angle is 0",
                         role, foot.heel_at.x(), foot.heel_at.y(), foot.toe_at.x(), foot.toe_at.y()));
    }
    for (const Side side : kSides)
      if (!seen[static_cast<std::size_t>(side)])
        fail(1, fmt::format("there is no [[foot]] with side = \"{}\"; a biped has one on each side", name_of(side)));

    const auto& mechanism = robot.mechanism;
    const VectorQ straight = VectorQ::Zero(mechanism.num_coordinates());
    const Kinematics pose = kinematics(mechanism, straight, straight);
    robot.leg_length =
        std::max(from_base(pose, robot.feet[0].ankle).norm(), from_base(pose, robot.feet[1].ankle).norm());
  }

  void check_names(const Robot& robot) const
  {
    std::vector<std::string> joints;
    for (const Actuator& actuator : robot.actuators)
      joints.push_back(actuator.name);
    check_distinct(joints, "actuators", {});
    check_distinct(robot.absolute_names, "absolute coordinates", robot.base_names);
    check_distinct(robot.relative_names, "relative coordinates", robot.base_names);
  }

  void check_distinct(const std::vector<std::string>& names, std::string_view what,
                      const std::array<std::string, 2>& base_names) const
  {
    std::set<std::string> seen;
    for (const std::string& name : base_names)
      if (!name.empty() && !seen.insert(name).second)
        fail(1, fmt::format("both base coordinates are called \"{}\"; names must differ", name));
    for (const std::string& name : names)
      if (!seen.insert(name).second)
        fail(1, fmt::format("two {} are called \"{}\"; names must differ", what, name));
  }

  // numbers that are fine one by one can still be useless together
  void check_magnitudes(const Robot& robot) const
  {
    constexpr double least = 1e-9;
    constexpr double most = 1e9;
    const auto useful = [](double x)
    {
      return x >= least && x <= most;
    };
    const double inertia = robot.mechanism.inertia().cwiseAbs().maxCoeff();
    if (!useful(robot.weight()) || !useful(robot.leg_length) || !(inertia <= most))
      fail(1, fmt::format(
                  "the robot weighs {:.3g} N, its legs are {:.3g} m long and its largest inertia is {:.3g} kg m^2; "
                  "each must lie between {:g} and {:g} to be computed with",
                  robot.weight(), robot.leg_length, inertia, least, most));
  }

  static std::int64_t model_id(const Robot& robot)
  {
    Fnv1a hash;
    hash.add(robot.mechanism.gravity());
    hash.add(robot.base_names[0]);
    hash.add(robot.base_names[1]);
    for (const Link& link : robot.links)
    {
      hash.add(link.name);
      hash.add(link.parent);
      hash.add(static_cast<int>(link.joint));
      hash.add(link.at);
      hash.add(link.angle);
      hash.add(link.mass);
      hash.add(link.com);
      hash.add(link.inertia);
    }
    for (const Actuator& actuator : robot.actuators)
    {
      hash.add(actuator.name);
      hash.add(actuator.on);
      hash.add(actuator.against);
      hash.add(actuator.torque_limit);
      hash.add(actuator.rate_limit);
    }
    for (const Foot& foot : robot.feet)
    {
      hash.add(foot.link);
      hash.add(foot.ankle_at);
      hash.add(foot.heel_at);
      hash.add(foot.toe_at);
      hash.add(foot.friction);
    }
    for (int i = 0; i < robot.num_angles(); ++i)
    {
      hash.add(robot.absolute_names[static_cast<std::size_t>(i)]);
      hash.add(robot.relative_names[static_cast<std::size_t>(i)]);
      hash.add(robot.b(i));
    }
    return hash.id();
  }

  const RobotDescription& description_;
  std::vector<Link> links_;
  std::map<std::string, int> index_;
  std::vector<int> order_;
  std::vector<std::string> absolute_names_;
  int root_ = -1;
};

} // namespace

std::string_view name_of(Side side)
{
  return side == Side::left ? "left" : "right";
}

Robot assemble(const RobotDescription& description)
{
  return Assembly(description).robot();
}

Robot load_robot(const std::string& name_or_path)
{
  if (const std::string_view text = shipped_robot_toml(name_or_path); !text.empty())
    return read_toml_robot(text, name_or_path + ".toml");
  if (name_or_path.ends_with(".toml"))
    return read_toml_robot(read_text_file(name_or_path), name_or_path);
  throw FileError(fmt::format("\"{}\" is neither a robot that ships ({}) nor a .toml file", name_or_path,
                              fmt::join(shipped_robot_names(), ", ")));
}

} // namespace torqued
