#include "methods/constrained.h"

#include "methods/method.h"
#include "methods/quadratic_program.h"
#include "methods/zmp_transition.h"
#include "planar/processors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace torqued
{

namespace
{

// The priorities of conditions, highest first.
enum class Rank
{
  contact,
  torque,
  window
};
constexpr std::array<Rank, 3> kRanks{Rank::contact, Rank::torque, Rank::window};

// What the contacts, and the windows if they are set, ask of the reactions, one after the other, by
//
//   add(side, bound, factor, is_window, form)    form(f_x, f_z, moment) ≤ bound, form linear; see ContactCondition
template <typename Add>
void for_each_condition(const Robot& robot, const SupportEquations& equations, const Support& support,
                        const Constrained& settings, const Add& add)
{
  const double p = support.progress();
  const double F_z = equations.force().y();
  const double per_weight = 1.0 / robot.weight();
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  for (const Side side : kSides)
  {
    const bool leading = side == support.leading;
    const Foot& foot = robot.foot(side);
    const bool sole = support.of(side) == Contact::sole && foot.has_extent();

    // the most load that a window leaves this foot
    std::optional<double> most;
    if (settings.windows && leading_sole && trailing_sole)
      most = std::min(1.0, 2.0 * (leading ? p : 1.0 - p)) * F_z;
    else if (settings.windows && leading_sole != trailing_sole && support.of(side) != Contact::sole)
      most = (leading ? p : 1.0 - p) * F_z;
    double least = settings.f_min.value_or(foot.f_min);
    if (most)
      least = std::min(least, std::max(*most, 0.0));

    add(side, -least, per_weight, false, [](const auto&, const auto& f_z, const auto&) { return -f_z; });
    const double mu = foot.friction;
    add(side, 0.0, per_weight, false, [mu](const auto& f_x, const auto& f_z, const auto&) { return f_x - mu * f_z; });
    add(side, 0.0, per_weight, false, [mu](const auto& f_x, const auto& f_z, const auto&) { return -f_x - mu * f_z; });
    if (sole)
    {
      // M − h_p f_x' − x f_z': the moment about the point of the sole at x from below the ankle, in the foot's frame
      const auto moment_at = [h = foot.ankle_height(), e = equations.foot(side).e](double x, double sign)
      {
        return [sign, of_x = sign * (x * e.y() - h * e.x()),
                of_z = -sign * (h * e.y() + x * e.x())](const auto& f_x, const auto& f_z, const auto& moment)
        {
          return of_x * f_x + of_z * f_z + sign * moment;
        };
      };
      const double heel = foot.heel_x(), toe = foot.toe_x();
      const double per_length = per_weight / (toe - heel);
      add(side, 0.0, per_length, false, moment_at(heel, -1.0));
      add(side, 0.0, per_length, false, moment_at(toe, 1.0));
      if (settings.windows && leading_sole != trailing_sole)
        add(side, 0.0, per_length, true, moment_at(heel + p * (toe - heel), leading ? 1.0 : -1.0));
    }
    if (most)
      add(side, *most, per_weight, true, [](const auto&, const auto& f_z, const auto&) { return f_z; });
  }
}

// Conditions as rows a·y ≤ b, in units in which their entries and those of y are of order 1: those of contacts, by
// w = w0 + Z y, and, once they are asked for, those of motors.
class Conditions
{
public:
  // rows: where they are kept
  explicit Conditions(Rows& rows) : rows_(rows), size_(0) {}

  // unit: of y, in N and N m
  void add_contacts(const Robot& robot, const SupportEquations& equations, const Support& support,
                    const AdmissibleReactions& all, const Constrained& settings, const Eigen::Vector3d& unit)
  {
    size_ = ContactConditions::kMost;
    // the components of both feet's wrenches, for w0 and for y at once; no moment at a heel or toe
    using Columns = Eigen::Vector4d;
    const Columns units(-1.0, unit(0), unit(1), unit(2));
    std::array<std::array<Columns, 3>, 2> wrench;
    for (const Side side : kSides)
      for (int i = 0; i < 3; ++i)
      {
        auto& component = wrench[static_cast<std::size_t>(side)][static_cast<std::size_t>(i)];
        if (i < wrench_components(support.of(side)))
          component = all.row(support.row(side) + i).cwiseProduct(units);
        else
          component.setZero();
      }

    // always as many rows, of which the last may ask nothing: the compiler then knows where each entry is
    rows_.A.resize(size_, all.redundancy);
    rows_.b.resize(size_);
    int row = 0;
    const auto write = [&](const Columns& a, double bound, Rank rank)
    {
      for (int k = 0; k < all.redundancy; ++k)
        rows_.A(row, k) = a(1 + k);
      rows_.b(row) = bound + a(0);
      rank_[static_cast<std::size_t>(row++)] = rank;
    };
    for_each_condition(robot, equations, support, settings,
                       [&](Side side, double bound, double factor, bool is_window, const auto& form)
                       {
                         const auto& [f_x, f_z, moment] = wrench[static_cast<std::size_t>(side)];
                         write(factor * form(f_x, f_z, moment), factor * bound,
                               is_window ? Rank::window : Rank::contact);
                       });
    while (row < size_)
      write(Columns::Zero(), 1.0, Rank::contact);
  }

  // τ ≤ limit of all motors and −τ ≤ limit of all, by τ = τ0 + T y, where a motor without limit has 0 ≤ 1; nothing
  // where none has one
  void add_motors(const Robot& robot, const ReactionTorques& torques, const Eigen::Vector3d& unit)
  {
    if (std::none_of(robot.actuators.begin(), robot.actuators.end(),
                     [](const Actuator& actuator) { return std::isfinite(actuator.torque_limit); }))
      return;
    // one over what is much of a motor's torque, and its limit over that; a motor with next to no limit would otherwise
    // outweigh all others
    const int motors = robot.num_joints();
    VectorJ factor(motors), limit(motors);
    const double least_scale = 1e-3 * robot.weight() * robot.leg_length;
    for (int j = 0; j < motors; ++j)
    {
      const double torque_limit = robot.actuators[static_cast<std::size_t>(j)].torque_limit;
      factor(j) = 1.0 / std::max(torque_limit, least_scale);
      limit(j) = std::isfinite(torque_limit) ? factor(j) * torque_limit : 1.0;
    }
    const VectorJ tau0 = factor.cwiseProduct(torques.tau0.head(motors));
    rows_.A.conservativeResize(size_ + 2 * motors, Eigen::NoChange);
    rows_.b.conservativeResize(size_ + 2 * motors);
    for (const double sign : {1.0, -1.0})
    {
      for (int k = 0; k < rows_.A.cols(); ++k)
        rows_.A.col(k).segment(size_, motors) = sign * unit(k) * factor.cwiseProduct(torques.T.col(k).head(motors));
      rows_.b.segment(size_, motors) = limit - sign * tau0;
      std::fill_n(rank_.begin() + size_, motors, Rank::torque);
      size_ += motors;
    }
  }

  // rows of this rank soft, those that give way to it left out
  Rows up_to(Rank soft) const
  {
    Rows rows{Bounded<kMaxRows, kMaxVariables>(size_, rows_.A.cols()), BoundedVector<kMaxRows>(size_), {}};
    int n = 0;
    for (int i = 0; i < size_; ++i)
      if (rank(i) <= soft)
      {
        rows.A.row(n) = rows_.A.row(i);
        rows.b(n) = rows_.b(i);
        rows.soft[static_cast<std::size_t>(n++)] = rank(i) == soft;
      }
    rows.A.conservativeResize(n, Eigen::NoChange);
    rows.b.conservativeResize(n);
    return rows;
  }

  Eigen::Index variables() const { return rows_.A.cols(); }
  bool any(Rank of) const { return std::find(rank_.begin(), rank_.begin() + size_, of) != rank_.begin() + size_; }

  // the most that a row of this rank lacks at y
  double lacking(Rank of, const BoundedVector<kMaxVariables>& y) const
  {
    double most = 0.0;
    for (int i = 0; i < size_; ++i)
      if (rank(i) == of)
        most = std::max(most, rows_.A.row(i).dot(y) - rows_.b(i));
    return most;
  }

  // Grants rows of this rank what they lack at y, and all of them room for rounding: of weight, of weight × sole
  // length, of a torque limit. What gave way leaves a point that rounding could close, so lower ranks get more.
  void relax(Rank of, const BoundedVector<kMaxVariables>& y)
  {
    const double room = of == Rank::contact ? 1e-9 : 1e-8;
    for (int i = 0; i < size_; ++i)
      if (rank(i) == of)
        rows_.b(i) = std::max(rows_.b(i), rows_.A.row(i).dot(y)) + room;
  }

private:
  static_assert(ContactConditions::kMost + 2 * kMaxJoints <= kMaxRows);
  Rank rank(int i) const { return rank_[static_cast<std::size_t>(i)]; }

  Rows& rows_;
  int size_;
  std::array<Rank, kMaxRows> rank_;
};

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
                              const ReactionTorques& torques, const Eigen::Vector3d& unit, double per_scale,
                              Conditions& conditions, QuadraticProgram& program)
{
  conditions.add_contacts(robot, equations, support, all, settings, unit);
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

bool within_limits(const Robot& robot, const ReactionTorques& torques, const Eigen::Vector3d& y)
{
  Eigen::Matrix<double, kMaxJoints, 1> torque;
  for (int j = 0; j < robot.num_joints(); j += kJointBlock)
  {
    JointBlock sum = torques.tau0.segment<kJointBlock>(j);
    for (int k = 0; k < torques.T.cols(); ++k)
      sum += y(k) * torques.T.col(k).segment<kJointBlock>(j);
    torque.segment<kJointBlock>(j) = sum;
  }
  bool within = true;
  const double* tau = torque.data();
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

// Grants the conditions what they lack at the least: windows alone where that is enough; else rank by rank, highest
// priority first, each while those before it hold. active: the working set in which the program turned out infeasible;
// then one to solve it from.
std::optional<Refusal> give_way(const SupportEquations& equations, bool relax, Conditions& conditions,
                                std::bitset<kMaxRows>& active)
{
  BoundedVector<kMaxVariables> y = BoundedVector<kMaxVariables>::Zero(conditions.variables());
  if (conditions.any(Rank::window))
    if (const auto least = least_violation(conditions.up_to(Rank::window), y, active);
        least.status == QuadraticProgramStatus::optimal)
    {
      conditions.relax(Rank::window, least.y);
      active = least.active;
      return {};
    }
  active.reset();
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

} // namespace

ContactConditions contact_conditions(const Robot& robot, const SupportEquations& equations, const Support& support,
                                     const Constrained& settings)
{
  ContactConditions conditions;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  for_each_condition(
      robot, equations, support, settings,
      [&](Side side, double bound, double factor, bool is_window, const auto& form) {
        conditions.push_back({side, form(unit.col(0), unit.col(1), unit.col(2)), bound, factor, is_window});
      });
  return conditions;
}

Result<Reactions> constrained(const Robot& robot, const SupportEquations& equations, const Support& support,
                              const AdmissibleReactions& all, const Constrained& settings, bool relax)
{
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
  add_contacts_and_torques(robot, equations, support, all, settings, torques, unit, per_scale, conditions, program);
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
  QuadraticProgramSolution solution = solve(program);
  if (solution.status == QuadraticProgramStatus::infeasible)
    conditions.add_motors(robot, torques, unit);
  else if (solution.status == QuadraticProgramStatus::optimal &&
           !within_limits(robot, torques, in_units(solution, unit)))
  {
    conditions.add_motors(robot, torques, unit);
    solution = solve(program, solution.active);
  }
  const bool relaxed = solution.status == QuadraticProgramStatus::infeasible;
  if (relaxed)
  {
    if (const std::optional<Refusal> refusal = give_way(equations, relax, conditions, solution.active))
      return *refusal;
    solution = solve(program, solution.active);
  }
  if (solution.status != QuadraticProgramStatus::optimal)
    return Refusal(Reason::numerical, "the optimisation did not end; the motion's numbers are too large");
  return Result<Reactions>(std::in_place_type<Reactions>, all, in_units(solution, unit), relaxed);
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
