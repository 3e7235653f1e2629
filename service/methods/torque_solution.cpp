#include "methods/torque_solution.h"

#include <cmath>

namespace torqued
{

namespace
{

// each foot's wrench about its ankle
PerSide<Wrench> about_ankles(const SupportEquations& equations, const Support& support, const WrenchVector& w)
{
  PerSide<Wrench> ground{};
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    const StandingFoot& foot = equations.standing[side];
    const int row = support.row(side);
    const double moment = contact == Contact::sole ? w(row + 2) : cross(foot.point - foot.ankle, w.segment<2>(row));
    ground[side] = {w(row), w(row + 1), moment};
  }
  return ground;
}

// Refuses a motion that no reaction can serve.
std::optional<Refusal> check_admissible(const Robot& robot, const Support& support, const AdmissibleReactions& all,
                                        double tolerance)
{
  const double force = tolerance * robot.weight();
  const double moment = force * robot.leg_length;
  const Eigen::Vector3d& unmet = all.unmet;
  if (unmet.head<2>().cwiseAbs().maxCoeff() <= force && std::abs(unmet(2)) <= moment)
    return {};
  if (support.wrench_components() == 0)
    return Refusal(Reason::under_actuated,
                   "in flight this motion would need {:.4g} N forward, {:.4g} N upward and {:.4g} N m about the base "
                   "point from the ground; a flight answered needs none",
                   unmet(0), unmet(1), unmet(2));
  if (support.redundancy() > 0)
    return Refusal(Reason::under_actuated,
                   "with both contact points at one place this motion leaves a moment of {:.4g} N m about it, which no "
                   "motor can supply; up to {:.4g} N m is answered",
                   unmet(2), moment);
  const Side side = support.of(Side::left) != Contact::none ? Side::left : Side::right;
  return Refusal(Reason::under_actuated,
                 "on the {} {} alone this motion leaves a moment of {:.4g} N m about the contact point, which no motor "
                 "can supply; up to {:.4g} N m is answered",
                 name_of(side), name_of(support.of(side)), unmet(2), moment);
}

} // namespace

TorqueSolution::TorqueSolution(const Robot& robot, const SupportEquations& equations, const Support& support,
                               Method used, const WrenchVector& reactions, bool was_clamped, bool was_relaxed)
    : method(used), clamped(was_clamped), relaxed(was_relaxed), ground(about_ankles(equations, support, reactions)),
      from_ground(supported(robot, equations, support, ground)), torque(joint_torques(robot, motor_forces(equations)))
{
  // in parts of a size that the compiler knows, because a copy of any size calls memmove; rows "single support" of
  // tools/bench
  w.resize(reactions.size());
  for (const Side side : kSides)
  {
    const int row = support.row(side), components = wrench_components(support.of(side));
    if (components > 0)
      w.segment<2>(row) = reactions.segment<2>(row);
    if (components == 3)
      w(row + 2) = reactions(row + 2);
  }
}

Result<TorqueSolution> solve_torques(const Robot& robot, const SupportEquations& equations, const Support& support,
                                     Method method, const MethodSettings& settings, double residual_tolerance)
{
  const AdmissibleReactions all = admissible_reactions(robot, equations, support);
  if (const auto refusal = check_admissible(robot, support, all, residual_tolerance))
    return *refusal;

  const Method asked = method == Method::none ? settings.method : method;
  const Method used = all.redundancy == 0 ? Method::none : asked;
  if (used == Method::none) // nothing to choose; a copy of what there is would be felt, in single support
    return Result<TorqueSolution>(std::in_place_type<TorqueSolution>, robot, equations, support, used, all.w0());
  const MethodRow& row = methods()[static_cast<std::size_t>(used) - 1];
  const Result<Reactions> chosen = row.choose({robot, equations, support, all, settings});
  if (const Refusal* refusal = std::get_if<Refusal>(&chosen))
    return *refusal;
  const Reactions& reactions = std::get<Reactions>(chosen);
  return Result<TorqueSolution>(std::in_place_type<TorqueSolution>, robot, equations, support, used, reactions.w,
                                reactions.clamped, reactions.relaxed);
}

} // namespace torqued
