#include "page/curves.h"

#include "stance/contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <tuple>
#include <utility>

namespace torqued
{

namespace
{

// a quantity of a foot, in the order in which they are shown
struct FootQuantity
{
  const char *name, *title, *unit;
  double Wrench::*force; // null: the centre of pressure
};
constexpr std::array<FootQuantity, 3> kFootQuantities{{{"fz", "upward force", "N", &Wrench::fz},
                                                       {"fx", "forward force", "N", &Wrench::fx},
                                                       {"cop", "centre of pressure", "m", nullptr}}};

const FootQuantity& force_of(const Channel& channel)
{
  return kFootQuantities[channel.component == 0 ? 1 : 0];
}

std::string torque_column(const std::string& actuator)
{
  return "tau_" + actuator;
}

// pairs from the hip down, as they lie in the picture; then what is on neither side
std::vector<std::size_t> in_picture_order(const Robot& robot)
{
  constexpr std::array<std::string_view, 3> order{"hip", "knee", "ankle"};
  const auto key = [&](std::size_t joint)
  {
    const auto [side, kind] = sided(robot.actuators[joint].name);
    return std::tuple(!side, side ? std::ranges::find(order, kind) : order.end(), side ? kind : "", side);
  };
  std::vector<std::size_t> joints(robot.actuators.size());
  std::iota(joints.begin(), joints.end(), 0);
  std::ranges::stable_sort(joints, {}, key);
  return joints;
}

Curve torque_curve(const Robot& robot, std::size_t joint)
{
  const Actuator& actuator = robot.actuators[joint];
  const auto [side, kind] = sided(actuator.name);
  const double limit = actuator.torque_limit;
  return {torque_column(actuator.name),
          side ? fmt::format("{} {}", name_of(*side), kind) : actuator.name,
          is_force(robot, actuator) ? "N" : "N m",
          side,
          side ? kind : torque_column(actuator.name),
          std::isfinite(limit) ? std::vector{limit, -limit} : std::vector<double>{},
          [j = static_cast<int>(joint)](const Answer& answer)
          {
            return answer.torque(j);
          }};
}

Curve foot_curve(const Robot& robot, const Foot& foot, const FootQuantity& quantity)
{
  const auto of = [no_load = kNoLoad * robot.weight(), force = quantity.force,
                   s = static_cast<std::size_t>(foot.side)](const Answer& answer)
  {
    const GroundReaction& ground = answer.ground[s];
    // there is no centre of pressure without load
    return force ? ground.wrench.*force : std::abs(ground.wrench.fz) < no_load ? NAN : ground.cop;
  };
  return {foot_column(quantity.name, foot.side),
          fmt::format("{} foot: {}", name_of(foot.side), quantity.title),
          quantity.unit,
          foot.side,
          quantity.name,
          quantity.force ? std::vector<double>{} : std::vector{foot.heel_x(), foot.toe_x()},
          of};
}

Curve acceleration_curve(const Robot& robot, int coordinate)
{
  const Link& link = *std::ranges::find(robot.links, coordinate, &Link::coordinate);
  const auto [side, kind] = sided(link.name);
  const std::string& name = robot.absolute_names[static_cast<std::size_t>(coordinate)];
  return {"a_" + name,
          fmt::format("{} ({})", side ? fmt::format("{} {}", name_of(*side), kind) : link.name, name),
          link.type().slides() ? "m/s²" : "rad/s²",
          side,
          "a_" + (side ? kind : name),
          {},
          Acceleration{coordinate}};
}

// those of both sides beside each other
std::vector<Curve> acceleration_curves(const Robot& robot)
{
  std::vector<Curve> curves;
  for (int i = 0; i < robot.num_coordinates(); ++i)
  {
    Curve curve = acceleration_curve(robot, i);
    const auto last = std::ranges::find(curves.rbegin(), curves.rend(), curve.group, &Curve::group);
    curves.insert(last == curves.rend() ? curves.end() : last.base(), std::move(curve));
  }
  std::ranges::stable_sort(curves, {}, [](const Curve& curve) { return !curve.side; });
  for (const int i : {0, 1})
    if (const std::string& name = robot.base_names[static_cast<std::size_t>(i)]; !name.empty())
      curves.push_back({"a_" + name,
                        fmt::format("base point {} ({})", i == 0 ? "forward" : "upward", name),
                        "m/s²",
                        std::nullopt,
                        "a_" + name,
                        {},
                        Acceleration{robot.num_coordinates() + i}});
  return curves;
}

} // namespace

std::string foot_column(std::string_view quantity, Side side)
{
  return fmt::format("{}{}", quantity, side == Side::left ? 'L' : 'R');
}

std::vector<CurveSection> curve_sections(const Robot& robot)
{
  CurveSection torques{"Joint torques", {}}, forces{"Ground reactions", {}}, checks{"How well it fits", {}};
  for (const std::size_t joint : in_picture_order(robot))
    torques.curves.push_back(torque_curve(robot, joint));
  for (const FootQuantity& quantity : kFootQuantities)
    for (const Foot& foot : robot.feet)
      if (foot.exists())
        forces.curves.push_back(foot_curve(robot, foot, quantity));
  const auto add = [&checks](const char* name, const char* title, const char* unit, decltype(Curve::of) of)
  {
    checks.curves.push_back({name, title, unit, std::nullopt, name, {}, std::move(of)});
  };
  add("contact_speed", "speed of resting contacts", "m/s or rad/s", &Answer::contact_speed);
  add("contact_residual", "acceleration of resting contacts", "m/s² or rad/s²", &Answer::contact_residual);
  add("dynamics_residual", "residual of the equation of motion", "N or N m", &Answer::dynamics_residual);
  add("compute_us", "time to compute the answer", "µs", &AnswerTime::compute_us);
  add("delay_us", "from desired state to answer, at the logger", "µs", &AnswerTime::delay_us);
  return {torques, forces, {"Accelerations, answered and asked for", acceleration_curves(robot)}, checks};
}

std::string title_of(const Channel& channel)
{
  return channel.joint >= 0 ? channel.kind : force_of(channel).title;
}

std::string column_of(const Channel& channel)
{
  return channel.joint >= 0 ? torque_column(channel.name) : foot_column(force_of(channel).name, channel.side);
}

} // namespace torqued
