#include "nearest/nearest_motion.h"

#include "methods/constrained.h"
#include "nearest/motion_program.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

// Beyond this share of what is much of it, something is not kept.
constexpr double kKept = 1e-9;
// What is granted to rounding, over what is much of it: a motion that is just possible leaves a method one point to
// choose from. Conditions get it beyond their bounds; torques stay so far within their range, and twice that in
// level 1.
constexpr double kRoom = 1e-10;

// how large the terms are whose sum a contact's acceleration is
double contact_scale(const SupportEquations& equations, const Support& support)
{
  double scale = 1.0 + equations.base_acceleration.cwiseAbs().maxCoeff();
  for (const Side side : kSides)
    if (support.of(side) != Contact::none)
      scale = std::max(scale, equations.standing[side].acceleration.cwiseAbs().maxCoeff());
  return scale;
}

// e: what the contacts' acceleration must lose
WrenchVector contact_error(const Robot& robot, const SupportEquations& equations, const Support& support,
                           const NearestSettings& settings)
{
  WrenchVector error = WrenchVector::Zero(support.wrench_components());
  if (settings.contacts == NearestContacts::as_desired)
    return error;
  const double c = settings.contact_damping;
  for (const Side side : kSides)
  {
    const Contact contact = support.of(side);
    if (contact == Contact::none)
      continue;
    const StandingFoot& standing = equations.standing[side];
    const int row = support.row(side), direction = robot.foot(side).direction;
    error.segment<2>(row) =
        equations.base_acceleration + standing.acceleration + c * (equations.base_velocity + standing.velocity);
    if (contact == Contact::sole)
      error(row + 2) = equations.direction_acceleration(direction) + c * equations.now.rate(direction);
  }
  return error;
}

// what contacts ask of the reactions, windows left out; a fixed root asks nothing
ContactConditions without_windows(const Robot& robot, const SupportEquations& equations, const Support& support,
                                  const ContactBounds& bounds)
{
  ContactConditions conditions;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  for_each_condition(robot, equations, support, bounds,
                     [&](Side side, double bound, double factor, bool is_window, const auto& form)
                     {
                       if (!is_window && !robot.is_root(robot.foot(side)))
                         conditions.push_back({side, form(unit.col(0), unit.col(1), unit.col(2)), bound, factor});
                     });
  return conditions;
}

double at(const ContactCondition& condition, const Support& support, const WrenchVector& w)
{
  const int row = support.row(condition.side);
  double value = condition.c.head<2>().dot(w.segment<2>(row));
  if (support.of(condition.side) == Contact::sole)
    value += condition.c(2) * w(row + 2);
  return value;
}

// whether reactions and torques keep their limits to this share of what is much of them
bool keeps(const Robot& robot, const Support& support, const ReactionLimits& limits, const WrenchVector& w,
           const VectorJ& torque, double share)
{
  for (const ContactCondition& condition : limits.contacts)
    if (condition.factor * (at(condition, support, w) - condition.bound) > share)
      return false;
  for (int j = 0; j < torque.size(); ++j)
    if (torque_factor(robot, j) * std::max(torque(j) - limits.torques.most(j), limits.torques.least(j) - torque(j)) >
        share)
      return false;
  return true;
}

Refusal not_found()
{
  return Refusal(Reason::numerical, "the nearest motion was not found; the motion's numbers are too large");
}

// One desired state, the equations of the motion that it is moved to, and what that motion must keep.
class Nearest
{
public:
  Nearest(const Robot& robot, const Support& support, Method method, const MethodSettings& methods,
          const NearestSettings& settings, const TorqueRange& range, SupportEquations& equations)
      : robot_(robot), support_(support), methods_(methods), settings_(settings), equations_(equations),
        method_(method == Method::none ? methods.method : method),
        limits_{without_windows(robot, equations, support,
                                {constrained_settings().windows, constrained_settings().f_min, settings.margin}),
                range}
  {
  }

  Result<NearestMotion> find();

private:
  const Constrained& constrained_settings() const { return methods_.of<Constrained>(); }

  std::optional<Reactions> usual(const AdmissibleReactions& all) const;
  std::optional<TorqueSolution> choose() const;
  std::optional<Reactions> nearest_reactions(const AdmissibleReactions& all, const WrenchVector& reference,
                                             const ReactionLimits& limits) const;
  void move_to(const MotionSpace& space, const VectorQ& delta);
  TorqueSolution torques_of(const Reactions& reactions, Method used) const
  {
    return TorqueSolution(robot_, equations_, support_, used, reactions.w, reactions.clamped, reactions.relaxed);
  }
  Result<NearestMotion> answer(const TorqueSolution& chosen, bool relaxed) const;
  TorqueRange narrowed(double room) const;
  ReactionLimits with_room() const;

  const Robot& robot_;
  const Support& support_;
  const MethodSettings& methods_;
  const NearestSettings& settings_;
  SupportEquations& equations_;
  Method method_;
  ReactionLimits limits_;
  VectorQ moved_; // from the desired acceleration
};

