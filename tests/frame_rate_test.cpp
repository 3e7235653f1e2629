#include "catch.h"

#include "motion/frame_rate.h"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace frame_rate_test
{

using namespace torqued;

namespace
{

double number(const std::string& text)
{
  double value = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::optional<FrameRate> found(const std::vector<double>& times)
{
  return find_frame_rate(times, rounding_errors(times));
}

// frames from this time on, as written by `write`
template <typename Write> std::vector<double> frames(double rate, int count, double first, Write write)
{
  std::vector<double> times;
  for (int k = 0; k < count; ++k)
    times.push_back(write(first + k / rate));
  return times;
}

double to_ms(double t)
{
  return number(fmt::format("{:.3f}", t));
}

} // namespace

TEST_CASE("rounded times are put back on their frames, whatever rounded them", "[frame_rate]")
{
  struct Writing
  {
    std::string name;
    double first, unit; // s; the largest change that it makes to a time
    double (*write)(double);
  };
  const std::vector<Writing> writings{
      {"ms", 0.0, 1e-3, to_ms},
      {"10 us", 0.0, 1e-5,
       [](double t)
       {
         return number(fmt::format("{:.5f}", t));
       }},
      {"us", 0.0, 1e-6,
       [](double t)
       {
         return number(fmt::format("{:.6f}", t));
       }},
      {"whole ms below", 0.0, 1e-3,
       [](double t)
       {
         return number(fmt::format("{:.3f}", std::floor(1e3 * t + 1e-6) / 1e3));
       }},
      {"ms of the epoch", 1.6e9, 1e-3, to_ms},
      {"double's digits of the epoch", 1.6e9, 2.4e-7,
       [](double t)
       {
         return t;
       }},
      {"six significant digits", 7.0, 1e-4,
       [](double t)
       {
         return number(fmt::format("{:g}", t));
       }},
      {"float", 100.0, 7.7e-6,
       [](double t)
       {
         return static_cast<double>(static_cast<float>(t));
       }},
      {"a float's shortest digits", 100.0, 1.6e-5,
       [](double t)
       {
         return number(fmt::format("{}", static_cast<float>(t)));
       }},
      {"nothing", 0.0, 1e-12,
       [](double t)
       {
         return t;
       }},
  };
  for (const double rate :
       {29.97, 30000.0 / 1001.0, 50.0, 59.94, 60.0, 100.0, 119.88, 120.0, 200.0, 240.0, 250.0, 300.0})
    for (const Writing& writing : writings)
    {
      CAPTURE(rate, writing.name);
      const int count = static_cast<int>(3.0 * rate);
      const std::vector<double> times = frames(rate, count, writing.first, writing.write);
      const auto found_rate = found(times);
      REQUIRE(found_rate);
      // two times that are each off by half a unit, 3 s apart
      CHECK(std::abs(found_rate->rate / rate - 1.0) <= writing.unit / 2.9);
      if (std::abs(rate - std::round(rate)) < 1e-9)
        CHECK(found_rate->rate == Approx(rate).epsilon(1e-14));
      CHECK(found_rate->largest_move <= 1.01 * writing.unit);
      for (int k = 0; k < count; ++k)
        REQUIRE(found_rate->number[static_cast<std::size_t>(k)] == k);
    }
}

TEST_CASE("times to two decimals are put back, too, at rates at which no two of them are equal", "[frame_rate]")
{
  const auto found_rate = found(frames(60.0, 180, 0.0, [](double t) { return number(fmt::format("{:.2f}", t)); }));
  REQUIRE(found_rate);
  CHECK(found_rate->rate == Approx(60.0).epsilon(1e-14));
  CHECK(found_rate->largest_move == Approx(0.01 / 3.0).epsilon(1e-6)); // 0.0166… is 0.02
  CHECK(found_rate->rounding == Approx(0.01));
}

TEST_CASE("of the rates that explain all times the roundest is taken", "[frame_rate]")
{
  // ten frames at 240 Hz in ms leave 228 to 254 Hz
  const auto few = found(frames(240.0, 10, 0.0, to_ms));
  REQUIRE(few);
  CHECK(few->rate == Approx(250.0).margin(11.0));
  CHECK(std::fmod(few->rate + 1e-9, 10.0) < 1e-8);
  // three seconds in ms tell 59.94 from 60
  const auto ntsc = found(frames(60000.0 / 1001.0, 180, 0.0, to_ms));
  REQUIRE(ntsc);
  CHECK(ntsc->rate == Approx(60000.0 / 1001.0).epsilon(1e-12));
}

TEST_CASE("missing frames keep their numbers, and rows between frames have none", "[frame_rate]")
{
  std::vector<double> times;
  std::vector<std::int64_t> numbers;
  for (int k = 0; k < 120; ++k)
  {
    if (k >= 50 && k < 54)
      continue;
    times.push_back(to_ms(k / 60.0));
    numbers.push_back(k);
    if (k % 20 == 7)
    {
      times.push_back(times.back() + 0.006);
      numbers.push_back(FrameRate::kNone);
    }
  }
  const auto found_rate = found(times);
  REQUIRE(found_rate);
  CHECK(found_rate->rate == Approx(60.0).epsilon(1e-14));
  CHECK(found_rate->number == numbers);
}

TEST_CASE("of two rows 1 us apart the one on the frame is the frame", "[frame_rate]")
{
  for (const int later : {-1, 1})
  {
    std::vector<double> times;
    for (int k = 0; k < 100; ++k)
    {
      if (k == 40 && later < 0)
        times.push_back(1e-6 * (5000 * k - 1));
      times.push_back(1e-6 * 5000 * k);
      if (k == 40 && later > 0)
        times.push_back(1e-6 * (5000 * k + 1));
    }
    const auto found_rate = found(times);
    REQUIRE(found_rate);
    CHECK(found_rate->rate == Approx(200.0).epsilon(1e-14));
    CHECK(found_rate->number[40] == (later < 0 ? FrameRate::kNone : 40));
    CHECK(found_rate->number[41] == (later < 0 ? 40 : FrameRate::kNone));
    CHECK(found_rate->largest_move < 1e-12);
  }
}

TEST_CASE("times that are no frames stay as they are", "[frame_rate]")
{
  std::mt19937 random(3);
  const auto irregular = [&](double shortest, double longest, double unit)
  {
    std::vector<double> times{0.0};
    while (times.size() < 200)
      times.push_back(
          times.back() +
          std::max(unit, unit * std::round(std::uniform_real_distribution<>(shortest, longest)(random) / unit)));
    return times;
  };
  CHECK_FALSE(found(irregular(0.004, 0.02, 1e-3)));
  CHECK_FALSE(found(irregular(0.004, 0.02, 1e-6)));
  // 100 Hz by a clock that jitters by 0.2 ms, written in µs: these are the times
  std::vector<double> jittered;
  for (int k = 0; k < 300; ++k)
    jittered.push_back(number(fmt::format("{:.6f}", 0.01 * k + std::uniform_real_distribution<>(-2e-4, 2e-4)(random))));
  CHECK_FALSE(found(jittered));
  // two rates one after another
  std::vector<double> two;
  for (int k = 0; k < 200; ++k)
    two.push_back(k < 100 ? 0.01 * k : 1.0 + (k - 100) / 130.0);
  CHECK_FALSE(found(two));
}

TEST_CASE("numbers may have lost half a unit of their last digit, or of a float's", "[frame_rate]")
{
  for (const double error : rounding_errors({0.017, 0.033, 0.05}))
    CHECK(error == Approx(5e-4).epsilon(1e-4));
  const auto six_digits = rounding_errors({0.0166667, 9.98333, 100.017});
  CHECK(six_digits[1] == Approx(5e-6).margin(1e-6)); // and a float's ulp
  CHECK(six_digits[2] == Approx(5e-4).epsilon(0.1));
  for (const double error : rounding_errors({1.0 / 3.0, 2.0 / 3.0}))
    CHECK(error < 1e-15);
}

} // namespace frame_rate_test
