/// A robot as engines in three dimensions are told of it: a tree of rigid bodies, each with joints of its own.
///
/// Their y axis points away from us, so that a turn about −y is counter-clockwise in the picture with x to the right
/// and z up. Their joints turn a body against its parent, whatever our coordinates are: both are linear in each other.
/// The bar of a rolling joint is a body of its own, and the circles are gears that make its angle depend on the others.
/// What has no mass has the least that engines take.
#pragma once

#include "robot/robot.h"

#include <Eigen/Core>
#include <string>
#include <vector>

namespace torqued
{

struct JointTree
{
  struct Joint
  {
    std::string name;
    bool turns; ///< about the axis; else it slides along it
    Eigen::Vector3d axis;
  };

  struct Body
  {
    std::string name;
    int link;                  ///< −1: a bar
    int parent;                ///< the body's; −1: the world
    Eigen::Vector2d at;        ///< in the parent's frame, m
    double angle;              ///< against the parent's; 0 with joints, rad
    std::vector<Joint> joints; ///< one, or none; of a floating root, slides along x and z and a turn
    double mass;
    Eigen::Vector2d com;
    double inertia; ///< about the centre of mass and y
  };

  /// What an engine's joints do, in the order of its joints.
  struct Motion
  {
    Eigen::VectorXd q, v, a;
  };

  explicit JointTree(const Robot& robot);

  /// q, v, a: our coordinates, absolute; angles and slides, then a floating root's x and z.
  Motion motion(const Eigen::VectorXd& q, const Eigen::VectorXd& v, const Eigen::VectorXd& a) const
  {
    return {T * q + offset, T * v, T * a};
  }
  /// Generalized forces in our coordinates, from those of the joints.
  Eigen::VectorXd ours(const Eigen::VectorXd& force) const { return T.transpose() * force; }

  std::vector<Body> bodies; ///< depth first
  Eigen::MatrixXd T;        ///< joints, in the order of their bodies, are T q + offset
  Eigen::VectorXd offset;
};

} // namespace torqued
