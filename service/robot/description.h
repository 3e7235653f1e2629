/// What a robot file says, names not yet resolved.
#pragma once

#include "robot/robot.h"

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// A number of a URDF that would change torques and that no robot takes from there, because a TOML file says it.
struct UnreadValue
{
  std::string element, attribute; ///< attribute: empty if the element has none that says more
  std::string value;
  std::string_view key; ///< of an [[actuator]]; empty: nothing of ours says it
};

/// A robot file. Lines are those of the file, for complaints.
struct RobotDescription
{
  struct LinkEntry
  {
    Link link;
    std::string parent; ///< "world" for a fixed root
    std::string coordinate;
    int line;
    std::string file = {}; ///< whose line that is; empty: the description's
  };
  struct ActuatorEntry
  {
    Actuator actuator;
    std::string on, against, coordinate; ///< against: "world" for the world
    double offset;
    int line;
    std::string file = {}; ///< as a link's
  };
  struct FootEntry
  {
    Foot foot;
    std::string link;
    int line;
  };
  /// What a URDF says of a joint's motor.
  struct UnreadEntry
  {
    std::string joint, on, against; ///< the links between which the joint's actuator acts
    std::vector<UnreadValue> values;
    std::string file;
    int line;
  };

  /// A joint of a URDF whose coordinate, that of the link `on` against `against`, has the opposite sign here.
  struct OppositeEntry
  {
    std::string joint, on, against;
    bool slides;
    std::string file;
  };

  std::string file;
  std::string name, source;
  double gravity;
  std::array<std::string, 2> base_names{"x", "z"};
  std::vector<LinkEntry> links;
  std::vector<ActuatorEntry>
      actuators;               ///< if empty: one for each joint that moves, turning the child against its parent
  std::vector<FootEntry> feet; ///< two; one or two, one of them on the root, if that is fixed; or none
  std::vector<UnreadEntry> unread = {};
  std::vector<OppositeEntry> opposite = {};
  std::vector<std::string> notes = {}; ///< what to know about how the file was read, a line each
};

} // namespace torqued
