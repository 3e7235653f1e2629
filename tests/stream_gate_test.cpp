#include "catch.h"

#include "daemon/latency.h"
#include "daemon/stream_gate.h"

#include <limits>
#include <random>

namespace stream_gate_test
{

using namespace torqued;

namespace
{

constexpr double kMaxAge = 0.020;
constexpr std::int64_t kSecond = 1'000'000;

// One sample through the gate: "" if it was accepted, else why not.
std::string pass(StreamGate& gate, std::int64_t stream_id, std::int64_t utime, std::int64_t now, bool check_age = true)
{
  if (const auto refusal = gate.arrive({utime, stream_id}, now))
    return std::string(name_of(refusal->reason()));
  if (const auto refusal = gate.accept(utime, now, check_age))
    return std::string(name_of(refusal->reason()));
  return "";
}

} // namespace

TEST_CASE("samples of one stream pass in order, and once each", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK_FALSE(gate.following());
  CHECK(pass(gate, 7, 1000, 50'000) == "");
  CHECK(gate.following());
  CHECK(pass(gate, 7, 2000, 51'000) == "");
  CHECK(pass(gate, 7, 2000, 52'000) == "OUT_OF_ORDER");
  CHECK(pass(gate, 7, 1500, 52'000) == "OUT_OF_ORDER");
  CHECK(pass(gate, 7, 3000, 52'000) == "");
}

TEST_CASE("a second stream is refused and counted until the first has been silent for 5 max_age", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, 1000, 0) == "");
  CHECK(pass(gate, 8, 1000, 50'000) == "OTHER_STREAM");
  CHECK(pass(gate, 8, 2000, 100'000) == "OTHER_STREAM");
  CHECK(gate.conflicts() == 2);
  CHECK_FALSE(gate.silent(100'000));
  CHECK(gate.silent(100'001));
  CHECK(pass(gate, 8, 3000, 100'001) == "");
  CHECK(pass(gate, 7, 101'000, 101'000) == "OTHER_STREAM");
}

TEST_CASE("age is measured against the freshest sample, whatever the sender's clock shows", "[stream_gate]")
{
  for (const std::int64_t epoch : {std::int64_t{0}, std::int64_t{1'700'000'000} * kSecond, -5 * kSecond})
  {
    CAPTURE(epoch);
    StreamGate gate(kMaxAge);
    CHECK(pass(gate, 7, epoch + 0, 10'000) == "");
    CHECK(pass(gate, 7, epoch + 1000, 11'000) == "");
    CHECK(pass(gate, 7, epoch + 2000, 12'000 + 20'000) == "");
    CHECK(pass(gate, 7, epoch + 3000, 13'000 + 20'001) == "STALE");
    CHECK(pass(gate, 7, epoch + 40'000, 50'000) == "");
    // a fresher sample than ever makes the others look older
    CHECK(pass(gate, 7, epoch + 50'000, 55'000) == "");
    CHECK(pass(gate, 7, epoch + 51'000, 76'001) == "STALE");
    // with the check off it passes
    CHECK(pass(gate, 7, epoch + 52'000, 99'000, false) == "");
  }
}

TEST_CASE("clocks that drift apart heal within the ten seconds that are remembered", "[stream_gate]")
{
  // the sender's clock loses 1 ms a second: the delay grows, but never by max_age within the window
  StreamGate gate(kMaxAge);
  for (std::int64_t t = 0; t < 60 * kSecond; t += 10'000)
    REQUIRE(pass(gate, 7, t - t / 1000, t) == "");
}

TEST_CASE("the freshest sample counts for ten seconds, and no longer", "[stream_gate]")
{
  for (const auto& [after, age] : {std::pair(9 * kSecond, "STALE"), std::pair(11 * kSecond, "")})
  {
    StreamGate gate(kMaxAge);
    CHECK(pass(gate, 7, 0, 0) == "");
    // everything later comes 15 ms late: still accepted
    for (std::int64_t t = 10'000; t < after; t += 10'000)
      REQUIRE(pass(gate, 7, t, t + 15'000) == "");
    // and now 30 ms late: too old against the first, fine against the others
    CHECK(pass(gate, 7, after, after + 30'000) == age);
  }
}

TEST_CASE("a sender whose clock jumps heals itself", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  const std::int64_t hour = 3600 * kSecond;
  std::int64_t now = 0;
  const auto accepted_within = [&](std::int64_t jump)
  {
    const std::int64_t start = now;
    while (pass(gate, 7, now + jump, now) != "")
    {
      now += 1000;
      REQUIRE(now - start < kSecond);
    }
    return now - start;
  };
  CHECK(accepted_within(0) == 0);
  now += 1000;
  CHECK(accepted_within(hour) == 0); // forward: still in order
  now += 1000;
  // backward: out of order until the stream counts as silent
  const std::int64_t healed = accepted_within(0);
  CHECK(healed >= 99'000);
  CHECK(healed <= 101'000);
}

TEST_CASE("an own pause keeps stream, order and offset, and what waited meanwhile is stale", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, 0, 0) == "");
  CHECK(pass(gate, 7, 1000, 1000) == "");
  const std::int64_t pause = 12 * kSecond;
  const std::int64_t now = 2000 + pause;
  gate.pause(pause, now);
  CHECK_FALSE(gate.silent(now));
  CHECK(pass(gate, 8, now, now) == "OTHER_STREAM");
  CHECK(pass(gate, 7, 1000, now) == "OUT_OF_ORDER");
  CHECK(pass(gate, 7, 2000, now) == "STALE");
  CHECK(pass(gate, 7, now, now) == "");
}

TEST_CASE("what waited through an own pause and belongs to no stream is stale, for it may be of any age",
          "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, 0, 0) == "");
  const std::int64_t resumed = 2 * kSecond; // silent for a second before, and for another while the process stood still
  gate.pause(kSecond, resumed);
  CHECK(pass(gate, 7, kSecond, resumed) == "STALE");
  CHECK(pass(gate, 7, kSecond + 1000, resumed + 100) == "STALE");
  CHECK(pass(gate, 7, kSecond + 2000, resumed + 20'000) == "STALE");
  CHECK(pass(gate, 7, resumed + 20'001, resumed + 20'001) == "");

  // a recorded motion is answered from its first sample on
  StreamGate every(kMaxAge);
  every.pause(kSecond, resumed);
  CHECK(pass(every, 7, 0, resumed, false) == "");
}

TEST_CASE("stale samples do not keep a stream alive", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, 0, 0) == "");
  // from now on the network holds everything up by 50 ms
  std::int64_t utime = 1000;
  while (pass(gate, 7, utime, utime + 50'000) == "STALE")
    utime += 1000;
  CHECK(utime + 50'000 >= 100'000);
  CHECK(utime + 50'000 <= 102'000);
}

TEST_CASE("no utime makes the arithmetic overflow", "[stream_gate]")
{
  using Limits = std::numeric_limits<std::int64_t>;
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, Limits::min(), 0) == "");
  CHECK(pass(gate, 7, 0, 1) == "");
  CHECK(pass(gate, 7, Limits::max(), 2) == "");
  CHECK(pass(gate, 7, Limits::max(), 3) == "OUT_OF_ORDER");
}

TEST_CASE("latency percentiles are nearest ranks, and each period starts anew", "[stream_gate]")
{
  Latencies latencies;
  CHECK(latencies.take().max == 0.0);
  std::vector<double> values;
  for (int i = 1; i <= 1000; ++i)
    values.push_back(i);
  std::shuffle(values.begin(), values.end(), std::mt19937(5));
  for (const double value : values)
    latencies.add(value);
  const LatencyPercentiles found = latencies.take();
  CHECK(found.p50 == 500.0);
  CHECK(found.p90 == 900.0);
  CHECK(found.p99 == 990.0);
  CHECK(found.p999 == 999.0);
  CHECK(found.max == 1000.0);
  latencies.add(3.0);
  CHECK(latencies.take().p50 == 3.0);
  for (int i = 0; i < 100'000; ++i)
    latencies.add(1.0);
  latencies.add(9.0);
  CHECK(latencies.take().max == 9.0);
}

} // namespace stream_gate_test
