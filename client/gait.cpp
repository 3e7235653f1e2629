#include "client/gait.h"

#include "client/failure.h"
#include "torque/checks.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

namespace torqued
{

namespace
{

constexpr double kDegree = std::numbers::pi / 180.0;

// A function of time and its derivatives.
struct Course
{
  double x, v, a;
};

// from 0 to 1 over a time, at rest at both ends: 10 u³ − 15 u⁴ + 6 u⁵
Course blend(double t, double begin, double end)
{
  const double T = end - begin;
  const double u = std::clamp((t - begin) / T, 0.0, 1.0);
  return {u * u * u * (10.0 + u * (-15.0 + 6.0 * u)), 30.0 * u * u * (1.0 - u) * (1.0 - u) / T,
          60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (T * T)};
}

// from 0 to 1 and back over a time, at rest at both ends: 64 u³ (1 − u)³
Course bump(double t, double begin, double end)
{
  const double T = end - begin;
  const double u = std::clamp((t - begin) / T, 0.0, 1.0);
  const double w = u * (1.0 - u), dw = 1.0 - 2.0 * u;
  return {64.0 * w * w * w, 192.0 * w * w * dw / T, 384.0 * w * (dw * dw - w) / (T * T)};
}

Course between(double from, double to, const Course& share)
{
  return {from + (to - from) * share.x, (to - from) * share.v, (to - from) * share.a};
}

Eigen::Vector2d unit(double angle)
{
  return {std::cos(angle), std::sin(angle)};
}

Side side_of(int step)
{
  return step % 2 == 0 ? Side::left : Side::right;
}

void require(double value, double least, double most, const char* option, const char* unit_name,
             double shown_unit = 1.0)
{
  if (!(value >= least && value <= most))
    throw Failure(ExitCode::usage,
                  fmt::format("--{}: found {:.4g}; expected {:.4g} to {:.4g}{}{}", option, value / shown_unit,
                              least / shown_unit, most / shown_unit, *unit_name ? " " : "", unit_name));
}

} // namespace

// The ankle and the pitch of a foot.
struct Gait::FootMotion
{
  Eigen::Vector2d p, v, a; // m, m/s, m/s²
  Course pitch;            // rad, rad/s, rad/s²
};

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
          .steps = 4};
}

Gait::Gait(const Robot& robot, const GaitOptions& options) : robot_(robot), options_(options)
{
  const auto unsuited = [&](const std::string& why)
  {
    return Failure(
        ExitCode::bad_configuration,
        fmt::format("{} cannot walk like this: {}; expected a floating trunk and two legs of thigh, shin and "
                    "foot, each with a joint that turns, and soles with extent, as in ck or rk",
                    robot.name, why));
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
    legs_[static_cast<std::size_t>(side)] = {thigh, shin, foot.link};
  }
  if (robot.num_coordinates() != 7)
    throw unsuited(fmt::format("it has {} coordinates", robot.num_coordinates()));

  const double leg = robot.leg_length;
  require(options.step_length, 0.0, 2.0 * leg, "step-length", "m");
  require(options.step_time, 0.05, 60.0, "step-time", "s");
  require(options.double_support, 0.01, 0.99, "double-support", "of the step time");
  require(options.first_part, 0.01, 0.99, "first-part", "of double support");
  require(options.heel_strike, 0.0, 60.0 * kDegree, "heel-strike", "degrees", kDegree);
  require(options.toe_off, 0.0, 60.0 * kDegree, "toe-off", "degrees", kDegree);
  require(options.hip_height, 0.0, 2.0 * leg, "hip-height", "m");
  require(options.clearance, 0.0, leg, "clearance", "m");
  require(options.trunk_angle, -60.0 * kDegree, 60.0 * kDegree, "trunk-angle", "degrees", kDegree);
  require(options.steps, 1, 1000, "steps", "");

  const double double_support = options.double_support * options.step_time;
  for (int step = 0; step < options.steps; ++step)
  {
    const double begin = step * options.step_time, end = (step + 1) * options.step_time;
    const double touch_down = end - double_support;
    const double heel_off = touch_down + options.first_part * double_support;
    phases_.push_back({GaitPhaseKind::ssp, step, begin, touch_down});
    phases_.push_back({GaitPhaseKind::dsp1, step, touch_down, heel_off});
    phases_.push_back({GaitPhaseKind::dsp2, step, heel_off, end});
  }
  find_hip_motion();
  report_ = survey();
}

