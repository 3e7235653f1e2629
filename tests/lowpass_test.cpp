#include "catch.h"

#include "matchers.h"
#include "motion/lowpass.h"

#include <cmath>
#include <complex>
#include <numbers>

namespace lowpass_test
{

using namespace torqued;

namespace
{

constexpr double kRate = 100.0;

Eigen::MatrixXd column(Eigen::Index count, double (*f)(double))
{
  Eigen::MatrixXd x(count, 1);
  for (Eigen::Index i = 0; i < count; ++i)
    x(i, 0) = f(static_cast<double>(i) / kRate);
  return x;
}

} // namespace

TEST_CASE("a sine passes with the filter's gain, and without lag", "[lowpass]")
{
  constexpr Eigen::Index count = 1200, end = 300;
  for (const double cut_off : {6.0, 10.0, 20.0})
    for (const double frequency : {0.5, 3.0, 6.0, 10.0, 25.0, 40.0})
    {
      CAPTURE(cut_off, frequency);
      const double w = 2.0 * std::numbers::pi * frequency / kRate;
      Eigen::MatrixXd x(count, 1);
      for (Eigen::Index i = 0; i < count; ++i)
        x(i, 0) = std::sin(w * static_cast<double>(i) + 0.7);
      const Eigen::MatrixXd y = lowpass(x, kRate, cut_off);
      const double ratio = std::tan(0.5 * w) / std::tan(std::numbers::pi * cut_off / kRate);
      const double gain = 1.0 / (1.0 + std::pow(ratio, 4));
      if (frequency == cut_off)
        CHECK(gain == Approx(0.5));
      // far from the ends, where 3 s have damped whatever began there by more than e^-79
      CHECK(mismatch(y.middleRows(end, count - 2 * end), gain * x.middleRows(end, count - 2 * end), 1e-12) == "");
    }
}

TEST_CASE("constants and straight lines pass the low-pass as they are, to their ends", "[lowpass]")
{
  for (const double cut_off : {0.5, 6.0, 49.0})
    for (const Eigen::Index count : {2, 7, 50, 500})
    {
      Eigen::MatrixXd x(count, 2);
      for (Eigen::Index i = 0; i < count; ++i)
        x.row(i) << 3.0, -2.0 + 1.3 * static_cast<double>(i);
      CHECK(mismatch(lowpass(x, kRate, cut_off), x, 1e-13) == "");
    }
}

TEST_CASE("the low-pass runs the same in both directions of time", "[lowpass]")
{
  const Eigen::MatrixXd x = column(400, [](double t) { return std::sin(7.0 * t) + 0.3 * std::cos(90.0 * t * t); });
  const Eigen::MatrixXd reversed = lowpass(x.colwise().reverse(), kRate, 8.0);
  // but for what is left of the start after a second of padding
  CHECK(mismatch(reversed.colwise().reverse().eval(), lowpass(x, kRate, 8.0), 1e-9) == "");
}

TEST_CASE("the low-pass is linear, and shorter motions than its padding are padded with what they have", "[lowpass]")
{
  const Eigen::MatrixXd x = column(40, [](double t) { return std::sin(20.0 * t); });
  const Eigen::MatrixXd y = column(40, [](double t) { return t * t * t; });
  CHECK(mismatch(lowpass(2.0 * x - 3.0 * y, kRate, 6.0), 2.0 * lowpass(x, kRate, 6.0) - 3.0 * lowpass(y, kRate, 6.0),
                 1e-13) == "");
}

} // namespace lowpass_test
