/// Units of the numbers in a table.
#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <string_view>

namespace torqued
{

/// One degree, rad.
inline constexpr double kDegree = std::numbers::pi / 180.0;

/// What a column holds.
enum class Quantity
{
  word,       ///< words or counts
  share,      ///< 0 to 1
  time,       ///< s
  time_stamp, ///< µs
  angle,      ///< rad
  length,     ///< m
  force,      ///< N
  moment      ///< N m
};

/// The factor from a unit, such as "deg/s", to that of the quantity's derivative of this order; nothing if it is none
/// of its units.
std::optional<double> unit_factor(Quantity quantity, int order, std::string_view unit);

/// A unit in ASCII, lower case, without spaces and signs of multiplication: "rad/s2" for "Rad · s⁻²".
std::string plain_unit(std::string_view unit);

/// The units that a column of this quantity may have, for a complaint.
std::string_view expected_units(Quantity quantity);

} // namespace torqued
