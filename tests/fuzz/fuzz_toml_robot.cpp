#include "robot/files/strict_toml.h"
#include "robot/files/toml_robot.h"
#include "robot_fuzz.h"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try
  {
    torqued::check_usable(torqued::read_toml_robot(text, CORPUS "/toml_robot/input.toml"));
  }
  catch (const torqued::FileError&)
  {
    // how a file is refused
  }
  return 0;
}
