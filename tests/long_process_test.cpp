// Tests that are the better the longer they run. SOAK_MINUTES, STORM_MESSAGES and ATTACK_SCALE say how long, SEED
// repeats a run.

#include "attack_scale.h"
#include "catch.h"
#include "daemon_bench.h"
#include "flood.h"
#include "relay.h"

#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

namespace long_process_test
{

using namespace torqued;

namespace
{

using namespace std::chrono_literals;

double number_from_environment(const char* name, double fallback)
{
  const char* text = std::getenv(name);
  return text == nullptr || *text == '\0' ? fallback : std::stod(text);
}

// Samples, and what might be taken for one.
class Messages
{
public:
  explicit Messages(std::uint64_t seed) : random_(seed) {}

  bool one_in(std::uint64_t n) { return random_() % n == 0; }
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  std::int64_t stream_id() { return static_cast<std::int64_t>(random_() >> 1); }

  // a motion that need not make sense
  void move(desired_state_t& desired)
  {
    const auto choice = [this](std::uint64_t n)
    {
      return static_cast<std::int8_t>(random_() % n);
    };
    desired.coordinates = choice(2);
    desired.left_contact = choice(4);
    desired.right_contact = choice(4);
    desired.leading_foot = choice(2);
    desired.method = choice(10);
    desired.load_transfer = between(0.0, 1.0);
    desired.phase = between(0.0, 1.0);
    const double size = std::pow(10.0, between(-3.0, 3.0));
    for (auto* numbers : {&desired.q, &desired.v, &desired.a})
      for (double& number : *numbers)
        number = between(-size, size);
  }

