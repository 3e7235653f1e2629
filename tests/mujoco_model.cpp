#include "mujoco_model.h"

#include <cstring>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

namespace torqued
{

namespace
{

// of the motor between a link and its parent
double rotor_inertia(const Robot& robot, int link)
{
  for (const Actuator& actuator : robot.actuators)
    for (const auto& [child, parent] :
         {std::pair(actuator.on, actuator.against), std::pair(actuator.against, actuator.on)})
      if (child == link && robot.link(child).parent == parent)
        return actuator.rotor_inertia;
  return 0.0;
}

std::string feet_of(const Robot& robot, int link)
{
  std::string text;
  for (const Side side : kSides)
    if (const Foot& foot = robot.foot(side); foot.exists() && foot.link == link)
      for (const auto& [name, r] :
           {std::pair("ankle", foot.ankle_at), std::pair("heel", foot.heel_at), std::pair("toe", foot.toe_at)})
        text += fmt::format("<site name=\"{}_{}\" pos=\"{} 0 {}\"/>", name_of(side), name, r.x(), r.y());
  return text;
}

// Points that stand on the ground: spheres, because MuJoCo's points have none.
std::string standing_points(const Robot& robot, int link)
{
  constexpr double radius = 1e-3;
  std::string text;
  for (const Side side : kSides)
    if (const Foot& foot = robot.foot(side); foot.exists() && foot.link == link)
      for (const Eigen::Vector2d& r : {foot.heel_at, foot.toe_at})
        text += fmt::format("<geom type=\"sphere\" size=\"{}\" pos=\"{} 0 {}\" friction=\"{} 0 0\" contype=\"1\" "
                            "conaffinity=\"2\"/>",
                            radius, r.x(), r.y() + radius, foot.friction);
  return text;
}

// Body `index` and all that hangs on it, as MJCF. Its moments of inertia are equal: only that about y matters.
std::string body_text(const JointTree& tree, int index, const Robot& robot, const MujocoModel::Parts& parts)
{
  const JointTree::Body& body = tree.bodies[static_cast<std::size_t>(index)];
  std::string text = fmt::format("<body name=\"{}\" pos=\"{} 0 {}\" axisangle=\"0 -1 0 {}\">", body.name, body.at.x(),
                                 body.at.y(), body.angle);
  for (const JointTree::Joint& joint : body.joints)
    text += fmt::format("<joint name=\"{}\" type=\"{}\" axis=\"{} {} {}\" armature=\"{}\"/>", joint.name,
                        joint.turns ? "hinge" : "slide", joint.axis.x(), joint.axis.y(), joint.axis.z(),
                        parts.rotors ? rotor_inertia(robot, body.link) : 0.0);
  text += fmt::format("<inertial pos=\"{} 0 {}\" mass=\"{}\" diaginertia=\"{} {} {}\"/>", body.com.x(), body.com.y(),
                      body.mass, body.inertia, body.inertia, body.inertia);
  if (parts.feet)
    text += feet_of(robot, body.link);
  if (parts.ground)
    text += standing_points(robot, body.link);
  for (int child = index + 1; child < static_cast<int>(tree.bodies.size()); ++child)
    if (tree.bodies[static_cast<std::size_t>(child)].parent == index)
      text += body_text(tree, child, robot, parts);
  return text + "</body>";
}

} // namespace

MujocoModel::MujocoModel(const Robot& robot, const Parts& parts) : tree_(robot)
{
  // Without ground there are only links and joints: MuJoCo need not look for contacts and the like. A foot sinks by
  // less than 0.1 mm into the ground, and comes to rest in some milliseconds; elliptic cones do not creep.
  const std::string world =
      parts.ground ? "<option timestep=\"0.0005\" cone=\"elliptic\" impratio=\"10\"/><default><geom solref=\"0.004 1\" "
                     "solimp=\"0.95 0.99 0.001\"/></default>"
                   : "<option><flag constraint=\"disable\" contact=\"disable\" passive=\"disable\" "
                     "actuation=\"disable\" sensor=\"disable\"/></option>";
  const std::string ground =
      parts.ground ? "<geom type=\"plane\" size=\"100 100 1\" friction=\"0 0 0\" contype=\"2\" conaffinity=\"1\"/>"
                   : "";
  const std::string text =
      fmt::format("<mujoco><compiler angle=\"radian\" inertiafromgeom=\"false\"/><option gravity=\"0 0 {}\"/>{}"
                  "<worldbody>{}{}</worldbody></mujoco>",
                  -robot.mechanism.gravity(), world, ground, body_text(tree_, 0, robot, parts));

  struct Files : mjVFS
  {
    Files() { mj_defaultVFS(this); }
    ~Files() { mj_deleteVFS(this); }
  };
  const auto files = std::make_unique<Files>(); // 2 MB
  mj_makeEmptyFileVFS(files.get(), "robot.xml", static_cast<int>(text.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), "robot.xml")], text.data(), text.size());
  char error[500] = "";
  model_.reset(mj_loadXML("robot.xml", files.get(), error, sizeof error));
  if (!model_)
    throw std::invalid_argument(fmt::format("{}\n{}", error, text));
  data_.reset(mj_makeData(model_.get()));

  int row = 0;
  for (const JointTree::Body& body : tree_.bodies)
    for (const JointTree::Joint& joint : body.joints)
      if (model_->jnt_dofadr[id(mjOBJ_JOINT, joint.name)] != row++)
        throw std::invalid_argument("MuJoCo numbers joints in another order than it was told of them");
  if (model_->nv != row)
    throw std::invalid_argument("MuJoCo has other joints than it was told of");
}

void MujocoModel::inverse(const JointTree::Motion& motion)
{
  mju_copy(data_->qpos, motion.q.data(), model_->nq);
  mju_copy(data_->qvel, motion.v.data(), model_->nv);
  mju_copy(data_->qacc, motion.a.data(), model_->nv);
  mj_inverse(model_.get(), data_.get());
}

Eigen::VectorXd MujocoModel::ours(const mjtNum* force) const
{
  return tree_.ours(Eigen::Map<const Eigen::VectorXd>(force, model_->nv));
}

Eigen::MatrixXd MujocoModel::mass_matrix() const
{
  Eigen::MatrixXd M(model_->nv, model_->nv);
  mj_fullM(model_.get(), M.data(), data_->qM);
  return tree_.T.transpose() * M * tree_.T;
}

} // namespace torqued
