#include "bench/tree_peer.h"

#include <kdl/tree.hpp>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>

namespace torqued::bench
{

namespace
{

KDL::Vector vector(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
}
KDL::Vector in_plane(const Eigen::Vector2d& r)
{
  return {r.x(), 0.0, r.y()};
}

// One segment for each joint, as KDL has it: those of a floating root's slides have no mass.
KDL::Tree tree_of(const JointTree& joints)
{
  KDL::Tree tree{std::string(kWorld)};
  for (const JointTree::Body& body : joints.bodies)
  {
    // equal moments of inertia: only that about y matters
    const KDL::RigidBodyInertia inertia(body.mass, in_plane(body.com),
                                        KDL::RotationalInertia(body.inertia, body.inertia, body.inertia));
    std::string parent =
        body.parent < 0 ? std::string(kWorld) : joints.bodies[static_cast<std::size_t>(body.parent)].name;
    KDL::Frame tip(KDL::Rotation::RotY(-body.angle), in_plane(body.at));
    const auto add = [&](const std::string& name, const KDL::Joint& joint, const KDL::RigidBodyInertia& own)
    {
      if (!tree.addSegment(KDL::Segment(name, joint, tip, own), parent))
        throw std::invalid_argument("KDL has more than one " + name);
      parent = name;
      tip = KDL::Frame::Identity();
    };
    if (body.joints.empty())
      add(body.name, KDL::Joint(body.name, KDL::Joint::Fixed), inertia);
    for (const JointTree::Joint& joint : body.joints)
    {
      const bool last = &joint == &body.joints.back();
      add(last ? body.name : joint.name,
          KDL::Joint(joint.name, tip.p, vector(joint.axis), joint.turns ? KDL::Joint::RotAxis : KDL::Joint::TransAxis),
          last ? inertia : KDL::RigidBodyInertia::Zero());
    }
  }
  return tree;
}

class KdlPeer : public TreePeer
{
public:
  explicit KdlPeer(const Robot& robot)
      : TreePeer(robot), kdl_tree_(tree_of(tree())), solver_(kdl_tree_, {0.0, 0.0, -robot.mechanism.gravity()}),
        q_(kdl_tree_.getNrOfJoints()), v_(q_), a_(q_), force_(q_)
  {
  }

  std::string_view name() const override { return "KDL"; }

  void compute(int number) override
  {
    q_.data = motion(number).q;
    v_.data = motion(number).v;
    a_.data = motion(number).a;
    if (const int error = solver_.CartToJnt(q_, v_, a_, no_forces_, force_); error < 0)
      throw std::runtime_error(solver_.strError(error));
  }

private:
  Eigen::VectorXd force() const override { return force_.data; }

  KDL::Tree kdl_tree_; // the solver refers to it
  KDL::TreeIdSolver_RNE solver_;
  KDL::JntArray q_, v_, a_, force_;
  KDL::WrenchMap no_forces_;
};

} // namespace

std::unique_ptr<Peer> make_kdl(const Robot& robot)
{
  return std::make_unique<KdlPeer>(robot);
}

} // namespace torqued::bench
