#include "robot/files/toml_robot.h"

#include "robot/assembly.h"
#include "robot/files/strict_toml.h"
#include "robot/files/urdf_robot.h"
#include "text/printable.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <set>

namespace torqued
{

namespace
{

std::string name(StrictTable& table, std::string_view key, std::optional<std::string> fallback = {})
{
  const std::string text = table.text(key, std::move(fallback));
  if (!is_name(text))
    table.fail(key, fmt::format("found \"{}\"{}; expected 1 to {} letters, digits, _ or -", printable(text),
                                text.size() > kLongestName ? fmt::format(" of {} characters", text.size()) : "",
                                kLongestName));
  return text;
}

std::array<std::string, 2> read_base(StrictTable& table, const std::array<std::string, 2>& fallback)
{
  const std::array<std::string, 2> names = table.two_texts("base", fallback);
  for (const std::string& text : names)
    if (!is_name(text))
      table.fail("base", fmt::format("found \"{}\"; expected two names of 1 to {} letters, digits, _ or -",
                                     printable(text), kLongestName));
  return names;
}

void read_drawing(StrictTable& table, Link& link)
{
  std::vector<StrictTable> segments = table.tables("draw", fmt::format("link '{}': draw", link.name));
  constexpr std::size_t most_segments = 16; // so that the robot still fits into a message
  if (segments.size() > most_segments)
    table.fail("draw", fmt::format("found {} strokes; expected at most {}", segments.size(), most_segments));
  for (StrictTable& segment : segments)
  {
    link.drawing.push_back({segment.vector("from"), segment.vector("to"), segment.magnitude("width", 0.02)});
    segment.finish();
  }
}

RobotDescription::LinkEntry read_link(StrictTable& table, std::array<std::string, 2>& base_names)
{
  RobotDescription::LinkEntry entry{{}, {}, {}, table.line()};
  Link& link = entry.link;
  link.name = name(table, "name");
  table.set_context(fmt::format("link '{}'", link.name));

  if (link.name == kWorld)
    table.fail("name", "found \"world\"; that is what a fixed root stands on, and no link");
  std::vector<std::string_view> kinds;
  for (const JointType& known : kJointTypes)
    kinds.push_back(known.name);
  link.joint = static_cast<JointKind>(table.choice("joint", kinds));
  const JointType& joint = link.type();

  if (joint.floats())
    base_names = read_base(table, base_names);
  else
    entry.parent = name(table, "parent");
  if (!joint.floats() && entry.parent != kWorld)
  {
    link.at = table.vector("at");
    if (!joint.constant.empty())
      link.angle = table.number("angle", 0.0);
  }
  if (joint.bar)
  {
    link.parent_radius = table.magnitude("parent_radius");
    link.child_radius = table.magnitude("child_radius");
  }
  if (joint.moves())
    entry.coordinate = name(table, "coordinate", link.name);

  link.mass = table.magnitude("mass");
  link.com = table.vector("com", Eigen::Vector2d(0.0, 0.0));
  link.inertia = table.magnitude("inertia");
  read_drawing(table, link);
  table.finish();
  return entry;
}

// Links and joints from the URDF that the file names.
void read_links_of_urdf(StrictTable& table, const std::string& file, RobotDescription& description)
{
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  const std::string named = table.text("urdf");
  const std::string shown = (folder / printable(named)).string();
  std::string text;
  try
  {
    text = read_text_file((folder / named).string());
  }
  catch (const FileError&)
  {
    table.fail("urdf", fmt::format("{} cannot be read; expected a URDF of at most 1 MB", shown));
  }
  const RobotDescription urdf = read_urdf(text, shown);
  description.name = urdf.name;
  description.links = urdf.links;
  description.actuators = urdf.actuators;
  description.unread = urdf.unread;
  description.opposite = urdf.opposite;
  description.notes = urdf.notes;
  for (auto& entry : description.links)
    entry.file = shown;
  for (auto& entry : description.actuators)
    entry.file = shown;
}

// What a file adds to a link of its URDF; returns the link's name.
std::string complete_link(StrictTable& table, RobotDescription& description)
{
  const std::string link = name(table, "name");
  table.set_context(fmt::format("link '{}'", link));
  const auto entry = std::ranges::find(description.links, link, [](const auto& one) { return one.link.name; });
  if (entry == description.links.end())
    table.fail("name", fmt::format("found \"{}\"; the URDF has no link of that name", link));
  for (const std::string_view key :
       {"joint", "parent", "at", "angle", "parent_radius", "child_radius", "mass", "com", "inertia"})
    if (table.has(key))
      table.fail(key, fmt::format("comes from the URDF, {}:{}; change it there", entry->file, entry->line));
  if (entry->link.type().floats())
    description.base_names = read_base(table, description.base_names);
  if (entry->link.type().moves())
    entry->coordinate = name(table, "coordinate", link);
  read_drawing(table, entry->link);
  table.finish();
  return link;
}

void complete_links(std::vector<StrictTable> tables, RobotDescription& description)
{
  std::set<std::string> seen;
  for (StrictTable& table : tables)
    if (const std::string link = complete_link(table, description); !seen.insert(link).second)
      table.fail("name", "is that of a second [[link]]; names must differ");
}

RobotDescription::ActuatorEntry read_actuator(StrictTable& table)
{
  RobotDescription::ActuatorEntry entry;
  entry.line = table.line();
  Actuator& actuator = entry.actuator;
  actuator.name = name(table, "name");
  table.set_context(fmt::format("actuator '{}'", actuator.name));
  entry.on = name(table, "on");
  entry.against = name(table, "against");
  entry.coordinate = name(table, "coordinate", actuator.name);
  entry.offset = table.number("offset", 0.0);
  std::vector<std::string_view> placements;
  for (const Placement placement : {Placement::links, Placement::bar_parent, Placement::bar_child})
    placements.push_back(name_of(placement));
  actuator.placement = static_cast<Placement>(table.choice("between", placements, 0));
  for (const auto& [key, value, range] : kActuatorNumbers)
  {
    double& number = actuator.*value;
    number = range == ActuatorNumber::Range::not_negative ? table.magnitude(key, number) : table.number(key, number);
    if (range == ActuatorNumber::Range::positive && !(number > 0.0))
      table.fail(key, fmt::format("found {}; expected a positive number", number));
  }
  table.finish();
  return entry;
}

// Takes from what the URDF says of the joint between the same links what the actuator's table says by itself.
void forget_unread(RobotDescription& description, const RobotDescription::ActuatorEntry& actuator,
                   const StrictTable& table)
{
  for (RobotDescription::UnreadEntry& entry : description.unread)
    if ((entry.on == actuator.on && entry.against == actuator.against) ||
        (entry.on == actuator.against && entry.against == actuator.on))
      std::erase_if(entry.values, [&](const UnreadValue& value) { return !value.key.empty() && table.has(value.key); });
  std::erase_if(description.unread, [](const auto& entry) { return entry.values.empty(); });
}

RobotDescription::FootEntry read_foot(StrictTable& table)
{
  RobotDescription::FootEntry entry;
  entry.line = table.line();
  Foot& foot = entry.foot;
  foot.side = static_cast<Side>(table.choice("side", {"left", "right"}));
  table.set_context(fmt::format("{} foot", name_of(foot.side)));
  entry.link = name(table, "link");
  foot.ankle_at = table.vector("ankle", Eigen::Vector2d(0.0, 0.0));
  const bool extent = table.has("heel") || table.has("toe");
  foot.heel_at = extent ? table.vector("heel") : foot.ankle_at;
  foot.toe_at = extent ? table.vector("toe") : foot.ankle_at;
  foot.friction = table.magnitude("friction");
  foot.f_min = table.magnitude("f_min", 0.0);
  table.finish();
  return entry;
}

} // namespace

Robot read_toml_robot(std::string_view text, const std::string& file)
{
  const toml::table document = parse_toml(text, file);
  StrictTable table(document, file);
  RobotDescription description;
  description.file = file;
  const bool has_urdf = table.has("urdf");
  if (has_urdf)
  {
    read_links_of_urdf(table, file, description);
    description.name = name(table, "name", description.name);
  }
  else
    description.name = name(table, "name");
  description.source = table.text("source", "");
  description.gravity = table.number("gravity", 9.81);
  if (!(description.gravity > 0.0))
    table.fail("gravity", fmt::format("found {}; expected a positive number", description.gravity));
  if (has_urdf)
    complete_links(table.tables("link", "link"), description);
  else
    for (StrictTable& link : table.tables("link", "link"))
      description.links.push_back(read_link(link, description.base_names));
  std::vector<StrictTable> actuators = table.tables("actuator", "actuator");
  if (!actuators.empty())
    description.actuators.clear();
  for (StrictTable& actuator : actuators)
  {
    description.actuators.push_back(read_actuator(actuator));
    forget_unread(description, description.actuators.back(), actuator);
  }
  for (StrictTable& foot : table.tables("foot", "foot"))
    description.feet.push_back(read_foot(foot));
  table.finish();
  return assemble(description);
}

} // namespace torqued
