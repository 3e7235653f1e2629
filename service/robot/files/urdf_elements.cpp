#include "robot/files/strict_xml.h"
#include "robot/files/text_file.h"
#include "robot/files/urdf_model.h"
#include "robot/files/urdf_unread.h"
#include "text/printable.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued::urdf
{

namespace
{

std::string name(StrictElement& element, std::string_view key)
{
  const std::string text = element.text(key);
  if (!is_name(text))
    element.fail(key, fmt::format("found \"{}\"{}; expected 1 to {} letters, digits, _ or -", printable(text),
                                  text.size() > kLongestName ? fmt::format(" of {} characters", text.size()) : "",
                                  kLongestName));
  return text;
}

// turns about fixed axes, x first, then y, then z
Eigen::Matrix3d rotation(const Eigen::Vector3d& rpy)
{
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(rpy.z(), Vector3d::UnitZ()).toRotationMatrix() *
          AngleAxisd(rpy.y(), Vector3d::UnitY()).toRotationMatrix()) *
         AngleAxisd(rpy.x(), Vector3d::UnitX()).toRotationMatrix();
}

Origin read_origin(StrictElement& element)
{
  Origin origin;
  if (std::optional<StrictElement> child = element.child("origin"))
  {
    origin.at = child->vector("xyz", Eigen::Vector3d::Zero());
    origin.rpy = child->vector("rpy", Eigen::Vector3d::Zero());
    origin.R = rotation(origin.rpy);
    child->finish();
  }
  return origin;
}

void read_inertia(StrictElement& inertia, Link& link)
{
  link.inertia_line = inertia.line();
  constexpr std::string_view keys[3][3] = {{"ixx", "ixy", "ixz"}, {"ixy", "iyy", "iyz"}, {"ixz", "iyz", "izz"}};
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column)
      link.inertia(row, column) = link.inertia(column, row) = inertia.number(keys[row][column]);
  for (int axis = 0; axis < 3; ++axis)
    if (link.inertia(axis, axis) < 0.0)
      inertia.fail(keys[axis][axis],
                   fmt::format("found {}; expected a number that is not negative", link.inertia(axis, axis)));
  inertia.finish();
}

void read_inertial(StrictElement& inertial, Link& link)
{
  const auto missing = [&inertial](std::string_view name)
  {
    inertial.fail({}, fmt::format("<{}> is missing; a link without mass has no <inertial>", name));
  };
  const Origin origin = read_origin(inertial);
  link.com = origin.at;
  link.inertia_R = origin.R;
  std::optional<StrictElement> mass = inertial.child("mass");
  if (!mass)
    missing("mass");
  link.mass = mass->magnitude("value");
  mass->finish();
  if (std::optional<StrictElement> inertia = inertial.child("inertia"))
    read_inertia(*inertia, link);
  else if (link.mass != 0.0)
    missing("inertia");
  inertial.skip({"volume"});
  inertial.finish();
}

// Reads the elements of one file into its model.
class ElementReader
{
public:
  explicit ElementReader(Model& model) : model_(model) {}

  void read(const tinyxml2::XMLElement& element)
  {
    StrictElement robot(element, model_.file);
    if (std::string_view(element.Value()) != "robot")
      robot.fail({}, fmt::format("found <{}>; expected <robot>", printable(element.Value(), kLongestName)));
    robot.skip({"material", "transmission"});
    model_.name = urdf::name(robot, "name");
    for (StrictElement& child : robot.children("link"))
      read_link(child);
    for (StrictElement& child : robot.children("joint"))
      read_joint(child);
    for (const std::string_view simulator : {"gazebo", "mujoco"})
      for (StrictElement& child : robot.children(simulator))
        look_at_simulator(child);
    finish(robot);
    for (const auto& [says, unread] : model_.not_read)
      model_.passed_over.erase(fmt::format("<{}>", says.substr(0, says.find(' '))));
    add_transmissions(element);
  }

private:
  // refuses what might be mechanics; of the rest, remembers what is passed over
  void finish(const StrictElement& element)
  {
    const auto attribute = [&](const tinyxml2::XMLAttribute& found)
    {
      const std::string_view name = found.Name();
      const bool common =
          name == "version" || name == "xmlns" || name.starts_with("xmlns:") || name.starts_with("xsi:");
      if (!common && mechanics_in(name))
        return false;
      if (!common)
        model_.passed_over.insert(fmt::format("{}=\"...\"", printable(found.Name(), kLongestName)));
      return true;
    };
    const auto child = [&](const tinyxml2::XMLElement& found)
    {
      const std::string shown = printable(found.Name(), kLongestName);
      if (const std::optional<std::string> why = mechanics_in(std::string_view(found.Name())))
        model_.fail(found.GetLineNum(), fmt::format("{}<{}> is not known here: {}", context_of(element), shown, *why));
      pass_over(found, context_of(element));
      return true;
    };
    element.finish(attribute, child);
  }

