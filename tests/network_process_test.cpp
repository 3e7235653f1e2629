#include "attack_scale.h"
#include "catch.h"
#include "daemon_bench.h"
#include "logger.h"
#include "relay.h"

#include <fmt/format.h>

namespace network_process_test
{

using namespace torqued;

namespace
{

using namespace std::chrono_literals;

constexpr std::uint16_t kDaemonsPort = 7667;
constexpr std::uint16_t kClientsPort = 7668;
constexpr std::int64_t kMaxAge = 20'000; // µs

// A client whose samples reach the daemon through a relay.
struct BadNetwork
{
  explicit BadNetwork(std::uint64_t seed) : relay(kClientsPort, kDaemonsPort, seed) { bench.send_through(bus); }

  Bench bench;
  lcm::LCM bus{fmt::format("udpm://{}:{}?ttl=0", Relay::kGroup, kClientsPort)};
  Relay relay;
};

} // namespace

TEST_CASE(
    "whatever the network does, each sample is counted once, answered at most once and in order, and good ones are "
    "answered afterwards",
    "[network_process]")
{
  const std::vector<std::pair<std::string, NetworkFaults>> rows{
      {"1 % lost", {.loss = 0.01}},
      {"10 % lost", {.loss = 0.1}},
      {"50 % lost", {.loss = 0.5}},
      {"repeated", {.repeat = 0.3}},
      {"reordered", {.reorder = 0.2}},
      {"5 ms late, with jitter", {.delay = 5.0, .jitter = 5.0}},
      {"50 ms late, with jitter", {.delay = 50.0, .jitter = 5.0}},
      {"damaged", {.corrupt = 0.3}},
      {"cut", {.truncate = 0.3}},
      {"all at once",
       {.loss = 0.1, .repeat = 0.1, .reorder = 0.1, .corrupt = 0.1, .truncate = 0.1, .delay = 2.0, .jitter = 3.0}},
  };
  std::uint64_t seed = 1;
  for (const auto& [name, faults] : rows)
  {
    CAPTURE(name, seed);
    BadNetwork network(seed++);
    Bench& bench = network.bench;
    network.relay.set(faults);
    bench.stream(1000ms);
    network.relay.set({});
    const status_t during = bench.settled_status();
    const auto reason = [&]
    {
      return bench.rejections.empty() ? "" : bench.rejections.back().detail;
    };
    CAPTURE(during.answered, during.rejected, during.superseded, reason());
    CHECK(network.relay.received() == 1000);
    CHECK(network.relay.passed() == 1000 - network.relay.lost() + network.relay.repeated());
    // a packet whose channel is damaged is none of ours
    CHECK(during.received <= network.relay.passed());
    if (network.relay.damaged() == 0)
      CHECK(during.received == network.relay.passed());
    CHECK(during.answered > 0);
    if (faults.repeat > 0.0 || faults.reorder > 0.0)
      CHECK(bench.rejected(rejection_t::OUT_OF_ORDER) > 0);

    // after a silence of 5 max_age another stream is followed, whatever clock a damaged sample has shown
    bench.hear_for(150ms);
    const std::size_t commands = bench.commands.size();
    desired_state_t anew = bench.standing();
    anew.stream_id = 78;
    bench.send_one(anew);
    CHECK(bench.commands.size() == commands + 1);
    if (network.relay.damaged() > 0)
    {
      // of a damaged number that is still a number nobody can know
      CHECK(std::all_of(bench.commands.begin(), bench.commands.end(), &all_finite));
      continue;
    }
    bench.check_account();
  }
}

TEST_CASE("what is late by more than max_age against the freshest of its stream is refused, a constant delay is not",
          "[network_process]")
{
  BadNetwork network(11);
  Bench& bench = network.bench;
  network.relay.set({.delay = 50.0});
  bench.stream(1000ms);
  network.relay.set({.delay = 50.0, .jitter = 100.0});
  bench.stream(1000ms);
  bench.settled_status();
  // by how much later than the freshest each command was heard here; that includes the way back, and what the machine
  // did in between
  const std::int64_t freshest = *std::min_element(bench.ages.begin(), bench.ages.end());
  CHECK(freshest > 50'000);
  const auto too_old = std::count_if(bench.ages.begin(), bench.ages.end(),
                                     [&](std::int64_t age) { return age - freshest > kMaxAge + 30'000; });
  CHECK(too_old <= static_cast<std::ptrdiff_t>(bench.ages.size() / 100));
  CHECK(bench.rejected(rejection_t::STALE) + bench.rejected(rejection_t::OUT_OF_ORDER) > 300);
  CHECK(bench.rejected(rejection_t::STALE) > 0);
  CHECK(bench.commands.size() > 500); // those of the first second, less what the machine did
  bench.check_account();
}

TEST_CASE("what comes late after a gap is refused, however long the gap was", "[network_process]")
{
  for (const auto& [gap, late] : {std::pair(300ms, 250ms), std::pair(3100ms, 3000ms)})
  {
    CAPTURE(gap.count(), late.count());
    Bench bench;
    bench.stream(100ms);
    bench.hear_for(gap);
    const std::size_t before = bench.commands.size();
    REQUIRE(before > 0);
    // a link that was held up goes on as late as it is
    const int samples = 200 * attack_scale();
    for (int i = 0; i < samples; ++i)
    {
      desired_state_t desired = bench.standing();
      desired.utime -= std::chrono::microseconds(late).count();
      bench.send_one(desired);
      bench.hear_for(1ms);
    }
    CHECK(bench.commands.size() == before);
    CHECK(bench.rejected(rejection_t::STALE) >= static_cast<std::size_t>(samples));
    bench.send_one(bench.standing());
    CHECK(bench.commands.size() == before + 1);
    bench.check_account();
  }
}

TEST_CASE("a sample that is sent again and again has one command, whatever the silence between", "[network_process]")
{
  Bench bench;
  const desired_state_t desired = bench.standing();
  for (int i = 0; i < 10; ++i)
  {
    bench.send_one(desired);
    bench.hear_for(120ms);
  }
  CHECK(bench.commands.size() == 1);
  CHECK(bench.rejected(rejection_t::OUT_OF_ORDER) == 9);
  // nor has it one after another client
  desired_state_t other = bench.standing();
  other.stream_id = 78;
  bench.send_one(other);
  CHECK(bench.commands.size() == 2);
  bench.hear_for(120ms);
  bench.send_one(desired);
  CHECK(bench.commands.size() == 2);
  CHECK(bench.rejected(rejection_t::OUT_OF_ORDER) == 10);
  bench.check_account();
}

TEST_CASE("a sample that is not later than the one before is refused, and a client that set its clock back is told to "
          "take a new stream",
          "[network_process]")
{
  Bench bench;
  const auto send_at = [&](std::int64_t utime)
  {
    desired_state_t desired = bench.standing();
    desired.utime = utime;
    bench.send_one(desired);
  };
  const std::int64_t hour = 3'600'000'000;
  bench.send_one(bench.standing());
  const std::int64_t last = bench.commands.back().utime;
  send_at(last);             // equal
  send_at(last - 1);         // backwards
  send_at(last - 1'000'000); // 1 s old
  send_at(last - hour);
  CHECK(bench.commands.size() == 1);
  CHECK(bench.rejected(rejection_t::OUT_OF_ORDER) == 4);

  send_at(Bench::now() + hour); // by itself a good sample
  CHECK(bench.commands.size() == 2);
  bench.send_one(bench.standing());
  CHECK(bench.commands.size() == 2);
  CHECK(bench.rejected(rejection_t::OUT_OF_ORDER) == 5);
  // for good
  bench.hear_for(300ms);
  bench.send_one(bench.standing());
  CHECK(bench.commands.size() == 2);
  CHECK(bench.rejections.back().detail.find("takes a new stream_id") != std::string::npos);
  desired_state_t anew = bench.standing();
  anew.stream_id = 78;
  bench.send_one(anew);
  CHECK(bench.commands.size() == 3);
  bench.check_account();
}

TEST_CASE("of a burst the newest is answered, then silence is STALE", "[network_process]")
{
  Bench bench;
  desired_state_t desired = bench.standing();
  constexpr int burst = 10'000;
  for (int i = 0; i < burst; ++i)
  {
    desired.utime = std::max(desired.utime + 1, Bench::now()); // or they would seem older and older
    bench.send(desired);
  }
  bench.hear_for(200ms);
  const status_t status = bench.settled_status();
  CHECK(status.received == status.answered + status.rejected + status.superseded);
  // the system may drop what does not fit into its buffers
  CHECK(status.received <= burst);
  CHECK(status.received > 100);
  CHECK(status.superseded > 0);
  CHECK(status.state == status_t::STALE);
  REQUIRE_FALSE(bench.commands.empty());
  // nor is the newest answered where the system stood still for longer than a sample may age, or heard where it dropped
  // answers
  if (status.received == burst && status.rejected == 0 &&
      status.answered == static_cast<std::int64_t>(bench.commands.size()))
    CHECK(bench.commands.back().utime == desired.utime);
  const std::size_t commands = bench.commands.size();
  bench.hear_for(200ms);
  CHECK(bench.commands.size() == commands);
  bench.check_commands();
}

TEST_CASE("under a flood torqued keeps its account and its statuses", "[network_process]")
{
  Bench bench;
  const auto begin = Bench::Clock::now();
  const auto end = begin + 2s;
  int samples = 0;
  for (auto next = begin; next < end; next += 25us) // 40 kHz, or what this machine can
  {
    while (Bench::Clock::now() < next)
    {
    }
    bench.send(bench.standing());
    if (++samples % 40 == 0)
      bench.hear_for(0ms);
    if (samples % 400 == 0)
      bench.hear_until(Bench::Clock::now() + 200us);
    if (Bench::Clock::now() > end)
      break;
  }
  bench.hear_for(300ms);
  CHECK(samples > 5000);
  CHECK(bench.statuses.size() >= 5);
  const status_t status = bench.settled_status();
  CHECK(status.received == status.answered + status.rejected + status.superseded);
  CHECK(status.answered > 0);
  bench.hear_for(150ms);
  bench.send_one(bench.standing());
  bench.torqued().signal(SIGTERM);
  CHECK(bench.torqued().wait() == 0);
  bench.check_commands();
}

TEST_CASE("without any input there is a status ten times a second, and nothing else", "[network_process]")
{
  Bench bench;
  const std::size_t before = bench.statuses.size();
  const std::int64_t uptime = bench.settled_status().uptime_us;
  bench.hear_for(2000ms);
  const auto statuses = static_cast<double>(bench.statuses.size() - before);
  const double seconds = 1e-6 * static_cast<double>(bench.statuses.back().uptime_us - uptime);
  CHECK(statuses / seconds > 8.0);  // ten, less what other programs take of the machine
  CHECK(statuses / seconds < 13.0); // and those of the time in which this one settled
  CHECK(bench.statuses.back().state == status_t::WAITING);
  CHECK(bench.statuses.back().input_age_us == -1);
  bench.check_account();
  CHECK(bench.statuses.back().received == 0);
}

TEST_CASE("of two clients one is followed, and the other when that one is silent", "[network_process]")
{
  Bench bench;
  desired_state_t other = bench.standing();
  for (int i = 0; i < 50; ++i)
  {
    bench.send_one(bench.standing());
    other.utime = Bench::now();
    other.stream_id = 99;
    bench.send_one(other);
  }
  CHECK(bench.commands.size() == 50);
  CHECK(bench.rejected(rejection_t::OTHER_STREAM) == 50);
  CHECK(bench.settled_status().conflicts == 50);
  bench.hear_for(150ms);
  other.utime = Bench::now();
  bench.send_one(other);
  CHECK(bench.commands.back().stream_id == 99);
  bench.send_one(bench.standing());
  CHECK(bench.rejected(rejection_t::OTHER_STREAM) == 51);
  bench.check_account();
}

TEST_CASE("after SIGSTOP and SIGCONT no command comes for what is older than max_age", "[network_process]")
{
  Bench bench;
  bench.stream(300ms);
  int old = 0;
  const int stops = 10 * attack_scale();
  for (int i = 0; i < stops; ++i)
  {
    bench.torqued().signal(SIGSTOP);
    bench.stream(i == 0 ? 1000ms : 150ms);
    bench.hear_for(50ms);
    const std::size_t before = bench.commands.size();
    const std::int64_t superseded = bench.statuses.back().superseded;
    const std::int64_t stopped_until = Bench::now();
    bench.torqued().signal(SIGCONT);
    bench.stream(100ms);
    REQUIRE(bench.commands.size() > before);
    // all that was sent while it stood still is older than max_age when it goes on, but for the last 20 ms
    old += bench.commands[before].utime > stopped_until - kMaxAge - 50'000 ? 0 : 1;
    CHECK(bench.settled_status().superseded > superseded + 20);
  }
  // between the last look at the clock and the system call that sends lie a few microseconds of a stream's thousand
  fmt::print("{} of {} stops let an old answer out\n", old, stops);
  CHECK(old <= 1 + stops / 50);
  bench.check_account();
}

TEST_CASE("killed and started anew in the middle of a stream torqued answers again", "[network_process]")
{
  Bench bench;
  bench.stream(200ms);
  CHECK_FALSE(bench.commands.empty());
  const std::int64_t instance = bench.statuses.back().instance_id;
  bench.start();
  const std::size_t before = bench.commands.size(); // with those of the one before that were still on their way
  bench.stream(200ms);
  REQUIRE(bench.commands.size() > before);
  CHECK(bench.commands[before].sequence == 1);
  bench.check_commands();
  CHECK(bench.settled_status().instance_id != instance);
}

TEST_CASE("a logger that is killed takes nothing with it but the end of its log", "[network_process]")
{
  Bench bench;
  const TemporaryFolder folder;
  {
    Logger logger(folder.file("log"), folder.file("out"));
    bench.stream(500ms);
    logger.end(SIGKILL);
  }
  bench.stream(200ms);
  bench.check_account();
  Process exported({TORQUECTL, "export", folder.file("log"), "--robot", "ck", "-o", folder.file("csv")},
                   folder.file("export"));
  const std::optional<int> code = exported.wait();
  CAPTURE(read_file(folder.file("out")), read_file(folder.file("export")));
  REQUIRE(code == 0);
  CHECK(read_file(folder.file("csv")).size() > 10'000);
}

TEST_CASE("packets that end within their channel's name are nobody's messages, and no harm", "[network_process]")
{
  Bench bench;
  std::vector<std::byte> sample;
  std::string packet("LC02\0\0\0\0TORQUED_DESIRED\0", 24);
  const Bytes bytes = encode(bench.standing(), sample);
  packet.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Relay relay(kClientsPort, kDaemonsPort, 1);
  const int out = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kClientsPort);
  inet_pton(AF_INET, Relay::kGroup, &to.sin_addr);
  const unsigned char ttl = 0;
  setsockopt(out, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  // of the buffers that whole packets have filled, many are used again
  for (int round = 0; round < 200; ++round)
    for (std::size_t size : {packet.size(), std::size_t{9}, std::size_t{16}, std::size_t{23}})
    {
      sendto(out, packet.data(), size, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
      bench.hear_for(1ms);
    }
  close(out);
  CHECK(bench.settled_status().received >= 200);
  bench.hear_for(150ms);
  bench.send_one(bench.standing());
  CHECK(bench.torqued().wait(0ms) == std::nullopt);
  bench.torqued().signal(SIGTERM);
  CHECK(bench.torqued().wait() == 0);
}

} // namespace network_process_test
