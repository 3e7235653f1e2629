#include "torque/reactions.h"

namespace torqued
{

namespace
{

// the wrench that a sole needs for G w = d when the other foot carries w_other
Eigen::Vector3d left_to_sole(const SupportEquations& equations, int sole_row, const Eigen::Vector3d& d)
{
  // its columns of G are [1 0 0; 0 1 0; −z x 1]
  const auto G = equations.G.middleCols<3>(sole_row);
  return {d(0), d(1), d(2) - G(2, 0) * d(0) - G(2, 1) * d(1)};
}

} // namespace

AdmissibleReactions admissible_reactions(const Robot& robot, const SupportEquations& equations, const Support& support)
{
  const Eigen::Vector3d& d = equations.d;
  const int components = support.wrench_components();
  AdmissibleReactions all;
  all.w0 = WrenchVector::Zero(components);
  all.Z.resize(components, 0);
  all.unmet.setZero();

  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  if (components == 0)
  {
    all.unmet = d;
  }
  else if (leading_sole || trailing_sole)
  {
    // one foot is free, and the sole takes the rest
    const Side sole = trailing_sole ? support.trailing() : support.leading;
    const int sole_row = support.row(sole);
    const int free_row = support.row(other(sole));
    const int free = wrench_components(support.of(other(sole)));
    all.w0.segment<3>(sole_row) = left_to_sole(equations, sole_row, d);
    all.Z = Bounded<6, 3>::Zero(components, free);
    for (int k = 0; k < free; ++k)
    {
      all.Z(free_row + k, k) = 1.0;
      all.Z.col(k).segment<3>(sole_row) = left_to_sole(equations, sole_row, -equations.G.col(free_row + k));
    }
  }
  else
  {
    // points only: moments about that of the trailing foot, or of the only one
    const bool two = components == 4;
    const Side at = two ? support.trailing() : support.of(Side::left) != Contact::none ? Side::left : Side::right;
    const Eigen::Vector2d p = equations.foot(at).point(support.of(at));
    const double moment = d(2) - cross(p - equations.base(), d.head<2>());
    const Eigen::Vector2d lever =
        two ? Eigen::Vector2d(equations.foot(support.leading).point(support.of(support.leading)) - p)
            : Eigen::Vector2d::Zero();
    const int row = support.row(at);
    const int leading_row = support.row(support.leading);
    all.w0.segment<2>(row) = d.head<2>();
    if (lever.norm() < kCoincident * robot.leg_length)
    {
      all.unmet(2) = moment;
      if (two)
      {
        all.Z = Bounded<6, 3>::Zero(4, 2);
        all.Z.middleRows<2>(leading_row).setIdentity();
        all.Z.middleRows<2>(row) = -Eigen::Matrix2d::Identity();
      }
    }
    else
    {
      all.w0.segment<2>(leading_row) = moment / lever.squaredNorm() * perp(lever);
      all.w0.segment<2>(row) -= all.w0.segment<2>(leading_row);
      all.Z.resize(4, 1);
      all.Z.middleRows<2>(leading_row) = lever.normalized();
      all.Z.middleRows<2>(row) = -lever.normalized();
    }
  }

  const int size = robot.mechanism.num_theta();
  const VectorQ rest = equations.r - equations.J.transpose() * all.w0;
  all.tau0 = joint_torques(robot, rest.head(size));
  all.T.resize(robot.num_joints(), all.Z.cols());
  for (Eigen::Index k = 0; k < all.Z.cols(); ++k)
  {
    const VectorQ force = equations.J.transpose() * all.Z.col(k);
    all.T.col(k) = -joint_torques(robot, force.head(size));
  }
  return all;
}

} // namespace torqued
