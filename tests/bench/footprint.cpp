#include "bench/footprint.h"

#include "bench/line.h"
#include "bench/servers.h"

#include <filesystem>
#include <fmt/format.h>
#include <fstream>

namespace torqued::bench
{

namespace
{

constexpr int kPort = 7705;

// A line of /proc/PID/status, in MB. Throws std::runtime_error if it is not there.
double megabytes(pid_t pid, const std::string& key)
{
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string word; status >> word;)
    if (double kilobytes = 0.0; word == key + ":" && status >> kilobytes)
      return 1.024e-3 * kilobytes;
  throw std::runtime_error("the system does not say " + key);
}

} // namespace

void measure_footprint(Rounds& rounds, bool quick)
{
  const std::string group = "footprint";
  LcmLine line(url(kPort), torque_command_t::getHash());
  const auto begin = Clock::now();
  const Process torqued(torqued_command(url(kPort)), "/dev/null");
  line.reach("torqued");
  const double started = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  for (int i = 0; i < (quick ? 100 : 5000); ++i)
    line.ask(microseconds(Clock::now()), Clock::now() + std::chrono::milliseconds(100));

  rounds.add(group, "start to first answer", "ms", started);
  rounds.add(group, "resident memory", "MB", megabytes(torqued.pid(), "VmRSS"));
  rounds.add(group, "  of it its own, not files", "MB", megabytes(torqued.pid(), "RssAnon"));
  rounds.add(group, "executable, with symbols", "MB", 1e-6 * static_cast<double>(std::filesystem::file_size(TORQUED)));
  rounds.promise({group, "start to first answer", "", 100.0});
  rounds.promise({group, "resident memory", "", 16.0});
}

} // namespace torqued::bench
