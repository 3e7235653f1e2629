#include "motion/acceleration_noise.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

namespace
{

// rms of the fourth differences of the accelerations that a quintic spline through white noise has, by their own rms;
// found by simulation, 13.70 ± 0.02
constexpr double kNoiseGain = 13.7;
// samples next to the ends where a spline's accelerations are less certain than inside
constexpr Eigen::Index kEnd = 4;

} // namespace

AccelerationNoise acceleration_noise(const Eigen::VectorXd& accelerations)
{
  const Eigen::Index end = accelerations.size() > 6 * kEnd ? kEnd : 0;
  const auto a = accelerations.segment(end, accelerations.size() - 2 * end);
  const Eigen::Index n = a.size();
  AccelerationNoise found;
  if (n < 5)
    return found;
  found.rms = std::sqrt(a.squaredNorm() / static_cast<double>(n));
  const Eigen::VectorXd differences =
      a.head(n - 4) - 4.0 * a.segment(1, n - 4) + 6.0 * a.segment(2, n - 4) - 4.0 * a.segment(3, n - 4) + a.tail(n - 4);
  const double rms = std::sqrt(differences.squaredNorm() / static_cast<double>(n - 4));
  found.noise = std::min(rms / kNoiseGain, found.rms);
  differences.cwiseAbs().maxCoeff(&found.worst);
  found.worst += end + 2;
  return found;
}

} // namespace torqued
