#include "robot/robot.h"

#include "planar/inverse.h"
#include "planar/kinematics.h"
#include "robot/files/strict_toml.h"
#include "robot/files/urdf_unread.h"
#include "robot/fnv.h"

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
    Robot robot{.name = description_.name,
                .source = description_.source,
                .links = links_,
                .order = order_,
                .absolute_names = absolute_names_,
                .mechanism = mechanism()};
    if (!fixed_root())
      robot.base_names = description_.base_names;
    add_actuators(robot);
    add_feet(robot);
    check_names(robot);
    check_magnitudes(robot);
    fold_motors(robot);
    robot.model_id = model_id(robot);
    robot.notes = description_.notes;
    for (const RobotDescription::UnreadEntry& entry : description_.unread)
      robot.notes.push_back(note_of(entry));
    if (const std::string note = note_of_signs(description_); !note.empty())
      robot.notes.push_back(note);
    return robot;
  }

private:
  [[noreturn]] void fail(int line, const std::string& message) const
  {
    throw FileError(fmt::format("{}:{}: {}", description_.file, line, message));
  }

  // entry: of a link, an actuator or a foot
  template <typename Entry> [[noreturn]] void fail(const Entry& entry, const std::string& message) const
  {
    if constexpr (requires { entry.file; })
      if (!entry.file.empty())
        throw FileError(fmt::format("{}:{}: {}", entry.file, entry.line, message));
    fail(entry.line, message);
  }

  template <typename Entry> int link_index(const std::string& name, const Entry& entry, std::string_view role) const
  {
    const auto found = index_.find(name);
    if (found == index_.end())
      fail(entry, fmt::format("{} \"{}\" is not the name of a link", role, name));
    return found->second;
  }

  void resolve_links()
  {
    if (description_.links.empty())
      fail(1, "there is no [[link]]; a robot needs at least its root");
    if (description_.links.size() > kMaxLinks)
      fail(description_.links[kMaxLinks],
           fmt::format("there are {} links; at most {} are possible", description_.links.size(), kMaxLinks));
    for (const auto& entry : description_.links)
    {
      if (!index_.emplace(entry.link.name, static_cast<int>(links_.size())).second)
        fail(entry, fmt::format("two links are called \"{}\"; names must differ", entry.link.name));
      links_.push_back(entry.link);
    }
    for (std::size_t i = 0; i < links_.size(); ++i)
    {
      const auto& entry = description_.links[i];
      const bool on_world = entry.parent == kWorld;
      const JointType& joint = links_[i].type();
      if (joint.carrier != JointType::Carrier::none && !on_world)
        links_[i].parent = link_index(entry.parent, entry, fmt::format("link '{}': parent", links_[i].name));
      else if (on_world && joint.carrier != JointType::Carrier::parent_or_world)
        fail(entry, fmt::format("link '{}' is {} on the world; a root that does not float is fixed there",
                                links_[i].name, joint.name));
      else if (root_ >= 0)
        fail(entry, fmt::format("links '{}' and '{}' are both roots; one root carries all others",
                                links_[static_cast<std::size_t>(root_)].name, links_[i].name));
      else
        root_ = static_cast<int>(i);
    }
    if (root_ < 0)
      fail(description_.links.front(),
           "there is no root: one link must have joint = \"floating\", or joint = \"fixed\" and parent = \"world\"");
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
        fail(description_.links[i],
             fmt::format("link '{}' does not hang on the root: its parents form a circle", links_[i].name));
  }

  // θ: the coordinates in the file's order, then the angle of a fixed root
  void number_coordinates()
  {
    for (std::size_t i = 0; i < links_.size(); ++i)
    {
      if (!links_[i].type().moves())
        continue;
      links_[i].coordinate = num_theta_++;
      absolute_names_.push_back(description_.links[i].coordinate);
      if (num_theta_ + (fixed_root() ? 1 : 0) + 2 > kMaxCoordinates)
        fail(description_.links[i], fmt::format("link '{}' is one too many that moves; at most {} are possible",
                                                links_[i].name, num_theta_ - 1));
    }
    if (fixed_root())
      links_[static_cast<std::size_t>(root_)].coordinate = num_theta_++;
  }

  // Each link's direction and origin. The first directions are the members of θ, though what slides turns nothing; bars
  // follow.
  void place_links()
  {
    W_ = Eigen::MatrixXd::Identity(num_theta_, num_theta_);
    for (const int i : order_)
    {
      Link& link = links_[static_cast<std::size_t>(i)];
      link.direction = link.coordinate;
      if (i != root_)
        place_link(link, links_[static_cast<std::size_t>(link.parent)],
                   description_.links[static_cast<std::size_t>(i)]);
      link.heading = unit(link.direction_angle);
    }
  }

  void place_link(Link& link, const Link& parent, const RobotDescription::LinkEntry& entry)
  {
    const JointType& joint = link.type();
    if (joint.angle.world != 0.0 && !fixed_root())
      fail(entry, fmt::format("link '{}' is parallel to the world, but the root floats: nothing could hold it; the "
                              "root must be fixed to the world",
                              link.name));
    link.origin = point_of(parent, link.at);
    link.slides = parent.slides;
    if (joint.slides())
      link.slides.push_back(link.coordinate);
    if (joint.bar)
      place_bar(link, parent, entry);

    // the link's angle: that of a direction that is there, or a mixture of such
    const double constant = joint.bar || joint.constant.empty() ? 0.0 : link.angle;
    if (joint.angle.own != 1.0)
    {
      const Link& root = links_[static_cast<std::size_t>(root_)];
      link.direction = joint.angle.parent == 1.0  ? parent.direction
                       : joint.angle.world == 1.0 ? root.direction
                                                  : add_direction(joint.angle, link, parent);
      link.direction_angle = joint.angle.parent * parent.direction_angle + constant;
    }
  }

  // the bar between the circles' centres, a direction of its own
  void place_bar(Link& link, const Link& parent, const RobotDescription::LinkEntry& entry)
  {
    const double length = link.parent_radius + link.child_radius;
    if (!(length > 0.0))
      fail(entry,
           fmt::format("link '{}': parent_radius and child_radius are both 0; that is a revolute joint", link.name));
    const AngleShares shares = link.bar_shares();
    const double angle = shares.parent * parent.direction_angle + link.angle;
    link.origin.push_back({add_direction(shares, link, parent), rotate(unit(angle), {0.0, -length})});
  }

  int add_direction(const AngleShares& shares, const Link& link, const Link& parent)
  {
    using Row = Eigen::RowVectorXd;
    const Row own = link.coordinate < 0 ? Row::Zero(num_theta_) : Row(W_.row(link.coordinate));
    const Row row =
        shares.of<Row>(own, W_.row(parent.direction), W_.row(links_[static_cast<std::size_t>(root_)].direction));
    W_.conservativeResize(W_.rows() + 1, Eigen::NoChange);
    W_.bottomRows<1>() = row;
    return static_cast<int>(W_.rows()) - 1;
  }

  bool fixed_root() const { return !links_[static_cast<std::size_t>(root_)].type().floats(); }

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
      bodies.push_back(body_of(link));
      mass += link.mass;
    }
    if (!(mass > 0.0))
      fail(description_.links.front(), "all links are massless; the robot's mass must be positive");
    return Mechanism(W_, bodies, description_.gravity);
  }

  // one for each joint that moves, turning the child against its parent
  std::vector<RobotDescription::ActuatorEntry> default_actuators() const
  {
    std::vector<RobotDescription::ActuatorEntry> entries;
    for (std::size_t i = 0; i < links_.size(); ++i)
      if (const Link& link = links_[i]; static_cast<int>(i) != root_ && link.coordinate >= 0)
      {
        Actuator actuator;
        actuator.name = link.name;
        entries.push_back({actuator, link.name, links_[static_cast<std::size_t>(link.parent)].name, link.name, 0.0,
                           description_.links[i].line, description_.links[i].file});
      }
    return entries;
  }

  // q_relative = A q_absolute + b
  void add_actuators(Robot& robot)
  {
    const auto entries = description_.actuators.empty() ? default_actuators() : description_.actuators;
    const auto fail_at_last = [&](const std::string& message)
    {
      if (entries.empty())
        fail(description_.links.front(), message);
      fail(entries.back(), message);
    };
    if (static_cast<int>(entries.size()) != num_theta_ - 1)
      fail_at_last(
          fmt::format("there are {} actuators; a robot needs one for each link that moves against the others, {}",
                      entries.size(), num_theta_ - 1));
    robot.A = MatrixQ::Zero(num_theta_, num_theta_);
    robot.b = VectorQ::Zero(num_theta_);
    robot.kappa.resize(num_theta_ - 1);
    for (const auto& entry : entries)
    {
      const int row = robot.num_joints();
      Actuator actuator = entry.actuator;
      const std::string role = fmt::format("actuator '{}'", actuator.name);
      actuator.on = link_index(entry.on, entry, role + ": on");
      if (entry.against == kWorld && !fixed_root())
        fail(entry, fmt::format("{}: against the world, but the root floats: a robot that nothing holds can push "
                                "against its own links only",
                                role));
      actuator.against = entry.against == kWorld ? root_ : link_index(entry.against, entry, role + ": against");
      const Link& on = links_[static_cast<std::size_t>(actuator.on)];
      const Link& against = links_[static_cast<std::size_t>(actuator.against)];
      if (on.type().slides() && on.parent == actuator.against)
        robot.A(row, on.coordinate) = 1.0;
      else
      {
        robot.A.row(row) = W_.row(on.direction) - W_.row(against.direction);
        robot.b(row) = on.direction_angle - against.direction_angle;
      }
      if (robot.A.row(row).isZero(0.0))
        fail(entry, fmt::format("{}: '{}' and '{}' do not turn against each other", role, entry.on, entry.against));
      robot.b(row) += entry.offset;
      actuator.offset = entry.offset;
      actuator.kappa = robot.kappa(row) = kappa(actuator, entry);
      robot.relative_names.push_back(entry.coordinate);
      robot.actuators.push_back(actuator);
      actuator_places_.emplace_back(entry.file, entry.line);
    }
    const Link& root = links_[static_cast<std::size_t>(root_)];
    robot.A(num_theta_ - 1, root.coordinate) = 1.0;
    if (!fixed_root())
      robot.relative_names.push_back(absolute_names_[static_cast<std::size_t>(root.coordinate)]);

    const std::optional<Eigen::MatrixXd> A_inverse = inverse_of(robot.A);
    if (!A_inverse)
      fail_at_last("the actuators do not reach every link that moves: some push between the same links");
    robot.A_inverse = *A_inverse;
  }

  // what answers need of A and κ
  static void fold_motors(Robot& robot)
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

  double kappa(const Actuator& actuator, const RobotDescription::ActuatorEntry& entry) const
  {
    if (actuator.placement == Placement::links)
      return 1.0;
    const Link* child = child_of_joint(links_, actuator);
    if (!child || !child->type().bar)
      fail(entry, fmt::format("actuator '{}': between = \"{}\", but there is no rolling joint between its links",
                              actuator.name, name_of(actuator.placement)));
    const double kappa =
        actuator.placement == Placement::bar_parent ? child->bar_shares().own : child->bar_shares().parent;
    if (!(kappa > 0.0))
      fail(entry,
           fmt::format("actuator '{}': between = \"{}\", but these two do not turn against each other, because a "
                       "radius of the joint of '{}' is 0",
                       actuator.name, name_of(actuator.placement), child->name));
    return kappa;
  }

  void add_feet(Robot& robot) const
  {
    std::array<bool, 2> seen{};
    for (const auto& entry : description_.feet)
    {
      const auto side = static_cast<std::size_t>(entry.foot.side);
      const std::string role = fmt::format("{} foot", name_of(entry.foot.side));
      if (seen[side])
        fail(entry, fmt::format("there is a second {}; a biped has one on each side", role));
      seen[side] = true;
      Foot& foot = robot.feet[side] = entry.foot;
      foot.link = link_index(entry.link, entry, role + ": link");
      const Link& link = links_[static_cast<std::size_t>(foot.link)];
      foot.ankle = point_of(link, foot.ankle_at);
      foot.heel = point_of(link, foot.heel_at);
      foot.toe = point_of(link, foot.toe_at);
      foot.direction = link.direction;
      foot.to_heel = rotate(link.heading, foot.heel_at - foot.ankle_at);
      foot.to_toe = rotate(link.heading, foot.toe_at - foot.ankle_at);
      if (foot.has_extent() && (foot.heel_at.y() != foot.toe_at.y() || !(foot.heel_at.x() < foot.toe_at.x())))
        fail(entry, fmt::format("{}: heel is at ({}, {}) and toe at ({}, {}); the toe must lie before the heel and "
                                "as high as it, so that the sole is level when the foot's angle is 0",
                                role, foot.heel_at.x(), foot.heel_at.y(), foot.toe_at.x(), foot.toe_at.y()));
    }
    if (robot.feet[0].exists() && robot.feet[0].link == robot.feet[1].link)
      fail(description_.feet.back().line, fmt::format("both feet are on link '{}'; each needs a link of its own",
                                                      robot.link(robot.feet[0].link).name));
    const auto on_root = [&](const Foot& foot)
    {
      return robot.is_root(foot);
    };
    if (fixed_root() && std::none_of(robot.feet.begin(), robot.feet.end(), on_root))
      fail(description_.links[static_cast<std::size_t>(root_)],
           fmt::format("link '{}' is fixed to the world, but is no [[foot]]: a fixed root stands for a foot, and its "
                       "[[foot]] says which",
                       links_[static_cast<std::size_t>(root_)].name));
    if (!fixed_root() && !description_.feet.empty())
      for (const Side side : kSides)
        if (!seen[static_cast<std::size_t>(side)])
          fail(1, fmt::format("there is no [[foot]] with side = \"{}\"; a biped has one on each side", name_of(side)));
    robot.leg_length = leg_length(robot);
    find_legs(robot);
  }

  // the links from one to the root
  std::vector<int> way_to_root(int link) const
  {
    std::vector<int> way;
    for (int i = link; i >= 0; i = links_[static_cast<std::size_t>(i)].parent)
      way.push_back(i);
    return way;
  }

  void find_legs(Robot& robot) const
  {
    robot.leg.resize(links_.size());
    if (!robot.feet[0].exists() || !robot.feet[1].exists())
      return;
    // both ways to the root without what they share, but for the link where they meet
    std::vector<int> way = way_to_root(robot.feet[0].link);
    std::vector<int> back = way_to_root(robot.feet[1].link);
    int meeting = root_;
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
      for (const int i : way_to_root(link))
      {
        if (i == robot.trunk)
          return name;
        name = i;
      }
      return root_;
    };
    for (std::size_t i = 0; i < links_.size(); ++i)
      for (const Side side : kSides)
        if (const int foot = robot.foot(side).link;
            static_cast<int>(i) != robot.trunk && foot != robot.trunk && part(static_cast<int>(i)) == part(foot))
          robot.leg[i] = side;
  }

  double leg_length(const Robot& robot) const
  {
    double length = 0.0;
    if (fixed_root() || description_.feet.empty())
    {
      for (const Link& link : links_)
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

  void check_names(const Robot& robot) const
  {
    Names joints, absolute, relative;
    for (std::size_t i = 0; i < robot.actuators.size(); ++i)
    {
      const auto& [file, line] = actuator_places_[i];
      joints.push_back({robot.actuators[i].name, file, line});
      relative.push_back({robot.relative_names[i], file, line});
    }
    for (std::size_t i = 0; i < links_.size(); ++i)
      if (links_[i].coordinate >= 0 && links_[i].coordinate < robot.num_coordinates())
        absolute.push_back({description_.links[i].coordinate, description_.links[i].file, description_.links[i].line});
    if (const auto& root = description_.links[static_cast<std::size_t>(root_)]; !fixed_root())
      relative.push_back({root.coordinate, root.file, root.line});
    check_distinct(joints, "actuators", {});
    check_distinct(absolute, "absolute coordinates", robot.base_names);
    check_distinct(relative, "relative coordinates", robot.base_names);
  }

  // a name, and where it stands
  struct Name
  {
    std::string name, file;
    int line;
  };
  using Names = std::vector<Name>;

  void check_distinct(const Names& names, std::string_view what, const std::array<std::string, 2>& base_names) const
  {
    std::set<std::string> seen;
    for (const std::string& name : base_names)
      if (!name.empty() && !seen.insert(name).second)
        fail(1, fmt::format("both base coordinates are called \"{}\"; names must differ", name));
    for (const Name& name : names)
      if (!seen.insert(name.name).second)
        fail(name, fmt::format("two {} are called \"{}\"; names must differ", what, name.name));
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
      hash.add(link.parent_radius);
      hash.add(link.child_radius);
      hash.add(link.mass);
      hash.add(link.com);
      hash.add(link.inertia);
    }
    for (const Actuator& actuator : robot.actuators)
    {
      hash.add(actuator.name);
      hash.add(actuator.on);
      hash.add(actuator.against);
      for (const double number :
           {actuator.kappa, actuator.torque_limit, actuator.rate_limit, actuator.rotor_inertia, actuator.coulomb,
            actuator.viscous, actuator.stribeck, actuator.stribeck_velocity, actuator.friction_offset})
        hash.add(number);
      if (actuator.stick_velocity != 0.0) // a robot without it keeps the id that it had before there was one
        hash.add(actuator.stick_velocity);
    }
    for (const Foot& foot : robot.feet)
    {
      hash.add(foot.link);
      if (!foot.exists())
        continue;
      hash.add(foot.ankle_at);
      hash.add(foot.heel_at);
      hash.add(foot.toe_at);
      hash.add(foot.friction);
      hash.add(foot.f_min);
    }
    for (int i = 0; i < robot.num_coordinates(); ++i)
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
  std::vector<std::pair<std::string, int>> actuator_places_; // file and line
  Eigen::MatrixXd W_;
  int root_ = -1, num_theta_ = 0;
};

} // namespace

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
  if (name_or_path.ends_with(".urdf"))
    return read_urdf_robot(read_text_file(name_or_path), name_or_path);
  throw FileError(fmt::format("\"{}\" is neither a robot that ships ({}) nor a .toml or .urdf file", name_or_path,
                              fmt::join(shipped_robot_names(), ", ")));
}

} // namespace torqued
