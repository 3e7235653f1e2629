/// Settings, each listed once: its key, its range and what it means. What reads, prints, hashes or checks settings is a
/// SettingList, which a listing function calls with one setting after another.
#pragma once

#include "robot/robot.h"

#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace torqued
{

/// The numbers that a setting may be, from least to most; `expected` says so in complaints.
struct Range
{
  double least, most;
  std::string expected;
  bool above_least = false; ///< the least itself is not one of them
  bool whole = false;       ///< only whole numbers are

  bool holds(double x) const
  {
    return (above_least ? x > least : x >= least) && x <= most && !(whole && x != std::trunc(x));
  }
};
/// "0 to 1".
Range from_0_to(double most);
Range not_negative();

/// For each setting: key, as in the configuration file; value; what: its meaning in a line.
class SettingList
{
public:
  virtual ~SettingList() = default;
  virtual void boolean(std::string_view key, bool& value, std::string_view what) = 0;
  virtual void number(std::string_view key, double& value, const Range& range, std::string_view what) = 0;
  /// A number, or a word that stands for none.
  virtual void number_or(std::string_view key, std::optional<double>& value, std::string_view word, const Range& range,
                         std::string_view what) = 0;
  /// Three positive numbers; `expected` says so in complaints.
  virtual void three(std::string_view key, Eigen::Vector3d& value, std::string_view expected,
                     std::string_view what) = 0;
  /// Of each motor's torque, or a symmetric positive definite matrix.
  virtual void weights(std::string_view key, JointWeights& value) = 0;
  virtual void word(std::string_view key, int& value, std::span<const std::string_view> words,
                    std::string_view what) = 0;
  /// The settings that follow belong to a table of this name.
  virtual void table(std::string_view name) = 0;

  /// An enumeration whose values number the words from 0.
  template <typename Enumeration>
  void word(std::string_view key, Enumeration& value, std::span<const std::string_view> words, std::string_view what)
  {
    int number = static_cast<int>(value);
    word(key, number, words, what);
    value = static_cast<Enumeration>(number);
  }
};

} // namespace torqued