Gait::FootMotion Gait::roll(const Foot& foot, double foothold, bool about_toe, double from, double to, double t,
                            const GaitPhase& phase) const
{
  // foothold: the ankle's x with the foot flat
  const Eigen::Vector2d pivot(foothold + (about_toe ? foot.toe_x() : foot.heel_x()), 0.0);
  const Course pitch = between(from, to, blend(t, phase.begin, phase.end));
  const Eigen::Vector2d r = rotate(unit(pitch.x), foot.ankle_at - (about_toe ? foot.toe_at : foot.heel_at));
  return {pivot + r, pitch.v * perp(r), pitch.a * perp(r) - pitch.v * pitch.v * r, pitch};
}

Gait::FootMotion Gait::carrying_foot(double t, const GaitPhase& phase) const
{
  const Foot& foot = robot_.foot(side_of(phase.step));
  const double lifted = phase.kind == GaitPhaseKind::dsp2 ? -options_.toe_off : 0.0;
  return roll(foot, phase.step * options_.step_length, true, 0.0, lifted, t, phase);
}

Gait::FootMotion Gait::other_foot(double t, const GaitPhase& phase) const
{
  const Foot& foot = robot_.foot(other(side_of(phase.step)));
  const double L = options_.step_length;
  const double next = (phase.step + 1) * L;
  if (phase.kind != GaitPhaseKind::ssp)
    return roll(foot, next, false, phase.kind == GaitPhaseKind::dsp1 ? options_.heel_strike : 0.0, 0.0, t, phase);

  // from toe-off two steps before to heel strike
  const FootMotion from = roll(foot, next - 2.0 * L, true, -options_.toe_off, -options_.toe_off, t, phase);
  const FootMotion to = roll(foot, next, false, options_.heel_strike, options_.heel_strike, t, phase);
  const Course share = blend(t, phase.begin, phase.end);
  const Course up = bump(t, phase.begin, phase.end);
  const Course x = between(from.p.x(), to.p.x(), share);
  const Course z = between(from.p.y(), to.p.y(), share);
  const double c = options_.clearance;
  return {
      {x.x, z.x + c * up.x}, {x.v, z.v + c * up.v}, {x.a, z.a + c * up.a}, between(from.pitch.x, to.pitch.x, share)};
}

// Angles, rates and accelerations of a leg by which its ankle moves as asked, the rest of the state being known.
void Gait::place_leg(Side side, const FootMotion& foot, double t, DesiredState& state) const
{
  const Mechanism& mechanism = robot_.mechanism;
  const Leg& leg = legs_[static_cast<std::size_t>(side)];
  const Point& ankle = robot_.foot(side).ankle;
  const int thigh = robot_.link(leg.thigh).coordinate, shin = robot_.link(leg.shin).coordinate;
  const int foot_coordinate = robot_.link(leg.foot).coordinate;
  state.q(foot_coordinate) = foot.pitch.x;
  state.v(foot_coordinate) = foot.pitch.v;
  state.a(foot_coordinate) = foot.pitch.a;

  // from the hip joint to the ankle, with the thigh upright and the knee bent by β: its length falls with β
  const Eigen::Vector2d target =
      foot.p - position(kinematics(mechanism, state.q, state.v), robot_.link(leg.thigh).origin);
  const auto reach = [&](double flexion) -> Eigen::Vector2d
  {
    state.q(thigh) = 0.0;
    state.q(shin) = -flexion;
    const Kinematics now = kinematics(mechanism, state.q, state.v);
    return position(now, ankle) - position(now, robot_.link(leg.thigh).origin);
  };
  double straight = 0.0, bent = 2.8;
  const double longest = reach(straight).norm(), shortest = reach(bent).norm();
  if (!(target.norm() < longest && target.norm() > shortest))
    throw Failure(
        ExitCode::usage,
        fmt::format("at {:.3f} s the {} ankle is {:.4g} m from the hip, and the leg can be {:.4g} to {:.4g} m "
                    "long; {}",
                    t, name_of(side), target.norm(), shortest, longest,
                    target.norm() >= longest ? "a lower --hip-height or a shorter --step-length would do"
                                             : "a higher --hip-height or less --clearance would do"));
  for (int i = 0; i < 20; ++i) // Newton does the rest
  {
    const double middle = 0.5 * (straight + bent);
    (reach(middle).norm() > target.norm() ? straight : bent) = middle;
  }
  const Eigen::Vector2d found = reach(straight);
  state.q(thigh) = std::atan2(cross(found, target), found.dot(target));
  state.q(shin) = state.q(thigh) - straight;

  // what remains, rates and accelerations: two equations for thigh and shin
  Jacobian J(2, mechanism.num_q());
  const auto solve = [&](const Eigen::Vector2d& rest) -> Eigen::Vector2d
  {
    Eigen::Matrix2d of_leg;
    of_leg << J.col(thigh), J.col(shin);
    return of_leg.partialPivLu().solve(rest);
  };
  for (int i = 0; i < 3; ++i)
  {
    const Kinematics now = kinematics(mechanism, state.q, state.v);
    point_jacobian(mechanism, now, ankle, 0, J);
    const Eigen::Vector2d step = solve(foot.p - position(now, ankle));
    state.q(thigh) += step.x();
    state.q(shin) += step.y();
  }
  state.v(thigh) = state.v(shin) = 0.0;
  point_jacobian(mechanism, kinematics(mechanism, state.q, state.v), ankle, 0, J);
  const Eigen::Vector2d rates = solve(foot.v - J * state.v);
  state.v(thigh) = rates.x();
  state.v(shin) = rates.y();
  state.a(thigh) = state.a(shin) = 0.0;
  const Eigen::Vector2d from_rates = jacobian_rate_times_v(kinematics(mechanism, state.q, state.v), ankle);
  const Eigen::Vector2d accelerations = solve(foot.a - from_rates - J * state.a);
  state.a(thigh) = accelerations.x();
  state.a(shin) = accelerations.y();
}

