// Trajectory files: tables, or logs of LCM, which parse_trajectory() tells by their bytes; packed by gzip or not.

#include "require.h"

#include "motion/failure.h"
#include "motion/files.h"
#include "motion/lcm_log.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"
#include "robot/files/robot_files.h"
#include "wire/finite.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

using namespace torqued;

namespace
{

void check_log(std::string_view bytes)
{
  LogReader reader(bytes);
  std::size_t whole = 0;
  while (const auto record = reader.next())
  {
    const auto inside = [&](const void* at, std::size_t size)
    {
      return at >= bytes.data() && static_cast<const char*>(at) + size <= bytes.data() + bytes.size();
    };
    require(inside(record->channel.data(), record->channel.size()) && inside(record->data.data(), record->data.size()),
            "a record lies inside the log");
    whole += 28 + record->channel.size() + record->data.size();
  }
  require(whole + reader.skipped() == bytes.size(), "each byte of a log is in a record, or skipped");
}

void check_csv(const Trajectory& trajectory)
{
  const desired_state_t* before = nullptr;
  for (const desired_state_t& state : trajectory.states)
  {
    for (const std::vector<double>* numbers : {&state.q, &state.v, &state.a})
      require(std::all_of(numbers->begin(), numbers->end(), is_finite), "what is read from a CSV is finite");
    require(before == nullptr || before->utime < state.utime, "time in a CSV goes on");
    before = &state;
  }
}

void check_file(std::string_view bytes)
{
  static const CoordinateNames names = coordinate_names(load_robot("ck"));
  check_log(bytes);
  for (const bool differentiate : {false, true})
    try
    {
      const Trajectory trajectory = parse_trajectory(bytes, "input", names, differentiate, Channels());
      require(trajectory.places.size() == trajectory.states.size(), "each state has a place");
      if (!trajectory.from_log)
        check_csv(trajectory);
    }
    catch (const Failure&)
    {
      // how a file is refused
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  check_file(bytes);
  if (is_gzip(bytes))
    try
    {
      check_file(unpack_gzip(bytes, "input"));
    }
    catch (const Failure&)
    {
      // a file that is cut or damaged
    }
  return 0;
}
