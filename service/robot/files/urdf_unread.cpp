#include "robot/files/urdf_unread.h"

#include "text/number.h"
#include "text/plain_text.h"
#include "text/printable.h"
#include "text/spelling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued
{

namespace
{

constexpr std::size_t kLongestValue = 40;

constexpr std::string_view kBlanks = " \t\r\n";

// an element's or attribute's text without blanks around it; null: there is none
std::string trimmed_text(const char* text)
{
  return std::string(trimmed(text ? text : "", kBlanks));
}

// a name without its namespace: "drake:rotor_inertia" is "rotor_inertia"
std::string_view local(std::string_view name)
{
  return name.substr(name.rfind(':') + 1); // 0 without one
}

// attributes about motors, and the key of an [[actuator]] that says the same
struct Meaning
{
  std::string_view attribute, key;
};
constexpr std::array<Meaning, 15> kMeanings{{{"damping", "viscous"},
                                             {"friction", "coulomb"},
                                             {"coulomb_friction", "coulomb"},
                                             {"frictionloss", "coulomb"},
                                             {"effort", "torque_limit"},
                                             {"armature", "rotor_inertia"},
                                             {"rotor_inertia", "rotor_inertia"},
                                             {"rotorinertia", "rotor_inertia"},
                                             {"motor_inertia", "rotor_inertia"},
                                             {"motorinertia", "rotor_inertia"},
                                             {"reduction", "rotor_inertia"},
                                             {"gearratio", "rotor_inertia"},
                                             {"mechanicalreduction", "rotor_inertia"},
                                             {"mechanical_reduction", "rotor_inertia"},
                                             {"gear_ratio", "rotor_inertia"}}};

std::string_view key_of(std::string_view attribute)
{
  const std::string name = lower_case(local(attribute));
  const auto found = std::ranges::find(kMeanings, std::string_view(name), &Meaning::attribute);
  return found == kMeanings.end() ? std::string_view() : found->key;
}

// of a gear: 1 is none
bool is_ratio(std::string_view attribute)
{
  const std::string name = lower_case(local(attribute));
  return key_of(name) == "rotor_inertia" && (name.ends_with("reduction") || name.ends_with("ratio"));
}

// of a motor, before its gear; what is called armature has passed it
bool is_motors_inertia(std::string_view attribute)
{
  const std::string name = lower_case(local(attribute));
  return key_of(name) == "rotor_inertia" && name.ends_with("inertia");
}

// what a value is about: <drake:gear_ratio value="50"> is about gear_ratio
std::string_view meant(std::string_view element, std::string_view attribute)
{
  return attribute.empty() || attribute == "value" ? element : attribute;
}

// what no torque depends on
bool bounds_motion(std::string_view attribute)
{
  const std::string name = lower_case(local(attribute));
  constexpr std::array<std::string_view, 10> bounds{
      "lower",        "upper", "velocity",         "acceleration",     "jerk",
      "deceleration", "name",  "soft_lower_limit", "soft_upper_limit", "coulomb_window"};
  return std::ranges::find(bounds, name) != bounds.end();
}

bool says_none(std::string_view attribute, const std::string& text)
{
  const std::optional<double> value = number_in<double>(text);
  if (lower_case(local(attribute)) != "effort")
    return value == (is_ratio(attribute) ? 1.0 : 0.0);
  constexpr double most = 1e9; // N m; more is an exporter's word for "none"
  return value && (!(*value > 0.0) || *value >= most);
}

void add_transmission(const tinyxml2::XMLElement& element, Transmission& transmission)
{
  for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement())
  {
    const std::string_view name = local(child->Name());
    const char* const attribute = child->Attribute("value");
    const std::string value = trimmed_text(attribute ? attribute : child->GetText());
    const std::string_view key = key_of(name);
    if (key == "rotor_inertia" && !says_none(name, value))
      transmission.values.push_back({"transmission", std::string(name), printable(value, kLongestValue), key});
    else if (name == "joint" && child->Attribute("name"))
      transmission.joints.emplace_back(child->Attribute("name"));
    if (name == "joint" || name == "actuator")
      add_transmission(*child, transmission);
  }
}

// the element of URDF that a name is but for a slip of the pen; a vendor's name, which has a prefix, is none
std::optional<std::string_view> misspelt(std::string_view name)
{
  constexpr std::array<std::string_view, 12> known{"inertial", "inertia", "mass",  "origin", "parent",   "child",
                                                   "axis",     "mimic",   "joint", "link",   "dynamics", "limit"};
  for (const std::string_view word : known)
    if (resembles(lower_case(name), word))
      return word;
  return {};
}

// how rotor_inertia comes of a gear and a motor, with the number if both are known; empty if neither is said
std::string reflected(const std::vector<UnreadValue>& values)
{
  std::vector<double> ratios, inertias;
  bool is_said = false, is_clear = true;
  for (const UnreadValue& value : values)
  {
    const std::string_view about = meant(value.element, value.attribute);
    if (!is_ratio(about) && !is_motors_inertia(about))
    {
      is_clear = is_clear && value.key != "rotor_inertia";
      continue;
    }
    is_said = true;
    const std::optional<double> number = number_in<double>(value.value);
    is_clear = is_clear && number;
    (is_ratio(about) ? ratios : inertias).push_back(number.value_or(0.0));
  }
  if (!is_said)
    return "";
  return fmt::format("{} (gear ratio squared times the motor's inertia)",
                     is_clear && ratios.size() == 1 && inertias.size() == 1
                         ? fmt::format(" = {:.6g}", ratios.front() * ratios.front() * inertias.front())
                         : "");
}

// what has a number for a simulator, and none for mechanics: how it draws, senses, steps and finds its files
bool is_harmless_to(const std::string& name)
{
  constexpr std::string_view words =
      " material visual sensor plugin laserretro selfcollide self_collide providefeedback provide_feedback "
      "preservefixedjoint disablefixedjointlumping maxcontacts max_contacts asset statistic size custom extension "
      "keyframe meshdir texturedir assetdir strippath discardvisual fusestatic convexhull angle timestep integrator "
      "solver iterations ";
  return words.find(" " + name + " ") != std::string_view::npos;
}

// a child of <gazebo> or <mujoco> as a note names it; nothing if it has no mechanics
std::optional<std::string> part_of_simulator(const tinyxml2::XMLElement& child)
{
  const std::string name = lower_case(child.Name());
  const std::string text = trimmed_text(child.GetText());
  if (is_harmless_to(name) || name == "turngravityoff" || (name == "gravity" && !child.FirstAttribute()))
    return {};
  std::string part = "<" + printable(child.Name(), kLongestValue);
  bool says = child.FirstChildElement() != nullptr;
  for (const auto* attribute = child.FirstAttribute(); attribute; attribute = attribute->Next())
    if (!is_harmless_to(lower_case(attribute->Name())))
    {
      says = true;
      part += fmt::format(" {}={}", printable(attribute->Name(), kLongestValue),
                          printable(trimmed_text(attribute->Value()), kLongestValue));
    }
  const bool is_none = text.empty() || text == "false" || (number_in<double>(text) == 0.0 && !name.starts_with("mu"));
  if (!says && is_none)
    return {};
  return part + ">";
}

// elements somewhere in a vendor's that speak of mechanics
void add_parts(const tinyxml2::XMLElement& element, std::vector<std::string>& parts)
{
  constexpr std::array<std::string_view, 12> words{"spring",  "stiff",   "damp", "friction", "mass",     "inerti",
                                                   "density", "gravity", "gear", "rotor",    "armature", "torque"};
  for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement())
  {
    const std::string name = lower_case(local(child->Name()));
    const auto is_part = [&name](std::string_view word)
    {
      return name.find(word) != std::string::npos;
    };
    if (is_harmless_to(name) || is_part("sensor"))
      continue;
    const std::string part = fmt::format("<{}>", printable(child->Name(), kLongestValue));
    if (std::ranges::any_of(words, is_part) && std::ranges::find(parts, part) == parts.end())
      parts.push_back(part);
    else
      add_parts(*child, parts);
  }
}

} // namespace

