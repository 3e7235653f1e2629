#include "bench/tree_peer.h"

#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/PlanarJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/WeldJoint.hpp>

namespace torqued::bench
{

namespace
{

namespace dyn = dart::dynamics;

class DartPeer : public TreePeer
{
public:
  explicit DartPeer(const Robot& robot) : TreePeer(robot), skeleton_(dyn::Skeleton::create(robot.name))
  {
    skeleton_->setGravity({0.0, 0.0, -robot.mechanism.gravity()});
    std::vector<dyn::BodyNode*> nodes;
    for (const JointTree::Body& body : tree().bodies)
      nodes.push_back(add(body, body.parent < 0 ? nullptr : nodes[static_cast<std::size_t>(body.parent)]));
  }

  std::string_view name() const override { return "DART"; }

  void compute(int number) override
  {
    skeleton_->setPositions(motion(number).q);
    skeleton_->setVelocities(motion(number).v);
    skeleton_->setAccelerations(motion(number).a);
    skeleton_->computeInverseDynamics();
  }

private:
  Eigen::VectorXd force() const override { return skeleton_->getForces(); }

  dyn::BodyNode* add(const JointTree::Body& body, dyn::BodyNode* parent)
  {
    // equal moments of inertia: only that about y matters
    const dyn::BodyNode::AspectProperties node(body.name, dyn::Inertia(body.mass, {body.com.x(), 0.0, body.com.y()},
                                                                       body.inertia * Eigen::Matrix3d::Identity()));
    dyn::Joint::Properties at(body.name);
    at.mT_ParentBodyToJoint =
        Eigen::Translation3d(body.at.x(), 0.0, body.at.y()) * Eigen::AngleAxisd(body.angle, -Eigen::Vector3d::UnitY());

    const std::vector<JointTree::Joint>& joints = body.joints;
    if (joints.empty())
      return add<dyn::WeldJoint>(parent, dyn::WeldJoint::Properties(at), node);
    if (joints.size() == 3) // a floating root, which turns about x × z = −y
      return add<dyn::PlanarJoint>(parent, {at, {joints[0].axis, joints[1].axis}}, node);
    if (joints.front().turns)
      return add<dyn::RevoluteJoint>(parent, {at, joints.front().axis}, node);
    return add<dyn::PrismaticJoint>(parent, {at, joints.front().axis}, node);
  }

  template <typename Joint>
  dyn::BodyNode* add(dyn::BodyNode* parent, const typename Joint::Properties& joint,
                     const dyn::BodyNode::AspectProperties& node)
  {
    return skeleton_->createJointAndBodyNodePair<Joint>(parent, joint, node).second;
  }

  dyn::SkeletonPtr skeleton_;
};

} // namespace

std::unique_ptr<Peer> make_dart(const Robot& robot)
{
  return std::make_unique<DartPeer>(robot);
}

} // namespace torqued::bench
