// Feet move along two polynomials in u = (t − begin) / (end − begin), whose first and second derivatives vanish at both
// ends: so a foot is at rest, without acceleration, where its contact changes.
//
//   blend(u) = 10 u³ − 15 u⁴ + 6 u⁵       from 0 to 1
//   bump(u)  = 64 u³ (1 − u)³             from 0 to 1 and back
//
// Rolling, a foot turns by its pitch α about its toe or heel, which is at rest. With r from there to the ankle, and r⊥
// turned by 90°,
//
//   p = pivot + r(α),   ṗ = α̇ r⊥,   p̈ = α̈ r⊥ − α̇² r
//
// Swinging, its ankle and pitch follow blend from lift-off to touch-down, and its height bump in addition.

#include "motion/gait_parts.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

Course blend(double t, const GaitPhase& phase)
{
  const double T = phase.end - phase.begin;
  const double u = std::clamp((t - phase.begin) / T, 0.0, 1.0);
  return {u * u * u * (10.0 + u * (-15.0 + 6.0 * u)), 30.0 * u * u * (1.0 - u) * (1.0 - u) / T,
          60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (T * T)};
}

Course bump(double t, const GaitPhase& phase)
{
  const double T = phase.end - phase.begin;
  const double u = std::clamp((t - phase.begin) / T, 0.0, 1.0);
  const double w = u * (1.0 - u), dw = 1.0 - 2.0 * u;
  return {64.0 * w * w * w, 192.0 * w * w * dw / T, 384.0 * w * (dw * dw - w) / (T * T)};
}

Course between(double from, double to, const Course& share)
{
  return {from + (to - from) * share.x, (to - from) * share.v, (to - from) * share.a};
}

// Pitches of the foot that swings in a step: 0 of feet that stay level, and where the robot stands.
double pitch_at_lift_off(const GaitOptions& options, int step)
{
  const bool flat = options.flat_footed || (options.standing > 0.0 && step == 0);
  return flat ? 0.0 : -options.toe_off;
}

double pitch_at_touch_down(const GaitOptions& options, int step)
{
  const bool flat = options.flat_footed || (options.standing > 0.0 && step + 1 == options.steps);
  return flat ? 0.0 : options.heel_strike;
}

enum class Pivot
{
  heel,
  toe
};

// foothold: the ankle's x with the foot flat; from, to: pitches at the ends of the phase
FootMotion roll(const Foot& foot, double foothold, Pivot about, double from, double to, double t,
                const GaitPhase& phase)
{
  const bool toe = about == Pivot::toe;
  const Eigen::Vector2d pivot(foothold + (toe ? foot.toe_x() : foot.heel_x()), 0.0);
  const Course pitch = between(from, to, blend(t, phase));
  const Eigen::Vector2d r =
      rotate({std::cos(pitch.x), std::sin(pitch.x)}, foot.ankle_at - (toe ? foot.toe_at : foot.heel_at));
  return {pivot + r, pitch.v * perp(r), pitch.a * perp(r) - pitch.v * pitch.v * r, pitch};
}

} // namespace

Side carrying_side(const GaitPhase& phase)
{
  return phase.step % 2 == 0 ? Side::left : Side::right;
}

double foothold(const GaitOptions& options, int step)
{
  return options.step_length * (options.standing > 0.0 ? std::clamp(step, 0, options.steps - 1) : step);
}

FootMotion carrying_foot(const Robot& robot, const GaitOptions& options, double t, const GaitPhase& phase)
{
  const Foot& foot = robot.foot(carrying_side(phase));
  const double lifted = phase.kind == GaitPhaseKind::dsp2 ? pitch_at_lift_off(options, phase.step + 1) : 0.0;
  return roll(foot, foothold(options, phase.step), Pivot::toe, 0.0, lifted, t, phase);
}

FootMotion other_foot(const Robot& robot, const GaitOptions& options, double t, const GaitPhase& phase)
{
  const Foot& foot = robot.foot(other(carrying_side(phase)));
  const double next = foothold(options, phase.step + 1);
  const double lifted = pitch_at_lift_off(options, phase.step), landing = pitch_at_touch_down(options, phase.step);
  if (phase.kind != GaitPhaseKind::ssp)
    return roll(foot, next, Pivot::heel, phase.kind == GaitPhaseKind::dsp1 ? landing : 0.0, 0.0, t, phase);

  const FootMotion from = roll(foot, foothold(options, phase.step - 1), Pivot::toe, lifted, lifted, t, phase);
  const FootMotion to = roll(foot, next, Pivot::heel, landing, landing, t, phase);
  const Course share = blend(t, phase), up = bump(t, phase);
  const Course x = between(from.p.x(), to.p.x(), share), z = between(from.p.y(), to.p.y(), share);
  const double c = options.clearance;
  return {
      {x.x, z.x + c * up.x}, {x.v, z.v + c * up.v}, {x.a, z.a + c * up.a}, between(from.pitch.x, to.pitch.x, share)};
}

double wished_zmp(const Robot& robot, const GaitOptions& options, double t, const GaitPhase& phase)
{
  const Side side = carrying_side(phase);
  const Foot &carrying = robot.foot(side), &next = robot.foot(other(side));
  const double here = foothold(options, phase.step), there = foothold(options, phase.step + 1);
  const auto along = [](const Foot& foot, double share)
  {
    return foot.heel_x() + share * (foot.toe_x() - foot.heel_x());
  };
  constexpr double first = 0.3, last = 0.7, standing = 0.5;
  const double middle = 0.5 * (here + carrying.toe_x() + there + next.heel_x());
  const double share = (t - phase.begin) / (phase.end - phase.begin);
  const auto linear = [&](double from, double to)
  {
    return from + share * (to - from);
  };
  switch (phase.kind)
  {
  case GaitPhaseKind::ssp: return linear(here + along(carrying, first), here + along(carrying, last));
  case GaitPhaseKind::dsp1: return linear(here + along(carrying, last), middle);
  case GaitPhaseKind::dsp2: return linear(middle, there + along(next, first));
  case GaitPhaseKind::flat: break;
  }
  return linear(here + along(carrying, phase.share_begin == 0.0 ? last : standing),
                there + along(next, phase.share_end == 1.0 ? first : standing));
}

} // namespace torqued
