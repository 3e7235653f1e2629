#include "questions/equation_of_motion.h"

#include "planar/dynamics.h"

namespace torqued
{

namespace
{

// S of q̇ = S q̇': from the n coordinates that are asked for to (θ, base point); those that a fixed root holds are left
// out
MatrixQ selection(const Robot& robot, Coordinates coordinates)
{
  const int size = robot.mechanism.num_theta();
  const int names = robot.num_coordinates();
  const int n = names + (robot.fixed_root() ? 0 : 2);
  MatrixQ S = MatrixQ::Zero(robot.mechanism.num_q(), n);
  if (coordinates == Coordinates::absolute)
    S.topLeftCorner(names, names).setIdentity();
  else
    S.topLeftCorner(size, names) = robot.A_inverse.leftCols(names);
  if (!robot.fixed_root())
    S.bottomRightCorner<2, 2>().setIdentity();
  return S;
}

} // namespace

EquationOfMotion equation_of_motion(const Robot& robot, const Motion& motion, const Support& support,
                                    Coordinates coordinates)
{
  const auto& [now, v, a] = motion;
  const MatrixQ S = selection(robot, coordinates);
  EquationOfMotion equation;
  equation.n = static_cast<int>(S.cols());

  // A is constant, so that C transforms like M
  const MatrixQ C = coriolis_matrix(robot.mechanism, now);
  equation.M = S.transpose() * mass_matrix(robot.mechanism, now) * S;
  equation.C = S.transpose() * C * S;
  equation.h = S.transpose() * (C * v);
  equation.g = S.transpose() * gravity_force(robot.mechanism, now);
  equation.B = S.transpose() * input_matrix(robot);
  equation.generalized_force = S.transpose() * inverse_dynamics(robot.mechanism, now, a);

  // a fixed root's own contact asks nothing of a motion
  Support free = support;
  for (const Side side : kSides)
    if (robot.is_root(robot.foot(side)))
      free.contact[side] = Contact::none;
  const ContactRows contact = contact_rows(robot, now, free);
  equation.J = contact.J * S;
  equation.Jdot = contact_rows_rate(robot, now, free) * S;
  equation.Jdot_v = contact.Jdot_v;
  return equation;
}

VectorQ in_coordinates(const Robot& robot, const VectorQ& force, Coordinates coordinates)
{
  return selection(robot, coordinates).transpose() * force;
}

} // namespace torqued
