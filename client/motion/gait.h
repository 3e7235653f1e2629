/// Walks that a robot with two feet and knees can do, made up: a motion on which methods of double support can be
/// compared, and a first desired motion for a controller.
#pragma once

#include "motion/failure.h"
#include "stance/desired_state.h"

#include <array>
#include <string>
#include <vector>

namespace torqued
{

/// Lengths in m, times in s, angles in rad.
struct GaitOptions
{
  double step_length;    ///< from one foothold to the next, of the other foot
  double step_time;      ///< of a single and a double support
  double double_support; ///< share of the step time
  double first_part;     ///< share of double support in which the trailing foot is still flat
  double heel_strike;    ///< pitch of the foot that lands, toe up
  double toe_off;        ///< pitch of the foot that lifts, heel up
  double hip_height;     ///< of the base point
  double clearance;      ///< how much higher than straight from toe-off to heel strike the ankle swings
  double trunk_angle;    ///< counter-clockwise; negative leans forward
  bool flat_footed; ///< feet stay level, and both are on their soles in double support; the first part, heel strike
                    ///< and toe off do not matter then
  double standing;  ///< for how long the robot stands before the first and after the last step; 0: the walk is a
                    ///< stretch of one that goes on for ever
  int steps;
};

/// A moderate walk for a robot of this size.
GaitOptions default_gait(const Robot& robot);

/// What feet do for a while. SSP: one foot flat, the other one swings. DSP1: trailing foot flat, leading one rolls down
/// on its heel. DSP2: leading foot flat, trailing one rolls off on its toe. Flat: both feet flat; also standing.
enum class GaitPhaseKind
{
  ssp,
  dsp1,
  dsp2,
  flat
};

struct GaitPhase
{
  GaitPhaseKind kind;
  int step;          ///< from 0; even: the left foot carries, and leads after it. −1: standing before the first
  double begin, end; ///< s
  /// load_transfer and phase at begin and end: 0 and 1 of a whole double support; standing is half of one.
  double load_begin, load_end, share_begin, share_end;
};

/// What a user should know about a walk.
struct GaitReport
{
  double zmp_margin; ///< least distance of the zero-moment point from the ends of the sole in single support, m;
                     ///< negative outside
  double
      switch_margin; ///< from the trailing toe and the leading heel where the trailing heel lifts, m; negative outside
  double zmp_error;  ///< largest distance of the zero-moment point from where it was meant to be, m
  double knee_flexion; ///< least, rad
};

/// A walk that its hips are too high for.
class LegTooShort : public Failure
{
  using Failure::Failure;
};

/// A walk: of equal steps, each the mirror image of the one before; or, from standing to standing, with both feet side
/// by side at its begin and its end, so that the first and the last step are half as long a way for the foot that
/// swings.
///
/// The feet rest at touch-down, at the change from DSP1 to DSP2 and at lift-off: rates and accelerations are zero
/// there; between, feet follow polynomials of fifth degree. The trunk keeps its angle and the base point its height.
/// Its x is found so that the zero-moment point of the whole robot runs along the carrying sole in single support and
/// from foot to foot in double support: uniform motion plus a Fourier series over a step; or, from standing, a spline
/// of fifth degree over the whole walk that is at rest at both ends. So position, rate and acceleration of every angle
/// are continuous, contacts rest exactly, and no foot is fixed by more than it can do.
class Gait
{
public:
  /// Throws Failure: usage for options out of range or out of reach, with what to change (LegTooShort is one of these);
  /// bad_configuration for a robot that is not made of a floating trunk and two legs of thigh, shin and foot.
  Gait(const Robot& robot, const GaitOptions& options);

  const GaitOptions& options() const { return options_; }
  /// In the order of time, from 0, without gaps.
  const std::vector<GaitPhase>& phases() const { return phases_; }
  const GaitReport& report() const { return report_; }

  /// The motion at t, seen as part of a phase: at its begin or end the one-sided limit. Base given; load_transfer,
  /// phase and leading foot as in desired_state_t; utime is t in µs.
  DesiredState at(double t, const GaitPhase& phase) const;

  /// Why feet or motors cannot do this walk with the method `constrained`, with what to change; empty if they can:
  /// no foot slips, lifts or tips, and no motor passes its limit.
  std::string obstacle() const;

private:
  void plan_phases();
  const GaitPhase& phase_at(double t) const;
  std::array<double, 3> hip(double t) const; // x of the base point and its derivatives
  void find_periodic_hip_motion();
  void find_hip_motion_from_standing();
  double zmp(double t, const GaitPhase& phase) const;
  std::vector<const GaitPhase*> different_phases() const; // those that later steps repeat but once
  GaitReport survey() const;

  Robot robot_;
  GaitOptions options_;
  std::vector<GaitPhase> phases_;
  double offset_ = 0.0;               // of the base point's x, m
  std::vector<double> cosine_, sine_; // its Fourier coefficients, from the first harmonic, m
  std::vector<double> control_;       // its spline's coefficients, m; empty without standing
  double knot_ = 0.0;                 // s between its knots
  GaitReport report_;
};

} // namespace torqued
