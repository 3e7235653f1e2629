#include "methods/constrained.h"

#include "methods/conditions.h"
#include "methods/method.h"
#include "methods/zmp_transition.h"
#include "planar/processors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace torqued
{

namespace
{

// H and g of ½ |A y + b|² × per_scale, the unit of y in it. A: one column for each entry of y
template <int rows, typename Columns, typename Column>
void set_objective(const Columns& A, const Column& b, const Eigen::Vector3d& unit, double per_scale,
                   QuadraticProgram& program)
{
  const int n = static_cast<int>(program.g.size());
  for (int k = 0; k < n; ++k)
  {
    const auto column = A.col(k).template head<rows>();
    const double scale = unit(k) * per_scale;
    program.g(k) = column.dot(b.template head<rows>()) * scale;
    for (int j = 0; j <= k; ++j)
      program.H(j, k) = program.H(k, j) = column.dot(A.col(j).template head<rows>()) * unit(j) * scale;
  }
}

// What the contacts ask, and what torques cost: all of the program that most samples have.
TORQUED_FOR_PROCESSORS
void add_contacts_and_torques(const Robot& robot, const SupportEquations& equations, const Support& support,
                              const AdmissibleReactions& all, const Constrained& settings,
                              const ReactionTorques& torques, const ReactionLimits* limits, const Eigen::Vector3d& unit,
                              double per_scale, Conditions& conditions, QuadraticProgram& program)
{
  conditions.add_contacts(robot, equations, support, all, {settings.windows, settings.f_min}, limits, unit);
  program.H.resize(all.redundancy, all.redundancy);
  program.g.resize(all.redundancy);
  const auto set = [&](const auto& A, const auto& b)
  {
    if (robot.num_joints() <= kJointBlock)
      set_objective<kJointBlock>(A, b, unit, per_scale, program);
    else
      set_objective<kMaxJoints>(A, b, unit, per_scale, program);
  };
  if (settings.weights.size() == 0)
    set(torques.T, torques.tau0);
  else
  {
    const SumOfSquares sum = torque_squares(robot, torques, settings.weights);
    set(sum.A, sum.b);
  }
}

// y in N and N m; 0 beyond the program's variables
Eigen::Vector3d in_units(const QuadraticProgramSolution& solution, const Eigen::Vector3d& unit)
{
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (k < solution.y.size())
      y(k) = unit(k) * solution.y(k);
  return y;
}

// range: null for the motors' own limits
bool within_limits(const Robot& robot, const ReactionTorques& torques, const TorqueRange* range,
                   const Eigen::Vector3d& y)
{
  Eigen::Matrix<double, kMaxJoints, 1> torque;
  for (int j = 0; j < robot.num_joints(); j += kJointBlock)
  {
    JointBlock sum = torques.tau0.segment<kJointBlock>(j);
    for (int k = 0; k < torques.T.cols(); ++k)
      sum += y(k) * torques.T.col(k).segment<kJointBlock>(j);
    torque.segment<kJointBlock>(j) = sum;
  }
  const double* tau = torque.data();
  if (range)
    return (torque.head(robot.num_joints()).array() <= range->most.array()).all() &&
           (torque.head(robot.num_joints()).array() >= range->least.array()).all();
  bool within = true;
  for (const Actuator& actuator : robot.actuators)
    within &= std::abs(*tau++) <= actuator.torque_limit;
  return within;
}

// adds ½ weight Σ_feet (L² |f|² + M²) of the reactions w = w0 + Z y to the objective; unit: of y
void add_reactions(const Robot& robot, const Support& support, const AdmissibleReactions& all, const WrenchVector& w0,
                   const Eigen::Vector3d& unit, double weight, QuadraticProgram& program)
{
  for (const Side side : kSides)
    for (int i = 0; i < wrench_components(support.of(side)); ++i)
    {
      const int c = support.row(side) + i;
      const double lever = i < 2 ? robot.leg_length : 1.0;
      for (int k = 0; k < all.redundancy; ++k)
      {
        const double slope = weight * lever * lever * all.rows(c, 1 + k) * unit(k);
        program.g(k) += slope * w0(c);
        for (int j = 0; j < all.redundancy; ++j)
          program.H(j, k) += slope * all.rows(c, 1 + j) * unit(j);
      }
    }
}

// whether no direction of y counts next to nothing against the others
bool tells_apart(const Bounded<3, 3>& H)
{
  // the pivots of H = L D Lᵀ, as quotients of the leading minors
  const double least = 1e-11 * H.diagonal().maxCoeff();
  const int n = static_cast<int>(H.cols());
  const double first = H(0, 0);
  if (n == 1)
    return first > least;
  const double second = H(0, 0) * H(1, 1) - H(1, 0) * H(1, 0);
  if (n == 2)
    return first > least && second > least * first;
  const double third = H(2, 2) * second - H(2, 1) * (H(0, 0) * H(2, 1) - H(2, 0) * H(1, 0)) +
                       H(2, 0) * (H(1, 0) * H(2, 1) - H(2, 0) * H(1, 1));
  return first > least && second > least * first && third > least * second;
}

// Grants the conditions what they lack at the least, rank by rank, highest priority first, each while those before it
// hold.
std::optional<Refusal> give_way(const SupportEquations& equations, bool relax, Conditions& conditions)
{
  BoundedVector<kMaxVariables> y = BoundedVector<kMaxVariables>::Zero(conditions.variables());
  for (const Rank rank : kRanks)
  {
    if (!conditions.any(rank))
      continue;
    const QuadraticProgramSolution least = least_violation(conditions.up_to(rank), y);
    if (least.status != QuadraticProgramStatus::optimal)
      return Refusal(Reason::numerical, "the least violation of the contact conditions was not found");
    y = least.y;
    const double lacking = conditions.lacking(rank, y);
    if (!relax && rank != Rank::window && lacking > 1e-9)
      return Refusal(Reason::infeasible,
                     "no ground reactions meet the conditions of {}: some lack {:.3g} (of weight, of weight x sole "
                     "length, of a torque limit); the total force is {:.4g} N forward, {:.4g} N upward, through x = "
                     "{:.4g} m",
                     rank == Rank::contact ? "the contacts" : "contacts and motors together", lacking,
                     equations.force().x(), equations.force().y(),
                     equations.moment_about_origin() / equations.force().y());
    conditions.relax(rank, y);
  }
  return {};
}

// limits: null for contacts' conditions and motors as they are. within: whether what cannot be met, windows apart, has
// no answer; else it gives way, or is refused.
Result<std::optional<Reactions>> choose(const Robot& robot, const SupportEquations& equations, const Support& support,
                                        const AdmissibleReactions& all, const Constrained& settings,
                                        const ReactionLimits* limits, bool within, bool relax)
{
  using Chosen = std::optional<Reactions>;
  const int n = all.redundancy;
  const ReactionTorques torques = reaction_torques(robot, equations, support, all);

  // units of y: N, and N m where it is a moment, the third of two soles
  Eigen::Vector3d unit = Eigen::Vector3d::Constant(robot.weight());
  if (n == 3)
    unit(2) *= robot.leg_length;
  QuadraticProgram program;
  Conditions conditions(program.rows);

  // objective, over its value for a torque of weight × leg length at every joint
  const double size = robot.weight() * robot.leg_length;
  const double mean_weight =
      settings.weights.size() == 0 ? 1.0 : settings.weights.trace() / static_cast<double>(robot.num_joints());
  const double per_scale = 1.0 / (mean_weight * size * size);
  add_contacts_and_torques(robot, equations, support, all, settings, torques, limits, unit, per_scale, conditions,
                           program);
  if (const double k = settings.reference_weight; k > 0.0)
  {
    const Result<Reactions> reference = zmp_transition(robot, equations, support);
    if (const Refusal* refusal = std::get_if<Refusal>(&reference))
      return *refusal;
    add_reactions(robot, support, all, all.w0() - std::get<Reactions>(reference).w, unit, k * per_scale, program);
  }
  if (!tells_apart(program.H))
    add_reactions(robot, support, all, all.w0(), unit, 1e-9 / (size * size), program);

  // motors take part only where one of them would be beyond its limit without it; mostly none is
  const TorqueRange* range = limits ? &limits->torques : nullptr;
  const BoundedVector<kMaxRows> bounds = program.rows.b;
  QuadraticProgramSolution solution;
  bool relaxed = false;
  const auto solve_with_windows = [&](const std::bitset<kMaxRows>& start)
  {
    solution = solve(program, start);
    relaxed = solution.status == QuadraticProgramStatus::infeasible;
    if (relaxed && windows_give_way(conditions, solution.active))
      solution = solve(program, solution.active);
  };
  const auto add_motors = [&]
  {
    program.rows.b = bounds;
    conditions.add_motors(robot, torques, range ? *range : TorqueRange(robot), unit);
  };
  solve_with_windows({});
  if (solution.status == QuadraticProgramStatus::optimal &&
      !within_limits(robot, torques, range, in_units(solution, unit)))
  {
    add_motors();
    solve_with_windows(solution.active);
  }
  else if (solution.status == QuadraticProgramStatus::infeasible && !within)
    add_motors();
  if (solution.status == QuadraticProgramStatus::infeasible)
  {
    if (within)
      return Result<Chosen>(std::in_place_type<Chosen>);
    if (const std::optional<Refusal> refusal = give_way(equations, relax, conditions))
      return *refusal;
    solution = solve(program);
  }
  if (solution.status != QuadraticProgramStatus::optimal)
    return Refusal(Reason::numerical, "the optimisation did not end; the motion's numbers are too large");
  return Result<Chosen>(std::in_place_type<Chosen>, std::in_place, all, in_units(solution, unit), relaxed);
}

} // namespace

Result<Reactions> constrained(const Robot& robot, const SupportEquations& equations, const Support& support,
                              const AdmissibleReactions& all, const Constrained& settings, bool relax)
{
  const auto chosen = choose(robot, equations, support, all, settings, nullptr, false, relax);
  if (const Refusal* refusal = std::get_if<Refusal>(&chosen))
    return *refusal;
  return *std::get<std::optional<Reactions>>(chosen);
}

Result<std::optional<Reactions>> constrained_within(const Robot& robot, const SupportEquations& equations,
                                                    const Support& support, const AdmissibleReactions& all,
                                                    const Constrained& settings, const ReactionLimits* limits)
{
  return choose(robot, equations, support, all, settings, limits, true, true);
}

static void list(Constrained& settings, SettingList& with)
{
  const Range force{0.0, std::numeric_limits<double>::max(), "\"robot\", or a force of 0 N or more"};
  with.weights("weights", settings.weights);
  with.boolean("windows", settings.windows, "bounds that close where contacts change, so that torques do not jump");
  with.number("reference_weight", settings.reference_weight, not_negative(),
              "of the distance to zmp-transition's reactions, x leg length, beside that of the torques");
  with.number_or("f_min", settings.f_min, "robot", force,
                 "least normal force of a loaded foot, N; 'robot': as its file says");
}

MethodRow constrained_row()
{
  return method_row<Constrained>("constrained",
                                 [](const DoubleSupport& now)
                                 {
                                   return constrained(now.robot, now.equations, now.support, now.all,
                                                      now.settings.of<Constrained>(),
                                                      now.settings.infeasible == OnInfeasible::relax);
                                 });
}

} // namespace torqued
