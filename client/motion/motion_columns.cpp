#include "motion/motion_columns.h"

#include "motion/failure.h"
#include "motion/table_text.h"
#include "text/plain_text.h"
#include "text/printable.h"
#include "text/spelling.h"

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

// all columns that a trajectory may have
std::vector<KnownColumn> known_columns(const CoordinateNames& names)
{
  std::map<std::string, KnownColumn> known;
  const auto add = [&known](const std::string& name, Quantity quantity)
  {
    for (const int order : {0, 1, 2})
      if (const std::string derivative = derivative_names({name}, order).front(); !name.empty())
        known.emplace(derivative, KnownColumn{derivative, quantity, order});
  };
  for (const char* const name : {"contactL", "contactR", "leading", "method"})
    known[name] = {name, Quantity::word, 0};
  for (const char* const name : {"load_transfer", "phase"})
    known[name] = {name, Quantity::share, 0};
  known["time"] = {"time", Quantity::time, 0};
  known["utime"] = {"utime", Quantity::time_stamp, 0};
  for (const auto* const coordinates : {&names.absolute, &names.relative})
    for (const std::string& name : *coordinates)
      add(name, names.displacements.contains(name) ? Quantity::length : Quantity::angle);
  for (const std::string& name : names.base)
    add(name, Quantity::length);

  std::vector<KnownColumn> columns;
  for (auto& [name, column] : known)
    columns.push_back(std::move(column));
  return columns;
}

// Looks the columns up in the names of a header.
class ColumnFinder
{
public:
  ColumnFinder(CsvReader& reader, const std::string& file, const CoordinateNames& names, bool differentiate)
      : reader_(reader), file_(file), names_(names), differentiate_(differentiate)
  {
    static_cast<ColumnNames&>(found_) = read_column_names(reader, file, known_columns(names));
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
    fail_in_column(file_, found_.line, column, found, expected);
  }
  Column find(const std::string& name) const
  {
    const auto found = found_.places.find(name);
    return found == found_.places.end() ? Column() : found->second;
  }
  std::vector<std::string> missing(const std::vector<std::string>& names) const
  {
    std::vector<std::string> absent;
    std::ranges::copy_if(names, std::back_inserter(absent), [&](const auto& name) { return !find(name); });
    return absent;
  }
  [[noreturn]] void fail_missing(const std::vector<std::string>& absent, std::string_view expected) const
  {
    explain_other_tables();
    fail(absent.front(), fmt::format("no column {}", fmt::join(absent, ", ")), expected);
  }
  // what a table is that lacks the columns of a motion, if that can be told
  void explain_other_tables() const
  {
    const char separator = reader_.text().separator();
    for (const std::string& name : found_.names)
      if (const std::optional<char> other = other_separator(name, separator))
        throw Failure(ExitCode::bad_data,
                      "{}:{}: found cells between {} and, in \"{}\", {}; expected one separator throughout", file_,
                      found_.line, name_of_separator(separator), printable(name), name_of_separator(*other));
    if (std::ranges::any_of(found_.names, [](const std::string& name) { return name.starts_with("tau_"); }))
      throw Failure(ExitCode::bad_data,
                    "{}:{}: found answers, as torquectl eval and export write them: torques, but not every position "
                    "and acceleration; expected a desired motion{}",
                    file_, found_.line, differentiate_ ? "" : ", or --differentiate if all positions are there");
    if (reader_.text().opensim() && missing(names_.absolute).size() == names_.absolute.size() &&
        missing(names_.relative).size() == names_.relative.size())
      throw Failure(ExitCode::bad_data,
                    "{}:{}: found an OpenSim file with columns {}, which are none of this robot's; expected time, "
                    "contactL, contactR and {}",
                    file_, found_.line, listed_names(), fmt::join(names_.absolute, ", "));
  }
  std::string listed_names() const { return listed(found_.names, 5, 40); }
  std::vector<std::size_t> indices(const std::vector<std::string>& names) const
  {
    std::vector<std::size_t> columns;
    for (const std::string& name : names)
      columns.push_back(found_.places.at(name));
    return columns;
  }

  void find_others()
  {
    found_.time = find("time");
    found_.utime = find("utime");
    if (!found_.time && !found_.utime)
    {
      explain_other_tables();
      fail("time", fmt::format("no column time or utime among {}", listed_names()), "time (s) or utime (µs)");
    }
    const std::vector<std::string> contacts{"contactL", "contactR"};
    if (const auto absent = missing(contacts); !absent.empty())
      fail_missing(absent, "what carries at each foot: 0 to 3, or none, heel, sole, toe");
    found_.contacts = {found_.places.at("contactL"), found_.places.at("contactR")};
    found_.leading = find("leading");
    found_.load_transfer = find("load_transfer");
    found_.phase = find("phase");
    found_.method = find("method");
    for (const std::string word : {"leading", "load_transfer", "phase", "method"})
      if (!find(word))
        for (const std::string& name : found_.names)
          if (resembles(lower_case(name), word))
            found_.assumptions.push_back(
                fmt::format("column {} is left out, and there is no column {}", printable(name, kLongestShown), word));
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

  CsvReader& reader_;
  const std::string& file_;
  const CoordinateNames& names_;
  bool differentiate_;
  MotionColumns found_;
};

} // namespace

std::vector<std::string> written_columns(const std::vector<std::string>& coordinates)
{
  std::vector<std::string> columns{"utime"};
  for (const int order : {0, 1, 2})
    for (const std::string& name : derivative_names(coordinates, order))
      columns.push_back(name);
  for (const char* column : {"contactL", "contactR", "leading", "load_transfer", "phase"})
    columns.emplace_back(column);
  return columns;
}

MotionColumns find_columns(CsvReader& reader, const std::string& file, const CoordinateNames& names, bool differentiate)
{
  return ColumnFinder(reader, file, names, differentiate).find_all();
}

} // namespace torqued
