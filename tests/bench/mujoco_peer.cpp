#include "bench/tree_peer.h"
#include "mujoco_model.h"

namespace torqued::bench
{

namespace
{

class MujocoPeer : public TreePeer
{
public:
  explicit MujocoPeer(const Robot& robot) : TreePeer(robot), model_(robot, {}) {}

  std::string_view name() const override { return "MuJoCo"; }
  void compute(int number) override { model_.inverse(motion(number)); }

private:
  Eigen::VectorXd force() const override
  {
    return Eigen::Map<const Eigen::VectorXd>(model_.data().qfrc_inverse, model_.model().nv);
  }

  MujocoModel model_;
};

} // namespace

std::unique_ptr<Peer> make_mujoco(const Robot& robot)
{
  return std::make_unique<MujocoPeer>(robot);
}

} // namespace torqued::bench
