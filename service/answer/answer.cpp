#include "answer/answer.h"

#include "robot/fnv.h"
#include "stance/projection.h"
#include "wire/finite.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace torqued
{

namespace
{

constexpr double kProjected = 1e-9; // m, rad, and per s and s²: less than this is rounding, and no reason for a flag

// whether the motion keeps its contacts, by where and how they are, and by how they accelerate
std::optional<Refusal> check_consistency(const AnswerSettings& settings, const ContactErrors& errors,
                                         const Support& support, std::int32_t& flags)
{
  const bool on_ground = std::abs(errors.height) <= settings.contact_height_tolerance;
  const bool at_rest = errors.speed <= settings.contact_speed_tolerance && errors.tilt <= settings.sole_tilt_tolerance;
  const bool stays = errors.acceleration <= settings.contact_tolerance;
  flags |= on_ground && at_rest ? 0 : flag::inconsistent;
  flags |= stays ? 0 : flag::contact_acceleration;
  if ((on_ground && at_rest && stays) || settings.consistency == OnExcess::flag)
    return {};
  if (!on_ground)
    return Refusal(Reason::inconsistent,
                   "the {} foot's {} carries, and is {:.3g} m {} the ground z = 0, more than contact_height_tolerance, "
                   "{:.3g} m",
                   name_of(errors.farthest), name_of(support.of(errors.farthest)), std::abs(errors.height),
                   errors.height > 0.0 ? "above" : "below", settings.contact_height_tolerance);
  return Refusal(
      Reason::inconsistent,
      "the motion gives its contacts a speed of {:.3g} (up to {:.3g} m/s, rad/s), an acceleration of {:.3g} (up to "
      "{:.3g} m/s^2, rad/s^2) and tilts a sole by {:.3g} (up to {:.3g} rad)",
      errors.speed, settings.contact_speed_tolerance, errors.acceleration, settings.contact_tolerance, errors.tilt,
      settings.sole_tilt_tolerance);
}

// The time since the answer before, µs, in which torques may have changed.
struct Elapsed
{
  bool follows;       // whether there is an answer before
  std::int64_t time;  // positive; of no consequence if there is none
  std::int64_t ahead; // StreamMemory::ahead after this one
};

Elapsed elapsed_since(const StreamMemory& memory, const DesiredState& desired, const std::optional<OwnClock>& clock)
{
  const bool same_stream = memory.answered && memory.stream_id == desired.stream_id && memory.utime < desired.utime;
  std::int64_t sent = 1;
  if (same_stream && __builtin_sub_overflow(desired.utime, memory.utime, &sent))
    sent = std::numeric_limits<std::int64_t>::max();
  if (!clock || !memory.answered)
    return {same_stream, sent, 0};

  const std::int64_t own = std::max<std::int64_t>(clock->now - memory.now, 0);
  const std::int64_t most = 5 * clock->max_age;
  if (!same_stream)
    return {true, std::clamp<std::int64_t>(own, 1, most), 0};
  const std::int64_t time =
      std::clamp<std::int64_t>(sent, 1, std::max<std::int64_t>(own + clock->max_age - memory.ahead, 1));
  return {true, time, std::max(memory.ahead + time - own, -most)};
}

// Whether a torque is one that a robot of this size could ever need.
std::optional<Refusal> check_magnitude(const Robot& robot, const VectorJ& torque)
{
  const double weight = robot.weight();
  const double most = kMostTorque * weight * std::min(robot.leg_length, 1.0);
  if (torque.lpNorm<Eigen::Infinity>() <= most)
    return {};
  for (int j = 0; j < robot.num_joints(); ++j)
  {
    const Actuator& actuator = robot.actuators[static_cast<std::size_t>(j)];
    const bool slide = is_force(robot, actuator);
    const double limit = kMostTorque * weight * (slide ? 1.0 : robot.leg_length);
    if (!(std::abs(torque(j)) <= limit))
      return Refusal(Reason::numerical,
                     "{} would need {:.4g} {}; expected at most {:.4g}, {} times {}: the motion's numbers are no "
                     "motion of this robot",
                     actuator.name, torque(j), slide ? "N" : "N m", limit, kMostTorque,
                     slide ? "the weight" : "weight times leg length");
  }
  return {};
}

// the last operation before the answer is checked: no torque is changed after this
std::optional<Refusal> apply_limits(const Robot& robot, const AnswerSettings& settings, const Elapsed& elapsed,
                                    const StreamMemory& memory, VectorJ& torque, std::int32_t& flags)
{
  constexpr double rounding = 1.0 + 1e-9;
  const bool follows = elapsed.follows;
  const double dt = 1e-6 * static_cast<double>(elapsed.time); // not 0: 0 times an infinite limit would be no number
  bool in_limits = true;
  const double* now = torque.data();
  const double* before = follows ? memory.torque.data() : now; // of no change, if it follows none
  for (const Actuator& actuator : robot.actuators)
  {
    in_limits &= std::abs(*now) <= actuator.torque_limit;
    in_limits &= std::abs(*now++ - *before++) <= actuator.rate_limit * dt;
  }
  if (in_limits)
    return {};

  for (int j = 0; j < robot.num_joints(); ++j)
  {
    const Actuator& actuator = robot.actuators[static_cast<std::size_t>(j)];
    const bool is_over = std::abs(torque(j)) > actuator.torque_limit * rounding;
    if (is_over)
    {
      flags |= flag::over_torque;
      if (settings.limits == OnExcess::refuse)
        return Refusal(Reason::over_limit, "{} would need {:.4g} N m; its torque limit is {:.4g} N m", actuator.name,
                       torque(j), actuator.torque_limit);
    }
    if (settings.limits == OnExcess::clamp)
    {
      // also what is over by no more than rounding: a clamped torque keeps its limit to the last bit
      flags |= is_over ? flag::clamped : 0;
      torque(j) = std::clamp(torque(j), -actuator.torque_limit, actuator.torque_limit);
    }

    const double step = actuator.rate_limit * dt;
    if (follows && std::abs(torque(j) - memory.torque(j)) > step * rounding)
    {
      flags |= flag::over_rate;
      if (settings.rate_limits == OnExcess::refuse)
        return Refusal(Reason::over_limit, "{} would change by {:.4g} N m in {:.4g} s; its rate limit is {:.4g} N m/s",
                       actuator.name, torque(j) - memory.torque(j), dt, actuator.rate_limit);
      if (settings.rate_limits == OnExcess::clamp)
      {
        flags |= flag::clamped;
        torque(j) = std::clamp(torque(j), memory.torque(j) - step, memory.torque(j) + step);
      }
    }
  }
  return {};
}

void add_weights(Fnv1a& hash, const JointWeights& weights)
{
  hash.add(static_cast<int>(weights.rows()));
  for (const double weight : weights.reshaped())
    hash.add(weight);
}

bool all_finite(const Answer& answer)
{
  // a number that is not finite makes the sum so; a torque, or a foot's wrench, that is not makes the residual so
  double sum = 0.0 * answer.zmp + 0.0 * answer.dynamics_residual;
  sum += 0.0 * answer.contact_speed + 0.0 * answer.contact_residual;
  sum += 0.0 * answer.base_a.x() + 0.0 * answer.base_a.y() + 0.0 * answer.adjustment;
  for (const GroundReaction& foot : answer.ground)
    sum += 0.0 * foot.cop + 0.0 * foot.friction_ratio;
  return is_finite(sum);
}

// The coordinates' accelerations: those asked for, or, where the motion was moved, its own in the coordinates that were
// asked in.
void set_accelerations(const Robot& robot, const DesiredState& asked, const DesiredState& motion, bool moved,
                       Answer& answer)
{
  const int n = robot.num_coordinates();
  const bool relative = asked.relative_a.size() > 0;
  if (relative)
    answer.a = asked.relative_a;
  else
    answer.a = asked.a.head(n);
  if (!moved)
    return;
  const VectorQ before = answer.a;
  if (relative)
    answer.a.noalias() = robot.A.topLeftCorner(n, n) * motion.a.head(n);
  else
    answer.a = motion.a.head(n);
  answer.adjustment = (answer.a - before).lpNorm<Eigen::Infinity>();
}

// asked, desired: the motion as it was sent, and the one that is answered. before: how far the motion was from its
// contacts before it was projected; empty if it was not
std::optional<Refusal> answer_motion(const Robot& robot, const AnswerSettings& settings, const DesiredState& asked,
                                     const DesiredState& desired, const std::optional<ContactErrors>& before,
                                     StreamMemory& memory, const std::optional<OwnClock>& clock, Answer& answer)
{
  const Result<SupportEquations> built = support_equations(robot, desired);
  if (const Refusal* refusal = std::get_if<Refusal>(&built))
    return *refusal;
  const SupportEquations& equations = std::get<SupportEquations>(built);
  const ContactErrors errors = before ? *before
                                      : ContactErrors{.height = equations.contact_height,
                                                      .farthest = equations.farthest,
                                                      .tilt = equations.sole_tilt,
                                                      .speed = equations.contact_speed,
                                                      .acceleration = equations.contact_residual};
  std::int32_t flags = 0;
  if (before && std::max({before->position, before->tilt, before->speed, before->acceleration}) > kProjected)
    flags |= flag::projected;
  if (const auto refusal = check_consistency(settings, errors, desired.support, flags))
    return *refusal;

  Result<TorqueSolution> solved =
      solve_torques(robot, equations, desired.support, desired.method, settings.methods, settings.residual_tolerance);
  if (const Refusal* refusal = std::get_if<Refusal>(&solved))
    return *refusal;
  TorqueSolution& solution = std::get<TorqueSolution>(solved);

  answer.utime = desired.utime;
  answer.stream_id = desired.stream_id;
  answer.method = solution.method;
  for (std::size_t side = 0; side < 2; ++side)
  {
    const Contact contact = desired.support.contact[side];
    if (contact == Contact::none)
      continue;
    answer.ground[side] = ground_reaction(robot, robot.feet[side], equations.feet[side], solution.ground[side]);
    flags |= contact_flags(robot, robot.feet[side], equations.feet[side], contact, solution.ground[side]);
  }
  flags |= solution.clamped ? flag::clamped : 0;
  flags |= solution.relaxed ? flag::relaxed : 0;
  answer.zmp = zero_moment_point(robot, equations);
  answer.contact_speed = errors.speed;
  answer.contact_residual = errors.acceleration;
  set_accelerations(robot, asked, desired, (flags & flag::projected) != 0, answer);
  if (!robot.fixed_root())
    answer.base_a = equations.base_acceleration;
  if (const auto refusal = check_magnitude(robot, solution.torque))
    return *refusal;
  const Elapsed elapsed = elapsed_since(memory, desired, clock);
  if (const auto refusal = apply_limits(robot, settings, elapsed, memory, solution.torque, flags))
    return *refusal;
  answer.dynamics_residual = dynamics_residual(robot, equations, solution);
  answer.flags = flags;
  copy_whole(solution.torque, answer.torque);
  if (!all_finite(answer))
    return Refusal(Reason::numerical, "a result is not finite; the motion's numbers are too large");

  memory.answered = true;
  memory.stream_id = desired.stream_id;
  memory.utime = desired.utime;
  memory.now = clock ? clock->now : 0;
  memory.ahead = elapsed.ahead;
  copy_whole(solution.torque, memory.torque);
  return {};
}

} // namespace

std::int64_t settings_id(const AnswerSettings& settings)
{
  Fnv1a hash;
  const MethodSettings& methods = settings.methods;
  hash.add(static_cast<int>(methods.method));
  add_weights(hash, methods.pseudo_inverse.weights);
  for (const double weight : methods.pseudo_inverse.reaction_weights)
    hash.add(weight);
  hash.add(methods.linear_transition.leading_cop.value_or(-1.0));
  hash.add(methods.internal_wrench.sigma);
  add_weights(hash, methods.internal_wrench.weights);
  add_weights(hash, methods.torso_wrench.weights);
  add_weights(hash, methods.constrained.weights);
  hash.add(static_cast<int>(methods.constrained.windows));
  hash.add(methods.constrained.reference_weight);
  hash.add(methods.constrained.f_min.value_or(-1.0));
  for (const double number : {methods.human_transition.trailing_cop, methods.human_transition.leading_cop,
                              methods.human_transition.time_weight, methods.human_transition.fade})
    hash.add(number);
  hash.add(static_cast<int>(methods.relax));
  hash.add(static_cast<int>(settings.consistency));
  hash.add(settings.contact_speed_tolerance);
  hash.add(settings.contact_tolerance);
  hash.add(settings.sole_tilt_tolerance);
  hash.add(settings.contact_height_tolerance);
  hash.add(settings.residual_tolerance);
  hash.add(static_cast<int>(settings.project));
  hash.add(static_cast<int>(settings.limits));
  hash.add(static_cast<int>(settings.rate_limits));
  return hash.id();
}

Result<DesiredState> answered_motion(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired)
{
  if (!settings.project)
    return desired;
  const Result<Projection> projected = project(robot, desired);
  if (const Refusal* refusal = std::get_if<Refusal>(&projected))
    return *refusal;
  return std::get<Projection>(projected).state;
}

Result<Answer> answer(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired,
                      StreamMemory& memory, const std::optional<OwnClock>& clock)
{
  Result<Answer> result(std::in_place_type<Answer>);
  const auto fill = [&](const DesiredState& motion, const std::optional<ContactErrors>& before)
  {
    if (const auto refusal =
            answer_motion(robot, settings, desired, motion, before, memory, clock, std::get<Answer>(result)))
      result = *refusal;
  };
  if (!settings.project)
  {
    fill(desired, {});
    return result;
  }
  const Result<Projection> projected = project(robot, desired);
  if (const Refusal* refusal = std::get_if<Refusal>(&projected))
    result = *refusal;
  else
    fill(std::get<Projection>(projected).state, std::get<Projection>(projected).before);
  return result;
}

void flush_denormals()
{
#if defined(__SSE2__)
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _mm_setcsr(_mm_getcsr() | 0x0040); // denormals are zero
#elif defined(__aarch64__)
  std::uint64_t fpcr;
  __asm__ volatile("mrs %0, fpcr" : "=r"(fpcr));
  __asm__ volatile("msr fpcr, %0" : : "r"(fpcr | (std::uint64_t{1} << 24)));
#endif
}

} // namespace torqued
