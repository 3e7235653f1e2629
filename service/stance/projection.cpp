#include "stance/projection.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

constexpr double kExact = 1e-13;   // m, rad: rounding of positions
constexpr double kReached = 1e-10; // m, rad; and the like of rates and accelerations, relative to them

// What should be 0 of a pose, in the rows of J.
struct Gap
{
  WrenchVector phi; // m, rad
  Side worst = Side::left;
  ContactErrors errors{}; // position, height and tilt
};

Gap gap(const Robot& robot, const Kinematics& now, const Support& support, const Footholds& footholds)
{
  Gap gap{.phi = WrenchVector::Zero(support.wrench_components())};
  for (const Side side : kSides)
  {
    const Foot& foot = robot.foot(side);
    const Contact contact = support.of(side);
    if (contact == Contact::none || robot.is_root(foot))
      continue;
    auto place = gap.phi.segment<2>(support.row(side));
    const double height = contact == Contact::sole ? foot.ankle_height() : 0.0;
    place.y() = position(now, contact_point(foot, contact)).y() - height;
    if (const auto& x = footholds[side])
      place.x() = foothold(robot, now, side, contact) - *x;
    if (const double above = foot_pose(robot, now, foot).height(contact); std::abs(above) > std::abs(gap.errors.height))
    {
      gap.errors.height = above;
      gap.errors.farthest = side;
    }
    if (place.norm() > gap.errors.position)
    {
      gap.errors.position = place.norm();
      gap.worst = side;
    }
    if (contact == Contact::sole)
    {
      const Eigen::Vector2d e = heading(robot.link(foot.link), now);
      double& tilt = gap.phi(support.row(side) + 2);
      tilt = std::atan2(e.y(), e.x());
      gap.errors.tilt = std::max(gap.errors.tilt, std::abs(tilt));
    }
  }
  return gap;
}

double largest(const WrenchVector& values)
{
  return values.size() > 0 ? values.cwiseAbs().maxCoeff() : 0.0;
}

// S: metres to coordinates
VectorQ scales(const Robot& robot)
{
  VectorQ S = VectorQ::Ones(robot.mechanism.num_q());
  S.head(robot.mechanism.num_theta()).setConstant(1.0 / robot.leg_length);
  for (const Link& link : robot.links)
    if (link.type().slides())
      S(link.coordinate) = 1.0;
  return S;
}

// J and the least x, in the scales S, with J x = y.
//
// J̃ᵀ P = Q R. Of rows that depend on others only those are served: if they contradict the others, what remains is seen
// in the end. (Eigen's complete decomposition would do that, too, but takes memory.)
class ContactSpace
{
public:
  ContactSpace(const Robot& robot, const Kinematics& now, const Support& support, const VectorQ& S)
      : rows(contact_rows(robot, now, support)), S_(S)
  {
    decomposition_.setThreshold(kCoincident);
    decomposition_.compute(S_.asDiagonal() * rows.J.transpose());
  }
  VectorQ least(const WrenchVector& y) const
  {
    const Eigen::Index rank = decomposition_.rank();
    VectorQ x = VectorQ::Zero(S_.size());
    for (Eigen::Index k = 0; k < rank; ++k)
      x(k) = y(decomposition_.colsPermutation().indices()(k));
    auto served = x.head(rank);
    decomposition_.matrixQR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>().transpose().solveInPlace(served);
    x.applyOnTheLeft(decomposition_.householderQ());
    return S_.cwiseProduct(x);
  }

  const ContactRows rows;

private:
  const VectorQ& S_;
  Eigen::ColPivHouseholderQR<Bounded<kMaxCoordinates, 6>> decomposition_;
};

} // namespace

double foothold(const Robot& robot, const Kinematics& now, Side side, Contact contact)
{
  const Foot& foot = robot.foot(side);
  const double x = position(now, contact_point(foot, contact)).x();
  return contact == Contact::heel  ? x
         : contact == Contact::toe ? x - (foot.toe_x() - foot.heel_x())
                                   : x + foot.heel_x();
}

Result<Projection> project(const Robot& robot, const DesiredState& desired, const Footholds& footholds)
{
  const Result<Motion> completed = complete_motion(robot, desired);
  if (const Refusal* refusal = std::get_if<Refusal>(&completed))
    return *refusal;
  const Motion& motion = std::get<Motion>(completed);
  const Support& support = desired.support;
  Projection projection{desired, {}};
  DesiredState& state = projection.state;
  state.base_given = !robot.fixed_root();
  state.q.tail<2>() = motion.now.base;
  state.v = motion.v;
  state.a = motion.a;
  if (support.wrench_components() == 0)
    return projection;

  Kinematics now = motion.now;
  Gap left = gap(robot, now, support, footholds);
  const auto [J, Jdot_v] = contact_rows(robot, now, support);
  projection.before = left.errors;
  projection.before.speed = largest(J * state.v);
  projection.before.acceleration = largest(J * state.a + Jdot_v);
  const double near = kNearPosition * robot.leg_length;
  if (!(left.errors.position <= near && left.errors.tilt <= kNearTilt))
    return Refusal(Reason::inconsistent,
                   "the {} foot is {:.6g} m from where its contact has it, and a sole tilts by {:.6g} rad; a motion is "
                   "projected from up to {:.6g} m and {:.6g} rad",
                   name_of(left.worst), left.errors.position, left.errors.tilt, near, kNearTilt);

  // Newton's method converges in three or four steps where there is a pose to find
  const VectorQ S = scales(robot);
  for (int step = 0; step < 20 && largest(left.phi) > kExact; ++step)
  {
    state.q -= ContactSpace(robot, now, support, S).least(left.phi);
    now = kinematics(robot.mechanism, state.q, state.v);
    left = gap(robot, now, support, footholds);
  }

  // J does not depend on rates, but J̇ v does
  const ContactSpace rates(robot, now, support, S);
  state.v -= rates.least(rates.rows.J * state.v);
  now = kinematics(robot.mechanism, state.q, state.v);
  const ContactSpace space(robot, now, support, S);
  state.a -= space.least(space.rows.J * state.a + space.rows.Jdot_v);

  const double speed = largest(space.rows.J * state.v);
  const double acceleration = largest(space.rows.J * state.a + space.rows.Jdot_v);
  if (!(largest(left.phi) <= kReached && speed <= kReached * (1.0 + motion.v.cwiseAbs().maxCoeff()) &&
        acceleration <= kReached * (1.0 + motion.a.cwiseAbs().maxCoeff() + largest(space.rows.Jdot_v))))
    return Refusal(Reason::inconsistent,
                   "no motion nearby keeps both contacts: {:.3g} m or rad, {:.3g} m/s or rad/s and {:.3g} m/s^2 or "
                   "rad/s^2 remain",
                   largest(left.phi), speed, acceleration);
  return projection;
}

} // namespace torqued
