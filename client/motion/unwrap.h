/// Angles that jump by whole turns where they were written modulo a turn.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace torqued
{

/// A step of one coordinate from one sample to the next.
struct CoordinateStep
{
  Eigen::Index row;    ///< after the step
  Eigen::Index column; ///< of the coordinate
  double size;         ///< rad or m
  double usual;        ///< what the steps around it make expect, rad or m
};

/// Takes a whole turn off steps of angles of which little remains then: 0.5 rad, or three times what the steps around
/// them make expect. Rows before the first such step stay as they are. Returns these steps, as found.
///
/// times: s, strictly increasing. motion: one row per time, one column per coordinate, rad or m; NaN where nothing is
/// known. is_angle: of each coordinate.
std::vector<CoordinateStep> unwrap(const std::vector<double>& times, Eigen::MatrixXd& motion,
                                   const std::vector<bool>& is_angle);

/// The first step of a coordinate between some rows that no motion makes: larger than a quarter turn, or 0.25 m, and
/// than ten times what the steps around it make expect. Links or marks were mistaken for one another, or the file
/// holds two motions.
std::optional<CoordinateStep> find_jump(const std::vector<double>& times, const Eigen::MatrixXd& motion, bool angle,
                                        Eigen::Index column, const std::vector<std::size_t>& rows);

} // namespace torqued
