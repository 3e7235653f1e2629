#include "torque/trunk_wrench.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>

namespace torqued
{

namespace
{

// An internal wrench that needs less torque than this, over the most that one of its size can need, needs none.
constexpr double kIndependent = 1e-9;

// row (f_x, f_z, m) of a wrench's moment about the point at r from where m is taken
Eigen::RowVector3d moment_about(const Eigen::Vector2d& r)
{
  return {r.y(), -r.x(), 1.0};
}

// the same wrench about the point at r
Eigen::Matrix3d transport(const Eigen::Vector2d& r)
{
  Eigen::Matrix3d U = Eigen::Matrix3d::Identity();
  U.row(2) = moment_about(r);
  return U;
}

// The trunk, the legs and the feet; wrenches about the trunk's origin.
struct Legs
{
  Eigen::Vector2d origin;              // of the trunk's frame, m
  Eigen::Vector3d trunk;               // f*
  std::array<Eigen::Vector3d, 2> rate; // n of each leg, indexed by Side

  const Eigen::Vector3d& leg(Side side) const { return rate[static_cast<std::size_t>(side)]; }
};

Legs legs_of(const Robot& robot, const SupportEquations& equations)
{
  const Kinematics& now = equations.now;
  const VectorD& turning = equations.turn;
  const Eigen::Vector2d& base_acceleration = equations.base_acceleration;
  Legs legs{position(now, robot.link(robot.trunk).origin), {}, {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}};
  for (std::size_t i = 0; i < robot.links.size(); ++i)
  {
    if (!robot.leg[i])
      continue;
    // rate of momentum, about the trunk's origin: the force at the link's frame, and about that frame
    const Link& link = robot.links[i];
    const double rate = now.rate(link.direction);
    const Eigen::Vector2d up =
        acceleration(now, link.origin, turning, base_acceleration) + Eigen::Vector2d(0.0, robot.mechanism.gravity());
    const Eigen::Vector2d c = rotate(heading(link, now), link.com);
    const Eigen::Vector2d force = link.mass * (up + turning(link.direction) * perp(c) - rate * rate * c);
    const double moment = (link.inertia + link.mass * c.squaredNorm()) * turning(link.direction) +
                          link.mass * cross(c, up) + cross(position(now, link.origin) - legs.origin, force);
    legs.rate[static_cast<std::size_t>(*robot.leg[i])] += Eigen::Vector3d(force.x(), force.y(), moment);
  }
  legs.trunk << equations.force(), equations.d(2) - cross(legs.origin - equations.base(), equations.force());
  legs.trunk -= legs.rate[0] + legs.rate[1];
  return legs;
}

// w of what the trailing leg carries
WrenchVector on_the_ground(const SupportEquations& equations, const Support& support, const Legs& legs,
                           const Eigen::Vector3d& f_T1)
{
  WrenchVector w(support.wrench_components());
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    const Eigen::Vector3d carried = side == support.leading ? Eigen::Vector3d(legs.trunk - f_T1) : f_T1;
    const Eigen::Vector2d r = equations.foot(side).point(contact) - legs.origin;
    const int components = wrench_components(contact);
    w.segment(support.row(side), components) = (transport(r) * (carried + legs.leg(side))).head(components);
  }
  return w;
}

// x of procedure 3: f_T1 by which one foot stands as linear_transition() has it
Result<Eigen::Vector3d> tracked(const Robot& robot, const SupportEquations& equations, const Support& support,
                                const LinearTransition& settings, const Legs& legs)
{
  const Result<Reactions> shared = linear_transition(robot, equations, support, settings);
  if (const Refusal* refusal = std::get_if<Refusal>(&shared))
    return *refusal;

  const Side trailing = support.trailing();
  const bool rolls_off = support.of(trailing) != Contact::sole && support.of(support.leading) == Contact::sole;
  const Side passive = rolls_off ? trailing : support.leading;
  const int components = wrench_components(support.of(passive));
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  y.head(components) = std::get<Reactions>(shared).w.segment(support.row(passive), components);

  // y about its point is f_T + n about the trunk's origin, transported; back by the opposite way
  const Eigen::Vector2d r = equations.foot(passive).point(support.of(passive)) - legs.origin;
  const Eigen::Vector3d f_T = transport(-r) * y - legs.leg(passive);
  return passive == trailing ? f_T : Eigen::Vector3d(legs.trunk - f_T);
}

} // namespace

