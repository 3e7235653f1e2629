/// How much of a motion's accelerations is noise.
#pragma once

#include <Eigen/Core>

namespace torqued
{

/// Of one coordinate's accelerations.
struct AccelerationNoise
{
  double rms = 0.0;       ///< of the accelerations, rad/s² or m/s²
  double noise = 0.0;     ///< rms of what is noise in them, at most rms
  Eigen::Index worst = 0; ///< the sample where it is largest
};

/// Noise of the samples themselves (rounding, jitter of markers) grows by two derivatives to accelerations that change
/// from sample to sample; a motion sampled well does not. Their fourth differences tell them apart: at ω they are
/// (2 sin(ω h / 2))⁴ of the acceleration, 0.0016 of it at 6 Hz and 200 samples per second; of the accelerations
/// that a quintic spline makes of white noise they are kNoiseGain times the rms.
///
/// accelerations: spline_derivatives() at samples in equal steps. Fewer than five samples have no noise.
AccelerationNoise acceleration_noise(const Eigen::VectorXd& accelerations);

} // namespace torqued
