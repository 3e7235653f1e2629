#include "robot/files/load.h"

#include "robot/files/text_file.h"
#include "robot/files/toml_robot.h"
#include "robot/files/urdf_robot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued
{

Robot load_robot(const std::string& name_or_path)
{
  if (const std::string_view text = shipped_robot_toml(name_or_path); !text.empty())
    return read_toml_robot(text, name_or_path + ".toml");
  if (name_or_path.ends_with(".toml"))
    return read_toml_robot(read_text_file(name_or_path), name_or_path);
  if (name_or_path.ends_with(".urdf"))
    return read_urdf_robot(read_text_file(name_or_path), name_or_path);
  throw FileError(fmt::format("\"{}\" is neither a robot that ships ({}) nor a .toml or .urdf file", name_or_path,
                              fmt::join(shipped_robot_names(), ", ")));
}

} // namespace torqued
