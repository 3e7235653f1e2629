/// The recursion of Newton and Euler over a robot's links: the second way to the same torques, without pair constants
/// or matrices, and the only one that tells what each joint's bearings carry.
///
/// Source: [Al-Shuka 2014, (30) to (60)]. There each leg is a manipulator that holds the trunk; here the root carries
/// whatever hangs on it, so that any robot file is computed, and (34) is written for a link with several children.
#pragma once

#include "robot/robot.h"

#include <array>
#include <vector>

namespace torqued
{

/// The dynamics of a link about its own frame, at the joint to its parent:
///
///   M V̇ + C V + g = f*                                                                                      (45)
///
/// V = (v_x, v_z, ω): velocity of the frame's origin and angular rate, V̇ the derivatives of these components; f* =
/// (f_x, f_z, moment about the origin): the net wrench of all forces but gravity. All components in the link's frame,
/// SI. With c the centre of mass:
///
///   M = m [ 1  0 −c_z ]    C = m ω [  0   −1  −c_x ]    g = m γ [ sin φ                  ]    φ: the link's angle
///         [ 0  1  c_x ]            [  1    0  −c_z ]            [ cos φ                  ]    γ: gravity, m/s²
///         [ ·  · I_o/m]            [ c_x  c_z   0  ]            [ c_x cos φ − c_z sin φ  ]
struct LinkDynamics
{
  Eigen::Matrix3d M, C;
  Eigen::Vector3d g;
};

/// heading: (cos, sin) of the link's angle; rate: ω, rad/s; gravity: m/s², downward.
LinkDynamics link_dynamics(const Link& link, const Eigen::Vector2d& heading, double rate, double gravity);

/// What the parent, through the joint, does to a link; the world to the root.
///
/// For a rolling joint the point is where the circles touch, and bar and contact act as one: along the line of the
/// centres only their sum is determined. A joint of kind parallel passes on no moment to the parent: the fixed root
/// holds it.
struct JointWrench
{
  Eigen::Vector2d at;    ///< the joint; rolling: the contact point; root: the base point. From the base point, world
                         ///< frame, m
  Eigen::Vector2d force; ///< world frame, N
  double moment;         ///< about the joint, N m
  double sideways;       ///< force out of the plane, along the sliding coordinates, N
};

struct NewtonEuler
{
  std::vector<JointWrench> joints; ///< by link. That of a floating root is the residual of the whole robot's equations
                                   ///< of Newton and Euler: 0 if motion and ground wrenches agree
  VectorJ torque;                  ///< N m, what the links need of each actuator, without rotor and friction
};

/// Runs the recursion.
///
/// q, v, a: length num_q(). ground: what the ground does to each foot, (f_x, f_z, moment about the ankle), world frame;
/// zero for a swinging foot.
NewtonEuler newton_euler(const Robot& robot, const VectorQ& q, const VectorQ& v, const VectorQ& a,
                         const std::array<Eigen::Vector3d, 2>& ground);

} // namespace torqued
