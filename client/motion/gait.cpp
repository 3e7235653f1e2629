// A walk is planned from the ground up, a layer in each file:
//
//   gait.cpp        phases, from the options; the desired state at a time
//   gait_feet.cpp   footholds, motion of the feet, wished zero-moment point
//   gait_hip.cpp    x of the base point, by which the zero-moment point is the wished one
//   gait_leg.cpp    inverse kinematics: thigh and shin of each leg
//   gait_check.cpp  margins, and feasibility by the method constrained
//
// Feet and hips are closed-form functions of time with their first two derivatives. So angles, rates and accelerations
// agree to rounding, at any rate of samples, and contacts rest exactly: nothing is differentiated numerically.
//
// Example, one step of default_gait(): single support for 60 % of it, the left sole down, the right foot swinging from
// toe-off to heel strike; for 20 % the right foot rolls down on its heel, the left one still flat; for 20 % the left
// foot rolls off on its toe, the right one flat. Then left and right are exchanged.

#include "motion/gait.h"

#include "motion/gait_parts.h"
#include "motion/unit_names.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace torqued
{

namespace
{

void require_between(double value, double least, double most, const char* option, const char* unit_name,
                     double shown_unit = 1.0)
{
  if (!(value >= least && value <= most))
    throw Failure(ExitCode::usage, "--{}: found {:.4g}; expected {:.4g} to {:.4g}{}{}", option, value / shown_unit,
                  least / shown_unit, most / shown_unit, *unit_name ? " " : "", unit_name);
}

void require_suited(const Robot& robot)
{
  const auto unsuited = [&](const std::string& why)
  {
    return Failure(ExitCode::bad_configuration,
                   "{} cannot walk like this: {}; expected a floating trunk and two legs of thigh, shin and foot, each "
                   "with a joint that turns, and soles with extent, as in ck or rk",
                   robot.name, why);
  };
  if (robot.fixed_root())
    throw unsuited("its root is fixed to the world");
  if (robot.trunk != robot.root())
    throw unsuited("its root is not what both legs carry");
  for (const Side side : kSides)
  {
    const Foot& foot = robot.foot(side);
    if (!foot.has_extent())
      throw unsuited(fmt::format("its {} foot has no extent", name_of(side)));
    const int shin = robot.link(foot.link).parent;
    const int thigh = shin < 0 ? -1 : robot.link(shin).parent;
    const bool leg = thigh >= 0 && robot.link(thigh).parent == robot.trunk &&
                     robot.link(thigh).joint == JointKind::revolute &&
                     robot.link(foot.link).joint == JointKind::revolute &&
                     (robot.link(shin).joint == JointKind::revolute || robot.link(shin).joint == JointKind::rolling);
    if (!leg)
      throw unsuited(fmt::format("its {} leg is made otherwise", name_of(side)));
  }
  if (robot.num_coordinates() != 7)
    throw unsuited(fmt::format("it has {} coordinates", robot.num_coordinates()));
}

void require_in_range(const Robot& robot, const GaitOptions& options)
{
  const double leg = robot.leg_length;
  require_between(options.step_length, 0.0, 2.0 * leg, "step-length", "m");
  require_between(options.step_time, 0.05, 60.0, "step-time", "s");
  require_between(options.double_support, 0.01, 0.99, "double-support", "of the step time");
  require_between(options.first_part, 0.01, 0.99, "first-part", "of double support");
  require_between(options.heel_strike, 0.0, 60.0 * kDegree, "heel-strike", "degrees", kDegree);
  require_between(options.toe_off, 0.0, 60.0 * kDegree, "toe-off", "degrees", kDegree);
  require_between(options.hip_height, 0.0, 2.0 * leg, "hip-height", "m");
  require_between(options.clearance, 0.0, leg, "clearance", "m");
  require_between(options.trunk_angle, -60.0 * kDegree, 60.0 * kDegree, "trunk-angle", "degrees", kDegree);
  require_between(options.steps, 1, 1000, "steps", "");
  if (options.standing != 0.0)
    require_between(options.standing, 0.1, 60.0, "standing", "s");
}

} // namespace

GaitOptions default_gait(const Robot& robot)
{
  const double leg = robot.leg_length;
  const double h_p = std::max(robot.foot(Side::left).ankle_height(), robot.foot(Side::right).ankle_height());
  // times scale as those of a pendulum of the leg's length
  return {.step_length = 0.45 * leg,
          .step_time = 2.6 * std::sqrt(leg / robot.mechanism.gravity()),
          .double_support = 0.4,
          .first_part = 0.5,
          .heel_strike = 10.0 * kDegree,
          .toe_off = 15.0 * kDegree,
          .hip_height = 0.94 * leg + h_p,
          .clearance = 0.04 * leg,
          .trunk_angle = 0.0,
          .flat_footed = false,
          .standing = 0.0,
          .steps = 4};
}

Gait::Gait(const Robot& robot, const GaitOptions& options) : robot_(robot), options_(options)
{
  require_suited(robot);
  require_in_range(robot, options);
  plan_phases();
  if (options.standing > 0.0)
    find_hip_motion_from_standing();
  else
    find_periodic_hip_motion();
  report_ = survey();
}

void Gait::plan_phases()
{
  const double standing = options_.standing, first = options_.first_part;
  const double double_support = options_.double_support * options_.step_time;
  if (standing > 0.0)
    phases_.push_back({GaitPhaseKind::flat, -1, 0.0, standing, 0.5, 1.0, 0.5, 1.0});
  for (int step = 0; step < options_.steps; ++step)
  {
    const double begin = standing + step * options_.step_time, end = standing + (step + 1) * options_.step_time;
    const double touch_down = end - double_support;
    const double heel_off = touch_down + first * double_support;
    phases_.push_back({GaitPhaseKind::ssp, step, begin, touch_down, 0.0, 0.0, 0.0, 1.0});
    if (standing > 0.0 && step + 1 == options_.steps)
    {
      phases_.push_back({GaitPhaseKind::flat, step, touch_down, touch_down + standing, 0.0, 0.5, 0.0, 0.5});
    }
    else if (options_.flat_footed)
    {
      phases_.push_back({GaitPhaseKind::flat, step, touch_down, end, 0.0, 1.0, 0.0, 1.0});
    }
    else
    {
      phases_.push_back({GaitPhaseKind::dsp1, step, touch_down, heel_off, 0.0, first, 0.0, 1.0});
      phases_.push_back({GaitPhaseKind::dsp2, step, heel_off, end, first, 1.0, 0.0, 1.0});
    }
  }
}

DesiredState Gait::at(double t, const GaitPhase& phase) const
{
  const int size = robot_.mechanism.num_q();
  const Side carrying = carrying_side(phase);
  DesiredState state{};
  state.utime = std::llround(1e6 * t);
  state.stream_id = 1;
  state.base_given = true;
  state.method = Method::none;
  state.q = state.v = state.a = VectorQ::Zero(size);

  // contacts
  Support& support = state.support;
  const bool single = phase.kind == GaitPhaseKind::ssp;
  support.leading = single ? carrying : other(carrying);
  support.contact[static_cast<std::size_t>(carrying)] =
      phase.kind == GaitPhaseKind::dsp2 ? Contact::toe : Contact::sole;
  support.contact[static_cast<std::size_t>(other(carrying))] = single                              ? Contact::none
                                                               : phase.kind == GaitPhaseKind::dsp1 ? Contact::heel
                                                                                                   : Contact::sole;
  const double share = std::clamp((t - phase.begin) / (phase.end - phase.begin), 0.0, 1.0);
  support.phase = (1.0 - share) * phase.share_begin + share * phase.share_end;
  support.load_transfer = (1.0 - share) * phase.load_begin + share * phase.load_end;

  // trunk and base point
  state.q(robot_.link(robot_.trunk).coordinate) = options_.trunk_angle;
  const std::array<double, 3> x = hip(t);
  state.q.tail<2>() << x[0], options_.hip_height;
  state.v.tail<2>() << x[1], 0.0;
  state.a.tail<2>() << x[2], 0.0;

  place_leg(robot_, carrying, carrying_foot(robot_, options_, t, phase), t, state);
  place_leg(robot_, other(carrying), other_foot(robot_, options_, t, phase), t, state);
  return state;
}

} // namespace torqued
