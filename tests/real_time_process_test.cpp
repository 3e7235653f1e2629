#include "catch.h"
#include "daemon_bench.h"

#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <sched.h>
#include <sstream>
#include <sys/mman.h>
#include <unistd.h>

namespace real_time_process_test
{

using namespace torqued;

namespace
{

// What may be tried here depends on who runs the tests: tools/private-network --privileged.
bool may_lock()
{
  const bool may = mlockall(MCL_FUTURE) == 0 && mlockall(MCL_CURRENT | MCL_ONFAULT) == 0;
  munlockall();
  return may;
}

bool may_come_first()
{
  const sched_param first{.sched_priority = 50}, usual{.sched_priority = 0};
  const bool may = sched_setscheduler(0, SCHED_FIFO, &first) == 0;
  if (may)
    sched_setscheduler(0, SCHED_OTHER, &usual);
  return may;
}

// Those that this process may run on.
std::vector<int> processors_here()
{
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof(set), &set);
  std::vector<int> here;
  for (int processor = 0; processor < CPU_SETSIZE; ++processor)
    if (CPU_ISSET(processor, &set))
      here.push_back(processor);
  return here;
}

// The value of a line of /proc/PID/status, or of a thread's.
std::string status_line(const std::string& folder, const std::string& name)
{
  std::istringstream lines(read_file(folder + "/status"));
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(name + ":"))
      return line.substr(line.find_first_not_of(" \t", name.size() + 1));
  return "";
}

std::string proc(const Bench& bench)
{
  return fmt::format("/proc/{}", const_cast<Bench&>(bench).torqued().pid());
}

// Page faults of all threads so far: those that a page in memory ended, and those that waited for a disk.
std::array<long, 2> faults(const Bench& bench)
{
  const std::string stat = read_file(proc(bench) + "/stat");
  std::istringstream words(stat.substr(stat.rfind(')') + 1)); // from the third field on; these are 10 and 12
  std::string word;
  for (int field = 3; field < 10; ++field)
    words >> word;
  long minor = -1, of_children = -1, major = -1;
  words >> minor >> of_children >> major;
  return {minor, major};
}

// The log is written by a thread of its own: soon, if it is.
bool logged(const Bench& bench, const std::string& text)
{
  return bench.output().find(text) != std::string::npos;
}

// What torqued prints and how it ends with such a configuration, behind these words.
std::pair<std::optional<int>, std::string> run(const std::string& toml, std::vector<std::string> words = {})
{
  const TemporaryFolder folder;
  words.insert(words.end(), {TORQUED, "--robot", "ck", "--config", folder.write("c.toml", toml)});
  Process torqued(words, folder.file("output"));
  const auto code = torqued.wait(std::chrono::seconds(5));
  return {code, read_file(folder.file("output"))};
}

} // namespace

TEST_CASE("policy, priority and processors are those of the thread that answers, and of no other",
          "[real_time_process]")
{
  if (!may_come_first())
  {
    WARN("this user may not set a real-time priority: only refusals are seen");
    return;
  }
  const TemporaryFolder folder;
  const int last = processors_here().back();
  for (const auto& [name, policy] : {std::pair("fifo", SCHED_FIFO), std::pair("rr", SCHED_RR)})
  {
    const std::string config =
        folder.write("c.toml", fmt::format("[scheduling]\npolicy = \"{}\"\npriority = 42\ncpus = \"{}\"", name, last));
    Bench bench({"--config", config});
    REQUIRE(bench.model);
    const pid_t pid = bench.torqued().pid();
    sched_param parameter{};
    CHECK(sched_getscheduler(pid) == policy);
    CHECK(sched_getparam(pid, &parameter) == 0);
    CHECK(parameter.sched_priority == 42);
    CHECK(status_line(proc(bench), "Cpus_allowed_list") == std::to_string(last));
    int others = 0;
    for (const auto& thread : std::filesystem::directory_iterator(proc(bench) + "/task"))
      if (const int id = std::stoi(thread.path().filename()); id != pid)
      {
        ++others;
        CHECK(sched_getscheduler(id) == SCHED_OTHER);
        CHECK(status_line(thread.path(), "Cpus_allowed_list") == status_line("/proc/self", "Cpus_allowed_list"));
      }
    CHECK(others >= 2); // signals and the log
    CHECK(bench.wait([&]
                     { return logged(bench, fmt::format("real time: cpus {}, policy {}, priority 42", last, name)); }));
    CHECK(status_line(proc(bench), "VmLck") == "0 kB");
    bench.stream(std::chrono::milliseconds(300));
    CHECK(bench.commands.size() > 100);
    bench.hear_for(std::chrono::milliseconds(100));
    bench.check_account();
  }
}

