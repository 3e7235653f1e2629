#include "motion/lowpass.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace torqued
{

namespace
{

// y_n = b (x_n + 2 x_{n−1} + x_{n−2}) − a₁ y_{n−1} − a₂ y_{n−2}: the Butterworth filter of second order,
// 1 / (s² + √2 s + 1), by the bilinear transform with the cut-off where it shall be
struct SecondOrder
{
  double b, a1, a2;
};

SecondOrder butterworth(double rate, double cut_off)
{
  const double k = std::tan(std::numbers::pi * cut_off / rate);
  const double norm = 1.0 / (1.0 + std::numbers::sqrt2 * k + k * k);
  return {k * k * norm, 2.0 * (k * k - 1.0) * norm, (1.0 - std::numbers::sqrt2 * k + k * k) * norm};
}

// in place, as if the first value had been there for ever
void filter(const SecondOrder& f, Eigen::VectorXd& x)
{
  double x1 = x(0), x2 = x(0), y1 = x(0), y2 = x(0);
  for (double& value : x)
  {
    const double y = f.b * (value + 2.0 * x1 + x2) - f.a1 * y1 - f.a2 * y2;
    x2 = x1;
    x1 = value;
    y2 = y1;
    y1 = value = y;
  }
}

} // namespace

Eigen::MatrixXd lowpass(const Eigen::MatrixXd& samples, double rate, double cut_off)
{
  const Eigen::Index n = samples.rows();
  assert(n >= 2 && cut_off > 0.0 && 2.0 * cut_off < rate);
  const SecondOrder butter = butterworth(rate, cut_off);
  const Eigen::Index padding = std::min<Eigen::Index>(std::lround(rate), n - 1);
  const Eigen::VectorXd share = Eigen::VectorXd::LinSpaced(n, 0.0, 1.0);

  Eigen::MatrixXd smooth(n, samples.cols());
  for (Eigen::Index j = 0; j < samples.cols(); ++j)
  {
    // the line through both ends passes a filter without lag unchanged; kept apart, it is free of the filter's start
    const Eigen::VectorXd line = samples(0, j) + share.array() * (samples(n - 1, j) - samples(0, j));
    const Eigen::VectorXd x = samples.col(j) - line;
    Eigen::VectorXd extended(n + 2 * padding);
    extended.head(padding) = 2.0 * x(0) - x.segment(1, padding).reverse().array();
    extended.segment(padding, n) = x;
    extended.tail(padding) = 2.0 * x(n - 1) - x.segment(n - 1 - padding, padding).reverse().array();
    filter(butter, extended);
    extended.reverseInPlace();
    filter(butter, extended);
    extended.reverseInPlace();
    smooth.col(j) = extended.segment(padding, n) + line;
  }
  return smooth;
}

} // namespace torqued
