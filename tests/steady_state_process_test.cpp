#include "catch.h"
#include "daemon_bench.h"

#include <cmath>
#include <regex>
#include <set>
#include <sstream>
#include <thread>

namespace steady_state_process_test
{

using namespace torqued;

namespace
{

// A configuration by which the nearest motion is answered.
std::string nearest_configuration(const TemporaryFolder& folder)
{
  return folder.write("nearest.toml", "infeasible = \"nearest\"\n[nearest]\ncontact_damping = 40\nmargin = 0.005\n");
}

// All that clients can send: desired states by each method, some that cannot be had, some that are refused, requests
// for the equation of motion and for what cannot be, other daemons' statuses. Waits until each is dealt with.
void send_all_kinds(Bench& bench)
{
  for (int round = 0; round < 20; ++round)
    for (std::int8_t method = 0; method <= 12; ++method)
    {
      const std::size_t before = bench.disposed();
      desired_state_t desired = bench.standing();
      desired.method = method;
      for (std::size_t i = 0; i < desired.a.size(); ++i)
        desired.a[i] = round * round * std::sin(static_cast<double>(i) + method);
      if (round % 5 == 1)
        desired.right_contact = desired_state_t::NONE;
      if (round % 5 == 2)
        desired.q[3] = NAN;
      if (round % 5 == 3)
        desired.left_contact = desired_state_t::HEEL;
      if (round % 5 == 4)
        desired.stream_id = 78;
      std::vector<std::byte> bytes(static_cast<std::size_t>(desired.getEncodedSize()));
      encode(desired, bytes);
      if (round % 10 == 6)
        bytes.resize(bytes.size() + static_cast<std::size_t>(100 * method), std::byte{7});
      bench.send(Bytes(bytes));
      REQUIRE(bench.wait([&] { return bench.disposed() > before; }));
    }

  const std::size_t replies = bench.dynamics.size();
  bench.ask(1);
  bench.ask(2);
  REQUIRE(bench.wait([&] { return bench.dynamics.size() >= replies + 2; }));
  status_t other{};
  other.instance_id = 5;
  other.version = std::string(300, 'v');
  bench.publish("TORQUED_STATUS", other);
  const std::size_t statuses = bench.statuses.size();
  REQUIRE(bench.wait([&] { return bench.statuses.size() >= statuses + 3; }));
}

} // namespace

TEST_CASE("once it has started, nothing a client sends makes torqued allocate", "[steady_state_process]")
{
  for (const char* robot : {"ck", "rk", "six-link", "human-subject01"})
    for (const bool nearest : {false, true})
    {
      const TemporaryFolder folder;
      const std::string path = folder.file("report");
      std::vector<std::string> arguments{"--robot", robot};
      if (nearest)
        arguments.insert(arguments.end(), {"--config", nearest_configuration(folder)});
      else
        arguments.push_back("--every-sample");
      Bench bench(arguments, {"env", "LD_PRELOAD=" ALLOCATION_GUARD, "ALLOCATION_REPORT=" + path});
      REQUIRE(bench.model);
      bench.torqued().signal(SIGUSR1);
      const std::size_t statuses = bench.statuses.size();
      REQUIRE(bench.wait([&] { return bench.statuses.size() > statuses; }));
      send_all_kinds(bench);
      bench.torqued().signal(SIGUSR2);
      std::string report;
      REQUIRE(bench.wait(
          [&]
          {
            report = std::filesystem::exists(path) ? read_file(path) : "";
            return report.ends_with("end\n");
          }));
      CAPTURE(robot, nearest, report);
      std::istringstream words(report);
      std::string program, all;
      long by_program = -1, seen = -1;
      words >> program >> by_program >> all >> seen;
      CHECK(by_program == 0);
      CHECK(seen > 100); // by the guard, while torqued started
    }
}

TEST_CASE("between a sample and its command torqued does nothing but receive, send, and wait", "[steady_state_process]")
{
  const TemporaryFolder folder;
  const std::string path = folder.file("calls");
  const bool nearest = GENERATE(false, true);
  CAPTURE(nearest);
  Bench bench(nearest ? std::vector<std::string>{"--config", nearest_configuration(folder)}
                      : std::vector<std::string>{},
              {"strace", "-D", "-f", "-qq", "-o", path});
  REQUIRE(bench.model);
  const auto answer = [&](int samples)
  {
    for (int i = 0; i < samples; ++i)
    {
      const std::size_t before = bench.commands.size();
      desired_state_t desired = bench.standing();
      for (double& a : desired.a)
        a = nearest ? 5.0 * std::sin(i) : 0.0;
      bench.send(desired);
      REQUIRE(bench.wait([&] { return bench.commands.size() > before; }));
      if (nearest && i > 0)
        CHECK((bench.commands.back().flags & torque_command_t::ADJUSTED) != 0);
    }
  };
  answer(20);
  const std::size_t begin = read_file(path).size();
  answer(300);
  const std::string calls = read_file(path).substr(begin);

  // one line for each call, "PID name(arguments…"; a call that another thread's interrupts has two
  const std::set<std::string> allowed{"poll",  "recvmmsg",      "sendmsg",        "sendto",
                                      "futex", "clock_gettime", "restart_syscall"};
  const std::regex call(R"(^\d+ +(?:<\.\.\. )?(\w+))");
  std::istringstream lines(calls);
  std::string line;
  std::getline(lines, line); // the rest of one that was cut
  int sent = 0;
  while (std::getline(lines, line))
  {
    std::smatch match;
    if (!std::regex_search(line, match, call))
      continue;
    CAPTURE(line);
    CHECK(allowed.count(match[1]) == 1);
    sent += match[1] == "sendmsg" || match[1] == "sendto" ? 1 : 0;
  }
  CHECK(sent >= 300);
}

} // namespace steady_state_process_test
