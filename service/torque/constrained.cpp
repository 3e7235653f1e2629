#include "torque/constrained.h"

#include "torque/linear_transition.h"
#include "torque/quadratic_program.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

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

// Conditions on y, in units in which its entries and the rows' are of order 1.
class Conditions
{
public:
  Conditions(const Robot& robot, const Support& support, const AdmissibleReactions& all, const ReactionTorques& torques)
      : robot_(robot), support_(support), all_(all), torques_(torques), unit_(all.Z.cols())
  {
    // N; N m where y is a moment, the third of two soles
    unit_.setConstant(robot.weight());
    if (unit_.size() == 3)
      unit_(2) *= robot.leg_length;
    rows_.A.resize(0, unit_.size());
    rows_.b.resize(0);
  }

  // c·w ≤ bound, w the foot's own components; scale: what is much
  void foot_row(Rank rank, Side side, const Eigen::Vector3d& c, double bound, double scale)
  {
    const int row = support_.row(side);
    const int components = wrench_components(support_.of(side));
    const auto own = c.head(components).transpose();
    add(rank, own * all_.Z.middleRows(row, components), bound - own.dot(all_.w0.segment(row, components)), scale);
  }

  void torque_rows()
  {
    for (int j = 0; j < robot_.num_joints(); ++j)
    {
      const double limit = robot_.actuators[static_cast<std::size_t>(j)].torque_limit;
      if (!std::isfinite(limit))
        continue;
      // a motor with next to no limit would otherwise outweigh all others
      const double scale = std::max(limit, 1e-3 * robot_.weight() * robot_.leg_length);
      add(Rank::torque, torques_.T.row(j), limit - torques_.tau0(j), scale);
      add(Rank::torque, -torques_.T.row(j), limit + torques_.tau0(j), scale);
    }
  }

  // rows of this rank soft, those that give way to it left out
  Rows up_to(Rank rank) const
  {
    Rows rows{Bounded<kMaxRows, kMaxVariables>(rows_.size(), unit_.size()), BoundedVector<kMaxRows>(rows_.size()), {}};
    int n = 0;
    for (int i = 0; i < rows_.size(); ++i)
      if (rank_[static_cast<std::size_t>(i)] <= rank)
      {
        rows.A.row(n) = rows_.A.row(i);
        rows.b(n) = rows_.b(i);
        rows.soft[static_cast<std::size_t>(n)] = rank_[static_cast<std::size_t>(i)] == rank;
        ++n;
      }
    rows.A.conservativeResize(n, Eigen::NoChange);
    rows.b.conservativeResize(n);
    return rows;
  }

  // the most that a row of this rank lacks at y
  double lacking(Rank rank, const BoundedVector<kMaxVariables>& y) const
  {
    double most = 0.0;
    for (int i = 0; i < rows_.size(); ++i)
      if (rank_[static_cast<std::size_t>(i)] == rank)
        most = std::max(most, rows_.A.row(i).dot(y) - rows_.b(i));
    return most;
  }

  // grants rows of this rank what they lack at y; and all of them room for rounding
  void relax(Rank rank, const BoundedVector<kMaxVariables>& y)
  {
    constexpr double rounding = 1e-9;
    for (int i = 0; i < rows_.size(); ++i)
      if (rank_[static_cast<std::size_t>(i)] == rank)
        rows_.b(i) = std::max(rows_.b(i), rows_.A.row(i).dot(y)) + rounding;
  }

  const Rows& rows() const { return rows_; }
  const BoundedVector<kMaxVariables>& unit() const { return unit_; }

private:
  template <typename Row> void add(Rank rank, const Row& a, double b, double scale)
  {
    const int i = rows_.size();
    rows_.A.conservativeResize(i + 1, Eigen::NoChange);
    rows_.b.conservativeResize(i + 1);
    rows_.A.row(i) = a.cwiseProduct(unit_.transpose()) / scale;
    rows_.b(i) = b / scale;
    rank_[static_cast<std::size_t>(i)] = rank;
  }

  const Robot& robot_;
  const Support& support_;
  const AdmissibleReactions& all_;
  const ReactionTorques& torques_;
  BoundedVector<kMaxVariables> unit_; // of y
  Rows rows_;
  std::array<Rank, kMaxRows> rank_{};
};

// c of c·w = M − h_p f_x' − x f_z': the moment about the point of the sole at x from below the ankle, in the foot's
// frame
Eigen::Vector3d moment_at(const Foot& foot, const FootPose& pose, double x)
{
  const double h = foot.ankle_height();
  return {-h * pose.e.x() + x * pose.e.y(), -h * pose.e.y() - x * pose.e.x(), 1.0};
}

