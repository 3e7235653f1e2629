/// The curves of a page: which quantities of an answer it plots, and how they are called.
#pragma once

#include "page/report_page.h"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace torqued
{

/// The acceleration of a coordinate, in ABSOLUTE coordinates, or of the base point: x and z after the last coordinate.
struct Acceleration
{
  int coordinate;
};

struct Curve
{
  std::string name;  ///< of its column: "tau_left_hip", "fzL"
  std::string title; ///< for people
  std::string unit;
  std::optional<Side> side;   ///< whose contacts are shaded behind it
  std::string group;          ///< curves of a group share their range
  std::vector<double> bounds; ///< values that matter: a motor's limits, the ends of a sole
  /// Its value in an answer; or in when that came, which not every run knows; or an acceleration, which is shown beside
  /// the one that was asked for, of motions that were moved.
  std::variant<std::function<double(const Answer&)>, double AnswerTime::*, Acceleration> of;
};

/// Curves under one heading, in the order in which they are shown.
struct CurveSection
{
  std::string title;
  std::vector<Curve> curves;
};

std::vector<CurveSection> curve_sections(const Robot& robot);

/// The column of a quantity of a foot: "fz" → "fzL".
std::string foot_column(std::string_view quantity, Side side);

/// What a measured channel is called in comparisons: "forward force", "ankle".
std::string title_of(const Channel& channel);

/// The column that a measured channel is compared with.
std::string column_of(const Channel& channel);

} // namespace torqued
