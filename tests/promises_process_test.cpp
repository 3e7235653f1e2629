#include "attack_scale.h"
#include "catch.h"
#include "daemon_bench.h"
#include "flood.h"

#include "robot/files/load.h"
#include "robot/files/robot_files.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

namespace promises_process_test
{

using namespace torqued;

namespace
{

using Clock = Bench::Clock;

std::vector<std::byte> encoded(const desired_state_t& desired)
{
  std::vector<std::byte> bytes(static_cast<std::size_t>(desired.getEncodedSize()));
  encode(desired, bytes);
  return bytes;
}

// whether a process is torqued, and keeps this signal for itself
bool torqued_blocks(pid_t pid, int signal)
{
  const std::string status = read_file(fmt::format("/proc/{}/status", pid));
  const std::size_t at = status.find("SigBlk:");
  return status.starts_with("Name:\ttorqued\n") && at != std::string::npos &&
         (std::stoull(status.substr(at + 7), nullptr, 16) >> (signal - 1) & 1) != 0;
}

// Runs a command of the shell that must succeed.
void shell(const std::string& command)
{
  CAPTURE(command);
  REQUIRE(std::system(command.c_str()) == 0);
}

// What systemd hears from a service.
class NotifySocket
{
public:
  explicit NotifySocket(const std::string& path) : path_(path), fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0))
  {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    REQUIRE(bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  }
  ~NotifySocket() { close(fd_); }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  std::string variable() const { return "NOTIFY_SOCKET=" + path_; }
  // how often this has been heard
  int heard(const std::string& what)
  {
    std::array<char, 256> buffer;
    for (ssize_t size = 0; (size = recv(fd_, buffer.data(), buffer.size(), 0)) >= 0;)
      words_.emplace_back(buffer.data(), static_cast<std::size_t>(size));
    return static_cast<int>(std::count(words_.begin(), words_.end(), what));
  }

private:
  std::string path_;
  int fd_;
  std::vector<std::string> words_;
};

constexpr const char* kMulticast = "ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo";

} // namespace

