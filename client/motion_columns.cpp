#include "client/motion_columns.h"

#include "client/failure.h"
#include "robot/printable.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <map>
#include <utility>

namespace torqued
{

namespace
{

// "dq0" and "ddq0" for order 1 and 2
std::vector<std::string> derivative_names(const std::vector<std::string>& names, int order)
{
  std::vector<std::string> derived;
  for (const std::string& name : names)
    derived.push_back(std::string(static_cast<std::size_t>(order), 'd') + name);
  return derived;
}

// Looks the columns up in the names of a header.
class ColumnFinder
{
public:
  ColumnFinder(const CsvLine& header, const std::string& file, const CoordinateNames& names, bool differentiate)
      : file_(file), line_(header.number), names_(names), differentiate_(differentiate)
  {
    found_.names = header.cells;
    for (std::size_t i = 0; i < header.cells.size(); ++i)
      if (const std::string& name = header.cells[i]; !name.empty() && !columns_.emplace(name, i).second)
        fail(name, "it twice", "it once");
  }

  MotionColumns find_all()
  {
    find_others();
    choose_coordinates();
    choose_base();
    find_motion();
    return std::move(found_);
  }

private:
  using Column = MotionColumns::Column;

  [[noreturn]] void fail(std::string_view column, std::string_view found, std::string_view expected) const
  {
    fail_in_column(file_, line_, column, found, expected);
  }
  Column find(const std::string& name) const
  {
    const auto found = columns_.find(name);
    return found == columns_.end() ? Column() : found->second;
  }
  std::vector<std::string> missing(const std::vector<std::string>& names) const
  {
    std::vector<std::string> absent;
    std::copy_if(names.begin(), names.end(), std::back_inserter(absent), [&](const auto& name) { return !find(name); });
    return absent;
  }
  [[noreturn]] void fail_missing(const std::vector<std::string>& absent, std::string_view expected) const
  {
    fail(absent.front(), fmt::format("no column {}", fmt::join(absent, ", ")), expected);
  }
  std::vector<std::size_t> indices(const std::vector<std::string>& names) const
  {
    std::vector<std::size_t> columns;
    for (const std::string& name : names)
      columns.push_back(columns_.at(name));
    return columns;
  }

  void find_others()
  {
    found_.time = find("time");
    found_.utime = find("utime");
    if (!found_.time && !found_.utime)
      fail("time", "no column time or utime", "time (s) or utime (µs)");
    if (found_.time && found_.utime)
      fail("utime", "both time and utime", "one of the two");
    const std::vector<std::string> contacts{"contactL", "contactR"};
    if (const auto absent = missing(contacts); !absent.empty())
      fail_missing(absent, "what carries at each foot: 0 to 3, or none, heel, sole, toe");
    found_.contacts = {columns_.at("contactL"), columns_.at("contactR")};
    found_.leading = find("leading");
    found_.load_transfer = find("load_transfer");
    found_.phase = find("phase");
    found_.method = find("method");
  }

  void choose_coordinates()
  {
    const auto no_absolute = missing(names_.absolute);
    const auto no_relative = missing(names_.relative);
    found_.relative = !no_absolute.empty() && no_relative.size() < no_absolute.size();
    found_.coordinates = found_.relative ? names_.relative : names_.absolute;
    if (!no_absolute.empty() && !no_relative.empty())
      fail_missing(found_.relative ? no_relative : no_absolute,
                   fmt::format("all of {} (absolute), or all of {} (relative)", fmt::join(names_.absolute, ", "),
                               fmt::join(names_.relative, ", ")));
  }

  void choose_base()
  {
    if (names_.base[0].empty() || names_.base[1].empty())
      return;
    const std::vector<std::string> positions(names_.base.begin(), names_.base.end());
    std::vector<std::string> all = positions;
    for (const int order : {1, 2})
      for (const std::string& name : derivative_names(positions, order))
        all.push_back(name);
    if (missing(all).size() == all.size())
      return;
    const auto& needed = differentiate_ ? positions : all;
    if (const auto absent = missing(needed); !absent.empty())
      fail_missing(absent,
                   fmt::format("all of {}, or no base columns and the resting foot places the base{}",
                               fmt::join(needed, ", "), differentiate_ ? "" : "; --differentiate finds derivatives"));
    found_.base_given = true;
  }

  void find_motion()
  {
    std::vector<std::string> all = found_.coordinates;
    if (found_.base_given)
      all.insert(all.end(), names_.base.begin(), names_.base.end());
    found_.motion[0] = indices(all);
    if (differentiate_)
      return;
    const auto velocities = derivative_names(all, 1);
    const auto accelerations = derivative_names(all, 2);
    auto absent = missing(velocities);
    for (const std::string& name : missing(accelerations))
      absent.push_back(name);
    if (!absent.empty())
      fail_missing(absent, "all derivatives, or --differentiate to find them by a spline through the samples");
    found_.motion[1] = indices(velocities);
    found_.motion[2] = indices(accelerations);
  }

  const std::string& file_;
  std::size_t line_;
  const CoordinateNames& names_;
  bool differentiate_;
  std::map<std::string, std::size_t> columns_;
  MotionColumns found_;
};

} // namespace

void fail_in_column(const std::string& file, std::size_t line, std::string_view column, std::string_view found,
                    std::string_view expected)
{
  throw Failure(ExitCode::bad_data, fmt::format("{}:{}: column {}: found {}; expected {}", file, line,
                                                printable(std::string(column)), found, expected));
}

MotionColumns find_columns(const CsvLine& header, const std::string& file, const CoordinateNames& names,
                           bool differentiate)
{
  return ColumnFinder(header, file, names, differentiate).find_all();
}

} // namespace torqued
