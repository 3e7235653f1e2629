#include "catch.h"

#include "matchers.h"
#include "motion/acceleration_noise.h"
#include "motion/differentiation.h"
#include "motion/failure.h"
#include "motion/lowpass.h"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <numbers>
#include <random>

namespace differentiation_test
{

using namespace torqued;

namespace
{

constexpr double kTurn = 2.0 * std::numbers::pi;

// a motion of two angles and the base, at known frequencies, and its derivatives
Eigen::RowVector4d position(double t)
{
  return {0.5 * std::sin(6.0 * t), 0.7 * std::cos(12.0 * t + 0.3), 1.2 * t, 0.9 + 0.02 * std::sin(12.0 * t)};
}
Eigen::RowVector4d acceleration(double t)
{
  return {-18.0 * std::sin(6.0 * t), -100.8 * std::cos(12.0 * t + 0.3), 0.0, -2.88 * std::sin(12.0 * t)};
}

double rounded(double x, int decimals)
{
  const std::string text = fmt::format("{:.{}f}", x, decimals);
  double value = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// the motion at some instants, written at these times
struct Recording
{
  WrittenMotion written;
  std::vector<double> instants;
  std::vector<std::size_t> lines;

  explicit Recording(std::vector<double> times, std::function<Eigen::RowVector4d(double)> at = position)
      : instants(std::move(times))
  {
    written.time_column = "time";
    written.times = instants;
    written.columns = {"p0", "p1", "x", "z"};
    written.is_angle = {true, true, false, false};
    written.base_given = true;
    written.positions.resize(static_cast<Eigen::Index>(instants.size()), 4);
    for (std::size_t i = 0; i < instants.size(); ++i)
    {
      written.positions.row(static_cast<Eigen::Index>(i)) = at(instants[i]);
      lines.push_back(i + 2);
    }
  }
  Recording& written_to(int decimals)
  {
    for (double& time : written.times)
      time = rounded(time, decimals);
    return *this;
  }
  Differentiated found(std::optional<double> lowpass = {}) const
  {
    Differentiation how(true);
    how.lowpass = lowpass;
    return differentiate(written, how, "t.csv", lines);
  }
  std::string complaint(std::optional<double> lowpass = {}) const
  {
    try
    {
      found(lowpass);
      return "";
    }
    catch (const Failure& failure)
    {
      CHECK(failure.code() == ExitCode::bad_data);
      return failure.what();
    }
  }
  // the largest error of an acceleration, rad/s², but for some rows at each end
  double error(const Differentiated& differentiated, std::size_t ends = 0) const
  {
    double worst = 0.0;
    for (std::size_t i = ends; i + ends < instants.size(); ++i)
      worst = std::max(
          worst, (differentiated.motion.acceleration.row(static_cast<Eigen::Index>(i)) - acceleration(instants[i]))
                     .cwiseAbs()
                     .maxCoeff());
    return worst;
  }
};

std::vector<double> frames(double rate, int count)
{
  std::vector<double> times;
  for (int k = 0; k < count; ++k)
    times.push_back(k / rate);
  return times;
}

// without what lies between two frames
std::vector<double> without(std::vector<double> times, int from, int count)
{
  times.erase(times.begin() + from, times.begin() + from + count);
  return times;
}

bool has(const std::vector<std::string>& notes, const std::string& part)
{
  return std::any_of(notes.begin(), notes.end(),
                     [&](const auto& note) { return note.find(part) != std::string::npos; });
}

} // namespace

TEST_CASE("rounded times do not show in the derivatives", "[differentiation]")
{
  for (const double rate : {60.0, 100.0, 120.0, 240.0})
    for (const int decimals : {3, 5})
    {
      CAPTURE(rate, decimals);
      Recording recording(frames(rate, static_cast<int>(2.0 * rate)));
      const Differentiated exact = recording.found();
      const Differentiated found = recording.written_to(decimals).found();
      CAPTURE(found.notes);
      CHECK(exact.notes.empty());
      CHECK(has(found.notes, fmt::format("put back on {:g} Hz", rate)) == (rate != 100.0));
      CHECK(mismatch(found.motion.acceleration, exact.motion.acceleration, 1e-8) == "");
      CHECK(mismatch(found.motion.velocity, exact.motion.velocity, 1e-9) == "");
    }
  CHECK(Recording(frames(60.0, 60)).written_to(3).found().notes ==
        std::vector<std::string>{"times are rounded to 0.001 s: put back on 60 Hz (largest move 0.00033 s)"});
}

TEST_CASE("rows that show one instant twice are one sample, wherever they lie between frames", "[differentiation]")
{
  for (const double rate : {60.0, 200.0, 300.0, 1000.0})
    for (const double share : {0.0, 1e-3, 0.02, 0.3, 0.5, 0.97})
    {
      CAPTURE(rate, share);
      std::vector<double> instants;
      for (int k = 0; k < static_cast<int>(2.0 * rate); ++k)
      {
        instants.push_back(k / rate);
        if (k % 50 == 20)
          for (int twice = share > 0.0 ? 0 : 1; twice < 2; ++twice)
            instants.push_back((k + share) / rate);
      }
      Recording recording(instants);
      recording.written_to(6);
      for (std::size_t i = 1; i < instants.size(); ++i)
        if (instants[i] == instants[i - 1])
          recording.written.times[i] = recording.written.times[i - 1] + 1e-6;
      const Differentiated found = recording.found();
      CAPTURE(found.notes);
      CHECK(has(found.notes, "the instant of the row before once more"));
      // as if there were frames only; off frames by a µs of jerk, 1200 rad/s³, and where they are samples by what
      // half a µs moves them
      const double alone = Recording(frames(rate, static_cast<int>(2.0 * rate)))
                               .error(Recording(frames(rate, static_cast<int>(2.0 * rate))).found());
      CHECK(recording.error(found) < 1.1 * alone + 0.1);
      for (std::size_t i = 1; i < instants.size(); ++i)
        if (instants[i] == instants[i - 1])
        {
          const auto row = static_cast<Eigen::Index>(i);
          CHECK(found.motion.acceleration.row(row) == found.motion.acceleration.row(row - 1));
          CHECK(found.motion.velocity.row(row) == found.motion.velocity.row(row - 1));
          CHECK(found.motion.position.row(row) == position(instants[i]));
        }
    }
}

TEST_CASE("whole turns are taken off angles, and said", "[differentiation]")
{
  const auto wide = [](double t) -> Eigen::RowVector4d
  {
    return position(t).cwiseProduct(Eigen::RowVector4d(8.0, 1.0, 1.0, 1.0));
  };
  Recording recording(frames(100.0, 200), wide);
  const Differentiated whole = recording.found();
  std::size_t first = 0, turns = 0;
  auto angles = recording.written.positions.col(0);
  const Eigen::VectorXd unwrapped = angles;
  for (double& angle : angles)
    angle = std::remainder(angle, kTurn);
  for (Eigen::Index i = 1; i < angles.size(); ++i)
    if (std::abs(angles(i) - angles(i - 1)) > 3.0 && turns++ == 0)
      first = static_cast<std::size_t>(i) + 2;
  REQUIRE(turns > 4);
  const Differentiated found = recording.found();
  CHECK(mismatch(found.motion.acceleration, whole.motion.acceleration, 1e-9) == "");
  CHECK(mismatch(found.motion.position.col(0).eval(), unwrapped, 1e-14) == "");
  REQUIRE(found.notes.size() == 1);
  CHECK(found.notes[0].starts_with(fmt::format(
      "column p0: a whole turn was taken off {} steps of the angle, the first in line {} (", turns, first)));
}

TEST_CASE("steps that no motion makes are refused with their place", "[differentiation]")
{
  for (const double size : {std::numbers::pi, -std::numbers::pi, 2.0})
    for (const Eigen::Index last : {100, 199}) // one row, or all that follow
    {
      Recording recording(frames(100.0, 200));
      recording.written.positions.col(1).segment(100, last - 99).array() += size;
      CHECK(recording.complaint().starts_with("t.csv:102: column p1: found a step of "));
    }
  Recording recording(frames(100.0, 200));
  recording.written.positions.col(2).tail(100).array() -= 1.0;
  CHECK(recording.complaint().starts_with("t.csv:102: column x: found a step of -0.988 m "));
  // but not a motion that is fast throughout
  CHECK(Recording(frames(5.0, 20),
                  [](double t) -> Eigen::RowVector4d {
                    return {2.0 * std::sin(6.0 * t), 0.0, 3.0 * t, 0.9};
                  })
            .complaint() == "");
}

TEST_CASE("frozen frames up to 0.1 s are bridged, longer ones refused", "[differentiation]")
{
  for (const Eigen::Index count : {1, 3, 10})
  {
    CAPTURE(count);
    Recording recording(frames(100.0, 200));
    recording.written.positions.middleRows(100, count).rowwise() = recording.written.positions.row(99).eval();
    const Differentiated found = recording.found();
    CAPTURE(found.notes);
    // as if these rows were not there
    Recording rest(without(recording.instants, 100, static_cast<int>(count)));
    const Differentiated alone = rest.found();
    CHECK(mismatch(found.motion.acceleration.topRows(100), alone.motion.acceleration.topRows(100), 1e-9) == "");
    CHECK(mismatch(found.motion.acceleration.bottomRows(100 - count), alone.motion.acceleration.bottomRows(100 - count),
                   1e-9) == "");
    // a gap of g s is bridged within the spline's g⁴ x⁽⁶⁾, here 12⁶ 0.7
    const double gap = 0.01 * static_cast<double>(count + 1);
    CHECK(recording.error(found, 5) < 0.05 * std::pow(gap, 4) * 0.7 * std::pow(12.0, 6) + 0.01);
    CHECK((found.motion.position.row(100) - position(1.0)).cwiseAbs().maxCoeff() < 1e-2 * std::pow(gap / 0.11, 6));
    REQUIRE(found.notes.size() == 1);
    CHECK(found.notes[0].find(count == 1 ? "bridged: line 102"
                                         : fmt::format("bridged: lines 102 to {}", 101 + count)) != std::string::npos);
  }
  Recording recording(frames(100.0, 200));
  recording.written.positions.middleRows(100, 11).rowwise() = recording.written.positions.row(99).eval();
  CHECK(recording.complaint() ==
        "t.csv:113: column p0: found one posture, while the motion goes on, for 0.12 s, from 0.99 s "
        "after the first row on (line 101); expected gaps of 0.1 s at most, which are bridged");
}

TEST_CASE("frozen frames at an end are refused, for nothing lies beyond them", "[differentiation]")
{
  for (const Eigen::Index count : {1, 2, 10})
  {
    CAPTURE(count);
    Recording end(frames(100.0, 200));
    end.written.positions.bottomRows(count).rowwise() = end.written.positions.row(199 - count).eval();
    CHECK(end.complaint() == fmt::format("t.csv:{}: found {} frozen frame{} at the motion's end, while it moves on; "
                                         "expected a motion without: leave {} out",
                                         202 - count, count, count == 1 ? "" : "s",
                                         count == 1 ? "this row" : "these rows"));
    Recording start(frames(100.0, 200));
    start.written.positions.topRows(count).rowwise() = start.written.positions.row(count).eval();
    CHECK_THAT(start.complaint(), Catch::Matchers::StartsWith(fmt::format("t.csv:2: found {} frozen frame", count)));
  }
  // a motion that comes to rest, in digits as files have them, is none
  const auto smooth = [](double s)
  {
    s = std::clamp(s, 0.0, 1.0);
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  };
  for (const double rest : {0.0, 0.02, 0.05, 0.3})
    for (const int digits : {3, 6})
    {
      CAPTURE(rest, digits);
      Recording recording(frames(100.0, 100),
                          [&](double t) -> Eigen::RowVector4d
                          {
                            const double s = smooth((t - rest) / (0.99 - 2.0 * rest));
                            return {0.5 * s, -0.7 * s, 0.1 * s, 0.9 + 0.1 * s};
                          });
      for (double& x : recording.written.positions.reshaped())
        x = rounded(x, digits);
      CHECK(recording.complaint() == "");
    }
}

TEST_CASE("a last or first sample that does not go on as the others is noted", "[differentiation]")
{
  CHECK_FALSE(has(Recording(frames(100.0, 200)).found().notes, "do not go on like the others"));
  for (const Eigen::Index row : {0, 199})
  {
    Recording recording(frames(100.0, 200));
    recording.written.positions(row, 1) += 0.02;
    const auto notes = recording.found().notes;
    CAPTURE(notes);
    CHECK(has(notes,
              row == 0 ? "accelerations at the motion's beginning reach" : "accelerations at the motion's end reach"));
    CHECK(has(notes, "in column p1"));
  }
}

TEST_CASE("a recording that shows every frame twice is one of half its rate", "[differentiation]")
{
  Recording recording(frames(100.0, 200));
  for (Eigen::Index i = 1; i < 200; i += 2)
    recording.written.positions.row(i) = recording.written.positions.row(i - 1).eval();
  const Differentiated found = recording.found();
  CHECK(has(found.notes, "100 frozen frames"));
  CHECK(recording.error(found, 10) < 0.1);
}

TEST_CASE("a posture that is held is not frozen", "[differentiation]")
{
  // smoothly, and by straight lines; for 0.05 s to 1 s; down and up again, and on in the same direction
  const auto smooth = [](double s)
  {
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  };
  for (const double hold : {0.2, 1.0})
    for (const double next : {-1.0, 1.0})
      for (const bool by_lines : {false, true})
      {
        CAPTURE(hold, next, by_lines);
        const auto ramp = [&](double s)
        {
          s = std::clamp(s, 0.0, 1.0);
          return by_lines ? s : smooth(s);
        };
        const Recording recording(frames(100.0, 350),
                                  [&](double t) -> Eigen::RowVector4d
                                  {
                                    const double s = ramp((t - 0.5) / 0.5) + next * ramp((t - 1.0 - hold) / 0.5);
                                    return {0.5 * s, -0.7 * s, 0.1 * s, 0.9 + 0.1 * s};
                                  });
        const Differentiated found = recording.found();
        CAPTURE(found.notes);
        CHECK_FALSE(has(found.notes, "frozen"));
        CHECK(mismatch(found.motion.position, recording.written.positions, 0.0) == "");
      }
  // standing still, to the digits that are written
  for (const double unit : {1.0, kTurn / 360.0}) // as written, and converted
  {
    Recording quiet(frames(200.0, 400));
    for (double& x : quiet.written.positions.reshaped())
      x = unit * rounded(1e-3 * x, 4);
    CHECK_FALSE(has(quiet.found().notes, "frozen"));
  }
  const Recording still(frames(200.0, 400), [](double) { return position(0.3); });
  CHECK(still.found().notes.empty());
  CHECK(still.found().motion.acceleration.cwiseAbs().maxCoeff() < 1e-8);
}

TEST_CASE("missing frames up to 0.1 s are bridged, longer gaps refused with their instant", "[differentiation]")
{
  for (const double rate : {60.0, 100.0})
    for (const int count : {1, 6})
    {
      Recording recording(without(frames(rate, 200), 100, count));
      recording.written_to(3);
      const Differentiated found = recording.found();
      CHECK(has(found.notes, fmt::format("{} missing frame{} bridged in 1 gap, the first between lines 101 and 102",
                                         count, count == 1 ? "" : "s")));
      CHECK(recording.error(found, 5) < 0.05 * std::pow((count + 1) / rate, 4) * 0.7 * std::pow(12.0, 6) + 0.05);
    }
  CHECK(
      Recording(without(frames(100.0, 200), 100, 11)).complaint() ==
      "t.csv:102: column p0: found no sample for 0.12 s, from 0.99 s after the first row on (line 101); expected gaps "
      "of 0.1 s at most, which are bridged");
  // also where the clock jitters
  std::mt19937 random(5);
  std::vector<double> jittered = without(frames(100.0, 200), 100, 30);
  for (double& time : jittered)
    time = rounded(time + std::uniform_real_distribution<>(-1e-4, 1e-4)(random), 6);
  CHECK(Recording(jittered).complaint().find("found no sample for 0.3") != std::string::npos);
  // but postures a second apart have no frame rate to miss frames of
  CHECK(Recording({0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 7.0, 8.0},
                  [](double t) -> Eigen::RowVector4d {
                    return {0.1 * t, 0.0, 0.1 * t, 0.9};
                  })
            .complaint() == "");
}

TEST_CASE("cells without a number are bridged up to 0.1 s, each coordinate by its own samples", "[differentiation]")
{
  Recording recording(frames(100.0, 200));
  const Differentiated whole = recording.found();
  recording.written.positions.col(0).segment(100, 10).setConstant(NAN);
  recording.written.positions.col(3).segment(105, 10).setConstant(NAN);
  const Differentiated found = recording.found();
  CHECK(found.notes ==
        std::vector<std::string>{"cells without a number bridged in 15 rows, line 102 first (column p0)"});
  CHECK(mismatch(found.motion.acceleration.middleCols(1, 2), whole.motion.acceleration.middleCols(1, 2), 0.0) == "");
  CHECK(mismatch(found.motion.acceleration, whole.motion.acceleration, 0.02) == ""); // of 100 rad/s²
  CHECK(mismatch(found.motion.position, whole.motion.position, 1e-3) == "");

  recording.written.positions(110, 0) = NAN;
  CHECK(recording.complaint().starts_with("t.csv:113: column p0: found no sample for 0.12 s, from 0.99 s"));
  recording = Recording(frames(100.0, 200));
  recording.written.positions(0, 1) = NAN;
  CHECK(recording.complaint() ==
        "t.csv:2: column p1: found nothing at the motion's end; expected a number: only what lies "
        "between two samples is bridged");
}

TEST_CASE("the low-pass comes before the spline, and needs a frame rate", "[differentiation]")
{
  std::mt19937 random(7);
  std::normal_distribution<> noise(0.0, 1e-3);
  Recording recording(frames(100.0, 300));
  for (double& x : recording.written.positions.reshaped())
    x += noise(random);
  const Differentiated found = recording.found(10.0);
  CHECK(found.notes ==
        std::vector<std::string>{"low-passed at 10 Hz: Butterworth of second order, forward and backward; "
                                 "the cut-off is that of one pass"});
  Recording smoothed = recording;
  smoothed.written.positions = lowpass(recording.written.positions, 100.0, 10.0);
  const Differentiated by_hand = smoothed.found();
  CHECK(mismatch(found.motion.position, by_hand.motion.position, 1e-12) == "");
  CHECK(mismatch(found.motion.acceleration, by_hand.motion.acceleration, 1e-9) == "");
  CHECK(recording.error(recording.found(), 20) > 20.0);
  CHECK(recording.error(found, 20) < 10.0);

  // a frozen frame and a missing one are bridged before
  recording.written.positions.row(150) = recording.written.positions.row(149).eval();
  CHECK(recording.error(recording.found(10.0), 20) < 10.0);

  CHECK(recording.complaint(50.0) ==
        "t.csv: found --lowpass 50 Hz for frames at 100 Hz; expected less than half of their rate");
  std::vector<double> irregular{0.0};
  while (irregular.size() < 100)
    irregular.push_back(irregular.back() + std::uniform_real_distribution<>(0.004, 0.02)(random));
  CHECK(Recording(irregular).complaint(6.0).starts_with("t.csv: found times that are no frames of one rate, "));
}

TEST_CASE("accelerations that are noise are told from those of a motion", "[differentiation]")
{
  // as much noise as the spline makes of the samples' noise, beside a motion of any size
  std::mt19937 random(11);
  std::normal_distribution<> normal;
  for (const double sigma : {1e-5, 1e-4, 1e-3})
  {
    Recording motion(frames(100.0, 1000)), noise(frames(100.0, 1000),
                                                 [](double) -> Eigen::RowVector4d {
                                                   return {0, 0, 0, 0};
                                                 });
    for (double& x : noise.written.positions.reshaped())
      x = sigma * normal(random);
    motion.written.positions += noise.written.positions;
    const Eigen::MatrixXd all = motion.found().motion.acceleration, alone = noise.found().motion.acceleration;
    for (Eigen::Index j = 0; j < 4; ++j)
    {
      CAPTURE(sigma, j);
      const AccelerationNoise found = acceleration_noise(all.col(j));
      // at 100 Hz the fourth differences of the motion are (0.12)⁴ / 13.7 of it
      const double expected = acceleration_noise(alone.col(j)).rms;
      CHECK(found.noise == Approx(expected).epsilon(0.1).margin(0.002));
      CHECK(found.noise <= found.rms);
    }
  }
  // angles to 1e-4 rad at 200 Hz, and a mark that leaps by 0.2 rad in one frame
  Recording quantized(frames(200.0, 400));
  for (double& x : quantized.written.positions.reshaped())
    x = rounded(x, 4);
  CHECK(has(quantized.found().notes, "accelerations leap from sample to sample, most in column "));
  Recording leap(frames(100.0, 200));
  leap.written.positions(120, 1) += 0.2;
  CHECK(has(leap.found().notes, "most in column p1"));
  CHECK(has(leap.found().notes, "most near line 122: "));
  for (const double rate : {60.0, 100.0, 200.0, 1000.0})
    CHECK(Recording(frames(rate, 300)).found().notes.empty());
}

TEST_CASE("units are told from their effect", "[differentiation]")
{
  const auto doubt = [](double seconds, double factor, const std::string& column, bool velocities = false)
  {
    // a motion at 100 Hz, of which the times are said to be these
    Recording recording(frames(100.0, 300));
    for (double& time : recording.written.times)
      time *= seconds;
    recording.written.positions.leftCols(2) *= factor;
    recording.written.time_column = column;
    if (velocities)
    {
      recording.written.velocities.setZero(300, 4);
      for (Eigen::Index i = 0; i < 300; ++i)
      {
        const double t = recording.instants[static_cast<std::size_t>(i)];
        recording.written.velocities.row(i) << 3.0 * std::cos(6.0 * t), -8.4 * std::sin(12.0 * t + 0.3), 1.2, 0.0;
      }
    }
    return fmt::format("{}", fmt::join(doubt_units(recording.written).sentences, "; "));
  };
  for (const bool velocities : {false, true})
  {
    CHECK(doubt(1.0, 1.0, "time", velocities) == "");
    CHECK(doubt(1.0, 1.0, "utime", velocities) == "");
    CHECK(doubt(1e3, 1.0, "time", velocities).starts_with("column time seems to be in ms, not in s: "));
    CHECK(doubt(1e6, 1.0, "time", velocities).starts_with("column time seems to be in µs, not in s: "));
    CHECK(doubt(1e3, 1.0, "utime", velocities).starts_with("column utime seems to be in ns, not in µs: "));
    CHECK(doubt(1e-3, 1.0, "utime", velocities).starts_with("column utime seems to be in ms, not in µs: "));
  }
  CHECK(doubt(1.0, 360.0 / kTurn, "time")
            .starts_with("angles seem to be in degrees, not in radians: column p1 goes from "));
  CHECK(doubt(1.0, 360.0 / kTurn, "time").ends_with("multiply angles, rates and accelerations by pi / 180"));
  // standing still says nothing of time, and neither does a slow motion with its velocities
  CHECK(doubt_units(Recording({0.0, 1.0, 2.0, 3.0, 4.0, 5.0}, [](double) { return position(0.0); }).written)
            .sentences.empty());
  Recording millimetres(frames(100.0, 10));
  millimetres.written.positions.rightCols(2) *= 1000.0;
  CHECK(doubt_units(millimetres.written).sentences.size() == 1);
  // a quiet stance whose links differ by more than a turn, and velocities alone
  Recording quiet(frames(100.0, 50), [](double) -> Eigen::RowVector4d { return {5.0, -5.0, 0.0, 0.9}; });
  CHECK(doubt_units(quiet.written).degrees);
  Recording bent(frames(100.0, 50), [](double) -> Eigen::RowVector4d { return {1.5, -1.5, 0.0, 0.9}; });
  CHECK(doubt_units(bent.written).sentences.empty());
  Recording rates(frames(100.0, 200));
  rates.written.velocities.resize(200, 4);
  for (Eigen::Index i = 0; i < 200; ++i)
    rates.written.velocities.row(i) =
        100.0 * (position(0.01 * static_cast<double>(i) + 0.005) - position(0.01 * static_cast<double>(i) - 0.005));
  CHECK(doubt_units(rates.written).sentences.empty());
  rates.written.velocities *= 360.0 / kTurn;
  REQUIRE(doubt_units(rates.written).sentences.size() == 1);
  CHECK(doubt_units(rates.written).sentences[0].starts_with("velocities seem to be in degrees per second"));
}

} // namespace differentiation_test
