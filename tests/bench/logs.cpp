#include "bench/logs.h"

#include "bench/sample.h"
#include "process.h"
#include "temporary_folder.h"

#include "motion/files.h"
#include "motion/lcm_log.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"

#include <fmt/format.h>
#include <lcm/lcm-cpp.hpp>

namespace torqued::bench
{

namespace
{

// In memory where that is possible: neither side waits for a disk.
const TemporaryFolder& folder()
{
  static const std::filesystem::path memory = "/dev/shm";
  static const TemporaryFolder one(std::filesystem::is_directory(memory) ? memory
                                                                         : std::filesystem::temp_directory_path());
  return one;
}

// The measured walk, so often that there are that many samples. Returns how many there are.
int write_log(const std::string& path, int samples)
{
  const std::string file = TRAJECTORIES "/subject01-walk/walk.csv";
  Trajectory walk = parse_trajectory(read_file(file), file, coordinate_names(load_robot(kRobot)), false, Channels());
  LogWriter log(path);
  std::vector<std::byte> buffer;
  int written = 0;
  for (std::int64_t utime = 0; written < samples;)
    for (desired_state_t& state : walk.states)
    {
      state.utime = utime += 5000;
      log.write(Channels().desired, utime, encode(state, buffer));
      ++written;
    }
  log.close();
  return written;
}

// How many seconds that process takes. Throws std::runtime_error if it fails.
double seconds(const std::vector<std::string>& command)
{
  const auto begin = Clock::now();
  Process process(command, folder().file("output"));
  if (process.wait_for_end() != 0)
    throw std::runtime_error(command[0] + " failed: " + read_file(folder().file("output")));
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

} // namespace

void measure_logs(Rounds& rounds, bool quick)
{
  static const std::string log = folder().file("walk.lcm");
  static const int samples = write_log(log, quick ? 447 : 200'000);
  const std::string group = "log of desired states";
  const double reading = samples / seconds({"/proc/self/exe", "read-log", log});
  const double answering =
      samples / seconds({TORQUECTL, "eval", log, "--robot", kRobot, "-o", folder().file("answers.lcm")});
  rounds.add(group, "LCM's reader", "1/s", reading);
  rounds.add(group, "torquectl eval", "1/s", answering);
  rounds.promise({group, "torquectl eval", "LCM's reader", 0.5, true});
}

int read_log(const std::string& path)
{
  lcm::LogFile log(path, "r");
  if (!log.good())
    return EXIT_FAILURE;
  const std::string channel = Channels().desired;
  int decoded = 0;
  desired_state_t state;
  while (const lcm::LogEvent* event = log.readNextEvent())
    if (event->channel == channel && state.decode(event->data, 0, event->datalen) == event->datalen)
      ++decoded;
  return decoded > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

} // namespace torqued::bench
