#include "robot/files/urdf_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued::urdf
{

namespace
{

bool is_world(const Link& link)
{
  return link.name == kWorld;
}

// links below one, itself first, parents before children
std::vector<int> links_below(const Model& model, int top)
{
  std::vector<int> order = {top};
  for (std::size_t done = 0; done < order.size(); ++done)
    for (const int i : model.link(order[done]).joints)
      order.push_back(model.joint(i).child);
  return order;
}

// the one link that is no child; a world that carries nothing is none
int top_of(Model& model)
{
  if (model.links.empty())
    model.fail(1, "there is no <link>; a robot needs at least its root");
  int top = -1;
  for (int i = 0; i < static_cast<int>(model.links.size()); ++i)
  {
    Link& link = model.link(i);
    if (link.joint >= 0)
      continue;
    if (is_world(link) && link.joints.empty() && link.mass == 0.0 && model.links.size() > 1)
    {
      link.of_the_world = true;
      continue;
    }
    if (top >= 0)
      model.fail(link, fmt::format("is no joint's child, and neither is '{}'; one root carries all others",
                                   model.link(top).name));
    top = i;
  }
  if (top < 0)
    model.fail(model.links.front(),
               "there is no root: every link is the child of a joint, so their parents form a circle");
  return top;
}

void check_all_hang_on(const Model& model, int top)
{
  std::vector<bool> reached(model.links.size());
  for (const int i : links_below(model, top))
    reached[static_cast<std::size_t>(i)] = true;
  for (std::size_t i = 0; i < reached.size(); ++i)
  {
    if (!reached[i] && !model.links[i].of_the_world)
      model.fail(model.links[i], "does not hang on the root: its parents form a circle");
    if (is_world(model.links[i]) && model.links[i].joint >= 0)
      model.fail(model.links[i], "is the child of a joint; \"world\" is what a root stands on");
  }
}

// Steps from link to link, off the top, until the root is found.
class RootFinder
{
public:
  RootFinder(Model& model, int top) : model_(model), top_(top) {}

  void find()
  {
    if (is_world(model_.link(top_)) && model_.link(top_).mass != 0.0)
      model_.fail(model_.link(top_), "has <inertial> with a mass; the world has no mass");
    if (!step_to_floating())
      step_off_world();
    for (const int i : used_)
      take_off(i);
    model_.link(model_.root).R = R_;
    note_what_carries();
  }

private:
  // what a link carries, but for what stands around: links that do not move against it, and have no mass or stand still
  std::vector<int> carried(int index, bool stands_still)
  {
    std::vector<int> joints;
    for (const int i : model_.link(index).joints)
    {
      const auto below = links_below(model_, model_.joint(i).child);
      const bool moves = model_.joint(i).type != Joint::Type::fixed ||
                         std::ranges::any_of(below,
                                             [&](int link) {
                                               return link != model_.joint(i).child &&
                                                      model_.joint(model_.link(link).joint).type != Joint::Type::fixed;
                                             });
      const bool weighs = std::ranges::any_of(below, [&](int link) { return model_.link(link).mass != 0.0; });
      if (moves || (weighs && !stands_still))
        joints.push_back(i);
    }
    return joints;
  }

  // Follows what lets a root float: a floating or a planar joint, or two prismatic ones in the plane and one about y,
  // all on links without mass. If there is no such thing, nothing has changed.
  bool step_to_floating()
  {
    std::vector<Eigen::Vector3d> slides;
    bool turns = false;
    std::vector<int> used;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    int at = top_;
    while (slides.size() < 2 || !turns)
    {
      const Link& link = model_.link(at);
      const bool moves = turns || !slides.empty();
      const std::vector<int> next = carried(at, !moves);
      if (!moves && link.mass != 0.0)
        return false;
      if (next.size() != 1)
        return false;
      if (moves && (link.mass != 0.0 || (turns && !link.inertia.isZero(0.0))))
      {
        if (slides.empty())
          return false;
        model_.fail(
            link,
            fmt::format(
                "moves with {} between the world and the root, and has {}; a root floats only on links without mass",
                name_of(model_.joint(link.joint)),
                link.mass != 0.0 ? fmt::format("a mass of {} kg", link.mass) : "an inertia"));
      }
      const Joint& joint = model_.joint(next.front());
      if (joint.mimic)
        return false;
      R = level(model_, R * joint.origin.R, name_of(joint));
      at = joint.child;
      used.push_back(next.front());
      if (joint.type == Joint::Type::floating || joint.type == Joint::Type::planar)
      {
        if (moves)
          return false;
        if (joint.type == Joint::Type::planar)
          check_plane(joint, R);
        break;
      }
      if (joint.type == Joint::Type::fixed)
        continue;
      const Eigen::Vector3d axis = axis_of(model_, joint, R);
      if (joint.type == Joint::Type::revolute)
      {
        if (turns || !is_about_y(model_, joint, axis))
          return false;
        turns = true;
        continue;
      }
      const bool in_plane = std::abs(axis.y()) <= kRoundedAngle;
      if (!in_plane || (!slides.empty() && slides.front().cross(axis).norm() <= kRoundedAngle))
        return false;
      slides.push_back(axis);
    }
    model_.root = at;
    used_ = used;
    R_ = R;
    return true;
  }

  void check_plane(const Joint& joint, const Eigen::Matrix3d& R)
  {
    if (const Eigen::Vector3d axis = axis_of(model_, joint, R); !is_about_y(model_, joint, axis))
      model_.fail(joint,
                  fmt::format("axis: found {}, the normal of its plane; expected y: the robot moves in the x-z plane",
                              shown(*joint.axis)));
  }

  // the root is the top, or what is fixed to the world
  void step_off_world()
  {
    model_.root = top_;
    const Link& top = model_.link(top_);
    if (!is_world(top))
      return;
    std::vector<int> joints = carried(top_, true);
    if (joints.empty() && top.joints.size() == 1)
      joints = top.joints;
    if (joints.size() != 1)
      model_.fail(
          top, fmt::format("has {} children that carry something; the world has one, the robot's root", joints.size()));
    const Joint& joint = model_.joint(joints.front());
    if (joint.type != Joint::Type::fixed)
      model_.fail(joint, "its parent is the world; a root there is floating, planar or fixed, or two joints slide in "
                         "the x-z plane and one turns about y, with no mass between them, and carry it");
    model_.root = joint.child;
    model_.root_is_fixed = true;
    R_ = level(model_, joint.origin.R, name_of(joint));
    used_ = joints;
  }

  // a joint that carries the root, the link before it, and what stands around there
  void take_off(int index)
  {
    model_.joint(index).carries_root = true;
    Link& before = model_.link(model_.joint(index).parent);
    before.of_the_world = true;
    for (const int other : before.joints)
      if (other != index)
      {
        for (const int link : links_below(model_, model_.joint(other).child))
          model_.link(link).of_the_world = true;
        model_.passed_over.insert(fmt::format("link '{}'", model_.link(model_.joint(other).child).name));
      }
  }

  void note_what_carries()
  {
    std::vector<std::string> names;
    for (const int i : used_)
      if (const Joint& joint = model_.joint(i); joint.has_range || !joint.unread.empty())
        if (joint.type != Joint::Type::fixed)
          names.push_back(fmt::format("'{}'", joint.name));
    if (!names.empty())
      model_.notes.push_back(
          fmt::format("{}:{}: joint{} {} let{} the root, '{}', float; limits and dynamics there are not read",
                      model_.file, model_.joint(used_.front()).line, names.size() == 1 ? "" : "s",
                      fmt::join(names, ", "), names.size() == 1 ? "s" : "", model_.link(model_.root).name));
  }

  Model& model_;
  const int top_;
  std::vector<int> used_; // joints, from the top to the root
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Identity();
};

} // namespace

void find_root(Model& model)
{
  const int top = top_of(model);
  check_all_hang_on(model, top);
  RootFinder(model, top).find();
  for (const int i : links_below(model, model.root))
    model.order.push_back(i);
  for (const Joint& joint : model.joints)
    if (!joint.carries_root && !model.link(joint.child).of_the_world &&
        (joint.type == Joint::Type::floating || joint.type == Joint::Type::planar))
      model.fail(joint, fmt::format("is {}; only a root floats, on the world or on links without mass",
                                    joint.type == Joint::Type::floating ? "floating" : "planar"));
}

} // namespace torqued::urdf
