#include "answer/answer.h"

#include "methods/torque_solution.h"
#include "nearest/nearest_motion.h"
#include "stance/checks.h"
#include "stance/projection.h"
#include "wire/command_fields.h"
#include "wire/finite.h"

#include <algorithm>
#include <cmath>
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
  // the nearest motion keeps its contacts, whatever feedback adds to the desired acceleration
  const bool may_move = settings.methods.infeasible == OnInfeasible::nearest;
  if ((on_ground && at_rest && (stays || may_move)) || settings.consistency == OnExcess::flag)
    return {};
  if (!on_ground)
    return Refusal(
        Reason::inconsistent,
        "the {} foot's {} carries, and is {:.3g} m {} the ground z = 0, more than contact_height_tolerance, {:.3g} m",
        name_of(errors.farthest), name_of(support.of(errors.farthest)), std::abs(errors.height),
        errors.height > 0.0 ? "above" : "below", settings.contact_height_tolerance);
  return Refusal(Reason::inconsistent,
                 "the motion gives its contacts a speed of {:.3g} (up to {:.3g} m/s, rad/s), an acceleration of {:.3g} "
                 "(up to {:.3g} m/s^2, rad/s^2) and tilts a sole by {:.3g} (up to {:.3g} rad)",
                 errors.speed, settings.contact_speed_tolerance, errors.acceleration, settings.contact_tolerance,
                 errors.tilt, settings.sole_tilt_tolerance);
}

// A sum of zeros that is not a number if one of the fields is not finite.
struct Finite
{
  double sum = 0.0;

  void operator()(const char*, double number) { sum += 0.0 * number; }
  void operator()(const char*, const Eigen::Vector2d& numbers) { sum += 0.0 * numbers.sum(); }
  // Wrenches, torque and a are left out, for the rows "single support" of tools/bench: the dynamics residual is no
  // number if one of theirs is none.
  void operator()(const char*, const GroundReaction& foot) { sum += 0.0 * (foot.cop + foot.friction_ratio); }
  void operator()(const char*, const VectorQ&) {}
  void operator()(const char*, std::int32_t) {}
  void operator()(const char*, Method) {}
};

bool all_finite(const Answer& answer)
{
  Finite finite;
  for_each_field(finite, answer);
  return is_finite(finite.sum);
}

// The coordinates' accelerations: those asked for, or, where the motion was moved, a, in the coordinates that were
// asked in.
void set_accelerations(const Robot& robot, const DesiredState& asked, const VectorQ& a, bool moved, Answer& answer)
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
    answer.a.noalias() = robot.A.topLeftCorner(n, n) * a.head(n);
  else
    answer.a = a.head(n);
  answer.adjustment = (answer.a - before).lpNorm<Eigen::Infinity>();
}

// What the nearest motion may ask of each motor: its limits, and, if they clamp, its rates. Where the last torque lies
// beyond a limit, the rate has the last word, as in apply_limits().
TorqueRange torque_range(const Robot& robot, const AnswerSettings& settings, const Elapsed& elapsed,
                         const StreamMemory& memory)
{
  TorqueRange range(robot);
  if (settings.rate_limits == OnExcess::clamp && elapsed.follows)
    for (int j = 0; j < robot.num_joints(); ++j)
    {
      const double step = robot.actuators[static_cast<std::size_t>(j)].rate_limit * elapsed.seconds();
      const double lowest = memory.torque(j) - step, highest = memory.torque(j) + step;
      range.least(j) = std::clamp(range.least(j), lowest, highest);
      range.most(j) = std::clamp(range.most(j), lowest, highest);
    }
  return range;
}

// What belongs together while a sample is answered. asked, desired: the motion as it was sent, and as it was projected,
// if it was.
struct Sample
{
  const Robot& robot;
  const AnswerSettings& settings;
  const DesiredState &asked, &desired;
  const ContactErrors& errors;
  const Elapsed& elapsed;
  StreamMemory& memory;
  const std::optional<OwnClock>& clock;
};

// equations: of the motion that is answered; a: its acceleration; moved: whether that is another than was asked for
std::optional<Refusal> complete(const Sample& sample, const SupportEquations& equations, const VectorQ& a, bool moved,
                                std::int32_t flags, TorqueSolution& solution, Answer& answer)
{
  const Robot& robot = sample.robot;
  const DesiredState& desired = sample.desired;
  StreamMemory& memory = sample.memory;
  const Elapsed& elapsed = sample.elapsed;
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
  answer.contact_speed = sample.errors.speed;
  answer.contact_residual = sample.errors.acceleration;
  set_accelerations(robot, sample.asked, a, moved, answer);
  if (!robot.fixed_root())
    answer.base_a = equations.base_acceleration;
  if (!keeps_limits(robot, elapsed, memory, solution.torque))
  {
    if (const auto refusal = check_magnitude(robot, solution.torque))
      return *refusal;
    if (const auto refusal = apply_limits(robot, sample.settings, elapsed, memory, solution.torque, flags))
      return *refusal;
  }
  answer.dynamics_residual = dynamics_residual(robot, equations, solution);
  answer.flags = flags;
  answer.torque = solution.torque;
  if (!all_finite(answer))
    return Refusal(Reason::numerical, "a result is not finite; the motion's numbers are too large");

  memory.answered = true;
  memory.stream_id = desired.stream_id;
  memory.utime = desired.utime;
  memory.now = sample.clock ? sample.clock->now : 0;
  memory.ahead = elapsed.ahead;
  memory.torque = solution.torque;
  return {};
}

// the nearest motion that can be had, completed
std::optional<Refusal> answer_nearest(const Sample& sample, SupportEquations& equations, std::int32_t flags,
                                      Answer& answer)
{
  const auto& [robot, settings, asked, desired, errors, elapsed, memory, clock] = sample;
  Result<NearestMotion> found =
      nearest_motion(robot, desired.support, desired.method, settings.methods, settings.nearest,
                     torque_range(robot, settings, elapsed, memory), equations);
  if (const Refusal* refusal = std::get_if<Refusal>(&found))
    return *refusal;
  auto& [solution, change] = std::get<NearestMotion>(found);
  if (!change)
    return complete(sample, equations, desired.a, (flags & flag::projected) != 0, flags, solution, answer);
  return complete(sample, equations, desired.a + *change, true, flags | flag::adjusted, solution, answer);
}

// before: how far the motion was from its contacts before it was projected; empty if it was not
std::optional<Refusal> answer_motion(const Robot& robot, const AnswerSettings& settings, const DesiredState& asked,
                                     const DesiredState& desired, const std::optional<ContactErrors>& before,
                                     StreamMemory& memory, const std::optional<OwnClock>& clock, Answer& answer)
{
  Result<SupportEquations> built = support_equations(robot, desired);
  if (const Refusal* refusal = std::get_if<Refusal>(&built))
    return *refusal;
  SupportEquations& equations = std::get<SupportEquations>(built);
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

  const Elapsed elapsed = elapsed_since(memory, desired, clock);
  const Sample sample{robot, settings, asked, desired, errors, elapsed, memory, clock};
  if (settings.methods.infeasible == OnInfeasible::nearest)
    return answer_nearest(sample, equations, flags, answer);

  Result<TorqueSolution> solved =
      solve_torques(robot, equations, desired.support, desired.method, settings.methods, settings.residual_tolerance);
  if (const Refusal* refusal = std::get_if<Refusal>(&solved))
    return *refusal;
  return complete(sample, equations, desired.a, (flags & flag::projected) != 0, flags, std::get<TorqueSolution>(solved),
                  answer);
}

} // namespace

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
