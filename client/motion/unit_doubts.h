/// Units that a motion's numbers do not look like.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace torqued
{

/// A motion as a file gives it.
struct WrittenMotion
{
  std::string time_column;          ///< "time" or "utime"
  std::vector<double> times;        ///< s, as that column's unit says
  std::vector<std::string> columns; ///< names of the coordinates
  std::vector<bool> is_angle;       ///< of each coordinate: rad, or else m
  bool base_given = false;          ///< whether the last two are the base's x and z
  Eigen::MatrixXd positions;        ///< one row per time, one column per coordinate; NaN where nothing is written
  Eigen::MatrixXd velocities;       ///< likewise; empty if they are not given
};

/// What a motion's numbers look like.
struct UnitDoubts
{
  std::vector<std::string> sentences; ///< one for each doubt
  bool degrees = false;               ///< whether one is that angles are in degrees
};

/// Times in ms, µs or ns where s are expected, ns or ms where µs are: the velocities' integral misses the positions by
/// that factor, or without velocities a moving robot's steps are longer than 0.5 s, or the whole motion lasts less than
/// 0.05 s. Velocities in degrees per second: the same, by 57.3. Angles in degrees: they reach more than a turn, two of
/// a row differ by more than a turn and a quarter, or one coordinate's range is more than 3.5 rad, and are no more than
/// two turns in degrees. A base in mm: more than 50 m high. Nothing is converted.
UnitDoubts doubt_units(const WrittenMotion& motion);

} // namespace torqued
