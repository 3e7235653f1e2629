// A robot whose mass were in one point at the hips' height h would move as a linear inverted pendulum. With its
// zero-moment point p,
//
//   x − ẍ / ω₀² = p,   ω₀² = g / h                                  (1)
//
// which is linear, so a wished p gives x at once:
//
//   Equal steps for ever: x is uniform motion plus a Fourier series over a step. (1) turns a harmonic of p of frequency
//   k ω into ω₀² / (ω₀² + (k ω)²) of it in x.
//
//   From standing to standing: x is a spline of fifth degree, (1) at samples in least squares. The first three and the
//   last three coefficients are those of rest.
//
// The whole robot's zero-moment point differs from the pendulum's, by its legs' inertia. The difference hardly depends
// on x: so (1) is solved in rounds, each for the wish corrected by the error of the round before.
//
// The pendulum is unstable: integrating (1) forward would let errors grow as exp(ω₀ t). A series or a spline cannot,
// being bounded or at rest at its ends by its form.

#include "motion/gait.h"
#include "motion/gait_parts.h"
#include "stance/checks.h"

#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/Splines>

namespace torqued
{

namespace
{

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

// The left side of (1) at some times, linear in the spline's coefficients. lag: 1/ω₀², s²
Eigen::SparseMatrix<double> pendulum(std::size_t size, double knot, double lag, const std::vector<double>& times)
{
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < times.size(); ++i)
  {
    const auto [first, weights] = spline_weights(size, knot, times[i]);
    for (std::size_t k = 0; k < weights[0].size(); ++k)
      entries.emplace_back(static_cast<int>(i), static_cast<int>(first + k), weights[0][k] - lag * weights[2][k]);
  }
  Eigen::SparseMatrix<double> rows(static_cast<int>(times.size()), static_cast<int>(size));
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

} // namespace

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

const GaitPhase& Gait::phase_at(double t) const
{
  return *std::ranges::upper_bound(phases_, t, {}, &GaitPhase::end);
}

void Gait::find_periodic_hip_motion()
{
  constexpr int samples = 120, harmonics = 20, rounds = 12;
  const double T = options_.step_time, L = options_.step_length;
  const double omega = 2.0 * std::numbers::pi / T;
  const double omega0_squared = robot_.mechanism.gravity() / options_.hip_height;
  cosine_.assign(harmonics, 0.0);
  sine_.assign(harmonics, 0.0);
  for (int round = 0; round < rounds; ++round)
  {
    // the error's mean and harmonics over a step
    double mean = 0.0;
    std::array<double, harmonics> cosine{}, sine{};
    for (int i = 0; i < samples; ++i)
    {
      const double t = T * (i + 0.5) / samples;
      const GaitPhase& phase = phase_at(t);
      const double error = wished_zmp(robot_, options_, t, phase) - (round == 0 ? L * t / T : zmp(t, phase));
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

void Gait::find_hip_motion_from_standing()
{
  constexpr int knots_per_step = 40, samples_per_knot = 3, rounds = 8;
  const double T = phases_.back().end;
  const auto intervals = static_cast<std::size_t>(std::ceil(knots_per_step * T / options_.step_time));
  knot_ = T / static_cast<double>(intervals);
  const std::size_t size = intervals + kSplineDegree;

  // standing: the wished zero-moment point is that of the robot at rest
  const double begin = wished_zmp(robot_, options_, 0.0, phases_.front());
  const double end = wished_zmp(robot_, options_, T, phases_.back());
  for (std::size_t i = 0; i < size; ++i)
    control_.push_back(begin + (end - begin) * static_cast<double>(i) / static_cast<double>(size - 1));

  std::vector<double> times;
  const std::size_t count = intervals * samples_per_knot;
  for (std::size_t i = 0; i < count; ++i)
    times.push_back(T * (static_cast<double>(i) + 0.5) / static_cast<double>(count));
  const Eigen::SparseMatrix<double> all =
      pendulum(size, knot_, options_.hip_height / robot_.mechanism.gravity(), times);
  const Eigen::SparseMatrix<double> inner = all.middleCols(3, static_cast<int>(size) - 6);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> normal(inner.transpose() * inner);
  const auto c = [this]
  {
    return Eigen::Map<Eigen::VectorXd>(control_.data(), static_cast<Eigen::Index>(control_.size()));
  };
  for (int round = 0; round < rounds; ++round)
  {
    const Eigen::VectorXd of_pendulum = all * c();
    Eigen::VectorXd wished(static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < count; ++i)
    {
      const double t = times[i];
      const GaitPhase& phase = phase_at(t);
      const auto row = static_cast<Eigen::Index>(i);
      wished(row) = wished_zmp(robot_, options_, t, phase) - (round == 0 ? 0.0 : zmp(t, phase) - of_pendulum(row));
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

} // namespace torqued
