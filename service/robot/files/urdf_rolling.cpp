#include "robot/files/urdf_model.h"
#include "text/printable.h"

#include <fmt/format.h>

namespace torqued::urdf
{

namespace
{

// the joint that is mimicked; refused unless both can roll on a bar between them
Joint& mimicked_by(Model& model, const Joint& mimicking)
{
  const Joint::Mimic& mimic = *mimicking.mimic;
  const auto refuse = [&](const std::string& why)
  {
    model.fail(mimic.line, fmt::format("joint '{}': mimic: {}", mimicking.name, why));
  };
  const auto found = model.joint_index.find(mimic.joint);
  if (found == model.joint_index.end())
    refuse(fmt::format("found \"{}\"; there is no joint of that name", printable(mimic.joint)));
  Joint& mimicked = model.joint(found->second);
  if (mimicked.child != mimicking.parent && mimicking.child != mimicked.parent)
    refuse(fmt::format(
        "does not follow joint '{}', nor the other way round; only two joints with a link between them can roll",
        mimicked.name));
  if (mimicking.type != Joint::Type::revolute || mimicked.type != Joint::Type::revolute)
    refuse("only two revolute joints can roll");
  if (mimicking.carries_root || mimicked.carries_root)
    refuse("one of the two joints lets the root float, and nothing can roll there");
  if (mimicked.mimic)
    refuse(fmt::format("joint '{}' mimics a joint itself", mimicked.name));
  if (mimic.offset != 0.0)
    refuse(fmt::format("offset: found {}; expected 0, circles that roll turn together", mimic.offset));
  const double sense = mimicking.sense * mimicked.sense;
  if (!(mimic.multiplier * sense > 0.0))
    refuse(fmt::format(
        "multiplier: found {}{}; expected one by which both turn in the same sense, as circles that roll do",
        mimic.multiplier, sense < 0.0 ? " between opposite axes" : ""));
  if (mimicking.rolls || mimicked.rolls)
    refuse("one of the two joints rolls with another one, too");
  return mimicked;
}

} // namespace

void pair_rolling(Model& model)
{
  for (Joint& mimicking : model.joints)
  {
    if (!mimicking.mimic)
      continue;
    Joint& mimicked = mimicked_by(model, mimicking);
    const auto refuse = [&](const std::string& why)
    {
      model.fail(mimicking.mimic->line, fmt::format("joint '{}': mimic: {}", mimicking.name, why));
    };
    const bool second_mimics = mimicked.child == mimicking.parent;
    const Joint& first = second_mimics ? mimicked : mimicking;
    const Joint& second = second_mimics ? mimicking : mimicked;
    Link& bar = model.link(first.child);
    if (bar.mass != 0.0 || !bar.inertia.isZero(0.0))
      refuse(fmt::format("link '{}' between the joints has a mass; the bar of a rolling joint has none", bar.name));
    if (bar.joints.size() != 1)
      refuse(fmt::format("link '{}' between the joints has {} children; the bar of a rolling joint has one", bar.name,
                         bar.joints.size()));
    if (second.origin.at.x() == 0.0 && second.origin.at.z() == 0.0)
      refuse(
          fmt::format("both joints are at the same place; the bar between them, '{}', must have a length", bar.name));
    // the ratio is r_p / r_c if the second joint mimics the first, r_c / r_p the other way round
    const double ratio = mimicking.mimic->multiplier * mimicking.sense * mimicked.sense;
    model.link(second.child).rolling = {first.child, second_mimics ? ratio / (1.0 + ratio) : 1.0 / (1.0 + ratio)};
    bar.bar_to = second.child;
    mimicking.rolls = mimicked.rolls = true;
  }
}

} // namespace torqued::urdf
