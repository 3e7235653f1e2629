// Cosines and sines of many angles at once, against libm's in long double.

#include "catch.h"
#include "oracles.h"

#include "planar/cosine_sine.h"

#include <cmath>

namespace cosine_sine_test
{

using namespace torqued;

namespace
{

// the largest difference of cosines and sines of n angles, and whether e has as many columns
double largest_error(const VectorD& phi)
{
  const PlaneVectors e = cosines_and_sines(phi);
  REQUIRE(e.cols() == phi.size());
  double worst = 0.0;
  for (Eigen::Index k = 0; k < phi.size(); ++k)
  {
    const long double angle = phi(k);
    worst = std::max({worst, std::abs(e(0, k) - static_cast<double>(std::cos(angle))),
                      std::abs(e(1, k) - static_cast<double>(std::sin(angle)))});
  }
  return worst;
}

} // namespace

TEST_CASE("cosines and sines are exact to a rounding or two, for any number of blocks of angles of any size",
          "[cosine_sine]")
{
  // half a unit in the last place of 1, for the rounding of the true value, and as much and again as much for ours
  constexpr double tolerance = 0x1p-52;
  oracle::Random random(1);
  for (int count = 0; count <= kMaxDirections; count += kDirectionBlock)
    for (const double size : {1e-300, 1e-9, 1.0, 4.0, 100.0, 9.9e4, 1e5, 1e9, 1e300})
      for (int i = 0; i < 50; ++i)
      {
        CAPTURE(count, size, i);
        VectorD phi(count);
        for (double& angle : phi)
          angle = oracle::uniform(random, -size, size);
        CHECK(largest_error(phi) <= tolerance);
      }
}

TEST_CASE("cosines and sines next to quarter turns keep their sign and all their digits", "[cosine_sine]")
{
  oracle::Random random(2);
  for (int quarter = -60'000; quarter <= 60'000; quarter += 7)
  {
    CAPTURE(quarter);
    VectorD phi(kDirectionBlock);
    phi << quarter * M_PI_2, std::nextafter(quarter * M_PI_2, 1e9), std::nextafter(quarter * M_PI_2, -1e9),
        quarter * M_PI_2 + oracle::uniform(random, -1e-7, 1e-7);
    const PlaneVectors e = cosines_and_sines(phi);
    for (int k = 0; k < kDirectionBlock; ++k)
    {
      // relative to the small one of both, whose digits come from those of pi/2 beyond a double
      const long double angle = phi(k);
      const double cosine = static_cast<double>(std::cos(angle)), sine = static_cast<double>(std::sin(angle));
      CHECK(std::abs(e(0, k) - cosine) <= 0x1p-51 * std::abs(cosine));
      CHECK(std::abs(e(1, k) - sine) <= 0x1p-51 * std::abs(sine));
    }
  }
}

TEST_CASE("what is no angle has no cosine", "[cosine_sine]")
{
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL})
  {
    VectorD phi(kDirectionBlock);
    phi << bad, 0.5, 0.5, 0.5;
    const PlaneVectors e = cosines_and_sines(phi);
    CHECK(std::isnan(e(0, 0)));
    CHECK(std::isnan(e(1, 0)));
    CHECK(std::abs(e(0, 1) - std::cos(0.5)) <= 0x1p-52);
  }
}

} // namespace cosine_sine_test