Result<CarriedTrunk> least_torque(const Robot& robot, const SupportEquations& equations, const Support& support,
                                  const InternalWrench& settings)
{
  const Legs legs = legs_of(robot, equations);
  const Kinematics& now = equations.now;
  const int size = robot.mechanism.num_theta();

  const double apart = (equations.foot(Side::left).point(support.of(Side::left)) -
                        equations.foot(Side::right).point(support.of(Side::right)))
                           .norm();
  if (support.redundancy() == 1 && apart < kCoincident * robot.leg_length)
    return Refusal(Reason::numerical,
                   "the contact points of both feet are {:.3g} m apart; with less than {:.3g} m the moments about them "
                   "are one condition, not two",
                   apart, kCoincident * robot.leg_length);

  // B1 and b1 from the wrenches about both ankles; a1 and a2 from the moments about heels and toes
  Bounded<kMaxJoints, 3> B1 = Bounded<kMaxJoints, 3>::Zero(robot.num_joints(), 3);
  VectorJ b1 = joint_torques(robot, equations.r);
  Bounded<3, 2> a1(3, 0);
  BoundedVector<2> a2(0);
  for (const Side side : kSides)
  {
    // what this leg carries is ± η and a share of f*
    const double sign = side == support.leading ? -1.0 : 1.0;
    const double share = side == support.leading ? 1.0 - settings.sigma : settings.sigma;
    const Eigen::Vector3d known = share * legs.trunk + legs.leg(side);

    const Foot& foot = robot.foot(side);
    const Eigen::Matrix3d U = transport(equations.foot(side).ankle - legs.origin);
    Jacobian J(2, robot.mechanism.num_q());
    point_jacobian(robot.mechanism, now, foot.ankle, 0, J);
    for (int k = 0; k < 3; ++k)
    {
      VectorQ force = J.transpose() * U.col(k).head<2>();
      force.head(size) += U(2, k) * robot.mechanism.W().row(robot.link(foot.link).direction).transpose();
      const VectorJ column = joint_torques(robot, force);
      B1.col(k) -= sign * column;
      b1 -= known(k) * column;
    }

    if (const Contact contact = support.of(side); contact != Contact::sole)
    {
      const Eigen::RowVector3d moment = moment_about(equations.foot(side).point(contact) - legs.origin);
      const Eigen::Index rows = a2.size();
      a1.conservativeResize(3, rows + 1);
      a2.conservativeResize(rows + 1);
      a1.col(rows) = sign * moment.transpose();
      a2(rows) = moment * known;
    }
  }

  // moments in N × leg length, so that the columns compare; W = L Lᵀ goes into B1 and b1
  const Eigen::Vector3d unit(1.0, 1.0, robot.leg_length);
  B1 = B1 * unit.asDiagonal();
  a1 = unit.asDiagonal() * a1;
  if (settings.weights.size() > 0)
  {
    const Eigen::LLT<JointWeights> W(settings.weights);
    B1 = W.matrixU() * B1;
    b1 = W.matrixU() * b1;
  }

  // (67) without P, which needs B1 to have full rank even where the moments at heel and toe leave no use for it: with
  // a1 = Y R and N what is orthogonal to it, η = −Y R⁻ᵀ a2 + N z meets them for every z
  const Eigen::Index conditions = a2.size();
  Eigen::Matrix3d YN = Eigen::Matrix3d::Identity();
  Eigen::Vector3d eta = Eigen::Vector3d::Zero();
  if (conditions > 0)
  {
    const Eigen::HouseholderQR<Bounded<3, 2>> QR(a1);
    YN = QR.householderQ();
    const Bounded<2, 2> R = QR.matrixQR().topRows(conditions);
    const BoundedVector<2> along = R.triangularView<Eigen::Upper>().transpose().solve(a2);
    eta = -YN.leftCols(conditions) * along;
  }
  const Bounded<3, 3> N = YN.rightCols(3 - conditions);
  const Bounded<kMaxJoints, 3> B1N = B1 * N;
  const Eigen::ColPivHouseholderQR<Bounded<kMaxJoints, 3>> QR(B1N);
  const bool determined = B1N.rows() >= B1N.cols() && std::abs(QR.matrixR()(B1N.cols() - 1, B1N.cols() - 1)) >
                                                          kIndependent * B1.cwiseAbs().maxCoeff();
  if (!determined)
    return Refusal(Reason::numerical,
                   "an internal wrench between the feet needs no torque here, as when both legs are straight, parallel "
                   "and at one place, so that the least torque does not determine the ground reactions");
  const VectorJ rest = b1 + B1 * eta;
  const BoundedVector<3> z = QR.solve(rest);
  eta = unit.cwiseProduct(Eigen::Vector3d(eta - N * z));
  return CarriedTrunk{
      legs.trunk, eta, settings.sigma, {on_the_ground(equations, support, legs, settings.sigma * legs.trunk + eta)}};
}

Result<CarriedTrunk> tracked_reaction(const Robot& robot, const SupportEquations& equations, const Support& support,
                                      const LinearTransition& settings)
{
  const Legs legs = legs_of(robot, equations);
  const Result<Eigen::Vector3d> x = tracked(robot, equations, support, settings, legs);
  if (const Refusal* refusal = std::get_if<Refusal>(&x))
    return *refusal;
  const Eigen::Vector3d& f_T1 = std::get<Eigen::Vector3d>(x);
  return CarriedTrunk{legs.trunk, f_T1, 0.0, {on_the_ground(equations, support, legs, f_T1)}};
}

Result<CarriedTrunk> tracked_internal(const Robot& robot, const SupportEquations& equations, const Support& support,
                                      const LinearTransition& settings)
{
  const Legs legs = legs_of(robot, equations);
  const Result<Eigen::Vector3d> x = tracked(robot, equations, support, settings, legs);
  if (const Refusal* refusal = std::get_if<Refusal>(&x))
    return *refusal;

  // B2 cancels: η + σ f* = x with the least |η|² + σ²
  const Eigen::Vector3d& f = legs.trunk;
  const double unclamped = f.dot(std::get<Eigen::Vector3d>(x)) / (1.0 + f.squaredNorm());
  const double sigma = std::clamp(unclamped, 0.0, 1.0);
  const Eigen::Vector3d eta = std::get<Eigen::Vector3d>(x) - sigma * f;
  CarriedTrunk carried{f, eta, sigma, {on_the_ground(equations, support, legs, eta + sigma * f)}};
  carried.reactions.clamped = sigma != unclamped;
  return carried;
}

} // namespace torqued