void contact_rows(const Robot& robot, const SupportEquations& equations, const Support& support,
                  const Constrained& settings, Conditions& conditions)
{
  const double p = support.phase;
  const double F_z = equations.force().y();
  const double weight = robot.weight();
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  for (const Side side : kSides)
  {
    const bool leading = side == support.leading;
    const Foot& foot = robot.foot(side);
    const FootPose& pose = equations.foot(side);
    const bool sole = support.of(side) == Contact::sole && foot.has_extent();
    const double length = weight * (foot.toe_x() - foot.heel_x());

    // the most load that a window leaves this foot
    std::optional<double> most;
    if (settings.windows && leading_sole && trailing_sole)
      most = std::min(1.0, 2.0 * (leading ? p : 1.0 - p)) * F_z;
    else if (settings.windows && leading_sole != trailing_sole && support.of(side) != Contact::sole)
      most = (leading ? p : 1.0 - p) * F_z;
    double least = settings.f_min.value_or(foot.f_min);
    if (most)
      least = std::min(least, std::max(*most, 0.0));

    conditions.foot_row(Rank::contact, side, {0.0, -1.0, 0.0}, -least, weight);
    conditions.foot_row(Rank::contact, side, {1.0, -foot.friction, 0.0}, 0.0, weight);
    conditions.foot_row(Rank::contact, side, {-1.0, -foot.friction, 0.0}, 0.0, weight);
    if (sole)
    {
      conditions.foot_row(Rank::contact, side, -moment_at(foot, pose, foot.heel_x()), 0.0, length);
      conditions.foot_row(Rank::contact, side, moment_at(foot, pose, foot.toe_x()), 0.0, length);
    }
    if (most)
      conditions.foot_row(Rank::window, side, {0.0, 1.0, 0.0}, *most, weight);
    if (settings.windows && sole && leading_sole != trailing_sole)
    {
      const Eigen::Vector3d moment = moment_at(foot, pose, foot.heel_x() + p * (foot.toe_x() - foot.heel_x()));
      conditions.foot_row(Rank::window, side, leading ? moment : -moment, 0.0, length);
    }
  }
}

} // namespace

Result<Reactions> constrained(const Robot& robot, const SupportEquations& equations, const Support& support,
                              const AdmissibleReactions& all, const Constrained& settings, bool relax)
{
  const ReactionTorques torques = reaction_torques(robot, equations, support, all);
  Conditions conditions(robot, support, all, torques);
  contact_rows(robot, equations, support, settings, conditions);
  conditions.torque_rows();

  // objective, over its value for a torque of weight × leg length at every joint
  const double size = robot.weight() * robot.leg_length;
  const Bounded<kMaxJoints, 3> T = torques.T * conditions.unit().asDiagonal() / size;
  const VectorJ tau0 = torques.tau0 / size;
  Bounded<kMaxJoints, 3> WT = T;
  double scale = 1.0;
  if (settings.weights.size() > 0)
  {
    scale = settings.weights.trace() / static_cast<double>(robot.num_joints());
    WT = settings.weights * T / scale;
  }
  QuadraticProgram program{T.transpose() * WT, WT.transpose() * tau0, {}};
  const Bounded<6, 3> Z = all.Z * conditions.unit().asDiagonal() / size;
  WrenchVector V(all.w0.size()); // L², and 1 for a moment
  V.setConstant(robot.leg_length * robot.leg_length);
  for (const Side side : kSides)
    if (support.of(side) == Contact::sole)
      V(support.row(side) + 2) = 1.0;
  const Bounded<3, 3> reactions = Z.transpose() * V.asDiagonal() * Z;
  if (const double k = settings.reference_weight / scale; k > 0.0)
  {
    const Result<Reactions> reference = zmp_transition(robot, equations, support);
    if (const Refusal* refusal = std::get_if<Refusal>(&reference))
      return *refusal;
    const WrenchVector off = (all.w0 - std::get<Reactions>(reference).w) / size;
    program.H += k * reactions;
    program.g += k * (Z.transpose() * V.cwiseProduct(off));
  }
  const BoundedVector<3> pivots = Eigen::LDLT<Bounded<3, 3>>(program.H).vectorD();
  if (!(pivots.minCoeff() > 1e-11 * pivots.maxCoeff()))
  {
    constexpr double tie_break = 1e-9;
    program.H += tie_break * reactions;
    program.g += tie_break * (Z.transpose() * V.cwiseProduct(all.w0 / size));
  }

  program.rows = conditions.rows();
  QuadraticProgramSolution solution = solve(program);
  Reactions chosen;
  if (solution.status == QuadraticProgramStatus::infeasible)
  {
    chosen.relaxed = true;
    BoundedVector<kMaxVariables> y = BoundedVector<kMaxVariables>::Zero(all.Z.cols());
    for (const Rank rank : kRanks)
    {
      const Rows rows = conditions.up_to(rank);
      const QuadraticProgramSolution least = least_violation(rows, y);
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
    program.rows = conditions.rows();
    solution = solve(program);
  }
  if (solution.status != QuadraticProgramStatus::optimal)
    return Refusal(Reason::numerical, "the optimisation did not end; the motion's numbers are too large");
  chosen.w = all.w0 + all.Z * conditions.unit().cwiseProduct(solution.y);
  return chosen;
}

} // namespace torqued
