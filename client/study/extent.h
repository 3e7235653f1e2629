/// How far something goes over a whole motion.
#pragma once

#include "robot/robot.h"

#include <cstddef>
#include <string>
#include <string_view>

namespace torqued
{

/// The largest of many numbers, their root mean square, and where the largest is.
class Extent
{
public:
  /// place: in the motion; name: of what has the number, if it is one of several.
  void add(double number, std::string_view place, std::string_view name = "");
  /// A line of a report; nothing if there were no numbers.
  std::string line(std::string_view what, std::string_view unit) const;

private:
  double squares_ = 0.0, largest_ = 0.0;
  std::size_t count_ = 0;
  std::string where_;
};

/// The unit of a robot's coordinates, or of their derivatives: per is "/s^2". "rad or m" if any link slides.
std::string coordinate_unit(const Robot& robot, std::string_view per);

} // namespace torqued
