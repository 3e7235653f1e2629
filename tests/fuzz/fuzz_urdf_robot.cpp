#include "robot/files/strict_toml.h"
#include "robot/files/urdf_robot.h"
#include "robot_fuzz.h"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try
  {
    torqued::check_usable(torqued::read_urdf_robot(text, CORPUS "/urdf_robot/input.urdf"));
  }
  catch (const torqued::FileError&)
  {
    // how a file is refused
  }
  return 0;
}
