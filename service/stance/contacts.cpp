#include "stance/contacts.h"

namespace torqued
{

namespace
{

// the foot whose contact point rests and so places the base
Side resting_side(const Robot& robot, const Support& support)
{
  for (const Side side : kSides)
    if (robot.is_root(robot.foot(side)) || support.of(other(side)) == Contact::none)
      return side;
  const bool left_sole = support.of(Side::left) == Contact::sole;
  const bool right_sole = support.of(Side::right) == Contact::sole;
  return left_sole == right_sole ? support.trailing() : left_sole ? Side::left : Side::right;
}

} // namespace

const Point& contact_point(const Foot& foot, Contact contact)
{
  return contact == Contact::heel ? foot.heel : contact == Contact::toe ? foot.toe : foot.ankle;
}

Eigen::Vector2d heading(const Link& link, const Kinematics& now)
{
  return rotate(link.heading, now.e.col(link.direction));
}

std::optional<Refusal> check_contacts(const Robot& robot, const Support& support)
{
  for (const Side side : kSides)
  {
    const Foot& foot = robot.foot(side);
    const Contact contact = support.of(side);
    const int number = static_cast<int>(contact);
    if (robot.is_root(foot) && contact != Contact::sole)
      return Refusal(Reason::not_supported,
                     "{}_contact is {}, but the {} foot is fixed to the world: it stands as SOLE (2)", name_of(side),
                     number, name_of(side));
    if (contact != Contact::none && !foot.exists())
      return Refusal(Reason::not_supported, "{}_contact is {}, but {} has no foot there: it is NONE (0)", name_of(side),
                     number, robot.name);
    if (contact == Contact::sole && !foot.has_extent() && !robot.is_root(foot))
      return Refusal(Reason::not_supported,
                     "{}_contact is SOLE (2), but the {} foot has no extent: it can stand as HEEL (1)", name_of(side),
                     name_of(side));
  }
  return {};
}

ContactRows contact_rows(const Robot& robot, const Kinematics& now, const Support& support)
{
  const Mechanism& mechanism = robot.mechanism;
  ContactRows rows{Jacobian(support.wrench_components(), mechanism.num_q()),
                   WrenchVector::Zero(support.wrench_components())};
  int row = 0;
  for (const Side side : kSides)
  {
    const Foot& foot = robot.foot(side);
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    point_jacobian(mechanism, now, contact_point(foot, contact), row, rows.J);
    rows.Jdot_v.segment<2>(row) = jacobian_rate_times_v(now, contact_point(foot, contact));
    if (contact == Contact::sole)
    {
      rows.J.row(row + 2).setZero();
      rows.J.row(row + 2).head(mechanism.num_theta()) = mechanism.W().row(robot.link(foot.link).direction);
    }
    row += wrench_components(contact);
  }
  return rows;
}

Jacobian contact_rows_rate(const Robot& robot, const Kinematics& now, const Support& support)
{
  Jacobian Jdot = Jacobian::Zero(support.wrench_components(), robot.mechanism.num_q());
  for (const Side side : kSides)
    if (const Contact contact = support.of(side); contact != Contact::none)
      point_jacobian_rate(robot.mechanism, now, contact_point(robot.foot(side), contact), support.row(side), Jdot);
  return Jdot;
}

void stand(const Robot& robot, const Kinematics& now, const VectorD& direction_acceleration, const Support& support,
           StandingFeet& feet)
{
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    const Foot& foot = robot.foot(side);
    StandingFoot& standing = feet[side];

    // Σ r, Σ φ̇ r, Σ φ̇² r, Σ φ̈ r of the arms, and of the way from ankle to heel or toe
    Eigen::Vector2d p = Eigen::Vector2d::Zero(), v = p, centripetal = p, a = p;
    const auto add = [&](int direction, const Eigen::Vector2d& r)
    {
      const double rate = now.rate(direction);
      p += r;
      v += rate * r;
      centripetal += rate * rate * r;
      a += direction_acceleration(direction) * r;
    };
    standing.arms.resize(2, static_cast<Eigen::Index>(foot.ankle.size()));
    int i = 0;
    for (const Arm& arm : foot.ankle)
    {
      const Eigen::Vector2d r = rotate(now.e.col(arm.direction), arm.r);
      standing.arms.col(i++) = r;
      add(arm.direction, r);
    }
    standing.ankle = p;
    if (contact != Contact::sole)
      add(foot.direction, rotate(now.e.col(foot.direction), contact == Contact::heel ? foot.to_heel : foot.to_toe));
    standing.point = p;
    standing.velocity = perp(v);
    standing.acceleration = perp(a) - centripetal;
  }
}

Result<BaseMotion> base_motion(const Robot& robot, const DesiredState& desired, const VectorD& direction_acceleration,
                               Kinematics& now, StandingFeet& feet)
{
  const Support& support = desired.support;
  if (const auto refusal = check_contacts(robot, support))
    return *refusal;
  if (desired.base_given && robot.fixed_root())
    return Refusal(Reason::not_supported,
                   "base is GIVEN (1), but the root of {} is fixed to the world: it is FROM_CONTACT (0)", robot.name);
  if (!desired.base_given && support.wrench_components() == 0)
    return Refusal(Reason::not_supported,
                   "base is FROM_CONTACT (0), but neither foot has contact: in flight the base must "
                   "be GIVEN (1)");
  stand(robot, now, direction_acceleration, support, feet);
  if (desired.base_given)
    return BaseMotion{desired.v.tail<2>(), desired.a.tail<2>()};

  // the resting point at x = 0, the point of the sole below the ankle, or the contact point, at z = 0, and at rest
  const Side side = resting_side(robot, support);
  const StandingFoot& standing = feet[side];
  const Foot& foot = robot.foot(side);
  const double height =
      support.of(side) == Contact::sole ? foot.ankle_height() * heading(robot.link(foot.link), now).x() : 0.0;
  now.base = Eigen::Vector2d(0.0, height) - standing.point;
  return BaseMotion{-standing.velocity, -standing.acceleration};
}

Result<Motion> complete_motion(const Robot& robot, const DesiredState& desired)
{
  Motion motion{kinematics(robot.mechanism, desired.q, desired.v), desired.v, desired.a};
  StandingFeet feet;
  const Result<BaseMotion> base =
      base_motion(robot, desired, robot.mechanism.of_directions(desired.a), motion.now, feet);
  if (const Refusal* refusal = std::get_if<Refusal>(&base))
    return *refusal;
  motion.v.tail<2>() = std::get<BaseMotion>(base).velocity;
  motion.a.tail<2>() = std::get<BaseMotion>(base).acceleration;
  return motion;
}

} // namespace torqued