  // bytes changed here and there, or cut, or longer, or all at random. The sender's clock and stream mostly stay.
  void damage(std::vector<std::byte>& bytes)
  {
    const auto any_byte = [this]
    {
      return static_cast<std::byte>(random_() & 0xff);
    };
    switch (random_() % 4)
    {
    case 0: bytes.resize(random_() % 1300); return;
    case 1:
      bytes.resize(random_() % 1300);
      for (std::byte& byte : bytes)
        byte = any_byte();
      return;
    case 2: // a whole number, as a wrong conversion would leave it
    {
      constexpr std::array<std::uint64_t, 8> odd{0,
                                                 0x7ff0'0000'0000'0000,
                                                 0xfff0'0000'0000'0000,
                                                 0x7ff8'0000'0000'0001,
                                                 0x7fef'ffff'ffff'ffff,
                                                 0x0000'0000'0000'0001,
                                                 0x7fff'ffff'ffff'ffff,
                                                 0xffff'ffff'ffff'ffff};
      const std::uint64_t number = odd[random_() % odd.size()];
      const std::size_t at = 32 + random_() % (bytes.size() - 40);
      for (std::size_t i = 0; i < 8; ++i)
        bytes[at + i] = static_cast<std::byte>(number >> (56 - 8 * i));
      return;
    }
    default:
      for (std::uint64_t count = 1 + random_() % 8; count > 0; --count)
        bytes[one_in(50) ? random_() % bytes.size() : 24 + random_() % (bytes.size() - 24)] = any_byte();
    }
  }

private:
  std::mt19937_64 random_;
};

template <typename Message> std::vector<std::byte> encoded(const Message& message)
{
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  encode(message, bytes);
  return bytes;
}

// kB that the process has in memory, but for pages of its files, which come when they are first used; and how many
// descriptors
std::pair<long, long> memory_and_descriptors(pid_t pid)
{
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  std::string line;
  long memory = -1;
  while (std::getline(status, line))
    if (line.starts_with("RssAnon:"))
      memory = std::stol(line.substr(8));
  const std::filesystem::directory_iterator descriptors(fmt::format("/proc/{}/fd", pid));
  return {memory, std::distance(begin(descriptors), end(descriptors))};
}

double median(std::vector<double> numbers)
{
  REQUIRE_FALSE(numbers.empty());
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

} // namespace

TEST_CASE("of messages made at random each is counted, none makes torqued allocate or answer what is not finite",
          "[long_process]")
{
  const auto messages = static_cast<std::int64_t>(number_from_environment("STORM_MESSAGES", 20'000));
  const auto seed = static_cast<std::uint64_t>(number_from_environment("SEED", std::random_device()()));
  CAPTURE(messages, seed);
  const TemporaryFolder folder;
#ifdef ALLOCATION_GUARD
  const std::string path = folder.file("report");
  Bench bench({"--every-sample"}, {"env", "LD_PRELOAD=" ALLOCATION_GUARD, "ALLOCATION_REPORT=" + path});
  bench.torqued().signal(SIGUSR1);
#else
  Bench bench({"--every-sample"});
#endif
  Messages random(seed);
  dynamics_request_t request{};
  request.num_coordinates = bench.model->num_coordinates;
  request.q.resize(7);
  request.v = request.a = request.q;
  const std::vector<std::byte> a_request = encoded(request), a_status = encoded(status_t{});

  std::int64_t answered = 0, rejected = 0, samples = 0;
  std::int64_t stream_id = 1;
  for (std::int64_t i = 0; i < messages; ++i)
  {
    std::vector<std::byte> bytes;
    if (random.one_in(20))
    {
      bytes = random.one_in(2) ? a_request : a_status;
      const bool asks = bytes.size() == a_request.size();
      if (!random.one_in(4))
        random.damage(bytes);
      bench.publish_bytes(asks ? "TORQUED_DYNAMICS_REQUEST" : "TORQUED_STATUS", bytes);
      continue;
    }
    desired_state_t desired = bench.standing();
    if (random.one_in(5000))
      stream_id = random.stream_id();
    desired.stream_id = stream_id;
    random.move(desired);
    bytes = encoded(desired);
    if (!random.one_in(3))
      random.damage(bytes);
    bench.send(Bytes(bytes));
    ++samples;
    // what waits fits into the system's buffers; a reply says that all before its request was dealt with
    if (samples % 40 == 0)
    {
      bench.ask(samples);
      REQUIRE(bench.wait(
          [&]
          {
            return std::any_of(bench.dynamics.begin(), bench.dynamics.end(),
                               [samples](const dynamics_t& reply) { return reply.request_id == samples; });
          }));
      if (bench.commands.empty()) // a damaged sample may have shown any clock
        stream_id = random.stream_id();
      REQUIRE(std::all_of(bench.commands.begin(), bench.commands.end(), &all_finite));
      answered += static_cast<std::int64_t>(bench.commands.size());
      rejected += static_cast<std::int64_t>(bench.rejections.size());
      bench.forget();
    }
  }
  const status_t& status = bench.settled_status();
  answered += static_cast<std::int64_t>(bench.commands.size());
  rejected += static_cast<std::int64_t>(bench.rejections.size());
  fmt::print("{} messages, {} of them samples: {} answered, {} rejected; seed {}\n", messages, samples, answered,
             rejected, seed);
  CHECK(answered > samples / 50);
  CHECK(status.received == samples);
  CHECK(status.answered == answered);
  CHECK(status.rejected == samples - answered);
  CHECK(rejected <= status.rejected); // at most a thousand a second are published
#ifdef ALLOCATION_GUARD
  bench.torqued().signal(SIGUSR2);
  std::string report;
  REQUIRE(bench.wait([&] { return std::filesystem::exists(path) && (report = read_file(path)).ends_with("end\n"); }));
  CAPTURE(report);
  CHECK(report.starts_with("program 0 seen "));
#endif
  bench.torqued().signal(SIGTERM);
  CHECK(bench.torqued().wait() == 0);
}

TEST_CASE("a client that floods takes over no stream, whatever finds no room", "[long_process]")
{
  const int runs = 2 * attack_scale();
  std::int64_t sent = 0, lost = 0, starved = 0;
  for (int i = 0; i < runs; ++i)
  {
    // with less room than the system gives, so that messages do get lost
    Bench bench(i % 2 == 0
                    ? std::vector<std::string>{}
                    : std::vector<std::string>{"--lcm-url", "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=20000"});
    bench.stream(100ms);
    desired_state_t other = bench.standing();
    other.stream_id = 99;
    {
      const Flood flood(encoded(other), 55'000);
      bench.stream(2000ms);
      sent += flood.sent();
    }
    CAPTURE(i, bench.longest_pause.count());
    CHECK((bench.followed_alone() || bench.longest_pause > kSilence));
    starved += bench.longest_pause > kSilence ? 1 : 0;
    lost += bench.settled_status().dropped_upper_bound;
    CHECK(bench.statuses.back().received ==
          bench.statuses.back().answered + bench.statuses.back().rejected + bench.statuses.back().superseded);
  }
  fmt::print("{} floods, {} samples of another stream, at most {} messages lost; {} times the client paused itself\n",
             runs, sent, lost, starved);
}

TEST_CASE("a long run on a bad network keeps account, memory, descriptors, statuses and latency", "[long_process]")
{
  const double minutes = number_from_environment("SOAK_MINUTES", 0.15);
  const auto seed = static_cast<std::uint64_t>(number_from_environment("SEED", std::random_device()()));
  CAPTURE(minutes, seed);
  Bench bench;
  lcm::LCM bus(fmt::format("udpm://{}:7668?ttl=0", Relay::kGroup));
  Relay relay(7668, 7667, seed);
  bench.send_through(bus);
  Messages random(seed);

  const auto begin = Bench::Clock::now();
  const auto end =
      begin + std::chrono::duration_cast<Bench::Clock::duration>(std::chrono::duration<double>(60 * minutes));
  const auto warm = begin + std::min<Bench::Clock::duration>(60s, (end - begin) / 3);
  std::int64_t stream_id = 1, sent = 0, commands = 0, rejections = 0, streams = 1;
  int stops = 0;
  long least_memory = std::numeric_limits<long>::max(), most_memory = 0;
  long least_descriptors = std::numeric_limits<long>::max(), most_descriptors = 0;
  auto next_second = begin, answered_at = begin;
  std::size_t seen = 0; // commands
  for (auto next = begin; next < end; next += 1ms)
  {
    bench.hear_until(next);
    desired_state_t desired = bench.standing();
    desired.stream_id = stream_id;
    if (random.one_in(4))
      random.move(desired);
    std::vector<std::byte> bytes = encoded(desired);
    if (random.one_in(10))
      random.damage(bytes);
    bench.send(Bytes(bytes));
    ++sent;
    if (bench.commands.size() != seen)
    {
      seen = bench.commands.size();
      answered_at = next;
    }
    if (random.one_in(5000) || next > answered_at + 200ms) // a damaged sample may have shown any clock
    {
      stream_id = random.stream_id();
      answered_at = next;
      ++streams;
    }
    if (random.one_in(10'000))
    {
      bench.torqued().signal(SIGSTOP);
      bench.hear_for(std::chrono::milliseconds(static_cast<int>(random.between(10.0, 1000.0))));
      bench.torqued().signal(SIGCONT);
      next = Bench::Clock::now();
      ++stops;
    }
    if (next < next_second)
      continue;
    next_second = next + 1s;
    const auto some = [&](double most)
    {
      return random.one_in(3) ? random.between(0.0, most) : 0.0;
    };
    // LCM remembers every name of a channel it ever heard: the start of a packet, with the name, stays whole
    relay.set({.loss = some(0.5),
               .repeat = some(0.5),
               .reorder = some(0.5),
               .corrupt = some(0.3),
               .truncate = some(0.3),
               .delay = some(10.0),
               .jitter = some(40.0),
               .whole = 24});
    REQUIRE(std::all_of(bench.commands.begin(), bench.commands.end(), &all_finite));
    commands += static_cast<std::int64_t>(bench.commands.size());
    rejections += static_cast<std::int64_t>(bench.rejections.size());
    bench.forget();
    seen = 0;
    if (next < warm)
      continue;
    const auto [memory, descriptors] = memory_and_descriptors(bench.torqued().pid());
    least_memory = std::min(least_memory, memory);
    most_memory = std::max(most_memory, memory);
    least_descriptors = std::min(least_descriptors, descriptors);
    most_descriptors = std::max(most_descriptors, descriptors);
  }
  relay.set({});
  const status_t last = bench.settled_status();

  const std::vector<status_t>& statuses = bench.statuses;
  int gaps = 0;
  for (std::size_t i = 1; i < statuses.size(); ++i)
  {
    REQUIRE(statuses[i].received == statuses[i].answered + statuses[i].rejected + statuses[i].superseded);
    gaps += statuses[i].uptime_us - statuses[i - 1].uptime_us > 500'000 ? 1 : 0;
  }
  std::vector<double> early, late;
  for (std::size_t i = 0; i < statuses.size(); ++i)
    if (statuses[i].latency_us_max > 0.0 && i < statuses.size() / 3)
      early.push_back(statuses[i].latency_us_p50);
    else if (statuses[i].latency_us_max > 0.0 && i >= 2 * statuses.size() / 3)
      late.push_back(statuses[i].latency_us_p50);
  const double ratio = median(late) / median(early);

  fmt::print(
      "{:.2f} min at 1 kHz, seed {}: {} samples of {} streams; relay: {} lost, {} repeated, {} damaged; {} times "
      "stopped\n",
      minutes, seed, sent, streams, relay.lost(), relay.repeated(), relay.damaged(), stops);
  fmt::print("received {} = answered {} + rejected {} + superseded {}\n", last.received, last.answered, last.rejected,
             last.superseded);
  fmt::print("memory {} to {} kB, descriptors {} to {} after the first {:.0f} s; {} statuses, {} gaps over 0.5 s\n",
             least_memory, most_memory, least_descriptors, most_descriptors,
             std::chrono::duration<double>(warm - begin).count(), statuses.size(), gaps);
  fmt::print("median latency: {:.0f} us in the first third, {:.0f} us in the last\n", median(early), median(late));

  commands += static_cast<std::int64_t>(bench.commands.size());
  rejections += static_cast<std::int64_t>(bench.rejections.size());
  CHECK(last.received > sent / 2);
  CHECK(last.answered > sent / 10);
  CHECK(commands == last.answered);
  CHECK(rejections <= last.rejected); // at most a thousand a second are published
  CHECK(gaps <= stops);
  CHECK(least_descriptors == most_descriptors);
#ifdef ALLOCATION_GUARD // sanitizers keep what was freed
  CHECK(most_memory - least_memory <= 64);
#endif
  if (minutes >= 10.0) // then a loop that slows down shows; before, other programs disturb it as much
    CHECK(ratio < 3.0);
  bench.torqued().signal(SIGTERM);
  CHECK(bench.torqued().wait() == 0);
}

} // namespace long_process_test
