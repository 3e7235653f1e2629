#include "study/extent.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace torqued
{

void Extent::add(double number, std::string_view place, std::string_view name)
{
  squares_ += number * number;
  ++count_;
  if (std::abs(number) > largest_ || count_ == 1)
  {
    largest_ = std::abs(number);
    where_ = name.empty() ? std::string(place) : fmt::format("{}, {}", name, place);
  }
}

std::string Extent::line(std::string_view what, std::string_view unit) const
{
  return count_ == 0 ? ""
                     : fmt::format("  {:<34} {:.4g} {} ({}), rms {:.4g}\n", what, largest_, unit, where_,
                                   std::sqrt(squares_ / static_cast<double>(count_)));
}

std::string coordinate_unit(const Robot& robot, std::string_view per)
{
  const bool slides = std::ranges::any_of(robot.links, [](const Link& link) { return link.type().slides(); });
  return slides ? fmt::format("rad{0} or m{0}", per) : fmt::format("rad{}", per);
}

} // namespace torqued