std::vector<UnreadValue> unread_values(const tinyxml2::XMLElement& element)
{
  std::vector<UnreadValue> values;
  for (const auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next())
  {
    const std::string text = trimmed_text(attribute->Value());
    const std::string_view about = meant(element.Name(), attribute->Name());
    if (!bounds_motion(about) && !says_none(about, text))
      values.push_back({printable(element.Name(), kLongestValue), printable(attribute->Name(), kLongestValue),
                        printable(text, kLongestValue), key_of(about)});
  }
  const std::string_view name = element.Name();
  if (!element.FirstAttribute() && name != "dynamics" && name != "limit" && name != "safety_controller")
    values.push_back({printable(element.Name(), kLongestValue), "",
                      printable(trimmed_text(element.GetText()), kLongestValue), key_of(element.Name())});
  return values;
}

std::vector<Transmission> transmissions_of(const tinyxml2::XMLElement& robot)
{
  std::vector<Transmission> transmissions;
  const auto add_all = [&transmissions](const tinyxml2::XMLElement& in)
  {
    for (const auto* element = in.FirstChildElement("transmission"); element;
         element = element->NextSiblingElement("transmission"))
    {
      add_transmission(*element, transmissions.emplace_back());
      transmissions.back().line = element->GetLineNum();
    }
  };
  add_all(robot);
  for (const auto* control = robot.FirstChildElement("ros2_control"); control;
       control = control->NextSiblingElement("ros2_control"))
    add_all(*control);
  return transmissions;
}

