// The foot's angle is its pitch. The ankle's place gives two equations for the angles of thigh and shin:
//
//   angles         |ankle − hip| is a function of the knee's flexion alone, which falls: bisection. The direction from
//                  hip to ankle is the thigh's angle. Newton's method finds the last digits of both.
//   rates          J q̇ = ṗ
//   accelerations  J q̈ = p̈ − J̇ q̇           J: the columns of thigh and shin; all others' part is on the right
//
// Bisection, between the straight leg and the most bent one, needs no law of cosines, which a rolling knee does not
// obey, and finds the knee that bends like a human's; Newton's method alone may find the other one.

#include "motion/gait_parts.h"
#include "planar/kinematics.h"

#include <Eigen/LU>
#include <cmath>
#include <fmt/format.h>

namespace torqued
{

namespace
{

constexpr double kMostFlexion = 2.8; // rad

// The knee's flexion, within 2⁻²⁰ of its range, and the thigh's angle, by which the ankle is where it should be.
void reach(const Robot& robot, Side side, const Eigen::Vector2d& p, double t, DesiredState& state)
{
  const Mechanism& mechanism = robot.mechanism;
  const Leg leg = leg_of(robot, side);
  const Point& ankle = robot.foot(side).ankle;
  const Point& hip = robot.link(leg.thigh).origin;
  const int thigh = robot.link(leg.thigh).coordinate, shin = robot.link(leg.shin).coordinate;
  const Eigen::Vector2d target = p - position(kinematics(mechanism, state.q, state.v), hip);
  // from the hip to the ankle, the thigh upright
  const auto bent_by = [&](double flexion) -> Eigen::Vector2d
  {
    state.q(thigh) = 0.0;
    state.q(shin) = -flexion;
    const Kinematics now = kinematics(mechanism, state.q, state.v);
    return position(now, ankle) - position(now, hip);
  };
  double straight = 0.0, bent = kMostFlexion;
  const double longest = bent_by(straight).norm(), shortest = bent_by(bent).norm();
  const auto out_of_reach = [&](const char* what)
  {
    return fmt::format(
        "at {:.3f} s the {} ankle is {:.4g} m from the hip, and the leg can be {:.4g} to {:.4g} m long; {} would do", t,
        name_of(side), target.norm(), shortest, longest, what);
  };
  if (!(target.norm() < longest))
    throw LegTooShort(ExitCode::usage, out_of_reach("a lower --hip-height or a shorter --step-length"));
  if (!(target.norm() > shortest))
    throw Failure(ExitCode::usage, out_of_reach("a higher --hip-height or less --clearance"));
  for (int i = 0; i < 20; ++i)
  {
    const double middle = 0.5 * (straight + bent);
    (bent_by(middle).norm() > target.norm() ? straight : bent) = middle;
  }
  const Eigen::Vector2d found = bent_by(straight);
  state.q(thigh) = std::atan2(cross(found, target), found.dot(target));
  state.q(shin) = state.q(thigh) - straight;
}

} // namespace

Leg leg_of(const Robot& robot, Side side)
{
  const int foot = robot.foot(side).link, shin = robot.link(foot).parent;
  return {robot.link(shin).parent, shin, foot};
}

void place_leg(const Robot& robot, Side side, const FootMotion& foot, double t, DesiredState& state)
{
  const Mechanism& mechanism = robot.mechanism;
  const Leg leg = leg_of(robot, side);
  const Point& ankle = robot.foot(side).ankle;
  const int thigh = robot.link(leg.thigh).coordinate, shin = robot.link(leg.shin).coordinate;
  const int pitch = robot.link(leg.foot).coordinate;
  state.q(pitch) = foot.pitch.x;
  state.v(pitch) = foot.pitch.v;
  state.a(pitch) = foot.pitch.a;
  reach(robot, side, foot.p, t, state);

  Jacobian J(2, mechanism.num_q());
  const auto solve = [&](const Eigen::Vector2d& rest) -> Eigen::Vector2d
  {
    Eigen::Matrix2d of_leg;
    of_leg << J.col(thigh), J.col(shin);
    return of_leg.partialPivLu().solve(rest);
  };
  for (int i = 0; i < 3; ++i)
  {
    const Kinematics now = kinematics(mechanism, state.q, state.v);
    point_jacobian(mechanism, now, ankle, 0, J);
    const Eigen::Vector2d step = solve(foot.p - position(now, ankle));
    state.q(thigh) += step.x();
    state.q(shin) += step.y();
  }
  state.v(thigh) = state.v(shin) = 0.0;
  point_jacobian(mechanism, kinematics(mechanism, state.q, state.v), ankle, 0, J);
  const Eigen::Vector2d rates = solve(foot.v - J * state.v);
  state.v(thigh) = rates.x();
  state.v(shin) = rates.y();
  state.a(thigh) = state.a(shin) = 0.0;
  const Eigen::Vector2d from_rates = jacobian_rate_times_v(kinematics(mechanism, state.q, state.v), ankle);
  const Eigen::Vector2d accelerations = solve(foot.a - from_rates - J * state.a);
  state.a(thigh) = accelerations.x();
  state.a(shin) = accelerations.y();
}

} // namespace torqued
