#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "questions/regressor.h"
#include "robot/files/load.h"
#include "robot/files/robot_files.h"
#include "robot/files/strict_toml.h"
#include "text/printable.h"

#include <CLI/CLI.hpp>

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <string>

namespace torqued
{

namespace
{

struct ModelOptions
{
  std::string robot;
  std::string toml_for; // a URDF's name
  bool list = false, toml = false, urdf = false;
};

std::string point(const Eigen::Vector2d& at)
{
  return fmt::format("({:.4g}, {:.4g})", at.x(), at.y());
}

std::string limit(double value, std::string_view unit)
{
  return std::isfinite(value) ? fmt::format("{:g} {}", value, unit) : std::string("none");
}

// row i of q_relative = A q_absolute + b, what is added before what is subtracted: "q2 - q1 + 1.5708"
std::string formula(const Robot& robot, int i)
{
  std::string text;
  const auto add = [&text](double factor, const std::string& of)
  {
    text += text.empty() ? (factor < 0.0 ? "-" : "") : (factor < 0.0 ? " - " : " + ");
    const double size = std::abs(factor);
    text += of.empty() ? fmt::format("{:g}", size) : size == 1.0 ? of : fmt::format("{:g} {}", size, of);
  };
  for (const bool negative : {false, true})
    for (int j = 0; j < robot.num_coordinates(); ++j)
      if (const double factor = robot.A(i, j); factor != 0.0 && (factor < 0.0) == negative)
        add(factor, robot.absolute_names[static_cast<std::size_t>(j)]);
  if (robot.b(i) != 0.0)
    add(robot.b(i), "");
  return text;
}

const std::string& link_name(const Robot& robot, int link)
{
  static const std::string world = "world";
  return link < 0 ? world : robot.links[static_cast<std::size_t>(link)].name;
}

// what the columns do not say of a joint
std::string joint_details(const Link& link)
{
  std::string text;
  if (link.type().bar)
    text = fmt::format("  radii {:.4g} m of the parent, {:.4g} m of its own", link.parent_radius, link.child_radius);
  if (link.angle == 0.0)
    return text;
  return fmt::format("{}{} angle {:.4g} rad {}", text, text.empty() ? " " : ",", link.angle, link.type().constant);
}

void print_links(const Robot& robot)
{
  fmt::print("\nlinks: x forward, z up in the link's frame, at its joint to the parent; of one that rolls, at the "
             "centre\nof its own circle, and `at` is the centre of the parent's\n"
             "  {:<16} {:<16} {:<9} {:<18} {:>8}  {:<18} {:>12}\n",
             "name", "parent", "joint", "at (m)", "mass kg", "com (m)", "inertia kg m²");
  for (const Link& link : robot.links)
    fmt::print("  {:<16} {:<16} {:<9} {:<18} {:>8.4g}  {:<18} {:>12.4g}{}\n", link.name, link_name(robot, link.parent),
               link.type().name, point(link.at), link.mass, point(link.com), link.inertia, joint_details(link));
}

void print_coordinates(const Robot& robot)
{
  fmt::print("\nABSOLUTE coordinates: angles against the world, rad, counter-clockwise; of a slide, m\n");
  for (const Link& link : robot.links)
    if (link.coordinate >= 0 && link.coordinate < robot.num_coordinates())
      fmt::print("  {} = {} of {}\n", robot.absolute_names[static_cast<std::size_t>(link.coordinate)],
                 link.type().slides() ? "displacement" : "angle", link.name);
  fmt::print("RELATIVE coordinates\n");
  for (int i = 0; i < robot.num_coordinates(); ++i)
    fmt::print("  {} = {}\n", robot.relative_names[static_cast<std::size_t>(i)], formula(robot, i));
  if (robot.fixed_root())
    fmt::print("the root, {}, is fixed to the world\n", robot.link(robot.root()).name);
  else
    fmt::print("base point: {}, m\n", fmt::join(robot.base_names, ", "));
}

// of a motor's numbers
struct Units
{
  std::string_view torque, rate, inertia, viscous, speed;
};
constexpr Units kTurning{"N m", "N m/s", "kg m²", "N m s/rad", "rad/s"};
constexpr Units kSliding{"N", "N/s", "kg", "N s/m", "m/s"};

// what the columns do not say of an actuator
std::string actuator_details(const Actuator& actuator, const Units& units)
{
  std::string text;
  const auto add = [&text](double value, std::string_view name, std::string_view unit)
  {
    if (value != 0.0)
      text += fmt::format("{} {} {:.4g} {}", text.empty() ? " " : ",", name, value, unit);
  };
  if (actuator.placement != Placement::links)
    text = fmt::format("  between {}, kappa {:.4g}", name_of(actuator.placement), actuator.kappa);
  add(actuator.rotor_inertia, "rotor inertia", units.inertia);
  add(actuator.coulomb, "Coulomb friction", units.torque);
  add(actuator.viscous, "viscous friction", units.viscous);
  add(actuator.stribeck, "Stribeck friction", units.torque);
  if (actuator.stribeck != 0.0)
    add(actuator.stribeck_velocity, "at", units.speed);
  add(actuator.friction_offset, "friction offset", units.torque);
  add(actuator.stick_velocity, "continuous below", units.speed);
  return text;
}

void print_actuators(const Robot& robot)
{
  fmt::print("\nactuators: a positive torque turns `on` counter-clockwise and pushes back on `against`\n"
             "  {:<16} {:<16} {:<16} {:<14} {}\n",
             "name", "on", "against", "torque limit", "rate limit");
  for (const Actuator& actuator : robot.actuators)
  {
    const Units& units = is_force(robot, actuator) ? kSliding : kTurning;
    fmt::print("  {:<16} {:<16} {:<16} {:<14} {}{}\n", actuator.name, link_name(robot, actuator.on),
               link_name(robot, actuator.against), limit(actuator.torque_limit, units.torque),
               limit(actuator.rate_limit, units.rate), actuator_details(actuator, units));
  }
}

void print_feet(const Robot& robot)
{
  if (!robot.foot(Side::left).exists() && !robot.foot(Side::right).exists())
  {
    fmt::print("\nfeet: none, so no contact with the ground is possible\n");
    return;
  }
  fmt::print("\nfeet: points in the link's frame, m\n  {:<6} {:<16} {:<20} {:<20} {:<20} {}\n", "side", "link", "ankle",
             "heel", "toe", "friction");
  for (const Foot& foot : robot.feet)
    if (foot.exists())
      fmt::print("  {:<6} {:<16} {:<20} {:<20} {:<20} {:g}{}{}\n", name_of(foot.side), link_name(robot, foot.link),
                 point(foot.ankle_at), point(foot.heel_at), point(foot.toe_at), foot.friction,
                 foot.f_min > 0.0 ? fmt::format("  (at least {:g} N by constrained)", foot.f_min) : "",
                 robot.is_root(foot) ? "  (fixed to the world: always on its sole)"
                 : foot.has_extent() ? ""
                                     : "  (no extent: cannot stand on a sole)");
}

// The whole robot as one TOML file: its own, unless that is not all of it.
std::string whole_toml(const std::string& name_or_path, const Robot& robot)
{
  if (const std::string_view shipped = shipped_robot_toml(name_or_path); !shipped.empty())
    return std::string(shipped);
  const std::string text = read_text_file(name_or_path);
  const bool whole = name_or_path.ends_with(".toml") && !parse_toml(text, name_or_path).contains("urdf");
  return whole ? text : to_toml(robot);
}

void print_parameters(const Robot& robot)
{
  const std::vector<BaseParameter> parameters = base_parameters(robot);
  fmt::print("\nbase parameters: what the equation of motion, linear in them, can show of masses m, first moments mx "
             "and mz,\ninertias I about the link's frame, and motors; SI; the order of alpha\n");
  for (const BaseParameter& parameter : parameters)
    fmt::print("  {:>12.6g}  {}\n", parameter.value, parameter.name);
}

ExitCode model(const ModelOptions& options)
{
  if (options.list)
  {
    fmt::print("{}\n", fmt::join(shipped_robot_names(), "\n"));
    return ExitCode::done;
  }
  const Robot robot = require_robot(options.robot);
  if (options.toml || options.urdf || !options.toml_for.empty())
  {
    if (!options.toml_for.empty())
      to_urdf(robot); // what has no URDF has no file that completes it
    fmt::print("{}", options.toml   ? whole_toml(options.robot, robot)
                     : options.urdf ? to_urdf(robot)
                                    : to_companion_toml(robot, options.toml_for));
    return ExitCode::done;
  }
  const bool walks = !robot.fixed_root() && robot.foot(Side::left).exists();
  fmt::print("{}: {:.6g} kg, gravity {:g} m/s²{}, model_id {}\n", robot.name, robot.mechanism.mass(),
             robot.mechanism.gravity(), walks ? fmt::format(", leg length {:.4g} m", robot.leg_length) : std::string(),
             robot.model_id);
  if (!robot.source.empty())
    fmt::print("{}\n", printable_lines(robot.source));
  print_links(robot);
  print_coordinates(robot);
  print_actuators(robot);
  print_feet(robot);
  print_parameters(robot);
  return ExitCode::done;
}

} // namespace

Subcommand add_model(CLI::App& torquectl)
{
  const auto options = std::make_shared<ModelOptions>();
  CLI::App* app = torquectl.add_subcommand("model", "say what a robot means: links, coordinates, actuators, feet");
  add_robot_option(*app, options->robot, "no default");
  CLI::Option* list = app->add_flag("--list", options->list, "list the robots that ship");
  CLI::Option* toml =
      app->add_flag("--toml", options->toml, "print the robot's whole file: a start for a robot of one's own")
          ->excludes(list);
  CLI::Option* urdf =
      app->add_flag("--urdf", options->urdf, "print its links and joints as a URDF")->excludes(list)->excludes(toml);
  app->add_option("--toml-for", options->toml_for,
                  "print what its URDF leaves out, feet, limits and more, as a TOML file that names this URDF")
      ->type_name("FILE.urdf")
      ->check([](const std::string& name)
              { return name.ends_with(".urdf") ? std::string() : "expected a name that ends in .urdf"; })
      ->excludes(list)
      ->excludes(toml)
      ->excludes(urdf);
  app->footer("Examples:\n"
              "  torquectl model --robot ck --toml > /tmp/mine.toml\n"
              "  torquectl model --robot /tmp/mine.toml\n\n"
              "  torquectl model --robot ck --urdf > /tmp/ck.urdf\n"
              "  torquectl model --robot ck --toml-for ck.urdf > /tmp/ck.toml\n"
              "  torquectl model --robot /tmp/ck.toml");
  return {app, options, model};
}

} // namespace torqued
