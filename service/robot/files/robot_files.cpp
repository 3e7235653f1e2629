#include "robot/files/robot_files.h"

#include "robot/description.h"
#include "robot/files/text_file.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <set>

namespace torqued
{

namespace
{

Eigen::Vector2d turned(double angle, const Eigen::Vector2d& r)
{
  return angle == 0.0 ? r : rotate({std::cos(angle), std::sin(angle)}, r);
}

// Numbers are written so that they read back as the same numbers.
template <typename... Args> void add(std::string& text, fmt::format_string<Args...> format, Args&&... args)
{
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
}

// A text as TOML, over several lines if it has them.
std::string quoted(const std::string& text)
{
  const bool lines = text.find('\n') != std::string::npos;
  std::string toml = lines ? "\"\"\"\n" : "\"";
  for (const char& c : text)
  {
    // one quotation mark stands as it is between lines; what could end the text does not
    const bool ends = c == '"' && (!lines || toml.back() == '"' || &c == &text.back());
    if (ends || c == '\\')
      toml += {'\\', c};
    else if ((c >= ' ' && c != '\x7f') || c < '\0' || (c == '\n' && lines))
      toml += c;
    else
      toml += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
  }
  return toml + (lines ? "\"\"\"" : "\"");
}

std::string vector(const Eigen::Vector2d& r)
{
  return fmt::format("[{}, {}]", r.x(), r.y());
}

// A link's frame in the file: as the robot has it, or aligned with the world's when all angles are 0.
enum class Frames
{
  own,
  aligned
};

double angle_in(Frames frames, const Link& link)
{
  return frames == Frames::aligned ? link.direction_angle : 0.0;
}

void add_head(std::string& toml, const Robot& robot)
{
  add(toml, "name = \"{}\"\n", robot.name);
  if (!robot.source.empty())
    add(toml, "source = {}\n", quoted(robot.source));
  add(toml, "gravity = {}\n", robot.mechanism.gravity());
}

// what a link's entry says besides geometry
struct LinkWords
{
  std::string base, coordinate, drawing;
  bool empty() const { return base.empty() && coordinate.empty() && drawing.empty(); }
};

LinkWords words_of(const Robot& robot, const Link& link, Frames frames)
{
  LinkWords words;
  const std::array<std::string, 2> default_base = RobotDescription().base_names;
  if (link.type().floats() && robot.base_names != default_base)
    words.base = fmt::format("base = [\"{}\", \"{}\"]\n", robot.base_names[0], robot.base_names[1]);
  if (link.coordinate >= 0 && link.coordinate < robot.num_coordinates())
    if (const std::string& name = robot.absolute_names[static_cast<std::size_t>(link.coordinate)]; name != link.name)
      words.coordinate = fmt::format("coordinate = \"{}\"\n", name);
  for (const Segment& segment : link.drawing)
  {
    const double angle = angle_in(frames, link);
    words.drawing += words.drawing.empty() ? "draw = [" : ", ";
    words.drawing +=
        fmt::format("{{ from = {}, to = {}", vector(turned(angle, segment.from)), vector(turned(angle, segment.to)));
    words.drawing += segment.width == 0.02 ? std::string(" }") : fmt::format(", width = {} }}", segment.width);
  }
  words.drawing += words.drawing.empty() ? "" : "]\n";
  return words;
}

void add_actuators(std::string& toml, const Robot& robot, Frames frames)
{
  const auto add_unless = [&toml](std::string_view key, double value, double fallback)
  {
    if (value != fallback)
      add(toml, "{} = {}\n", key, value);
  };
  for (int i = 0; i < robot.num_joints(); ++i)
  {
    const Actuator& actuator = robot.actuators[static_cast<std::size_t>(i)];
    add(toml, "\n[[actuator]]\nname = \"{}\"\non = \"{}\"\nagainst = \"{}\"\n", actuator.name,
        robot.link(actuator.on).name, robot.link(actuator.against).name);
    if (const std::string& name = robot.relative_names[static_cast<std::size_t>(i)]; name != actuator.name)
      add(toml, "coordinate = \"{}\"\n", name);
    add_unless("offset", frames == Frames::aligned ? robot.b(i) : actuator.offset, 0.0);
    if (actuator.placement != Placement::links)
      add(toml, "between = \"{}\"\n", name_of(actuator.placement));
    for (const auto& [key, value, range] : kActuatorNumbers)
      add_unless(key, actuator.*value, Actuator().*value);
  }
}

void add_feet(std::string& toml, const Robot& robot, Frames frames)
{
  for (const Side side : kSides)
  {
    const Foot& foot = robot.foot(side);
    if (!foot.exists())
      continue;
    const Link& link = robot.link(foot.link);
    const double angle = angle_in(frames, link);
    if (angle != 0.0 && foot.has_extent())
      throw FileError(fmt::format("link '{}' rides on '{}' at an angle and has a sole; in a URDF's frames that sole is "
                                  "not level, and this robot has no URDF",
                                  link.name, robot.link(link.parent).name));
    add(toml, "\n[[foot]]\nside = \"{}\"\nlink = \"{}\"\n", name_of(side), link.name);
    if (!foot.ankle_at.isZero(0.0))
      add(toml, "ankle = {}\n", vector(turned(angle, foot.ankle_at)));
    if (foot.heel_at != foot.ankle_at || foot.has_extent())
      add(toml, "heel = {}\ntoe = {}\n", vector(turned(angle, foot.heel_at)), vector(turned(angle, foot.toe_at)));
    add(toml, "friction = {}\n", foot.friction);
    if (foot.f_min != 0.0)
      add(toml, "f_min = {}\n", foot.f_min);
  }
}

// Writes a URDF link by link, in the robot's order, so that the coordinates keep theirs.
class UrdfWriter
{
public:
  explicit UrdfWriter(const Robot& robot) : robot_(robot)
  {
    for (const Link& link : robot.links)
      link_names_.insert(link.name);
  }

