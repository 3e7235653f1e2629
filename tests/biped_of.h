/// Bipeds with as many links as one asks for.
#pragma once

#include "robot/files/toml_robot.h"
#include "robot/robot.h"

#include <fmt/format.h>
#include <string>

namespace torqued
{

/// A biped of so many links, an odd number from 3: a trunk, and legs of equal links, of which the last have soles.
inline Robot biped_of(int links)
{
  const int per_leg = (links - 1) / 2;
  const double length = 0.9 / per_leg;
  std::string toml = R"(name = "biped"
gravity = 9.81
[[link]]
name = "trunk"
joint = "floating"
mass = 30
com = [0, 0.2]
inertia = 0.8
)";
  for (const Side side : kSides)
  {
    std::string parent = "trunk";
    for (int i = 0; i < per_leg; ++i)
    {
      const std::string name = fmt::format("{}_{}", name_of(side), i);
      toml += fmt::format(R"([[link]]
name = "{}"
joint = "revolute"
parent = "{}"
at = [0, {}]
mass = 3
com = [0.01, {}]
inertia = 0.03
)",
                          name, parent, i == 0 ? 0.0 : -length, -0.4 * length);
      parent = name;
    }
    toml += fmt::format(R"([[foot]]
side = "{}"
link = "{}"
ankle = [0, {}]
heel = [-0.07, {}]
toe = [0.15, {}]
friction = 0.8
)",
                        name_of(side), parent, -length, -length - 0.06, -length - 0.06);
  }
  return read_toml_robot(toml, "biped.toml");
}

} // namespace torqued
