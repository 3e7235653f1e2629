/// The equation of motion as a linear function of the robot's inertial parameters.
///
///   Y(q, v, a) α = M a + h + g + B τ_f                                                                       (4)
///
/// Source: [Al-Shuka 2014, (4)].
#pragma once

#include "stance/contacts.h"

#include <string>
#include <vector>

namespace torqued
{

/// One of the parameters α, and what it stands for.
///
/// A link's standard parameters are its mass m, its first moments mx and mz (mass × centre of mass) and its moment of
/// inertia I, about its frame's origin. Two rules say which of them there are: links to which the file gives the same
/// numbers are copies of one link (left and right), and what is 0 is no parameter (a centre of mass on the link's
/// axis). Of what is left, not everything shows in a motion; base parameters are those sums of it that do, as many as
/// the rank of Y. A motor adds those of I, κ_c, κ_v, κ_s and κ_o that are not 0 (joint_friction.h); η_s and s
/// are no parameters, because the equation is not linear in them; a rotor that only turns with a link is part of it.
struct BaseParameter
{
  std::string name; ///< e.g. "I(left_shin, right_shin) + 0.1521 m(left_foot, right_foot)"
  double value;     ///< SI
  Mechanism unit;   ///< the robot in which the first term is 1 and all else 0; of a motor's parameter: nothing
  int joint = -1;   ///< a motor's parameter: which motor
  Actuator motor{}; ///< a motor's parameter: one in which it is 1 and all else 0
};

/// The base parameters of a robot, in the order of the columns of Y.
///
/// A parameter is left out if its column depends on those before it, at states drawn once and for all; inertias and
/// moments come before masses, and the root's mass first, so that its sum is the robot's whole mass;
/// motors come last.
std::vector<BaseParameter> base_parameters(const Robot& robot);

/// One column of Y, length num_q(). Does not allocate.
VectorQ regressor_column(const Robot& robot, const BaseParameter& parameter, const Motion& motion);

/// Y, num_q() × parameters.
Eigen::MatrixXd regressor(const Robot& robot, const std::vector<BaseParameter>& parameters, const Motion& motion);

} // namespace torqued