  std::string text()
  {
    add(urdf_,
        "<?xml version=\"1.0\"?>\n"
        "<!-- The links and joints of {0}. A URDF cannot say all of a robot: its feet, what its actuators act "
        "between,\n"
        "     limits, rotors, friction, gravity and the names of coordinates stand in a TOML file that names this "
        "one;\n"
        "     torquectl model prints that file, too (its help says how). The robot moves in the x-z plane: of its\n"
        "     inertias only the moments about y, iyy, are its own. -->\n"
        "<robot name=\"{0}\">\n",
        robot_.name);
    const Link& root = robot_.link(robot_.root());
    if (robot_.fixed_root())
      add_massless(std::string(kWorld));
    for (const Link& link : robot_.links)
      add_link(link);
    if (robot_.fixed_root())
      add_joint(fresh(joint_names_, root.name), "fixed", std::string(kWorld), root.name, {0.0, 0.0});
    for (const Link& link : robot_.links)
      if (link.parent >= 0)
        add_joint_of(link);
    add(urdf_, "</robot>\n");
    return urdf_;
  }

private:
  void add_massless(const std::string& name) { add(urdf_, "  <link name=\"{}\"/>\n", name); }

  void add_link(const Link& link)
  {
    if (link.mass == 0.0 && link.inertia == 0.0)
      return add_massless(link.name);
    const Eigen::Vector2d com = turned(link.direction_angle, link.com);
    add(urdf_,
        "  <link name=\"{0}\">\n"
        "    <inertial>\n"
        "      <origin xyz=\"{1} 0 {2}\"/>\n"
        "      <mass value=\"{3}\"/>\n"
        "      <inertia ixx=\"{4}\" ixy=\"0\" ixz=\"0\" iyy=\"{4}\" iyz=\"0\" izz=\"{4}\"/>\n"
        "    </inertial>\n"
        "  </link>\n",
        link.name, com.x(), com.y(), link.mass, link.inertia);
  }

  void add_joint_of(const Link& link)
  {
    const Link& parent = robot_.link(link.parent);
    const Eigen::Vector2d at = turned(parent.direction_angle, link.at);
    const std::string name = fresh(joint_names_, actuator_of(link));
    const JointType& joint = link.type();
    if (joint.urdf_type.empty())
      throw FileError(fmt::format("link '{}' is {}{}; a URDF cannot say that, and this robot has none", link.name,
                                  joint.name, joint.angle.world != 0.0 ? " to the world" : ""));
    if (joint.bar)
      add_rolling(link, parent, at, name);
    else
      add_joint(name, joint.urdf_type, parent.name, link.name, at,
                joint.slides()  ? kSlides
                : joint.moves() ? kTurns
                                : std::string());
  }