  static std::string context_of(const StrictElement& element)
  {
    const tinyxml2::XMLElement& xml = element.xml();
    const char* const name = xml.Attribute("name");
    return std::string_view(xml.Name()) == "robot" || !name ? std::string()
                                                            : fmt::format("{} '{}': ", xml.Name(), name);
  }

  void read_link(StrictElement& element)
  {
    Link link;
    link.name = urdf::name(element, "name");
    link.line = element.line();
    element.set_context(fmt::format("link '{}'", link.name));
    element.skip({"visual", "collision"});
    if (std::optional<StrictElement> inertial = element.child("inertial"))
      read_inertial(*inertial, link);
    finish(element);
    if (!model_.link_index.emplace(link.name, static_cast<int>(model_.links.size())).second)
      model_.fail(link, "there is a second link of this name; names must differ");
    model_.links.push_back(link);
  }

  void read_joint(StrictElement& element)
  {
    Joint joint;
    joint.name = urdf::name(element, "name");
    joint.line = element.line();
    element.set_context(fmt::format("joint '{}'", joint.name));
    joint.type = read_type(element);
    joint.origin = read_origin(element);
    joint.parent = read_end(element, "parent");
    joint.child = read_end(element, "child");
    if (std::optional<StrictElement> axis = element.child("axis"))
    {
      joint.axis = axis->vector("xyz", Eigen::Vector3d::UnitX());
      axis->finish();
    }
    if (std::optional<StrictElement> mimic = element.child("mimic"))
    {
      joint.mimic = {mimic->text("joint"), mimic->number("multiplier", 1.0), mimic->number("offset", 0.0),
                     mimic->line()};
      mimic->finish();
    }
    look_at_motor(element, joint);
    finish(element);

    const int index = static_cast<int>(model_.joints.size());
    if (!model_.joint_index.emplace(joint.name, index).second)
      model_.fail(joint, "there is a second joint of this name; names must differ");
    Link& child = model_.link(joint.child);
    if (child.joint >= 0)
      model_.fail(joint, fmt::format("its child \"{}\" is the child of joint '{}', too; a link has one parent",
                                     child.name, model_.joint(child.joint).name));
    child.joint = index;
    model_.link(joint.parent).joints.push_back(index);
    model_.joints.push_back(joint);
  }

  static Joint::Type read_type(StrictElement& element)
  {
    const std::string type = element.text("type");
    if (type == "revolute" || type == "continuous")
      return Joint::Type::revolute;
    if (type == "fixed")
      return Joint::Type::fixed;
    if (type == "prismatic")
      return Joint::Type::prismatic;
    if (type == "floating")
      return Joint::Type::floating;
    if (type == "planar")
      return Joint::Type::planar;
    element.fail("type",
                 fmt::format("found \"{}\"; expected revolute, continuous, prismatic, fixed, floating or planar",
                             printable(type, kLongestName)));
  }

  // the index of the parent or the child; the world need not be declared as a link
  int read_end(StrictElement& element, std::string_view end)
  {
    std::optional<StrictElement> child = element.child(end);
    if (!child)
      element.fail({}, fmt::format("<{}> is missing", end));
    const std::string name = child->text("link");
    child->finish();
    const auto found = model_.link_index.find(name);
    if (found != model_.link_index.end())
      return found->second;
    if (name != kWorld || end != "parent")
      child->fail("link", fmt::format("found \"{}\"; there is no link of that name", printable(name)));
    const int index = static_cast<int>(model_.links.size());
    model_.link_index.emplace(name, index);
    Link world;
    world.name = name;
    world.line = child->line();
    model_.links.push_back(world);
    return index;
  }

