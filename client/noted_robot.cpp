#include "client/noted_robot.h"

#include "client/subcommands.h"

namespace torqued
{

Robot load_noted_robot(const std::string& name_or_path)
{
  Robot robot = load_robot(name_or_path);
  for (const std::string& line : robot.notes)
    note(line);
  return robot;
}

} // namespace torqued