  void add_rolling(const Link& link, const Link& parent, const Eigen::Vector2d& at, const std::string& name)
  {
    if (!(link.parent_radius > 0.0) || !(link.child_radius > 0.0))
      throw FileError(fmt::format(
          "link '{}' rolls with a radius of 0; a URDF cannot say that: make it a revolute joint", link.name));
    const std::string bar = fresh(link_names_, link.name + "_bar");
    const std::string second = fresh(joint_names_, link.name + "_roll");
    const double bar_angle = link.bar_shares().parent * parent.direction_angle + link.angle;
    add_massless(bar);
    const std::string_view type = link.type().urdf_type;
    add_joint(name, type, parent.name, bar, at, kTurns);
    add_joint(second, type, bar, link.name, turned(bar_angle, {0.0, -(link.parent_radius + link.child_radius)}),
              kTurns + fmt::format("    <mimic joint=\"{}\" multiplier=\"{}\"/>\n", name,
                                   link.parent_radius / link.child_radius));
  }

  void add_joint(const std::string& name, std::string_view type, const std::string& parent, const std::string& child,
                 const Eigen::Vector2d& at, const std::string& rest = "")
  {
    add(urdf_,
        "  <joint name=\"{}\" type=\"{}\">\n"
        "    <origin xyz=\"{} 0 {}\"/>\n"
        "    <parent link=\"{}\"/>\n"
        "    <child link=\"{}\"/>\n"
        "{}"
        "  </joint>\n",
        name, type, at.x(), at.y(), parent, child, rest);
  }

  // the name of the actuator between a link and its parent, or the link's
  std::string actuator_of(const Link& link) const
  {
    for (const Actuator& actuator : robot_.actuators)
      if (child_of_joint(robot_.links, actuator) == &link)
        return actuator.name;
    return link.name;
  }

  // a name that is not taken yet, and takes it
  static std::string fresh(std::set<std::string>& taken, const std::string& wanted)
  {
    std::string name = wanted.substr(0, kLongestName);
    for (int i = 2; !taken.insert(name).second; ++i)
    {
      const std::string number = fmt::format("_{}", i);
      name = wanted.substr(0, kLongestName - number.size()) + number;
    }
    return name;
  }

  inline static const std::string kTurns = "    <axis xyz=\"0 -1 0\"/>\n";
  // a prismatic joint is not allowed without a limit; these say none
  inline static const std::string kSlides =
      "    <axis xyz=\"0 1 0\"/>\n    <limit lower=\"-1e9\" upper=\"1e9\" effort=\"1e9\" velocity=\"1e9\"/>\n";

  const Robot& robot_;
  std::string urdf_;
  std::set<std::string> link_names_, joint_names_;
};

} // namespace

std::string to_toml(const Robot& robot)
{
  std::string toml;
  add_head(toml, robot);
  for (const Link& link : robot.links)
  {
    const LinkWords words = words_of(robot, link, Frames::own);
    add(toml, "\n[[link]]\nname = \"{}\"\njoint = \"{}\"\n", link.name, link.type().name);
    if (link.parent >= 0)
      add(toml, "parent = \"{}\"\nat = {}\n", robot.link(link.parent).name, vector(link.at));
    else if (!link.type().floats())
      add(toml, "parent = \"{}\"\n", kWorld);
    if (link.angle != 0.0)
      add(toml, "angle = {}\n", link.angle);
    if (link.type().bar)
      add(toml, "parent_radius = {}\nchild_radius = {}\n", link.parent_radius, link.child_radius);
    add(toml, "{}{}mass = {}\n", words.base, words.coordinate, link.mass);
    if (!link.com.isZero(0.0))
      add(toml, "com = {}\n", vector(link.com));
    add(toml, "inertia = {}\n{}", link.inertia, words.drawing);
  }
  add_actuators(toml, robot, Frames::own);
  add_feet(toml, robot, Frames::own);
  return toml;
}

std::string to_urdf(const Robot& robot)
{
  return UrdfWriter(robot).text();
}

std::string to_companion_toml(const Robot& robot, const std::string& urdf_file)
{
  std::string toml;
  add_head(toml, robot);
  add(toml, "urdf = {}\n", quoted(urdf_file));
  for (const Link& link : robot.links)
    if (const LinkWords words = words_of(robot, link, Frames::aligned); !words.empty())
      add(toml, "\n[[link]]\nname = \"{}\"\n{}{}{}", link.name, words.base, words.coordinate, words.drawing);
  add_actuators(toml, robot, Frames::aligned);
  add_feet(toml, robot, Frames::aligned);
  return toml;
}

} // namespace torqued