// what would be chosen without any of this
std::optional<Reactions> Nearest::usual(const AdmissibleReactions& all) const
{
  if (all.redundancy == 0)
    return Reactions(all.w0());
  if (method_ == Method::constrained)
  {
    const auto chosen = constrained_within(robot_, equations_, support_, all, constrained_settings(), nullptr);
    const auto* found = std::get_if<std::optional<Reactions>>(&chosen);
    return found ? *found : std::nullopt;
  }
  const MethodRow& row = torqued::methods()[static_cast<std::size_t>(method_) - 1];
  const Result<Reactions> chosen = row.choose({robot_, equations_, support_, all, methods_});
  const auto* found = std::get_if<Reactions>(&chosen);
  return found ? std::optional(*found) : std::nullopt;
}

// level 2, for the motion as it now is; nothing if no reactions keep the limits, or rounding hides them
std::optional<TorqueSolution> Nearest::choose() const
{
  constexpr double share = 0.5 * kRoom;
  const ReactionLimits limits = with_room();
  const AdmissibleReactions all = admissible_reactions(robot_, equations_, support_);
  if (all.redundancy == 0 || method_ != Method::constrained)
    if (const std::optional<Reactions> own = usual(all))
    {
      std::optional<TorqueSolution> found = torques_of(*own, all.redundancy == 0 ? Method::none : method_);
      if (keeps(robot_, support_, limits, found->w, found->torque, share))
        return found;
      std::optional<Reactions> nearest;
      if (all.redundancy > 0)
        nearest = nearest_reactions(all, own->w, limits);
      if (!nearest)
        return {};
      nearest->clamped = own->clamped;
      return torques_of(*nearest, method_);
    }
  const auto chosen = constrained_within(robot_, equations_, support_, all, constrained_settings(), &limits);
  const auto* found = std::get_if<std::optional<Reactions>>(&chosen);
  if (!found || !*found)
    return {};
  return torques_of(**found, Method::constrained);
}

// the reactions that keep the limits, in least squares of their distance from others
std::optional<Reactions> Nearest::nearest_reactions(const AdmissibleReactions& all, const WrenchVector& reference,
                                                    const ReactionLimits& limits) const
{
  const ReactionTorques torques = reaction_torques(robot_, equations_, support_, all);
  Eigen::Vector3d unit = Eigen::Vector3d::Constant(robot_.weight());
  if (all.redundancy == 3)
    unit(2) *= robot_.leg_length;
  QuadraticProgram program;
  Conditions conditions(program.rows);
  conditions.add_contacts(robot_, equations_, support_, all, {.windows = false}, &limits, unit);
  conditions.add_motors(robot_, torques, limits.torques, unit);

  program.H.setZero(all.redundancy, all.redundancy);
  program.g.setZero(all.redundancy);
  for (const Side side : kSides)
    for (int i = 0; i < wrench_components(support_.of(side)); ++i)
    {
      const Foot& foot = robot_.foot(side);
      const double length = foot.has_extent() ? foot.toe_x() - foot.heel_x() : robot_.leg_length;
      const double factor = 1.0 / (robot_.weight() * (i < 2 ? 1.0 : length));
      const int c = support_.row(side) + i;
      const double off = factor * (all.rows(c, 0) - reference(c));
      for (int k = 0; k < all.redundancy; ++k)
      {
        const double slope = factor * all.rows(c, 1 + k) * unit(k);
        program.g(k) += slope * off;
        for (int j = 0; j < all.redundancy; ++j)
          program.H(j, k) += slope * factor * all.rows(c, 1 + j) * unit(j);
      }
    }
  const QuadraticProgramSolution solution = solve(program);
  if (solution.status != QuadraticProgramStatus::optimal)
    return {};
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  for (int k = 0; k < all.redundancy; ++k)
    y(k) = unit(k) * solution.y(k);
  return Reactions(all, y);
}

void Nearest::move_to(const MotionSpace& space, const VectorQ& delta)
{
  const VectorQ step = delta - moved_;
  const Mechanism& mechanism = robot_.mechanism;
  VectorQ force(step.size());
  force.noalias() = space.mass().lazyProduct(step);
  equations_.r += force;
  double moment = force.head(mechanism.num_theta()).sum();
  for (const auto& [row, column, mass] : mechanism.sliding())
    if (row == column)
      moment -= force(row);
  equations_.d += Eigen::Vector3d(force(force.size() - 2), force(force.size() - 1), moment);
  equations_.base_acceleration += step.tail<2>();
  equations_.direction_acceleration += mechanism.of_directions(step);
  moved_ = delta;
}

// the range without this share of what is much of a torque at both ends; at least half of it is left
TorqueRange Nearest::narrowed(double room) const
{
  TorqueRange range = limits_.torques;
  for (int j = 0; j < robot_.num_joints(); ++j)
  {
    const double less = std::min(room / torque_factor(robot_, j), 0.25 * (range.most(j) - range.least(j)));
    range.most(j) -= less;
    range.least(j) += less;
  }
  return range;
}

