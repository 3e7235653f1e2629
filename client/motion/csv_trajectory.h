/// A desired motion from the text of a trajectory CSV.
#pragma once

#include "motion/trajectory.h"

#include <string>
#include <string_view>

namespace torqued
{

/// As parse_trajectory() reads a file that is no log.
Trajectory parse_csv_trajectory(std::string_view text, const std::string& file, const CoordinateNames& names,
                                const Differentiation& how);

} // namespace torqued
