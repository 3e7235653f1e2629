#include "motion/gait.h"

#include "answer/answer.h"
#include "motion/unit_names.h"

#include <Eigen/LU>
#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/Splines>

namespace torqued
{

namespace
{

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

// Of a spline of fifth degree with uniform knots, clamped at both ends: which coefficients count at t, and how much in
// its value and its first two derivatives.
constexpr int kSplineDegree = 5;
struct SplineWeights
{
  std::size_t first;
  std::array<std::array<double, kSplineDegree + 1>, 3> weights;
};
SplineWeights spline_weights(std::size_t size, double knot, double t)
{
  using Spline = Eigen::Spline<double, 1>;
  const auto intervals = static_cast<Eigen::Index>(size) - kSplineDegree;
  Spline::KnotVectorType knots(static_cast<Eigen::Index>(size) + kSplineDegree + 1);
  for (Eigen::Index i = 0; i < knots.size(); ++i)
    knots(i) = static_cast<double>(std::clamp<Eigen::Index>(i - kSplineDegree, 0, intervals));
  const double u = std::clamp(t / knot, 0.0, static_cast<double>(intervals));
  const auto basis = Spline::BasisFunctionDerivatives(u, 2, kSplineDegree, knots);
  SplineWeights result{static_cast<std::size_t>(Spline::Span(u, kSplineDegree, knots) - kSplineDegree), {}};
  for (Eigen::Index order = 0; order < 3; ++order)
    for (Eigen::Index i = 0; i <= kSplineDegree; ++i)
      result.weights[static_cast<std::size_t>(order)][static_cast<std::size_t>(i)] =
          basis(order, i) / std::pow(knot, static_cast<double>(order));
  return result;
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
          .flat_footed = false,
          .standing = 0.0,
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
  if (options.standing != 0.0)
    require(options.standing, 0.1, 60.0, "standing", "s");

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

// where the foot stands that carries in a step, the ankle's x with the foot flat; side by side where the robot stands
double Gait::foothold(int step) const
{
  return options_.step_length * (options_.standing > 0.0 ? std::clamp(step, 0, options_.steps - 1) : step);
}

// of the foot that swings in a step
double Gait::pitch_at_lift_off(int step) const
{
  const bool flat = options_.flat_footed || (options_.standing > 0.0 && step == 0);
  return flat ? 0.0 : -options_.toe_off;
}

double Gait::pitch_at_touch_down(int step) const
{
  const bool flat = options_.flat_footed || (options_.standing > 0.0 && step + 1 == options_.steps);
  return flat ? 0.0 : options_.heel_strike;
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
  const double lifted = phase.kind == GaitPhaseKind::dsp2 ? pitch_at_lift_off(phase.step + 1) : 0.0;
  return roll(foot, foothold(phase.step), true, 0.0, lifted, t, phase);
}

Gait::FootMotion Gait::other_foot(double t, const GaitPhase& phase) const
{
  const Foot& foot = robot_.foot(other(side_of(phase.step)));
  const double next = foothold(phase.step + 1);
  const double lifted = pitch_at_lift_off(phase.step), landing = pitch_at_touch_down(phase.step);
  if (phase.kind != GaitPhaseKind::ssp)
    return roll(foot, next, false, phase.kind == GaitPhaseKind::dsp1 ? landing : 0.0, 0.0, t, phase);

  const FootMotion from = roll(foot, foothold(phase.step - 1), true, lifted, lifted, t, phase);
  const FootMotion to = roll(foot, next, false, landing, landing, t, phase);
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
  const auto out_of_reach = [&](const char* what)
  {
    return fmt::format("at {:.3f} s the {} ankle is {:.4g} m from the hip, and the leg can be {:.4g} to {:.4g} m long; "
                       "{} would do",
                       t, name_of(side), target.norm(), shortest, longest, what);
  };
  if (!(target.norm() < longest))
    throw LegTooShort(ExitCode::usage, out_of_reach("a lower --hip-height or a shorter --step-length"));
  if (!(target.norm() > shortest))
    throw Failure(ExitCode::usage, out_of_reach("a higher --hip-height or less --clearance"));
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
  const double share = std::clamp((t - phase.begin) / (phase.end - phase.begin), 0.0, 1.0);
  support.phase = (1.0 - share) * phase.share_begin + share * phase.share_end;
  support.load_transfer = (1.0 - share) * phase.load_begin + share * phase.load_end;

  // trunk and base point
  state.q(robot_.link(robot_.trunk).coordinate) = options_.trunk_angle;
  const std::array<double, 3> x = hip(t);
  state.q.tail<2>() << x[0], options_.hip_height;
  state.v.tail<2>() << x[1], 0.0;
  state.a.tail<2>() << x[2], 0.0;

  place_leg(carrying, carrying_foot(t, phase), t, state);
  place_leg(other(carrying), other_foot(t, phase), t, state);
  return state;
}

// x of the base point and its derivatives
std::array<double, 3> Gait::hip(double t) const
{
  if (!control_.empty())
  {
    const auto [first, weights] = spline_weights(control_.size(), knot_, t);
    std::array<double, 3> x{};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t i = 0; i < weights[k].size(); ++i)
        x[k] += weights[k][i] * control_[first + i];
    return x;
  }
  const double omega = 2.0 * std::numbers::pi / options_.step_time;
  const double speed = options_.step_length / options_.step_time;
  std::array<double, 3> x{offset_ + speed * t, speed, 0.0};
  for (std::size_t k = 0; k < cosine_.size(); ++k)
  {
    const double w = omega * static_cast<double>(k + 1);
    const double c = std::cos(w * t), s = std::sin(w * t);
    x[0] += cosine_[k] * c + sine_[k] * s;
    x[1] += w * (sine_[k] * c - cosine_[k] * s);
    x[2] -= w * w * (cosine_[k] * c + sine_[k] * s);
  }
  return x;
}

double Gait::zmp(double t, const GaitPhase& phase) const
{
  return zero_moment_point(robot_, std::get<SupportEquations>(support_equations(robot_, at(t, phase))));
}

// In single support along the middle part of the sole; in double support on to where the trailing heel can lift, midway
// between its toe and the leading heel, and on to the leading sole. Standing, from or to the middle of the sole.
double Gait::wished_zmp(double t, const GaitPhase& phase) const
{
  const Foot& carrying = robot_.foot(side_of(phase.step));
  const Foot& next = robot_.foot(other(side_of(phase.step)));
  const double here = foothold(phase.step), there = foothold(phase.step + 1);
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

// The linear inverted pendulum x'' = ω0² (x − p) turns a harmonic of the zero-moment point p into ω0²/(ω0² + (kω)²) of
// it in x. What the whole robot then does with its zero-moment point is corrected by the same rule, until it settles.
void Gait::find_periodic_hip_motion()
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
      const double error = wished_zmp(t, phase) - (round == 0 ? L * t / T : zmp(t, phase));
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

// The same pendulum for a spline that is at rest at both ends, x − x''/ω0² = p in least squares. Its first three and
// its last three coefficients are where the robot stands.
void Gait::find_hip_motion_from_standing()
{
  constexpr int knots_per_step = 40, samples_per_knot = 3, rounds = 8;
  const double T = phases_.back().end;
  const auto intervals = static_cast<std::size_t>(std::ceil(knots_per_step * T / options_.step_time));
  knot_ = T / static_cast<double>(intervals);
  const std::size_t size = intervals + kSplineDegree;
  const double lag = options_.hip_height / robot_.mechanism.gravity(); // 1/ω0²

  // standing: the wished zero-moment point is that of the robot at rest
  const double begin = wished_zmp(0.0, phases_.front()), end = wished_zmp(T, phases_.back());
  for (std::size_t i = 0; i < size; ++i)
    control_.push_back(begin + (end - begin) * static_cast<double>(i) / static_cast<double>(size - 1));

  struct Sample
  {
    double t;
    const GaitPhase* phase;
  };
  std::vector<Sample> samples;
  std::size_t current = 0;
  const std::size_t count = intervals * samples_per_knot;
  for (std::size_t i = 0; i < count; ++i)
  {
    const double t = T * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    while (phases_[current].end < t)
      ++current;
    samples.push_back({t, &phases_[current]});
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < count; ++i)
  {
    const auto [first, weights] = spline_weights(size, knot_, samples[i].t);
    for (std::size_t k = 0; k < weights[0].size(); ++k)
      entries.emplace_back(static_cast<int>(i), static_cast<int>(first + k), weights[0][k] - lag * weights[2][k]);
  }
  Eigen::SparseMatrix<double> all(static_cast<int>(count), static_cast<int>(size));
  all.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseMatrix<double> inner = all.middleCols(3, static_cast<int>(size) - 6);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> normal(inner.transpose() * inner);
  const auto c = [this]
  {
    return Eigen::Map<Eigen::VectorXd>(control_.data(), static_cast<Eigen::Index>(control_.size()));
  };
  for (int round = 0; round < rounds; ++round)
  {
    // what the robot's zero-moment point is beyond the pendulum's does not change much from round to round
    const Eigen::VectorXd pendulum = all * c();
    Eigen::VectorXd wished(static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < count; ++i)
    {
      const auto& [t, phase] = samples[i];
      const auto row = static_cast<Eigen::Index>(i);
      wished(row) = wished_zmp(t, *phase) - (round == 0 ? 0.0 : zmp(t, *phase) - pendulum(row));
    }
    if (round > 0)
    {
      c().head<3>().array() += begin - zmp(0.0, phases_.front());
      c().tail<3>().array() += end - zmp(T, phases_.back());
    }
    else
    {
      c().head<3>().setConstant(begin);
      c().tail<3>().setConstant(end);
    }
    Eigen::VectorXd ends = c();
    ends.segment(3, ends.size() - 6).setZero();
    c().segment(3, ends.size() - 6) = normal.solve(inner.transpose() * (wished - all * ends));
  }
}

// those that later steps repeat but once
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
      const Side carrying = side_of(phase.step);
      std::array<FootPose, 2> feet;
      for (const Side side : kSides)
        feet[static_cast<std::size_t>(side)] = foot_pose(robot_, equations.now, robot_.foot(side));
      const FootPose& foot = feet[static_cast<std::size_t>(carrying)];
      const FootPose& next = feet[static_cast<std::size_t>(other(carrying))];
      report.zmp_error = std::max(report.zmp_error, std::abs(x - wished_zmp(t, phase)));
      if (phase.kind == GaitPhaseKind::ssp)
        report.zmp_margin = std::min({report.zmp_margin, x - foot.heel.x(), foot.toe.x() - x});
      if (phase.kind == GaitPhaseKind::flat)
        report.zmp_margin = std::min(
            {report.zmp_margin, x - std::min(foot.heel.x(), next.heel.x()), std::max(foot.toe.x(), next.toe.x()) - x});
      if (phase.kind == GaitPhaseKind::dsp2 && i == 0)
        report.switch_margin = std::min({report.switch_margin, x - foot.toe.x(), next.heel.x() - x});
      for (const Leg& leg : legs_)
        report.knee_flexion = std::min(report.knee_flexion, state.q(robot_.link(leg.thigh).coordinate) -
                                                                state.q(robot_.link(leg.shin).coordinate));
      for (const FootPose& pose : feet)
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
            "{} a foot would tip: the zero-moment point is at {:.3f} m, {:.3f} m from where it was meant "
            "to be; a longer --step-time, more --double-support or a shorter --step-length would do",
            when, found.zmp, std::abs(found.zmp - wished_zmp(t, *phase)));
      if ((found.flags & flag::slips) != 0)
        return fmt::format("{} a foot would slip: it needs a friction coefficient of {:.2f}, and has {:.2f}; a longer "
                           "--step-time or a shorter --step-length would do",
                           when, std::max(found.ground[0].friction_ratio, found.ground[1].friction_ratio),
                           robot_.foot(Side::left).friction);
      for (int j = 0; j < robot_.num_joints() && (found.flags & flag::over_torque) != 0; ++j)
        if (const Actuator& motor = robot_.actuators[static_cast<std::size_t>(j)];
            std::abs(found.torque(j)) > motor.torque_limit)
          return fmt::format("{} {} would need {:.4g} N m, and has {:.4g}; a higher --hip-height or a longer "
                             "--step-time would do",
                             when, motor.name, std::abs(found.torque(j)), motor.torque_limit);
    }
  return "";
}

} // namespace torqued