DesiredState Gait::at(double t, const GaitPhase& phase) const
{
  const int size = robot_.mechanism.num_q();
  const Side carrying = side_of(phase.step);
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
  support.phase = std::clamp((t - phase.begin) / (phase.end - phase.begin), 0.0, 1.0);
  const double end = (phase.step + 1) * options_.step_time;
  const double double_support = options_.double_support * options_.step_time;
  support.load_transfer = single ? 0.0 : std::clamp(1.0 - (end - t) / double_support, 0.0, 1.0);

  // trunk and base point
  const double omega = 2.0 * std::numbers::pi / options_.step_time;
  const double speed = options_.step_length / options_.step_time;
  state.q(robot_.link(robot_.trunk).coordinate) = options_.trunk_angle;
  Course x{offset_ + speed * t, speed, 0.0};
  for (std::size_t k = 0; k < cosine_.size(); ++k)
  {
    const double w = omega * static_cast<double>(k + 1);
    const double c = std::cos(w * t), s = std::sin(w * t);
    x.x += cosine_[k] * c + sine_[k] * s;
    x.v += w * (sine_[k] * c - cosine_[k] * s);
    x.a -= w * w * (cosine_[k] * c + sine_[k] * s);
  }
  state.q.tail<2>() << x.x, options_.hip_height;
  state.v.tail<2>() << x.v, 0.0;
  state.a.tail<2>() << x.a, 0.0;

  place_leg(carrying, carrying_foot(t, phase), t, state);
  place_leg(other(carrying), other_foot(t, phase), t, state);
  return state;
}

// In single support along the middle part of the sole; in double support on to where the trailing heel can lift, midway
// between its toe and the leading heel, and on to the leading sole.
double Gait::wished_zmp(double t, const GaitPhase& phase) const
{
  const Foot& carrying = robot_.foot(side_of(phase.step));
  const Foot& next = robot_.foot(other(side_of(phase.step)));
  const double L = options_.step_length;
  const auto along = [](const Foot& foot, double share)
  {
    return foot.heel_x() + share * (foot.toe_x() - foot.heel_x());
  };
  constexpr double first = 0.3, last = 0.7;
  const double middle = 0.5 * (carrying.toe_x() + L + next.heel_x());
  const double share = (t - phase.begin) / (phase.end - phase.begin);
  const auto linear = [&](double from, double to)
  {
    return phase.step * L + from + share * (to - from);
  };
  switch (phase.kind)
  {
  case GaitPhaseKind::ssp: return linear(along(carrying, first), along(carrying, last));
  case GaitPhaseKind::dsp1: return linear(along(carrying, last), middle);
  case GaitPhaseKind::dsp2: break;
  }
  return linear(middle, L + along(next, first));
}