  // what the joint says of its motor, its springs and how far it goes
  static void look_at_motor(StrictElement& element, Joint& joint)
  {
    element.skip({"calibration"});
    for (const auto* child = element.xml().FirstChildElement(); child; child = child->NextSiblingElement())
    {
      const std::string_view name = child->Name();
      const bool is_motors = name == "dynamics" || name == "limit" || name == "safety_controller";
      const std::optional<std::string> why =
          is_motors || name == "origin" || name == "axis" || name == "parent" || name == "child" || name == "mimic"
              ? std::nullopt
              : mechanics_in(name);
      if (!is_motors && (!why || why->starts_with("did you mean")))
        continue;
      element.skip({name});
      std::vector<UnreadValue> values = unread_values(*child);
      joint.unread.insert(joint.unread.end(), values.begin(), values.end());
      if (name == "dynamics") // the first that a note names
        std::rotate(joint.unread.begin(), joint.unread.end() - static_cast<std::ptrdiff_t>(values.size()),
                    joint.unread.end());
      for (const char* bound : {"lower", "upper"})
        joint.has_range = joint.has_range || (name == "limit" && child->DoubleAttribute(bound) != 0.0);
    }
  }

  // names an element as one that moves nothing, or as one that is not read
  void pass_over(const tinyxml2::XMLElement& xml, const std::string& context)
  {
    const std::string shown = printable(xml.Name(), kLongestName);
    const std::vector<std::string> parts = unread_parts(xml);
    if (parts.empty())
    {
      model_.passed_over.insert(fmt::format("<{}>", shown));
      return;
    }
    const auto [found, is_first] = model_.not_read.try_emplace(fmt::format("{} {}", shown, fmt::join(parts, " ")));
    Unread& unread = found->second;
    if (!is_first)
    {
      ++unread.others;
      return;
    }
    const char* const reference = xml.Attribute("reference");
    unread = {.line = xml.GetLineNum(),
              .first =
                  fmt::format("{}<{}{}>", context, shown,
                              reference ? fmt::format(" reference=\"{}\"", printable(reference, kLongestName)) : ""),
              .parts = parts};
  }

  void look_at_simulator(StrictElement& element)
  {
    const tinyxml2::XMLElement& xml = element.xml();
    if (const std::optional<std::string> why = mechanics_in(xml))
      model_.fail(xml.GetLineNum(), fmt::format("<{}> {}", xml.Name(), *why));
    bool keeps_gravity = true;
    for (const auto* child = xml.FirstChildElement(); child; child = child->NextSiblingElement())
      if (takes_gravity(*child))
      {
        keeps_gravity = false;
        model_.notes.push_back(fmt::format("{}:{}: <gazebo> {}={} is not read: gravity pulls at every link",
                                           model_.file, child->GetLineNum(), child->Name(), child->GetText()));
      }
    if (keeps_gravity || !unread_parts(xml).empty())
      pass_over(xml, "");
  }

  void add_transmissions(const tinyxml2::XMLElement& robot)
  {
    for (const Transmission& transmission : transmissions_of(robot))
    {
      bool has_joint = transmission.values.empty();
      for (const std::string& name : transmission.joints)
        if (const auto found = model_.joint_index.find(name); found != model_.joint_index.end())
        {
          has_joint = true;
          std::vector<UnreadValue>& unread = model_.joint(found->second).unread;
          unread.insert(unread.end(), transmission.values.begin(), transmission.values.end());
        }
      if (!has_joint)
        model_.notes.push_back(fmt::format("{}:{}: <transmission {}={}> is not read, and names no joint of the robot",
                                           model_.file, transmission.line, transmission.values.front().attribute,
                                           transmission.values.front().value));
    }
  }

  Model& model_;
};

} // namespace

void Model::fail(int line, const std::string& message) const
{
  throw FileError(fmt::format("{}:{}: {}", file, line, message));
}

void Model::fail(const Joint& joint, const std::string& message) const
{
  fail(joint.line, fmt::format("joint '{}': {}", joint.name, message));
}

void Model::fail(const Link& link, const std::string& message) const
{
  fail(link.line, fmt::format("link '{}': {}", link.name, message));
}

Model read_elements(std::string_view text, const std::string& file)
{
  Model model{.file = file};
  tinyxml2::XMLDocument document;
  parse_xml(text, file, document);
  const tinyxml2::XMLElement* element = nullptr;
  for (const auto* node = document.FirstChild(); node; node = node->NextSibling())
  {
    if (node->ToComment() || node->ToDeclaration())
      continue;
    if (element || !node->ToElement())
      model.fail(node->GetLineNum(), "expected one element <robot>, and nothing else");
    element = node->ToElement();
  }
  if (!element)
    model.fail(1, "there is no element <robot>");
  ElementReader(model).read(*element);
  return model;
}

} // namespace torqued::urdf
