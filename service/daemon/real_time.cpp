#include "daemon/real_time.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numeric>
#include <sched.h>
#include <stdexcept>
#include <string_view>
#include <sys/mman.h>
#include <system_error>
#include <vector>

namespace torqued
{

namespace
{

// what the loop's deepest call has on the stack, several times over
constexpr std::size_t kStack = 256 * 1024;
constexpr std::size_t kPage = 4096;

// What asked for something, why the system refuses it (errno), and what permits it. Both capabilities at once: a second
// setcap would take the first one's away.
[[noreturn]] void refuse(std::string_view asked, std::string_view limit)
{
  const std::string reason = std::generic_category().message(errno);
  std::error_code none;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", none).string();
  throw std::runtime_error(fmt::format(
      "{}: the system refuses it: {}; \"sudo setcap cap_sys_nice,cap_ipc_lock+ep {}\" permits it, for a service "
      "{} in a drop-in, as realtime.conf has it: man torqued-running",
      asked, reason, program, limit));
}

// So that the stack has its pages before they are locked: the system gives them one by one, where it grows.
[[gnu::noinline]] void touch_stack()
{
  std::byte stack[kStack];
  volatile std::byte* const page = stack;
  for (std::size_t i = 0; i < kStack; i += kPage)
    page[i] = std::byte{0};
}

std::string lock_memory()
{
  touch_stack();
  // Not MCL_ONFAULT: a page that has never been used would be a fault when a sample first needs it.
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    refuse("lock_memory = true", "LimitMEMLOCK=infinity");
  return "memory is locked";
}

std::string set_policy(const Scheduling& scheduling)
{
  sched_param parameter{};
  parameter.sched_priority = static_cast<int>(scheduling.priority.value_or(0.0));
  if (sched_setscheduler(0, scheduling.policy == Scheduling::Policy::fifo ? SCHED_FIFO : SCHED_RR, &parameter) != 0)
    refuse(fmt::format("policy = \"{}\", priority = {}", name_of(scheduling.policy), parameter.sched_priority),
           "LimitRTPRIO=99, RestrictRealtime=no and SystemCallFilter=sched_setscheduler");
  sched_getparam(0, &parameter);
  const int policy = sched_getscheduler(0);
  return fmt::format("policy {}, priority {}",
                     policy == SCHED_FIFO ? "fifo"
                     : policy == SCHED_RR ? "rr"
                                          : "other",
                     parameter.sched_priority);
}

// Those that the calling thread may run on.
std::vector<int> allowed_processors()
{
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> allowed;
  if (sched_getaffinity(0, sizeof(set), &set) == 0)
    for (int processor = 0; processor < CPU_SETSIZE; ++processor)
      if (CPU_ISSET(processor, &set))
        allowed.push_back(processor);
  return allowed;
}

std::string set_processors(const std::string& list)
{
  const std::vector<int> asked = processors(list);
  const auto run_on = [&list](const std::vector<int>& processors)
  {
    cpu_set_t set;
    CPU_ZERO(&set);
    for (const int processor : processors)
      CPU_SET(processor, &set);
    if (sched_setaffinity(0, sizeof(set), &set) != 0)
      refuse(fmt::format("cpus = \"{}\"", list), "SystemCallFilter=sched_setaffinity");
  };
  // of too many the system leaves out, without a word, those that are not there
  std::vector<int> all(CPU_SETSIZE);
  std::iota(all.begin(), all.end(), 0);
  run_on(all);
  const std::vector<int> there = allowed_processors();
  for (const int processor : asked)
    if (std::ranges::find(there, processor) == there.end())
      throw std::runtime_error(
          fmt::format("cpus = \"{}\": processor {} is not there, or not for this process; those that are: {}", list,
                      processor, fmt::join(there, ", ")));
  run_on(asked);
  return fmt::format("cpus {}", fmt::join(allowed_processors(), ", "));
}

} // namespace

std::string enter_real_time(const Config& config)
{
  std::vector<std::string> effects;
  if (config.lock_memory)
    effects.push_back(lock_memory());
  if (!config.scheduling.cpus.empty())
    effects.push_back(set_processors(config.scheduling.cpus));
  if (config.scheduling.policy != Scheduling::Policy::other)
    effects.push_back(set_policy(config.scheduling));
  return fmt::format("{}", fmt::join(effects, ", "));
}

} // namespace torqued
