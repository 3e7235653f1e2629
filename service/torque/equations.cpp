#include "torque/equations.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

const Point& contact_point(const Foot& foot, Contact contact)
{
  return contact == Contact::heel ? foot.heel : contact == Contact::toe ? foot.toe : foot.ankle;
}

// the foot whose contact point rests and so places the base
Side resting_side(const Support& support)
{
  if (support.of(Side::left) == Contact::none)
    return Side::right;
  if (support.of(Side::right) == Contact::none)
    return Side::left;
  const bool left_sole = support.of(Side::left) == Contact::sole;
  const bool right_sole = support.of(Side::right) == Contact::sole;
  return left_sole == right_sole ? support.trailing() : left_sole ? Side::left : Side::right;
}

// (cos, sin) of a link's angle against the world
Eigen::Vector2d heading(const Link& link, const Kinematics& now)
{
  return rotate({std::cos(link.direction_angle), std::sin(link.direction_angle)}, now.e.col(link.direction));
}

// a motion of a floating robot whose base is fixed by its contact
void place_base(const Robot& robot, const Support& support, Kinematics& now, VectorQ& v, VectorQ& a)
{
  const Mechanism& mechanism = robot.mechanism;
  const Side side = resting_side(support);
  const Foot& foot = robot.foot(side);
  const Contact contact = support.of(side);
  const Point& point = contact_point(foot, contact);

  // the resting point at x = 0, the point of the sole below the ankle, or the contact point, at z = 0
  now.base = -from_base(now, point);
  if (contact == Contact::sole)
    now.base.y() += foot.ankle_height() * heading(robot.links[static_cast<std::size_t>(foot.link)], now).x();

  // 0 = J v and 0 = J a + J̇ v at the resting point
  Jacobian J(2, mechanism.num_coordinates());
  point_jacobian(mechanism, now, point, 0, J);
  const int angles = mechanism.num_angles();
  v.tail<2>() = -J.leftCols(angles) * v.head(angles);
  a.tail<2>() = -J.leftCols(angles) * a.head(angles) - jacobian_rate_times_v(now, point);
}

} // namespace

Result<SupportEquations> support_equations(const Robot& robot, const DesiredState& desired)
{
  const Mechanism& mechanism = robot.mechanism;
  const Support& support = desired.support;
  for (const Side side : kSides)
    if (support.of(side) == Contact::sole && !robot.foot(side).has_sole())
      return Refusal(Reason::not_supported,
                     "{}_contact is SOLE (2), but the {} foot has no extent: it can stand as HEEL (1)", name_of(side),
                     name_of(side));
  if (!desired.base_given && support.wrench_components() == 0)
    return Refusal(Reason::not_supported,
                   "base is FROM_CONTACT (0), but neither foot has contact: in flight the base must "
                   "be GIVEN (1)");

  VectorQ v = desired.v;
  VectorQ a = desired.a;
  Kinematics now = kinematics(mechanism, desired.q, v);
  if (!desired.base_given)
    place_base(robot, support, now, v, a);

  SupportEquations equations;
  equations.r = inverse_dynamics(mechanism, now, a);
  equations.base = now.base;
  equations.contact_speed = 0.0;
  equations.contact_residual = 0.0;
  equations.sole_tilt = 0.0;

  equations.J.resize(support.wrench_components(), mechanism.num_coordinates());
  equations.G.resize(3, support.wrench_components());
  int row = 0;
  for (const Side side : kSides)
  {
    const Foot& foot = robot.foot(side);
    const Link& link = robot.links[static_cast<std::size_t>(foot.link)];
    FootPose& pose = equations.feet[static_cast<std::size_t>(side)];
    pose = {position(now, foot.ankle), position(now, foot.heel), position(now, foot.toe), heading(link, now)};
    const Contact contact = support.of(side);
    const int rows = wrench_components(contact);
    if (rows == 0)
      continue;

    // J, and J̇ v of the contact
    const Point& point = contact_point(foot, contact);
    Eigen::Vector3d Jdot_v = Eigen::Vector3d::Zero();
    point_jacobian(mechanism, now, point, row, equations.J);
    Jdot_v.head<2>() = jacobian_rate_times_v(now, point);
    if (contact == Contact::sole)
    {
      equations.J.row(row + 2).setZero();
      equations.J.row(row + 2).head(mechanism.num_angles()) = mechanism.W().row(link.direction);
      equations.sole_tilt = std::max(equations.sole_tilt, std::abs(std::atan2(pose.e.y(), pose.e.x())));
    }

    // what should be at rest
    const auto J = equations.J.middleRows(row, rows);
    equations.contact_speed = std::max(equations.contact_speed, (J * v).cwiseAbs().maxCoeff());
    equations.contact_residual =
        std::max(equations.contact_residual, (J * a + Jdot_v.head(rows)).cwiseAbs().maxCoeff());

    // columns of G: the force itself, and its moment about the base point
    const Eigen::Vector2d lever = pose.point(contact) - now.base;
    equations.G.col(row) << 1.0, 0.0, -lever.y();
    equations.G.col(row + 1) << 0.0, 1.0, lever.x();
    if (contact == Contact::sole)
      equations.G.col(row + 2) << 0.0, 0.0, 1.0;
    row += rows;
  }

  const int angles = mechanism.num_angles();
  equations.d.head<2>() = equations.r.tail<2>();
  equations.d(2) = robot.A_inverse.col(angles - 1).dot(equations.r.head(angles));
  return equations;
}

} // namespace torqued
