#include "planar/cosine_sine.h"

#include "planar/processors.h"

#include <bit>
#include <cmath>
#include <cstdint>

namespace torqued
{

namespace
{

constexpr double kLargest = 1e5; // rad; n times each of the first two parts of π/2 is exact

// π/2 in parts of 33 bits, and the rest
constexpr double kHalfPi1 = 0x1.921fb544p+0;
constexpr double kHalfPi2 = 0x1.0b4611a6p-34;
constexpr double kHalfPi3 = 0x1.3198a2e037073p-69;

// adding it rounds to a whole number, and leaves that in the last bits
constexpr double kRounder = 0x1.8p52;

// Polynomials in y = r² for |r| ≤ π/4, through the functions' values at Chebyshev's points: less than 2⁻⁵⁵ off. Even
// and odd powers are summed apart, because each term waits for the one before.
double cosine_near_0(double y)
{
  const double yy = y * y;
  const double even = 0x1.5555555555555p-5 + yy * (0x1.a01a019f4eafdp-16 + yy * 0x1.1eeb68e8f3790p-29);
  const double odd = -0x1.6c16c16c16967p-10 + yy * (-0x1.27e4fa17d9c4ep-22 + yy * -0x1.907da333d278fp-37);
  return 1.0 + y * (-0.5 + y * (even + y * odd));
}
double sine_near_0(double r, double y)
{
  const double yy = y * y;
  const double even = -0x1.5555555555555p-3 + yy * (-0x1.a01a019e83aa8p-13 + yy * -0x1.ae600b0226713p-26);
  const double odd = 0x1.1111111110bb2p-7 + yy * (0x1.71de379689862p-19 + yy * 0x1.5e0b19c4eccadp-33);
  return r + r * (y * (even + y * odd));
}

} // namespace

TORQUED_FOR_PROCESSORS
PlaneVectors cosines_and_sines(const VectorD& phi)
{
  const int blocks = static_cast<int>(phi.size()) / kDirectionBlock;
  const int count = blocks * kDirectionBlock;
  PlaneVectors e(2, count);
  DirectionBlock size = DirectionBlock::Zero();
  for (int k = 0; k < count; k += kDirectionBlock)
    size += phi.segment<kDirectionBlock>(k).array().abs().transpose();
  if (!(size.sum() <= kLargest))
  {
    for (int k = 0; k < count; ++k)
      e.col(k) << std::cos(phi(k)), std::sin(phi(k));
    return e;
  }
  // no step branches, so that the compiler does several angles at a time
  const double* const x = phi.data();
  double* const cosine = e.data();
  double* const sine = cosine + count;
#if !defined(__clang__)
#pragma GCC ivdep
#endif
  for (int k = 0; k < count; ++k)
  {
    const double shifted = x[k] * M_2_PI + kRounder;
    const double n = shifted - kRounder;
    const double r = ((x[k] - n * kHalfPi1) - n * kHalfPi2) - n * kHalfPi3;
    const double y = r * r;
    const auto c = std::bit_cast<std::uint64_t>(cosine_near_0(y));
    const auto s = std::bit_cast<std::uint64_t>(sine_near_0(r, y));

    // each quarter turn makes (−sin, cos) of (cos, sin): bit by bit, because a branch would do one angle at a time
    const auto quarters = std::bit_cast<std::uint64_t>(shifted);
    const std::uint64_t odd = -(quarters & 1);
    cosine[k] = std::bit_cast<double>(((c & ~odd) | (s & odd)) ^ (((quarters + 1) & 2) << 62));
    sine[k] = std::bit_cast<double>(((s & ~odd) | (c & odd)) ^ ((quarters & 2) << 62));
  }
  return e;
}

} // namespace torqued
