#include "robot_fuzz.h"

#include "require.h"

#include "planar/dynamics.h"
#include "robot/files/robot_files.h"
#include "robot/files/toml_robot.h"

#include <exception>
#include <fmt/format.h>

namespace torqued
{

void check_usable(const Robot& robot)
{
  const VectorQ zero = VectorQ::Zero(robot.mechanism.num_q());
  require(inverse_dynamics(robot.mechanism, kinematics(robot.mechanism, zero, zero), zero).allFinite(),
          "the dynamics at rest are finite");
  require(mass_matrix(robot.mechanism, kinematics(robot.mechanism, zero, zero)).allFinite(),
          "the mass matrix is finite");
  require(robot.A.allFinite() && robot.A_inverse.allFinite() && robot.b.allFinite() && robot.kappa.allFinite(),
          "the coordinates are finite");
  const std::string toml = to_toml(robot);
  try
  {
    const Robot again = read_toml_robot(toml, "written.toml");
    require(again.model_id == robot.model_id && again.name == robot.name && again.source == robot.source,
            "a robot written as TOML reads back as the same robot");
  }
  catch (const std::exception& error)
  {
    fmt::print(stderr, "{}\n{}\n", toml, error.what());
    require(false, "a robot written as TOML reads back");
  }
}

} // namespace torqued
