/// Which column of a trajectory CSV is what.
#pragma once

#include "client/csv_lines.h"
#include "client/trajectory.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// Places in a row, from 0.
struct MotionColumns
{
  using Column = std::optional<std::size_t>;

  std::vector<std::string> names; ///< of all columns
  Column time, utime;             ///< one of the two
  Column leading, load_transfer, phase, method;
  std::array<std::size_t, 2> contacts{}; ///< left, right
  bool relative = false;                 ///< whether the coordinates are the relative ones
  bool base_given = false;
  std::vector<std::string> coordinates; ///< their names
  /// Of positions, velocities and accelerations: each coordinate's column, then the base's x and z if it is given; with
  /// differentiate, only of positions.
  std::array<std::vector<std::size_t>, 3> motion;
};

/// From the line that names the columns. Throws Failure, bad_data, for what is missing or there twice.
MotionColumns find_columns(const CsvLine& header, const std::string& file, const CoordinateNames& names,
                           bool differentiate);

/// Throws Failure, bad_data: "FILE:LINE: column NAME: found …; expected …".
[[noreturn]] void fail_in_column(const std::string& file, std::size_t line, std::string_view column,
                                 std::string_view found, std::string_view expected);

} // namespace torqued
