/// A robot in MuJoCo.
#pragma once

#include "joint_tree.h"

#include <memory>
#include <mujoco/mujoco.h>
#include <string>

namespace torqued
{

class MujocoModel
{
public:
  /// What a model has besides links and joints.
  struct Parts
  {
    bool rotors = false; ///< the motors' inertia
    bool feet = false;   ///< sites at their points: left_ankle, left_heel, …
    bool ground =
        false; ///< z = 0, on which heels and toes stand with their friction; for robots without rolling joints
  };

  MujocoModel(const Robot& robot, const Parts& parts);

  const mjModel& model() const { return *model_; }
  mjModel& model() { return *model_; }
  mjData& data() { return *data_; }
  const mjData& data() const { return *data_; }
  const JointTree& tree() const { return tree_; }

  /// Sets the motion and computes its inverse dynamics, and what that needs.
  void inverse(const JointTree::Motion& motion);

  /// In our coordinates.
  Eigen::VectorXd ours(const mjtNum* force) const;
  Eigen::MatrixXd mass_matrix() const;

  int id(mjtObj kind, const std::string& name) const { return mj_name2id(model_.get(), kind, name.c_str()); }

private:
  struct Delete
  {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  JointTree tree_;
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
};

} // namespace torqued
