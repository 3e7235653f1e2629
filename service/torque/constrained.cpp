#include "torque/constrained.h"

#include "torque/linear_transition.h"
#include "torque/quadratic_program.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace torqued
{

namespace
{

// Which conditions give way to which: the first hold the longest.
enum class Rank
{
  contact,
  torque,
  window
};
constexpr std::array<Rank, 3> kRanks{Rank::contact, Rank::torque, Rank::window};

// The square root of what a window's lack costs, a torque of weight × leg length at every joint costing 1: so much that
// a window lacks some 1e-8 of the weight more than it must, and so little that doubles still tell the torques apart. A
// power of two, so that nothing is lost when rows are multiplied by it and divided.
constexpr double kRootOfWindowPrice = 0x1p13;

// Conditions as rows a·y ≤ b, in units in which their entries and those of y are of order 1: first τ ≤ limit of all
// motors and −τ ≤ limit of all, by τ = τ0 + T y, where a motor without limit has 0 ≤ 1; then those of contacts, by
// w = w0 + Z y.
class Conditions
{
public:
  // rows: where they are kept; unit: of y, in N and N m
  Conditions(Rows& rows, const Robot& robot, const Support& support, const AdmissibleReactions& all,
             const ReactionTorques& torques, const ContactConditions& contacts, const Eigen::Vector3d& unit)
      : rows_(rows)
  {
    const bool limited = std::any_of(robot.actuators.begin(), robot.actuators.end(),
                                     [](const Actuator& actuator) { return std::isfinite(actuator.torque_limit); });
    const int motors = limited ? robot.num_joints() : 0;
    size_ = 2 * motors + contacts.size();
    rows_.A.resize(size_, all.redundancy());
    rows_.b.resize(size_);
    add_motors(robot, motors, torques, unit);
    add_contacts(2 * motors, support, all, contacts, unit);
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

  // lets windows give way at their price, or takes that back
  void price_windows(bool soft)
  {
    const double factor = soft ? kRootOfWindowPrice : 1.0 / kRootOfWindowPrice;
    for (int i = 0; i < size_; ++i)
      if (rank(i) == Rank::window)
      {
        rows_.A.row(i) *= factor;
        rows_.b(i) *= factor;
        rows_.soft[static_cast<std::size_t>(i)] = soft;
      }
  }

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

  // grants rows of this rank what they lack at y; and all of them room for rounding
  void relax(Rank of, const BoundedVector<kMaxVariables>& y)
  {
    constexpr double rounding = 1e-9;
    for (int i = 0; i < size_; ++i)
      if (rank(i) == of)
        rows_.b(i) = std::max(rows_.b(i), rows_.A.row(i).dot(y)) + rounding;
  }

private:
  Rank rank(int i) const { return rank_[static_cast<std::size_t>(i)]; }

  // In whole blocks: what is written beyond the motors is written again by what follows, or is room that is left.
  static_assert(ContactConditions::kMost + 2 * kMaxJoints + kJointBlock <= kMaxRows);
  void add_motors(const Robot& robot, int motors, const ReactionTorques& torques, const Eigen::Vector3d& unit)
  {
    // one over what is much of a motor's torque, and its limit over that; a motor with next to no limit would otherwise
    // outweigh all others
    Eigen::Matrix<double, kMaxJoints, 1> factor, limit;
    const double least_scale = 1e-3 * robot.weight() * robot.leg_length;
    for (int j = 0; j < motors; ++j)
    {
      const double torque_limit = robot.actuators[static_cast<std::size_t>(j)].torque_limit;
      factor(j) = 1.0 / std::max(torque_limit, least_scale);
      limit(j) = std::isfinite(torque_limit) ? factor(j) * torque_limit : 1.0;
    }
    const auto write = [motors](double* column, const auto& entries)
    {
      for (int j = 0; j < motors; j += kJointBlock)
        Eigen::Map<JointBlock>(column + j) = entries(1.0, j);
      for (int j = 0; j < motors; j += kJointBlock)
        Eigen::Map<JointBlock>(column + motors + j) = entries(-1.0, j);
    };
    for (int k = 0; k < rows_.A.cols(); ++k)
      write(rows_.A.col(k).data(),
            [&](double sign, int j) -> JointBlock {
              return sign * unit(k) *
                     factor.segment<kJointBlock>(j).cwiseProduct(torques.T.block<kJointBlock, 1>(j, k));
            });
    write(rows_.b.data(),
          [&](double sign, int j) -> JointBlock
          {
            return limit.segment<kJointBlock>(j) -
                   sign * factor.segment<kJointBlock>(j).cwiseProduct(torques.tau0.segment<kJointBlock>(j));
          });
    std::fill_n(rank_.begin(), 2 * motors, Rank::torque);
  }

  void add_contacts(int row, const Support& support, const AdmissibleReactions& all, const ContactConditions& contacts,
                    const Eigen::Vector3d& unit)
  {
    // the components of both feet's wrenches, for y and for w0 at once; no moment at a heel or toe
    using Columns = Eigen::Vector4d;
    std::array<std::array<Columns, 3>, 2> wrench;
    for (const Side side : kSides)
      for (int i = 0; i < 3; ++i)
      {
        const int c = support.row(side) + i;
        const bool exists = i < wrench_components(support.of(side));
        const auto of_y = [&](int k)
        {
          return exists && k < all.redundancy() ? unit(k) * all.Z(c, k) : 0.0;
        };
        wrench[static_cast<std::size_t>(side)][static_cast<std::size_t>(i)] =
            Columns(of_y(0), of_y(1), of_y(2), exists ? -all.w0(c) : 0.0);
      }
    for (const ContactCondition& contact : contacts)
    {
      const auto& [fx, fz, moment] = wrench[static_cast<std::size_t>(contact.side)];
      const Columns a = contact.factor * (contact.c(0) * fx + contact.c(1) * fz + contact.c(2) * moment);
      for (int k = 0; k < rows_.A.cols(); ++k)
        rows_.A(row, k) = a(k);
      rows_.b(row) = contact.factor * contact.bound + a(3);
      rank_[static_cast<std::size_t>(row++)] = contact.is_window ? Rank::window : Rank::contact;
    }
  }

  Rows& rows_;
  int size_;
  std::array<Rank, kMaxRows> rank_;
};

// c of c·w = M − h_p f_x' − x f_z': the moment about the point of the sole at x from below the ankle, in the foot's
// frame
Eigen::Vector3d moment_at(const Foot& foot, const FootPose& pose, double x)
{
  const double h = foot.ankle_height();
  return {-h * pose.e.x() + x * pose.e.y(), -h * pose.e.y() - x * pose.e.x(), 1.0};
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
      for (int k = 0; k < all.redundancy(); ++k)
      {
        const double slope = weight * lever * lever * all.Z(c, k) * unit(k);
        program.g(k) += slope * w0(c);
        for (int j = 0; j < all.redundancy(); ++j)
          program.H(j, k) += slope * all.Z(c, j) * unit(j);
      }
    }
}

// whether no direction of y counts next to nothing against the others
bool tells_apart(const Bounded<3, 3>& H)
{
  // pivots of H = L D Lᵀ
  Eigen::Matrix3d rest = Eigen::Matrix3d::Identity();
  const int n = static_cast<int>(H.cols());
  double largest = 0.0, least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      rest(j, k) = H(j, k);
  for (int k = 0; k < n; ++k)
  {
    const double pivot = rest(k, k);
    largest = std::max(largest, H(k, k));
    least = std::min(least, pivot);
    for (int i = k + 1; i < n; ++i)
      for (int j = k + 1; j < n; ++j)
        rest(i, j) -= rest(i, k) * rest(k, j) / pivot;
  }
  return least > 1e-11 * largest;
}

} // namespace

ContactConditions contact_conditions(const Robot& robot, const SupportEquations& equations, const Support& support,
                                     const Constrained& settings)
{
  ContactConditions conditions;
  const double p = support.phase;
  const double F_z = equations.force().y();
  const double per_weight = 1.0 / robot.weight();
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  for (const Side side : kSides)
  {
    const bool leading = side == support.leading;
    const Foot& foot = robot.foot(side);
    const FootPose& pose = equations.foot(side);
    const bool sole = support.of(side) == Contact::sole && foot.has_extent();
    const double per_length = sole ? per_weight / (foot.toe_x() - foot.heel_x()) : 0.0;

    // the most load that a window leaves this foot
    std::optional<double> most;
    if (settings.windows && leading_sole && trailing_sole)
      most = std::min(1.0, 2.0 * (leading ? p : 1.0 - p)) * F_z;
    else if (settings.windows && leading_sole != trailing_sole && support.of(side) != Contact::sole)
      most = (leading ? p : 1.0 - p) * F_z;
    double least = settings.f_min.value_or(foot.f_min);
    if (most)
      least = std::min(least, std::max(*most, 0.0));

    const auto add = [&](const Eigen::Vector3d& c, double bound, double factor, bool is_window = false)
    {
      conditions.push_back({side, c, bound, factor, is_window});
    };
    add({0.0, -1.0, 0.0}, -least, per_weight);
    add({1.0, -foot.friction, 0.0}, 0.0, per_weight);
    add({-1.0, -foot.friction, 0.0}, 0.0, per_weight);
    if (sole)
    {
      add(-moment_at(foot, pose, foot.heel_x()), 0.0, per_length);
      add(moment_at(foot, pose, foot.toe_x()), 0.0, per_length);
    }
    if (most)
      add({0.0, 1.0, 0.0}, *most, per_weight, true);
    if (settings.windows && sole && leading_sole != trailing_sole)
    {
      const Eigen::Vector3d moment = moment_at(foot, pose, foot.heel_x() + p * (foot.toe_x() - foot.heel_x()));
      add(leading ? moment : -moment, 0.0, per_length, true);
    }
  }
  return conditions;
}

Result<Reactions> constrained(const Robot& robot, const SupportEquations& equations, const Support& support,
                              const AdmissibleReactions& all, const Constrained& settings, bool relax)
{
  const int n = static_cast<int>(all.redundancy());
  const ReactionTorques torques = reaction_torques(robot, equations, support, all);

  // units of y: N, and N m where it is a moment, the third of two soles
  Eigen::Vector3d unit = Eigen::Vector3d::Constant(robot.weight());
  if (n == 3)
    unit(2) *= robot.leg_length;
  const ContactConditions contacts = contact_conditions(robot, equations, support, settings);
  QuadraticProgram program;
  Conditions conditions(program.rows, robot, support, all, torques, contacts, unit);

  // objective, over its value for a torque of weight × leg length at every joint
  const double size = robot.weight() * robot.leg_length;
  const double mean_weight =
      settings.weights.size() == 0 ? 1.0 : settings.weights.trace() / static_cast<double>(robot.num_joints());
  const double per_scale = 1.0 / (mean_weight * size * size);
  const SumOfSquares sum = torque_squares(robot, torques, settings.weights);
  program.H.resize(n, n);
  program.g.resize(n);
  sum.with_rows(
      [&](auto rows)
      {
        for (int k = 0; k < n; ++k)
        {
          const auto column = sum.A.col(k).template head<rows>();
          program.g(k) = column.dot(sum.b.head<rows>()) * unit(k) * per_scale;
          for (int j = 0; j <= k; ++j)
            program.H(j, k) = program.H(k, j) =
                column.dot(sum.A.col(j).template head<rows>()) * unit(j) * unit(k) * per_scale;
        }
      });
  if (const double k = settings.reference_weight; k > 0.0)
  {
    const Result<Reactions> reference = zmp_transition(robot, equations, support);
    if (const Refusal* refusal = std::get_if<Refusal>(&reference))
      return *refusal;
    add_reactions(robot, support, all, all.w0 - std::get<Reactions>(reference).w, unit, k * per_scale, program);
  }
  if (!tells_apart(program.H))
    add_reactions(robot, support, all, all.w0, unit, 1e-9 / (size * size), program);

  QuadraticProgramSolution solution = solve(program);
  const bool relaxed = solution.status == QuadraticProgramStatus::infeasible;
  if (relaxed && conditions.any(Rank::window))
  {
    conditions.price_windows(true);
    solution = solve(program, solution.active);
    conditions.price_windows(false);
  }
  if (relaxed && solution.status != QuadraticProgramStatus::optimal)
  {
    // not the windows alone: rank by rank, each row by what it lacks at the least, before the next rank is looked at
    BoundedVector<kMaxVariables> y = BoundedVector<kMaxVariables>::Zero(n);
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
    solution = solve(program);
  }
  if (solution.status != QuadraticProgramStatus::optimal)
    return Refusal(Reason::numerical, "the optimisation did not end; the motion's numbers are too large");
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  for (int k = 0; k < n; ++k)
    y(k) = unit(k) * solution.y(k);
  return Reactions{all.at(y), false, relaxed};
}

} // namespace torqued