std::string note_of(const RobotDescription::UnreadEntry& entry)
{
  std::vector<std::string> elements;
  std::vector<std::string> keys;
  std::string_view last;
  bool all_have_keys = true;
  for (const UnreadValue& value : entry.values)
  {
    if (value.element != last)
      elements.push_back("<" + value.element);
    last = value.element;
    if (!value.attribute.empty())
      elements.back() += fmt::format(" {}={}", value.attribute, value.value);
    if (value.key.empty())
      all_have_keys = false;
    else if (std::ranges::find(keys, value.key) == keys.end())
      keys.emplace_back(value.key);
  }
  if (const auto key = std::ranges::find(keys, "rotor_inertia"); key != keys.end())
    *key += reflected(entry.values);
  const std::string advice = keys.empty() ? ", and no key in the TOML says it"
                                          : fmt::format(": set {} in the TOML{}", fmt::join(keys, ", "),
                                                        all_have_keys ? "" : "; no key there says the others");
  return fmt::format("{}:{}: joint '{}': {}> {} not read{}", entry.file, entry.line, entry.joint,
                     fmt::join(elements, "> and "), elements.size() == 1 ? "is" : "are", advice);
}

std::string note_of_signs(const RobotDescription& description)
{
  std::vector<std::string> turning, sliding;
  for (const auto& entry : description.opposite)
    if (std::ranges::any_of(description.actuators, [&entry](const auto& actuator)
                            { return actuator.on == entry.on && actuator.against == entry.against; }))
      (entry.slides ? sliding : turning).push_back(fmt::format("'{}'", entry.joint));
  const auto named = [&description](std::vector<std::string> names)
  {
    constexpr std::size_t most = 12;
    if (names.size() > 1 && names.size() == description.actuators.size())
      return std::string("all joints");
    const std::size_t others = names.size() > most ? names.size() - most : 0;
    names.resize(names.size() - others);
    return fmt::format("{}{}", fmt::join(names, ", "), others > 0 ? fmt::format(" and {} more", others) : "");
  };
  std::vector<std::string> parts;
  if (!turning.empty())
    parts.push_back(fmt::format(
        "angle and torque of {} count against the URDF's: its axis is +y, ours counter-clockwise in the x-z plane",
        named(turning)));
  if (!sliding.empty())
    parts.push_back(
        fmt::format("displacement and force of {} count against the URDF's: its axis is -y, ours +y", named(sliding)));
  return parts.empty() ? "" : fmt::format("{}: {}", description.opposite.front().file, fmt::join(parts, "; "));
}

std::optional<std::string> mechanics_in(std::string_view full_name)
{
  const std::string name = lower_case(local(full_name));
  constexpr std::array<std::string_view, 9> harmless{"sensor",   "collision", "visual",  "plugin",   "controller",
                                                     "material", "geometry",  "contact", "proximity"};
  const auto is_part = [&name](std::string_view word)
  {
    return name.find(word) != std::string::npos;
  };
  if (std::ranges::any_of(harmless, is_part))
    return {};
  if (const auto word = misspelt(full_name))
    return fmt::format("did you mean <{}>?", *word);
  constexpr std::array<std::string_view, 27> words{
      "joint",  "loop",   "closure", "constraint", "equality", "weld",    "mimic",  "coupl",    "force",
      "torque", "thrust", "spring",  "stiff",      "damp",     "bushing", "tendon", "muscle",   "friction",
      "mass",   "inerti", "density", "gravity",    "gear",     "rotor",   "motor",  "armature", "scale"};
  if (const auto word = std::ranges::find_if(words, is_part); word != words.end())
    return fmt::format("its name speaks of mechanics, which are not read from it ({})", *word);
  return {};
}

std::optional<std::string> mechanics_in(const tinyxml2::XMLElement& simulator)
{
  for (const auto* child = simulator.FirstChildElement(); child; child = child->NextSiblingElement())
  {
    const std::string name = lower_case(child->Name());
    if (name == "equality" || name == "tendon" || name == "worldbody" || name == "model" ||
        (name == "joint" && child->FirstChildElement("child")) ||
        (name == "link" && child->FirstChildElement("inertial")))
      return fmt::format(
          "holds <{}>, which changes how the robot moves; only <link> and <joint> of the <robot> itself are read",
          name);
  }
  return {};
}

std::vector<std::string> unread_parts(const tinyxml2::XMLElement& element)
{
  const std::string_view name = element.Name();
  std::vector<std::string> parts;
  if (name != "gazebo" && name != "mujoco")
  {
    // the transmissions of a <ros2_control> are read by themselves
    if (!is_harmless_to(lower_case(local(name))) && name != "sensor" && name != "ros2_control")
      add_parts(element, parts);
    return parts;
  }
  for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement())
    if (const auto part = part_of_simulator(*child); part && std::ranges::find(parts, *part) == parts.end())
      parts.push_back(*part);
  return parts;
}

bool takes_gravity(const tinyxml2::XMLElement& child)
{
  const std::string_view name = child.Name();
  const std::string text = trimmed_text(child.GetText());
  return (name == "turnGravityOff" && (text == "true" || text == "1")) ||
         (name == "gravity" && (text == "false" || text == "0"));
}

} // namespace torqued