TEST_CASE("the processors of the thread that answers need no privilege", "[real_time_process]")
{
  const TemporaryFolder folder;
  const std::vector<int> here = processors_here();
  Bench bench({"--config", folder.write("c.toml", fmt::format("[scheduling]\ncpus = \"{}\"", here.front()))});
  REQUIRE(bench.model);
  CHECK(status_line(proc(bench), "Cpus_allowed_list") == std::to_string(here.front()));
  CHECK(sched_getscheduler(bench.torqued().pid()) == SCHED_OTHER);

  const auto [code, output] = run(fmt::format("[scheduling]\ncpus = \"{},1023\"", here.front()));
  CHECK(code == 78);
  CAPTURE(output);
  CHECK(output.starts_with(fmt::format("torqued: cpus = \"{},1023\": processor 1023 is not there, or not for this "
                                       "process; those that are: {}",
                                       here.front(), here.front())));
}

TEST_CASE("with lock_memory all memory is locked, and no sample is a page fault", "[real_time_process]")
{
  if (!may_lock())
  {
    WARN("this user may not lock memory: only refusals are seen");
    return;
  }
  const TemporaryFolder folder;
  const std::string config = folder.write("c.toml", "lock_memory = true");
  // From the very first sample on. The system moves pages at times, so one daemon of three is enough that sees no
  // fault; one of our own would be seen by each.
  std::array<long, 2> seen{-1, -1};
  for (int attempt = 0; attempt < 3 && seen != std::array<long, 2>{}; ++attempt)
  {
    Bench bench({"--config", config});
    REQUIRE(bench.model);
    CHECK(bench.wait([&] { return logged(bench, "real time: memory is locked"); }));
    CHECK(std::stol(status_line(proc(bench), "VmLck")) > 10'000); // kB
    const std::array<long, 2> before = faults(bench);
    CHECK(before[0] > 100); // while it started
    for (int i = 0; i < 3000; ++i)
    {
      desired_state_t desired = bench.standing();
      desired.method = static_cast<std::int8_t>(i % 10);
      bench.send_one(desired);
    }
    const std::array<long, 2> after = faults(bench);
    seen = {after[0] - before[0], after[1] - before[1]};
    CHECK(bench.commands.size() > 1000);
  }
  CHECK(seen[0] == 0);
  CHECK(seen[1] == 0);
}

TEST_CASE("what the system refuses ends the start with the command that permits it", "[real_time_process]")
{
  std::vector<std::string> unprivileged{"prlimit", "--rtprio=0", "--memlock=65536"};
  if (geteuid() == 0)
    unprivileged.insert(unprivileged.begin(), {"setpriv", "--bounding-set=-all"});
  const std::string permits = fmt::format("\"sudo setcap cap_sys_nice,cap_ipc_lock+ep {}\" permits it", TORQUED);
  const auto [locks, lock_output] = run("lock_memory = true", unprivileged);
  CAPTURE(lock_output);
  CHECK(locks == 78);
  CHECK(lock_output.starts_with("torqued: lock_memory = true: the system refuses it: Cannot allocate memory; " +
                                permits + ", for a service LimitMEMLOCK=infinity in a drop-in"));
  const auto [schedules, output] = run("[scheduling]\npolicy = \"rr\"\npriority = 7", unprivileged);
  CAPTURE(output);
  CHECK(schedules == 78);
  CHECK(output.starts_with("torqued: policy = \"rr\", priority = 7: the system refuses it: Operation not permitted; " +
                           permits + ", for a service LimitRTPRIO=99, "));
}

} // namespace real_time_process_test
