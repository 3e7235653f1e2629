/// Which column of a trajectory CSV is what.
#pragma once

#include "motion/column_names.h"
#include "motion/trajectory.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace torqued
{

/// What each column is; places in a row, from 0.
struct MotionColumns : ColumnNames
{
  using Column = std::optional<std::size_t>;

  Column time, utime; ///< one of the two, or both
  Column leading, load_transfer, phase, method;
  std::array<std::size_t, 2> contacts{}; ///< left, right
  bool relative = false;                 ///< whether the coordinates are the relative ones
  bool base_given = false;
  std::vector<std::string> coordinates; ///< their names
  /// Of positions, velocities and accelerations: each coordinate's column, then the base's x and z if it is given; with
  /// differentiate, only of positions.
  std::array<std::vector<std::size_t>, 3> motion;
};

/// Reads them from the names at the beginning of a table. Throws Failure, bad_data, as read_column_names() does, and
/// for what is missing.
MotionColumns find_columns(CsvReader& reader, const std::string& file, const CoordinateNames& names,
                           bool differentiate);

/// The columns of a motion in the order in which torquectl writes them: the time, each coordinate and its derivatives,
/// and the support. coordinates: the names, with those of the base point if it is given.
std::vector<std::string> written_columns(const std::vector<std::string>& coordinates);

} // namespace torqued
