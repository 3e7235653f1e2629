#include "torque/torque_method.h"

#include <cmath>

namespace torqued
{

namespace
{

// w when equations (2) leave nothing to choose
Result<WrenchVector> determined_wrench(const Robot& robot, const SupportEquations& equations, const Support& support,
                                       double tolerance)
{
  const Eigen::Vector3d& d = equations.d;
  const int components = support.wrench_components();
  WrenchVector w(components);
  if (components == 0)
  {
    const double force = d.head<2>().cwiseAbs().maxCoeff();
    if (force > tolerance * robot.weight() || std::abs(d(2)) > tolerance * robot.weight() * robot.leg_length)
      return Refusal(Reason::under_actuated,
                     "in flight this motion would need {:.4g} N forward, {:.4g} N upward and {:.4g} N m about the base "
                     "point from the ground; a flight answered needs none",
                     d(0), d(1), d(2));
    return w;
  }

  const Side side = support.of(Side::left) != Contact::none ? Side::left : Side::right;
  const Eigen::Vector2d lever = equations.foot(side).point(support.of(side)) - equations.base;
  const double moment = d(2) - cross(lever, d.head<2>());
  w.head<2>() = d.head<2>();
  if (components == 3)
    w(2) = moment;
  else if (std::abs(moment) > tolerance * robot.weight() * robot.leg_length)
    return Refusal(
        Reason::under_actuated,
        "on the {} {} alone this motion leaves a moment of {:.4g} N m about the contact point, which no motor can "
        "supply; up to {:.4g} N m is answered",
        name_of(side), name_of(support.of(side)), moment, tolerance * robot.weight() * robot.leg_length);
  return w;
}

} // namespace

std::string_view name_of(Method method)
{
  for (const NamedMethod& known : kMethods)
    if (known.method == method)
      return known.name;
  return "none";
}

Result<TorqueSolution> solve_torques(const Robot& robot, const SupportEquations& equations, const Support& support,
                                     Method method, const MethodSettings& settings, double residual_tolerance)
{
  const bool choice = support.redundancy() > 0;
  const Result<WrenchVector> chosen = choice ? linear_transition(robot, equations, support, settings.linear_transition)
                                             : determined_wrench(robot, equations, support, residual_tolerance);
  if (const Refusal* refusal = std::get_if<Refusal>(&chosen))
    return *refusal;
  const WrenchVector& w = std::get<WrenchVector>(chosen);

  TorqueSolution solution;
  solution.method = !choice ? Method::none : method == Method::none ? settings.method : method;

  // τ = B⁺ (r − Jᵀ w)
  const VectorQ rest = equations.r - equations.J.transpose() * w;
  solution.torque = joint_torques(robot, rest.head(robot.mechanism.num_theta()));
  solution.w = w;

  // each foot's wrench about its ankle
  int row = 0;
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    const FootPose& foot = equations.foot(side);
    const double moment =
        contact == Contact::sole ? w(row + 2) : cross(foot.point(contact) - foot.ankle, w.segment<2>(row));
    solution.ground[static_cast<std::size_t>(side)] = {w(row), w(row + 1), moment};
    row += wrench_components(contact);
  }
  return solution;
}

double dynamics_residual(const Robot& robot, const SupportEquations& equations, const WrenchVector& w,
                         const VectorJ& torque)
{
  VectorQ rest = equations.r - equations.J.transpose() * w;
  rest.head(robot.mechanism.num_theta()) -= joint_forces(robot, torque);
  return rest.cwiseAbs().maxCoeff();
}

} // namespace torqued