// what a method chooses within
ReactionLimits Nearest::with_room() const
{
  ReactionLimits limits{limits_.contacts, narrowed(kRoom)};
  for (ContactCondition& condition : limits.contacts)
    condition.bound += kRoom / condition.factor;
  return limits;
}

Result<NearestMotion> Nearest::answer(const TorqueSolution& chosen, bool relaxed) const
{
  Result<NearestMotion> result(std::in_place_type<NearestMotion>, chosen, moved_);
  TorqueSolution& found = std::get<NearestMotion>(result).solution;
  found.relaxed |= relaxed;
  if (!keeps(robot_, support_, limits_, found.w, found.torque, kNoLoad)) // accelerations of 10⁹ rad/s² and the like
    return not_found();
  // what rounding left beyond the range
  for (int j = 0; j < found.torque.size(); ++j)
    found.torque(j) = std::clamp(found.torque(j), limits_.torques.least(j), limits_.torques.most(j));
  return result;
}

Result<NearestMotion> Nearest::find()
{
  using enum QuadraticProgramStatus;
  const AdmissibleReactions all = admissible_reactions(robot_, equations_, support_);
  const WrenchVector error = contact_error(robot_, equations_, support_, settings_);
  const double force = kKept * robot_.weight();
  const bool met =
      all.unmet.head<2>().cwiseAbs().maxCoeff() <= force && std::abs(all.unmet(2)) <= force * robot_.leg_length;
  const bool rests = error.size() == 0 || error.cwiseAbs().maxCoeff() <= kKept * contact_scale(equations_, support_);
  if (met && rests)
    if (const std::optional<Reactions> own = usual(all))
    {
      Result<NearestMotion> result(std::in_place_type<NearestMotion>,
                                   torques_of(*own, all.redundancy == 0 ? Method::none : method_), std::nullopt);
      const TorqueSolution& found = std::get<NearestMotion>(result).solution;
      if (keeps(robot_, support_, limits_, found.w, found.torque, kKept))
        return result;
    }

  MotionSpace space(robot_, equations_, support_, all, error, settings_.metric);
  if (space.singular())
    return Refusal(
        Reason::numerical,
        "a link of {} can move without mass or inertia, so that M does not tell accelerations apart; expected "
        "mass or inertia, or [nearest] metric = \"angles\"",
        robot_.name);
  moved_ = VectorQ::Zero(robot_.mechanism.num_q());
  const bool contradictory = space.contradictory();
  move_to(space, space.least_change());

  // the least change that contacts and rows without motors ask for may be all
  if (const std::optional<TorqueSolution> found = choose())
    return answer(*found, contradictory);

  const Eigen::Matrix3d D = space.span();
  const VectorQ least = moved_;
  const bool bounded = limits_.torques.most.array().isFinite().any() || limits_.torques.least.array().isFinite().any();
  for (const bool motors : {false, true})
  {
    if (motors && !bounded)
      break;
    move_to(space, least);
    const AdmissibleReactions all0 = admissible_reactions(robot_, equations_, support_);
    const std::optional<TorqueRange> range = motors ? std::optional(narrowed(2.0 * kRoom)) : std::nullopt;
    MotionProgram built(robot_, equations_, support_, all0, space, D, limits_.contacts, range);
    const BoundedVector<kMaxVariables> from = BoundedVector<kMaxVariables>::Zero(built.program.g.size());
    QuadraticProgramSolution solution = solve_semidefinite(built.program, from);
    if (solution.status == infeasible && bounded && !motors)
      continue;
    bool relaxed = contradictory;
    std::optional<VectorQ> least_violating;
    if (solution.status == infeasible)
    {
      relaxed = true;
      least_violating = built.relax(limits_.contacts, kRoom);
      if (least_violating)
        solution = solve_semidefinite(built.program, *least_violating);
    }
    if (solution.status != optimal && !least_violating)
      return not_found();

    // where rounding has closed what was granted, the motion that violates least is answered, if not the nearest one
    const VectorQ variables =
        built.unit.cwiseProduct(solution.status == optimal ? VectorQ(solution.y) : *least_violating);
    const VectorQ zeta = variables.head(built.zeta);
    move_to(space, space.change(zeta));
    if (const std::optional<TorqueSolution> found = choose())
      return answer(*found, relaxed);
    if (motors || !bounded)
    {
      // rounding has closed the one point that there was: that of level 1
      const AdmissibleReactions now = admissible_reactions(robot_, equations_, support_);
      Eigen::Vector3d y = Eigen::Vector3d::Zero();
      for (int k = 0; k < now.redundancy; ++k)
        y(k) = variables(built.zeta + k);
      return answer(torques_of(Reactions(now, y), now.redundancy == 0 ? Method::none : method_), relaxed);
    }
  }
  return not_found();
}

} // namespace

Result<NearestMotion> nearest_motion(const Robot& robot, const Support& support, Method method,
                                     const MethodSettings& methods, const NearestSettings& settings,
                                     const TorqueRange& range, SupportEquations& equations)
{
  return Nearest(robot, support, method, methods, settings, range, equations).find();
}

} // namespace torqued
