/// What all engines share: their coordinates, and ours.
#pragma once

#include "bench/peers.h"
#include "joint_tree.h"

#include <stdexcept>

namespace torqued::bench
{

class TreePeer : public Peer
{
public:
  int remember(const VectorQ& q, const VectorQ& v, const VectorQ& a) final
  {
    motions_.push_back(tree_.motion(q, v, a));
    return static_cast<int>(motions_.size()) - 1;
  }
  VectorQ generalized_force() const final { return tree_.ours(force()); }

protected:
  explicit TreePeer(const Robot& robot) : tree_(robot)
  {
    if (robot.fixed_root())
      throw std::invalid_argument(robot.name + " has a fixed root: engines are told of robots with a floating one");
  }

  const JointTree& tree() const { return tree_; }
  const JointTree::Motion& motion(int number) const { return motions_[static_cast<std::size_t>(number)]; }

private:
  /// Of the joints, as computed last.
  virtual Eigen::VectorXd force() const = 0;

  JointTree tree_;
  std::vector<JointTree::Motion> motions_;
};

} // namespace torqued::bench