// The linear inverted pendulum x'' = ω0² (x − p) turns a harmonic of the zero-moment point p into ω0²/(ω0² + (kω)²) of
// it in x. What the whole robot then does with its zero-moment point is corrected by the same rule, until it settles.
void Gait::find_hip_motion()
{
  constexpr int samples = 120, harmonics = 20, rounds = 12;
  const double T = options_.step_time, L = options_.step_length;
  const double omega = 2.0 * std::numbers::pi / T;
  const double omega0_squared = robot_.mechanism.gravity() / options_.hip_height;
  cosine_.assign(harmonics, 0.0);
  sine_.assign(harmonics, 0.0);
  const auto phase_of = [this](double t) -> const GaitPhase&
  {
    return *std::find_if(phases_.begin(), phases_.end(), [t](const GaitPhase& phase) { return t < phase.end; });
  };
  for (int round = 0; round < rounds; ++round)
  {
    double mean = 0.0;
    std::array<double, harmonics> cosine{}, sine{};
    for (int i = 0; i < samples; ++i)
    {
      const double t = T * (i + 0.5) / samples;
      const GaitPhase& phase = phase_of(t);
      double zmp = L * t / T;
      if (round > 0)
      {
        const auto equations = std::get<SupportEquations>(support_equations(robot_, at(t, phase)));
        zmp = zero_moment_point(robot_, equations);
      }
      const double error = wished_zmp(t, phase) - zmp;
      mean += error / samples;
      for (int k = 0; k < harmonics; ++k)
      {
        const double w = omega * (k + 1);
        cosine[static_cast<std::size_t>(k)] += 2.0 / samples * error * std::cos(w * t);
        sine[static_cast<std::size_t>(k)] += 2.0 / samples * error * std::sin(w * t);
      }
    }
    offset_ += mean;
    for (std::size_t k = 0; k < cosine_.size(); ++k)
    {
      const double w = omega * static_cast<double>(k + 1);
      const double gain = omega0_squared / (omega0_squared + w * w);
      cosine_[k] += gain * cosine[k];
      sine_[k] += gain * sine[k];
    }
  }
}

GaitReport Gait::survey() const
{
  constexpr int samples = 200;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  GaitReport report{infinity, infinity, 0.0, infinity};
  double lowest = 0.0, lowest_at = 0.0;
  for (const GaitPhase& phase : phases_)
    for (int i = 0; i <= samples && phase.step < 2; ++i) // later steps repeat these
    {
      const double t = phase.begin + (phase.end - phase.begin) * i / samples;
      const DesiredState state = at(t, phase);
      const auto equations = std::get<SupportEquations>(support_equations(robot_, state));
      const double zmp = zero_moment_point(robot_, equations);
      const Side carrying = side_of(phase.step);
      const FootPose& foot = equations.foot(carrying);
      const FootPose& next = equations.foot(other(carrying));
      report.zmp_error = std::max(report.zmp_error, std::abs(zmp - wished_zmp(t, phase)));
      if (phase.kind == GaitPhaseKind::ssp)
        report.zmp_margin = std::min({report.zmp_margin, zmp - foot.heel.x(), foot.toe.x() - zmp});
      if (phase.kind == GaitPhaseKind::dsp2 && i == 0)
        report.switch_margin = std::min({report.switch_margin, zmp - foot.toe.x(), next.heel.x() - zmp});
      for (const Leg& leg : legs_)
        report.knee_flexion = std::min(report.knee_flexion, state.q(robot_.link(leg.thigh).coordinate) -
                                                                state.q(robot_.link(leg.shin).coordinate));
      for (const FootPose& pose : equations.feet)
        if (const double height = std::min(pose.heel.y(), pose.toe.y()); height < lowest)
        {
          lowest = height;
          lowest_at = t;
        }
    }
  if (lowest < -1e-9 * robot_.leg_length)
    throw Failure(
        ExitCode::usage,
        fmt::format("at {:.3f} s the swinging foot would be {:.3g} m below the ground; more --clearance would do",
                    lowest_at, -lowest));
  return report;
}

} // namespace torqued
