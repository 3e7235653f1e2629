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

TEST_CASE("where messages are lost, a stream's silence may be their loss: no other one is followed", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, 1000, 0) == "");
  gate.note_loss(90'000);
  CHECK(gate.silent(150'000)); // nothing came of it, for whatever reason
  CHECK(pass(gate, 8, 1000, 150'000) == "OTHER_STREAM");
  CHECK(pass(gate, 8, 2000, 190'000) == "OTHER_STREAM");
  CHECK(pass(gate, 8, 3000, 190'001) == "");
  // nor is the time in which the process stood still
  gate.note_loss(200'000);
  gate.pause(1'000'000);
  CHECK(pass(gate, 7, 1'301'000, 1'300'000) == "OTHER_STREAM");
  CHECK(pass(gate, 7, 1'301'001, 1'300'001) == "");
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
    CHECK(pass(gate, 7, epoch + 3000, 13'000 + 20'100) == "STALE");
    CHECK(pass(gate, 7, epoch + 40'000, 50'000) == "");
    // a fresher sample than ever makes the others look older
    CHECK(pass(gate, 7, epoch + 50'000, 55'000) == "");
    CHECK(pass(gate, 7, epoch + 51'000, 76'100) == "STALE");
    // with the check off it passes
    CHECK(pass(gate, 7, epoch + 52'000, 99'000, false) == "");
  }
}

TEST_CASE("what comes late after a gap is late, however long the gap was", "[stream_gate]")
{
  for (const std::int64_t gap : {kSecond / 10, kSecond / 5, kSecond, 3 * kSecond, 60 * kSecond, 24 * 3600 * kSecond})
  {
    CAPTURE(gap);
    StreamGate gate(kMaxAge);
    CHECK(pass(gate, 7, 0, 0) == "");
    CHECK(pass(gate, 7, 1000, 1000) == "");
    // a link that was held up goes on as late as it is
    for (std::int64_t utime = 2000; utime < 202'000; utime += 1000)
      REQUIRE(pass(gate, 7, utime, utime + gap) == "STALE");
    const std::int64_t healed = 202'000 + gap;
    CHECK(pass(gate, 7, healed, healed) == "");
  }
}

TEST_CASE("clocks that drift apart by 100 ppm cost no sample, even after a minute's gap", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  for (std::int64_t t = 0; t < 3600 * kSecond; t += 100'000)
    REQUIRE(pass(gate, 7, t - t / 10'000, t) == "");
  const std::int64_t later = 3660 * kSecond;
  CHECK(pass(gate, 7, later - later / 10'000, later) == "");
}

TEST_CASE("no gap makes the clock offset be forgotten by more than half of max_age", "[stream_gate]")
{
  for (const auto& [late, result] : {std::pair(29'000, ""), std::pair(31'000, "STALE")})
  {
    StreamGate gate(kMaxAge);
    CHECK(pass(gate, 7, 0, 0) == "");
    CHECK(pass(gate, 7, 3600 * kSecond, 3600 * kSecond + late) == result);
  }
}

TEST_CASE("a clock that loses more than 100 ppm ends as stale, like a link that gets later and later", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  std::int64_t t = 0;
  while (t < 60 * kSecond && pass(gate, 7, t - t / 1000, t) == "")
    t += 1000;
  // what it loses, less what is forgotten, adds up to max_age
  CHECK(1e-6 * static_cast<double>(t) == Approx(kMaxAge / (1e-3 - 1e-4)).epsilon(0.01));
}

TEST_CASE("order belongs to a stream for good: no silence makes an old sample new", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, 1000, 0) == "");
  for (int i = 1; i <= 10; ++i)
    CHECK(pass(gate, 7, 1000, i * 120'000) == "OUT_OF_ORDER");
  // nor does another stream in between
  CHECK(pass(gate, 8, 5, 2 * kSecond) == "");
  CHECK(pass(gate, 7, 1000, 4 * kSecond) == "OUT_OF_ORDER");
  CHECK(pass(gate, 7, 1001, 4 * kSecond) == "STALE"); // four seconds late
  CHECK(pass(gate, 7, 5 * kSecond + 1000, 5 * kSecond) == "");
  CHECK(pass(gate, 8, 5, 6 * kSecond) == "OUT_OF_ORDER");
}

TEST_CASE("a sender whose clock was set back needs a new stream, and is told so", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  const std::int64_t hour = 3600 * kSecond;
  CHECK(pass(gate, 7, hour, 0) == "");
  const auto refusal = gate.arrive({10 * kSecond, 7}, 10 * kSecond);
  REQUIRE(refusal);
  CHECK(refusal->reason() == Reason::out_of_order);
  CHECK(std::string(refusal->detail()).find("takes a new stream_id") != std::string::npos);
  CHECK(pass(gate, 9, 10 * kSecond, 10 * kSecond) == "");
}

TEST_CASE("the last 64 streams that were followed are remembered, and those that were refused do not count",
          "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  std::int64_t now = 0;
  for (std::int64_t id = 0; id < 64; ++id)
  {
    CHECK(pass(gate, id, 1000, now) == "");
    for (std::int64_t other = 1000; other < 1100; ++other) // while it is not silent
      CHECK(pass(gate, other, 1, now + 1) == "OTHER_STREAM");
    now += kSecond;
  }
  for (std::int64_t id = 0; id < 64; ++id)
    CHECK(pass(gate, id, 1000, now) == "OUT_OF_ORDER");
  CHECK(pass(gate, 64, 1000, now) == ""); // one more, for which the one that was left first is forgotten
  now += kSecond;
  CHECK(pass(gate, 1, 1000, now) == "OUT_OF_ORDER");
  CHECK(pass(gate, 0, 1000, now) == "");
}

TEST_CASE("a stream that is taken up again takes no other one's place", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  std::int64_t now = 0;
  for (std::int64_t id = 0; id < 64; ++id, now += kSecond)
    CHECK(pass(gate, id, now, now) == "");
  for (const std::int64_t again : {5, 62, 40, 63, 5, 0})
  {
    CHECK(pass(gate, again, now, now) == "");
    now += kSecond;
    for (std::int64_t id = 0; id < 64; ++id)
      CHECK(pass(gate, id, 0, now) == "OUT_OF_ORDER");
  }
}

TEST_CASE("a sample that waits for its answer keeps its stream", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, 0, 0) == "");
  CHECK_FALSE(gate.arrive({90'000, 7}, 90'000));
  CHECK(pass(gate, 8, 0, 150'000) == "OTHER_STREAM"); // 150 ms after the last one that was accepted
  CHECK_FALSE(gate.accept(90'000, 90'000, true));
  CHECK(pass(gate, 8, 0, 150'000) == "OTHER_STREAM");
  CHECK(pass(gate, 8, 0, 190'001) == "");
}

TEST_CASE("an own pause is nobody's silence, and what waited meanwhile is stale", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, 0, 0) == "");
  CHECK(pass(gate, 7, 1000, 1000) == "");
  const std::int64_t pause = 12 * kSecond;
  const std::int64_t now = 2000 + pause;
  gate.pause(pause);
  CHECK_FALSE(gate.silent(now));
  CHECK(pass(gate, 8, now, now) == "OTHER_STREAM");
  CHECK(pass(gate, 7, 1000, now) == "OUT_OF_ORDER");
  CHECK(pass(gate, 7, 2000, now) == "STALE");
  CHECK(pass(gate, 7, now, now) == "");
}

TEST_CASE("a sample a second is answered, though the process stood still before each of them", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  for (std::int64_t now = 0; now < 500 * kSecond; now += kSecond)
  {
    gate.pause(30'000);
    REQUIRE(pass(gate, 7, now, now) == "");
  }
}

TEST_CASE("stale samples do not keep a stream alive", "[stream_gate]")
{
  StreamGate gate(kMaxAge);
  CHECK(pass(gate, 7, 0, 0) == "");
  // from now on the network holds everything up by 50 ms
  for (std::int64_t utime = 1000; utime <= 60'000; utime += 1000)
    CHECK(pass(gate, 7, utime, utime + 50'000) == "STALE");
  CHECK(pass(gate, 8, 0, 110'500) == "");
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
