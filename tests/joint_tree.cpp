#include "joint_tree.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace torqued
{

namespace
{

// What MuJoCo, above 1e-15, and DART, above 0, ask of all that moves, in place of our 0.
constexpr double kLeast = 1e-12;

// what is linear in our coordinates: row · q + offset
struct Linear
{
  Eigen::RowVectorXd row;
  double offset;

  Linear operator-(const Linear& other) const { return {row - other.row, offset - other.offset}; }
};

class Walk
{
public:
  Walk(const Robot& robot, JointTree& tree) : robot_(robot), tree_(tree)
  {
    const Link& root = robot.link(robot.root());
    if (robot.fixed_root())
      body(robot.root(), -1, {0.0, 0.0}, 0.0, {}, constant(0.0));
    else
    {
      const Linear own = coordinate(root.coordinate);
      body(robot.root(), -1, {0.0, 0.0}, 0.0,
           {joint("base_x", false, Eigen::Vector3d::UnitX(), coordinate(robot.num_coordinates())),
            joint("base_z", false, Eigen::Vector3d::UnitZ(), coordinate(robot.num_coordinates() + 1)),
            hinge(root.name, own)},
           own);
    }
    const auto n = static_cast<Eigen::Index>(values_.size());
    tree.T.resize(n, size());
    tree.offset.resize(n);
    for (Eigen::Index i = 0; i < n; ++i)
    {
      tree.T.row(i) = values_[static_cast<std::size_t>(i)].row;
      tree.offset(i) = values_[static_cast<std::size_t>(i)].offset;
    }
  }

private:
  int size() const { return robot_.num_coordinates() + (robot_.fixed_root() ? 0 : 2); }
  Linear coordinate(int index) const { return {Eigen::RowVectorXd::Unit(size(), index), 0.0}; }
  Linear constant(double value) const { return {Eigen::RowVectorXd::Zero(size()), value}; }

  JointTree::Joint joint(const std::string& name, bool turns, const Eigen::Vector3d& axis, const Linear& value)
  {
    values_.push_back(value);
    return {name, turns, axis};
  }
  JointTree::Joint hinge(const std::string& name, const Linear& angle)
  {
    return joint(name, true, -Eigen::Vector3d::UnitY(), angle);
  }

  // a link, and all that hangs on it; phi: its angle against the world
  void body(int index, int parent, const Eigen::Vector2d& at, double angle, std::vector<JointTree::Joint> joints,
            const Linear& phi)
  {
    const Link& link = robot_.link(index);
    const int number = static_cast<int>(tree_.bodies.size());
    tree_.bodies.push_back({link.name, index, parent, at, angle, std::move(joints), std::max(link.mass, kLeast),
                            link.com, std::max(link.inertia, kLeast)});
    for (const int child : robot_.order)
      if (robot_.link(child).parent == index)
        hang(child, number, phi);
  }

  // parent: its body; phi: the parent's angle against the world
  void hang(int index, int parent, const Linear& phi)
  {
    const Link& link = robot_.link(index);
    switch (link.joint)
    {
    case JointKind::floating: break;
    case JointKind::revolute:
    {
      const Linear own = coordinate(link.coordinate);
      return body(index, parent, link.at, 0.0, {hinge(link.name, own - phi)}, own);
    }
    case JointKind::rolling:
    {
      const Linear own = coordinate(link.coordinate);
      const double r_p = link.parent_radius;
      const double r_c = link.child_radius;
      const Linear gamma{(r_p * phi.row + r_c * own.row) / (r_p + r_c),
                         (r_p * phi.offset + r_c * own.offset) / (r_p + r_c) + link.angle};
      const std::string name = link.name + "_bar";
      const int bar = static_cast<int>(tree_.bodies.size());
      tree_.bodies.push_back(
          {name, -1, parent, link.at, 0.0, {hinge(name, gamma - phi)}, kLeast, Eigen::Vector2d::Zero(), kLeast});
      return body(index, bar, {0.0, -(r_p + r_c)}, 0.0, {hinge(link.name, own - gamma)}, own);
    }
    case JointKind::parallel:
      return body(index, parent, link.at, 0.0, {hinge(link.name, constant(link.angle) - phi)}, constant(link.angle));
    case JointKind::slide:
      return body(index, parent, link.at, 0.0,
                  {joint(link.name, false, Eigen::Vector3d::UnitY(), coordinate(link.coordinate))}, phi);
    case JointKind::fixed:
      return body(index, parent, link.at, link.angle, {}, Linear{phi.row, phi.offset + link.angle});
    }
    throw std::invalid_argument("a joint that no engine was told of");
  }

  const Robot& robot_;
  JointTree& tree_;
  std::vector<Linear> values_;
};

} // namespace

JointTree::JointTree(const Robot& robot)
{
  Walk(robot, *this);
}

} // namespace torqued
