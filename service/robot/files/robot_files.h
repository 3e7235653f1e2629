/// A robot written as files: TOML, URDF, and the TOML that completes a URDF.
#pragma once

#include "robot/robot.h"

#include <string>

namespace torqued
{

/// The whole robot as TOML; read_toml_robot() of it gives the same robot, with the same model_id.
std::string to_toml(const Robot& robot);

/// Links and joints as a URDF. Throws FileError for a link that a URDF cannot say: one that is parallel to the world,
/// or rolls with a radius of 0.
///
/// All frames are aligned with the world's when all angles are 0, and all axes are −y, so that the URDF's joint angles
/// equal ours, that of the child against the parent. A joint has its actuator's name if one acts between its links. A
/// rolling joint is two joints with a massless bar between them, the second of which mimics the first. Of inertia
/// tensors only the moment about y is known, and stands for all three. A root that is fixed hangs on a link called
/// "world". read_urdf() gives the same mechanism.
std::string to_urdf(const Robot& robot);

/// What to_urdf() leaves out, as TOML that names the URDF: with that file beside it read_toml_robot() gives the same
/// robot; the same numbers, that is: frames of links that ride on others at an angle are aligned with those. Throws
/// FileError for a sole on such a link.
std::string to_companion_toml(const Robot& robot, const std::string& urdf_file);

} // namespace torqued
