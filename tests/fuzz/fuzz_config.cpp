#include "require.h"

#include "answer/config.h"
#include "robot/files/load.h"
#include "robot/files/robot_files.h"
#include "robot/files/strict_toml.h"

#include <cstddef>
#include <cstdint>

using namespace torqued;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  static const Robot robot = load_robot("ck");
  try
  {
    const Config config = read_config(std::string_view(reinterpret_cast<const char*>(data), size), "input.toml");
    const std::string printed = to_toml(config);
    try
    {
      require(to_toml(read_config(printed, "printed.toml")) == printed, "a printed configuration reads back as itself");
    }
    catch (const FileError& error)
    {
      fmt::print(stderr, "{}\n{}\n", printed, error.what());
      require(false, "a printed configuration reads back");
    }
    check_fits(config, robot);
  }
  catch (const FileError&)
  {
    // how a file is refused
  }
  return 0;
}
