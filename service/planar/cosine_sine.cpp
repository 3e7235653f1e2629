#include "planar/cosine_sine.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace torqued
{

namespace
{

// angles done together
constexpr int kBlock = 4;
static_assert(kMaxDirections % kBlock == 0);

constexpr double kLargest = 1e5; // rad; n times each of the first two parts of π/2 is exact

// π/2 in parts of 33 bits, and the rest
constexpr double kHalfPi1 = 0x1.921fb544p+0;
constexpr double kHalfPi2 = 0x1.0b4611a6p-34;
constexpr double kHalfPi3 = 0x1.3198a2e037073p-69;

// adding it rounds to a whole number, and leaves that in the last bits
constexpr double kRounder = 0x1.8p52;

// Taylor's series in y = r²; what is left out is below 2⁻⁵⁷ of the sum for |r| ≤ π/4
double cosine_near_0(double y)
{
  return 1.0 +
         y * (-1.0 / 2 +
              y * (1.0 / 24 + y * (-1.0 / 720 +
                                   y * (1.0 / 40320 + y * (-1.0 / 3628800 + y * (1.0 / 479001600 +
                                                                                 y * (-1.0 / 87178291200 +
                                                                                      y * (1.0 / 20922789888000))))))));
}
double sine_near_0(double r, double y)
{
  return r + r * (y * (-1.0 / 6 +
                       y * (1.0 / 120 + y * (-1.0 / 5040 +
                                             y * (1.0 / 362880 +
                                                  y * (-1.0 / 39916800 +
                                                       y * (1.0 / 6227020800 + y * (-1.0 / 1307674368000 +
                                                                                    y * (1.0 / 355687428096000)))))))));
}

// angles x; their cosines and sines in turn
void block(const double* x, double* e)
{
  for (int i = 0; i < kBlock; ++i)
  {
    const double shifted = x[i] * M_2_PI + kRounder;
    const double n = shifted - kRounder;
    const double r = ((x[i] - n * kHalfPi1) - n * kHalfPi2) - n * kHalfPi3;
    const auto c = std::bit_cast<std::uint64_t>(cosine_near_0(r * r));
    const auto s = std::bit_cast<std::uint64_t>(sine_near_0(r, r * r));

    // each quarter turn makes (−sin, cos) of (cos, sin): bit by bit, because a branch would do one angle at a time
    const auto quarters = std::bit_cast<std::uint64_t>(shifted);
    const std::uint64_t odd = -(quarters & 1);
    e[2 * i] = std::bit_cast<double>(((c & ~odd) | (s & odd)) ^ (((quarters + 1) & 2) << 62));
    e[2 * i + 1] = std::bit_cast<double>(((s & ~odd) | (c & odd)) ^ ((quarters & 2) << 62));
  }
}

} // namespace

void cosines_and_sines(const VectorD& phi, PlaneVectors& e)
{
  const Eigen::Index count = phi.size();
  e.resize(2, count);
  if (count > 0 && !(phi.cwiseAbs().maxCoeff() <= kLargest))
  {
    for (Eigen::Index k = 0; k < count; ++k)
      e.col(k) << std::cos(phi(k)), std::sin(phi(k));
    return;
  }
  Eigen::Index k = 0;
  for (; k + kBlock <= count; k += kBlock)
    block(phi.data() + k, e.data() + 2 * k);
  if (k == count)
    return;
  std::array<double, kBlock> rest{};
  for (Eigen::Index i = k; i < count; ++i)
    rest[static_cast<std::size_t>(i - k)] = phi(i);
  block(rest.data(), e.data() + 2 * k); // the storage of e goes on to the end of the block
}

} // namespace torqued
