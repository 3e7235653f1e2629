// A walk is checked at samples: survey() finds its margins, which no method changes, and obstacle() computes its
// torques by the method `constrained`, which keeps all contacts and limits if any method can. Each sample is answered
// by itself, with nothing remembered of the one before: an obstacle is one of the instant, at any rate of samples.

#include "motion/gait.h"

#include "answer/answer.h"
#include "motion/gait_parts.h"
#include "stance/checks.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace torqued
{

std::vector<const GaitPhase*> Gait::different_phases() const
{
  const bool standing = options_.standing > 0.0;
  std::vector<const GaitPhase*> phases;
  for (const GaitPhase& phase : phases_)
    if (phase.step < (standing ? 3 : 2) || (standing && phase.step >= options_.steps - 3))
      phases.push_back(&phase);
  return phases;
}

GaitReport Gait::survey() const
{
  constexpr int samples = 200;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  GaitReport report{infinity, infinity, 0.0, infinity};
  double lowest = 0.0, lowest_at = 0.0;
  for (const GaitPhase* one : different_phases())
    for (int i = 0; i <= samples; ++i)
    {
      const GaitPhase& phase = *one;
      const double t = phase.begin + (phase.end - phase.begin) * i / samples;
      const DesiredState state = at(t, phase);
      const auto equations = std::get<SupportEquations>(support_equations(robot_, state));
      const double x = zero_moment_point(robot_, equations);
      const Side carrying = carrying_side(phase);
      std::array<FootPose, 2> feet;
      for (const Side side : kSides)
        feet[static_cast<std::size_t>(side)] = foot_pose(robot_, equations.now, robot_.foot(side));
      const FootPose& foot = feet[static_cast<std::size_t>(carrying)];
      const FootPose& next = feet[static_cast<std::size_t>(other(carrying))];
      report.zmp_error = std::max(report.zmp_error, std::abs(x - wished_zmp(robot_, options_, t, phase)));
      if (phase.kind == GaitPhaseKind::ssp)
        report.zmp_margin = std::min({report.zmp_margin, x - foot.heel.x(), foot.toe.x() - x});
      if (phase.kind == GaitPhaseKind::flat)
        report.zmp_margin = std::min(
            {report.zmp_margin, x - std::min(foot.heel.x(), next.heel.x()), std::max(foot.toe.x(), next.toe.x()) - x});
      if (phase.kind == GaitPhaseKind::dsp2 && i == 0)
        report.switch_margin = std::min({report.switch_margin, x - foot.toe.x(), next.heel.x() - x});
      for (const Side side : kSides)
      {
        const Leg leg = leg_of(robot_, side);
        report.knee_flexion = std::min(report.knee_flexion, state.q(robot_.link(leg.thigh).coordinate) -
                                                                state.q(robot_.link(leg.shin).coordinate));
      }
      for (const FootPose& pose : feet)
        if (const double height = std::min(pose.heel.y(), pose.toe.y()); height < lowest)
        {
          lowest = height;
          lowest_at = t;
        }
    }
  if (lowest < -1e-9 * robot_.leg_length)
    throw Failure(ExitCode::usage,
                  "at {:.3f} s the swinging foot would be {:.3g} m below the ground; more --clearance would do",
                  lowest_at, -lowest);
  return report;
}

std::string Gait::obstacle() const
{
  constexpr int samples = 40;
  constexpr std::array<const char*, 4> names{"single support", "the first part of double support",
                                             "the second part of double support", "double support"};
  AnswerSettings settings;
  settings.methods.method = Method::constrained;
  for (const GaitPhase* phase : different_phases())
    for (int i = 0; i <= samples; ++i)
    {
      const double t = phase->begin + (phase->end - phase->begin) * i / samples;
      const DesiredState state = at(t, *phase);
      StreamMemory memory;
      const Result<Answer> result = answer(robot_, settings, state, memory);
      const std::string when = fmt::format("at {:.3f} s, in {},", t, names[static_cast<std::size_t>(phase->kind)]);
      if (const Refusal* refusal = std::get_if<Refusal>(&result))
        return fmt::format("{} it cannot be answered: {}", when, refusal->detail());
      const Answer& found = std::get<Answer>(result);
      if ((found.flags & flag::lifts) != 0)
        return fmt::format("{} the ground would have to pull a foot; a longer --step-time would do", when);
      if ((found.flags & flag::tips) != 0)
        return fmt::format(
            "{} a foot would tip: the zero-moment point is at {:.3f} m, {:.3f} m from where it was meant to be; a "
            "longer --step-time, more --double-support or a shorter --step-length would do",
            when, found.zmp, std::abs(found.zmp - wished_zmp(robot_, options_, t, *phase)));
      if ((found.flags & flag::slips) != 0)
        return fmt::format("{} a foot would slip: it needs a friction coefficient of {:.2f}, and has {:.2f}; a longer "
                           "--step-time or a shorter --step-length would do",
                           when, std::max(found.ground[0].friction_ratio, found.ground[1].friction_ratio),
                           robot_.foot(Side::left).friction);
      for (int j = 0; j < robot_.num_joints() && (found.flags & flag::over_torque) != 0; ++j)
        if (const Actuator& motor = robot_.actuators[static_cast<std::size_t>(j)];
            std::abs(found.torque(j)) > motor.torque_limit)
          return fmt::format(
              "{} {} would need {:.4g} N m, and has {:.4g}; a higher --hip-height or a longer --step-time would do",
              when, motor.name, std::abs(found.torque(j)), motor.torque_limit);
    }
  return "";
}

} // namespace torqued