TEST_CASE("whatever the bytes of a sample, it is counted once and the next good one is answered", "[promises_process]")
{
  Bench bench;
  const desired_state_t good = bench.standing();
  const std::vector<std::byte> bytes = encoded(good);
  std::vector<std::vector<std::byte>> bad;
  // numbers: load_transfer, phase, base and motion, in the places where they stand, most significant byte first
  constexpr std::size_t load_transfer = 8 + 3 * 8 + 6, count = load_transfer + 8 * 8;
  const auto with_number = [&](std::size_t at, double number)
  {
    std::vector<std::byte> changed = bytes;
    const auto bits = std::bit_cast<std::uint64_t>(number);
    for (std::size_t i = 0; i < 8; ++i)
      changed[at + i] = static_cast<std::byte>(bits >> (56 - 8 * i));
    return changed;
  };
  for (const double number : std::initializer_list<double>{NAN, -NAN, HUGE_VAL, -HUGE_VAL})
  {
    for (std::size_t at = load_transfer; at < count; at += 8)
      bad.push_back(with_number(at, number));
    for (std::size_t at = count + 4; at < bytes.size(); at += 8)
      bad.push_back(with_number(at, number));
  }
  for (const double number : {-1e-300, 1.0000001, 1e308})
    for (const std::size_t at : {load_transfer, load_transfer + 8})
      bad.push_back(with_number(at, number));
  for (const std::int32_t n : {-1, 0, 6, 8, 100'000'000, 1 << 29, INT32_MAX, INT32_MIN})
  {
    bad.push_back(bytes);
    for (std::size_t i = 0; i < 4; ++i)
      bad.back()[count + i] = static_cast<std::byte>(static_cast<std::uint32_t>(n) >> (24 - 8 * i));
  }
  for (std::size_t size = 0; size < bytes.size(); ++size)
    bad.emplace_back(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  for (std::size_t extra = 1; extra <= 1000; ++extra)
  {
    bad.push_back(bytes);
    bad.back().resize(bytes.size() + extra);
  }
  for (std::size_t at = 0; at < 8; ++at) // fingerprint
    for (int bit = 0; bit < 8; ++bit)
    {
      bad.push_back(bytes);
      bad.back()[at] ^= static_cast<std::byte>(1 << bit);
    }
  for (std::size_t at = 32; at < 38; ++at) // choices
    for (const int value : {-128, -1, 10, 127})
    {
      bad.push_back(bytes);
      bad.back()[at] = static_cast<std::byte>(value);
    }

  for (std::size_t i = 0; i < bad.size(); ++i)
  {
    bench.send(Bytes(bad[i]));
    // what waits fits into a socket's buffer, and a thousand rejections a second are published
    if (i % 50 == 49 || i + 1 == bad.size())
    {
      CAPTURE(i);
      REQUIRE(bench.wait([&] { return bench.rejections.size() == i + 1; }));
      bench.hear_for(std::chrono::milliseconds(55));
    }
  }
  CHECK(bench.commands.empty());
  bench.send_one(bench.standing());
  CHECK(bench.commands.size() == 1);
  bench.check_account();
}

TEST_CASE("whatever the motion, its answer is finite and within clamped limits, or it is refused", "[promises_process]")
{
  struct Variant
  {
    std::string name, torque_limit, friction;
  };
  for (const Variant& variant : {Variant{"as it ships", "150.0", "0.6"}, Variant{"weak", "0.0", "0.6"},
                                 Variant{"on ice", "150.0", "0.0"}, Variant{"weak on ice", "0.0", "0.0"}})
  {
    const TemporaryFolder folder;
    std::string toml = to_toml(load_robot("ck"));
    const auto replace = [&toml](const std::string& key, const std::string& value)
    {
      int replaced = 0;
      for (std::size_t at = 0; (at = toml.find("\n" + key + " = ", at)) != std::string::npos; ++replaced)
      {
        const std::size_t begin = at + key.size() + 4;
        toml.replace(begin, toml.find('\n', begin) - begin, value);
        at = begin;
      }
      REQUIRE(replaced >= 2);
    };
    replace("torque_limit", variant.torque_limit);
    replace("friction", variant.friction);
    Bench bench({"--robot", folder.write("robot.toml", toml), "--config",
                 folder.write("config.toml", "limits = 'clamp'\nrate_limits = 'clamp'\nevery_sample = true")});
    REQUIRE(bench.model);

    std::vector<std::pair<std::string, desired_state_t>> motions;
    const auto add = [&](const std::string& name, const std::function<void(desired_state_t&)>& change)
    {
      desired_state_t desired = bench.standing();
      for (const std::size_t i : {1U, 2U, 3U, 4U})
        desired.q[i] = i < 3 ? 0.2 : -0.1;
      change(desired);
      motions.emplace_back(name, desired);
    };
    add("walking", [](auto&) {});
    add("straight knees, feet at one place", [](auto& d) { d.q.assign(7, 0.0); });
    add("straight knees, one leg before the other", [](auto& d) { d.q = {0, 0.3, 0.3, -0.3, -0.3, 0, 0}; });
    add("almost no weight", [](auto& d) { d.base = desired_state_t::GIVEN, d.base_a[1] = -9.81; });
    add("no weight at all, from the contact", [](auto& d) { d.a = {0, 30, -30, -30, 30, 0, 0}; });
    add("zero-moment point far outside", [](auto& d) { d.a[6] = 1e4; });
    add("as fast as numbers go", [](auto& d) { d.v.assign(7, 1e308); });
    add("as large as numbers go", [](auto& d) { d.q.assign(7, 1e308), d.a.assign(7, -1e308); });
    add("denormal", [](auto& d) { d.q.assign(7, 5e-324), d.v.assign(7, -5e-324), d.a.assign(7, 5e-324); });
    add("flight", [](auto& d) { d.left_contact = d.right_contact = 0, d.base = 1, d.base_a[1] = -9.81; });
    add("flight that is none", [](auto& d) { d.left_contact = d.right_contact = 0, d.base = 1; });
    add("one heel", [](auto& d) { d.left_contact = 1, d.right_contact = 0; });
    add("one toe", [](auto& d) { d.left_contact = 0, d.right_contact = 3; });
    for (std::int8_t pair = 0; pair < 16; ++pair)
      for (int times = 0; times < 2; ++times)
        add(fmt::format("contacts {} and {}", pair / 4, pair % 4),
            [pair, times](auto& d)
            {
              d.left_contact = static_cast<std::int8_t>(pair / 4);
              d.right_contact = static_cast<std::int8_t>(pair % 4);
              d.load_transfer = d.phase = times;
            });

    for (std::int8_t method = 1; method <= 9; ++method)
      for (auto& [name, desired] : motions)
      {
        CAPTURE(variant.name, int{method}, name);
        desired.utime = Bench::now();
        desired.method = method;
        const std::size_t commands = bench.commands.size();
        bench.send_one(desired);
        if (bench.commands.size() == commands)
        {
          CHECK(name != "walking");
          continue;
        }
        const torque_command_t& command = bench.commands.back();
        CHECK(all_finite(command));
        CHECK(command.utime == desired.utime);
        for (std::size_t j = 0; j < command.torque.size(); ++j)
          CHECK(std::abs(command.torque[j]) <= bench.model->torque_limits[j]);
      }
    bench.check_account();
  }
}

TEST_CASE("a log that nobody reads neither delays answers nor the end", "[promises_process]")
{
  const TemporaryFolder folder;
  // a pipe that is full before the daemon writes its first line
  const std::string pipe = folder.file("errors");
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  const int fd = open(pipe.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  const std::vector<char> filling(4096, '.');
  while (write(fd, filling.data(), filling.size()) > 0)
  {
  }
  {
    Bench bench({}, {}, pipe);
    for (int i = 0; i < 100; ++i)
    {
      desired_state_t desired = bench.standing();
      if (i % 2 == 0)
        desired.method = 99; // is logged
      bench.send_one(desired);
    }
    CHECK(bench.commands.size() == 50);
    const auto begin = Clock::now();
    bench.torqued().signal(SIGTERM);
    REQUIRE(bench.torqued().wait() == 0);
    // 100 ms are promised; what the machine adds while other programs use it is not the daemon's
    CHECK(Clock::now() - begin < std::chrono::seconds(1));
    CHECK(bench.wait([&] { return bench.statuses.back().state == status_t::STOPPING; }));
  }
  close(fd);
}

TEST_CASE("a log that cannot be written stops nothing", "[promises_process]")
{
  Bench bench({}, {}, "/dev/full");
  desired_state_t bad = bench.standing();
  bad.method = 99;
  bench.send_one(bad);
  bench.send_one(bench.standing());
  CHECK(bench.commands.size() == 1);
  bench.check_account();
}

TEST_CASE("a log whose reader has gone ends nothing", "[promises_process]")
{
  const TemporaryFolder folder;
  const std::string pipe = folder.file("errors");
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  const auto open_reader = [&pipe]
  {
    return open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  };
  const std::vector<std::string> as_in_a_shell{"env", "--default-signal=PIPE"};
  {
    const int reader = open_reader();
    Bench bench({}, as_in_a_shell, pipe);
    close(reader);
    for (int i = 0; i < 3; ++i)
    {
      desired_state_t bad = bench.standing();
      bad.method = static_cast<std::int8_t>(99);
      bad.model_id += i == 1 ? 1 : 0; // another reason is another line
      bench.send_one(bad);
      bench.hear_for(std::chrono::milliseconds(20));
    }
    bench.send_one(bench.standing());
    CHECK(bench.commands.size() == 1);
    bench.check_account();
  }

  // a start that fails has its exit code, though nobody can read why
  struct Row
  {
    std::string arguments;
    int code;
  };
  for (const Row& row : {Row{"--nonsense", 64}, {"--robot nobody", 78}, {"--robot ck --lcm-url nothing://", 69}})
  {
    CAPTURE(row.arguments);
    std::vector<std::string> command = as_in_a_shell;
    command.insert(command.end(), {"sh", "-c", fmt::format("sleep 0.3; exec {} {}", TORQUED, row.arguments)});
    const int reader = open_reader();
    Process torqued(command, folder.file("out"), pipe);
    close(reader);
    CHECK(torqued.wait() == row.code);
  }
}

TEST_CASE("a client that floods takes no stream over, and keeps nobody from answers, statuses, watchdog and end",
          "[promises_process]")
{
  const TemporaryFolder folder;
  for (const bool samples : {true, false})
  {
    CAPTURE(samples);
    NotifySocket systemd(folder.file(samples ? "samples" : "junk"));
    Bench bench({}, {"env", systemd.variable()});
    desired_state_t other = bench.standing();
    other.stream_id = 99;
    std::vector<std::byte> bytes = encoded(other);
    if (!samples)
      bytes.resize(bytes.size() - 9);
    bench.stream(std::chrono::milliseconds(100));
    const status_t before = bench.statuses.back();
    const int fed = systemd.heard("WATCHDOG=1");
#ifdef ALLOCATION_GUARD
    const Flood flood(bytes, samples ? 55'000 : 100'000);
#else // sanitized, the daemon does not keep up with that: what comes out of its backlog is stale
    const Flood flood(bytes, 5'000);
#endif
    bench.stream(std::chrono::milliseconds(1500) * attack_scale());
    const status_t during = bench.statuses.back();
    const double seconds = 1e-6 * static_cast<double>(during.uptime_us - before.uptime_us);
    const auto answered = static_cast<double>(during.answered - before.answered);
    // how far from a multiple of 100 ms the statuses that we heard were published; the flood loses others on the way
    std::vector<double> off;
    for (std::size_t i = 1; i < bench.statuses.size(); ++i)
      if (bench.statuses[i - 1].uptime_us >= before.uptime_us)
        off.push_back(std::abs(std::remainder(
            static_cast<double>(bench.statuses[i].uptime_us - bench.statuses[i - 1].uptime_us), 100'000.0)));
    std::sort(off.begin(), off.end());
    CAPTURE(flood.sent(), seconds, answered, during.superseded, during.rejected, during.dropped_upper_bound, off,
            bench.rejections.size(), bench.sent.size());
    CHECK(flood.sent() > 2000);
    REQUIRE(seconds > 0.5);
    CHECK((bench.followed_alone() || bench.longest_pause > kSilence));
    CHECK(during.answered <= static_cast<std::int64_t>(bench.sent.size()));
    // under a flood the system drops some of all messages, before they reach the daemon or us
    CHECK(answered / seconds > 50.0);
    REQUIRE(off.size() >= 2);
    CHECK(off[off.size() / 2] < 25'000.0);
    CHECK(systemd.heard("WATCHDOG=1") - fed >= 2);
    CHECK(static_cast<double>(bench.rejections.size()) < 1000.0 * (seconds + 2.0));
    CHECK(during.received == during.answered + during.rejected + during.superseded);

    const auto begin = Clock::now();
    bench.torqued().signal(SIGTERM);
    REQUIRE(bench.torqued().wait() == 0);
    // 100 ms are promised; what the machine adds while other programs use it is not the daemon's
    CHECK(Clock::now() - begin < std::chrono::milliseconds(500));
    CHECK(systemd.heard("STOPPING=1") == 1);
  }
}

TEST_CASE("systemd hears READY when the bus is proven, WATCHDOG as long as it carries messages, and STOPPING",
          "[promises_process]")
{
  const TemporaryFolder folder;
  NotifySocket systemd(folder.file("notify"));
  Bench bench({}, {"env", systemd.variable()});
  CHECK(bench.wait([&] { return systemd.heard("WATCHDOG=1") >= 5; }));
  CHECK(systemd.heard("READY=1") == 1);
  CHECK(systemd.heard("STOPPING=1") == 0);

  // the loop turns, but the bus is gone
  shell("ip link set lo down");
  CHECK(bench.wait([&] { return bench.output().find("deaf") != std::string::npos; }));
  const int fed = systemd.heard("WATCHDOG=1");
  bench.hear_for(std::chrono::milliseconds(500));
  CHECK(systemd.heard("WATCHDOG=1") == fed);

  // and is back
  shell(kMulticast);
  CHECK(bench.wait([&] { return bench.output().find("the bus carries messages again") != std::string::npos; }));
  bench.send_one(bench.standing());
  CHECK(bench.commands.size() == 1);
  CHECK(bench.wait([&] { return systemd.heard("WATCHDOG=1") > fed; }));

  bench.torqued().signal(SIGTERM);
  CHECK(bench.torqued().wait() == 0);
  CHECK(systemd.heard("STOPPING=1") == 1);
  CHECK(systemd.heard("READY=1") == 1);
}

TEST_CASE("a systemd that does not read delays no answer", "[promises_process]")
{
  const TemporaryFolder folder;
  const NotifySocket systemd(folder.file("notify"));
  Bench bench({}, {"env", systemd.variable()});
  // far more than a socket's queue holds
  CHECK(bench.wait([&] { return bench.statuses.size() >= 40; }));
  for (int i = 0; i < 20; ++i)
    bench.send_one(bench.standing());
  CHECK(bench.commands.size() + bench.rejected(rejection_t::STALE) == 20);
  CHECK(bench.commands.size() >= 15);
  bench.torqued().signal(SIGTERM);
  CHECK(bench.torqued().wait() == 0);
}

TEST_CASE("two daemons on the same channels notice each other", "[promises_process]")
{
  const auto notices = [](const Bench& bench)
  {
    return bench.output().find("another daemon") != std::string::npos;
  };
  Bench first;
  bool alone = true;
  for (int i = 0; i < 3; ++i)
  {
    const std::size_t statuses = first.statuses.size();
    first.wait([&] { return first.statuses.size() > statuses; });
    alone = alone && !notices(first);
  }
  CHECK(alone);
  Bench second;
  CHECK(first.wait([&] { return notices(first); }));
  CHECK(second.wait([&] { return notices(second); }));
  CHECK(first.output().find("--prefix") != std::string::npos);
}

TEST_CASE("a bus that a firewall closes ends the start, and a signal ends it at once", "[promises_process]")
{
  // the rest of this network goes on: the rule stands in a network of its own
  const TemporaryFolder folder;
  const std::string closed =
      fmt::format("{} && nft add table ip closed && nft 'add chain ip closed input {{ type filter "
                  "hook input priority 0; }}' && nft add rule ip closed input udp dport 7667 "
                  "drop && exec {} --robot ck",
                  kMulticast, TORQUED);
  const std::vector<std::string> command{"unshare", "--net", "sh", "-c", closed};
  Process refused(command, folder.file("refused"));
  std::string for_client = closed;
  for_client.replace(for_client.rfind(TORQUED), std::string::npos, TORQUECTL " echo");
  Process client({"unshare", "--net", "sh", "-c", for_client}, folder.file("client"));
  {
    Process stopped(command, folder.file("stopped"));
    // until it waits for signals itself
    for (int i = 0; i < 500 && !torqued_blocks(stopped.pid(), SIGTERM); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const auto begin = Clock::now();
    stopped.signal(SIGTERM);
    const std::optional<int> code = stopped.wait();
    CAPTURE(code.value_or(-1000), read_file(folder.file("stopped")));
    CHECK(code == 0);
    CHECK(Clock::now() - begin < std::chrono::seconds(1)); // LCM would look for messages for twenty
  }
  CHECK(client.wait() == 69);
  CHECK(read_file(folder.file("client")).find("torquectl: the LCM bus does not carry messages") != std::string::npos);
  CHECK(refused.wait() == 69);
  CHECK(read_file(folder.file("refused")).find("torqued: the LCM bus does not carry messages") != std::string::npos);
}

TEST_CASE("the language of the user changes no number", "[promises_process]")
{
  const TemporaryFolder folder;
  shell(fmt::format("localedef -i de_DE -f UTF-8 {} 2> /dev/null", folder.file("de_DE.UTF-8")));
  const std::vector<std::string> german{"env", "LOCPATH=" + folder.file(""), "LC_ALL=de_DE.UTF-8"};
  const auto printed = [&](std::vector<std::string> command)
  {
    command.insert(command.end(), {TORQUED, "--print-config", "--robot", "human-subject01"});
    Process torqued(command, folder.file("out"));
    REQUIRE(torqued.wait() == 0);
    return read_file(folder.file("out"));
  };
  CHECK(printed(german) == printed({"env"}));

  Bench plain, in_german({"--prefix", ""}, german);
  desired_state_t desired = plain.standing();
  desired.method = 77;
  plain.send(desired);
  REQUIRE(plain.wait([&] { return plain.rejections.size() == 2; }));
  CHECK(plain.rejections[0].detail == plain.rejections[1].detail);
}

#ifdef FAKETIME // and no sanitizer, which would need descriptors, terabytes of address space, and much more time
TEST_CASE("a process with too few descriptors says so and ends, or works", "[promises_process]")
{
  std::set<int> worked;
  for (int descriptors : {4, 5, 6, 7, 8, 9, 10, 11, 12, 24}) // less those that this process has open, and hands down
  {
    CAPTURE(descriptors);
    const TemporaryFolder folder;
    Process torqued({"prlimit", fmt::format("--nofile={}", descriptors), TORQUED, "--robot", "ck"}, folder.file("out"));
    const std::optional<int> code = torqued.wait(std::chrono::milliseconds(1500));
    const std::string output = read_file(folder.file("out"));
    CAPTURE(output);
    if (!code)
    {
      CHECK(output.find("answering ck") != std::string::npos);
      worked.insert(descriptors);
      continue;
    }
    if (*code == 127)
    {
      CHECK(output.find("error while loading shared libraries") != std::string::npos); // torqued has not even begun
      continue;
    }
    CHECK(*code == 69);
    CHECK(output.find("torqued: the LCM bus") != std::string::npos);
  }
  CHECK(worked.count(24) == 1);
  CHECK(worked.count(4) == 0);
}

TEST_CASE("starved of processor time torqued answers each sample at most once, in order, and loses no account",
          "[promises_process]")
{
  Bench bench({}, {"nice", "-n", "19"});
  const TemporaryFolder folder;
  Process stress({"stress-ng", "--quiet", "--cpu", "4", "--timeout", "3"}, folder.file("stress"));
  bench.stream(std::chrono::milliseconds(2500));
  CHECK(stress.wait() == 0);
  bench.hear_for(std::chrono::milliseconds(200));
  bench.send_one(bench.standing());
  CHECK(bench.commands.back().utime > Bench::now() - 1'000'000);
  bench.check_account();
}

TEST_CASE("without the memory it needs torqued says so and ends, with it it goes on", "[promises_process]")
{
  // threads' stacks are address space, not memory
  bool worked = false;
  for (int megabytes = 20; !worked && megabytes <= 1280; megabytes *= 2)
  {
    CAPTURE(megabytes);
    const TemporaryFolder folder;
    Process torqued({"prlimit", fmt::format("--as={}", megabytes * 1'000'000), TORQUED, "--robot", "ck"},
                    folder.file("out"));
    const std::optional<int> code = torqued.wait(std::chrono::milliseconds(1500));
    const std::string output = read_file(folder.file("out"));
    CAPTURE(output);
    worked = !code;
    if (code)
    {
      CHECK(*code > 0); // no signal killed it
      CHECK_FALSE(output.empty());
    }
  }
  CHECK(worked);
}

TEST_CASE("a wall clock that is an hour off, and jumps by hours, changes nothing", "[promises_process]")
{
  const TemporaryFolder folder;
  const std::string offset = folder.write("offset", "+3600");
  Bench bench({}, {"env", "LD_PRELOAD=" FAKETIME, "FAKETIME_DONT_FAKE_MONOTONIC=1", "FAKETIME_NO_CACHE=1",
                   "FAKETIME_TIMESTAMP_FILE=" + offset});
  const std::int64_t hour = 3'600'000'000;
  std::int64_t uptime = 0;
  for (const int hours : {1, 2, -1, 0, 1})
  {
    folder.write("offset", fmt::format("{:+}", 3600 * hours));
    const std::size_t statuses = bench.statuses.size();
    for (int i = 0; i < 200 || bench.statuses.size() < statuses + 3; ++i)
      bench.send_one(bench.standing());
    const status_t& status = bench.statuses.back();
    const std::int64_t wall =
        std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
            .count();
    CAPTURE(hours);
    CHECK(std::abs(status.utime - wall - hours * hour) < 60'000'000); // the daemon does live in another hour
    CHECK(status.uptime_us > uptime);
    CHECK(status.uptime_us < uptime + 60'000'000);
    uptime = status.uptime_us;
  }
  // on a shared machine a sample may be late; no other reason is there to refuse one
  for (const rejection_t& rejection : bench.rejections)
    CHECK(rejection.reason == rejection_t::STALE);
  CHECK(bench.rejections.size() < bench.commands.size() / 10);
  bench.check_account();
}
#endif

} // namespace promises_process_test
