#include "motion/column_names.h"

#include "motion/failure.h"
#include "text/plain_text.h"
#include "text/printable.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <optional>
#include <set>
#include <utility>

namespace torqued
{

namespace
{

// "q0 (deg)": "q0" and "deg"; of a text that does not end with brackets, the text and no unit
struct NameAndUnit
{
  std::string name;
  std::optional<std::string> unit;
};

NameAndUnit split_unit(std::string_view text)
{
  text = trimmed(text);
  const bool closed = text.ends_with(')') || text.ends_with(']');
  const std::size_t open = closed ? text.find(text.back() == ')' ? '(' : '[') : std::string_view::npos;
  if (open == std::string_view::npos)
    return {std::string(text), std::nullopt};
  return {std::string(trimmed(text.substr(0, open))),
          std::string(trimmed(text.substr(open + 1, text.size() - open - 2)))};
}

bool says_no_unit(std::string_view unit)
{
  return unit.empty() || unit == "-" || unit == "1";
}

// a unit for a note
std::string shown_unit(const std::string& unit)
{
  return printable(unit) == unit ? unit : plain_unit(unit);
}

// whether this is a unit of anything
bool is_unit(std::string_view unit)
{
  for (const Quantity quantity :
       {Quantity::share, Quantity::time, Quantity::angle, Quantity::length, Quantity::force, Quantity::moment})
    for (const int order : {0, 1, 2})
      if (unit_factor(quantity, order, unit))
        return true;
  return false;
}

// a unit that stands alone in a cell, without the brackets around it
std::string unit_in_cell(const std::string& cell)
{
  const NameAndUnit split = split_unit(cell);
  return split.unit && split.name.empty() ? *split.unit : std::string(trimmed(cell));
}

std::size_t count_numbers(const CsvLine& line)
{
  return static_cast<std::size_t>(
      std::ranges::count_if(line.cells, [](const std::string& cell) { return is_number(cell, '.'); }));
}

constexpr std::size_t kMostListed = 8;

// Finds the known columns among the cells of a header, and their units.
class NameReader
{
public:
  NameReader(CsvReader& reader, const std::string& file, const std::vector<KnownColumn>& known)
      : reader_(reader), file_(file), known_(known)
  {
  }

  ColumnNames read()
  {
    find_header();
    found_.line = header_.number;
    found_.names = header_.cells;
    found_.factors.assign(header_.cells.size(), 1.0);
    columns_.assign(header_.cells.size(), nullptr);
    units_.resize(header_.cells.size());
    unit_lines_.assign(header_.cells.size(), header_.number);
    recognize_names();
    for (std::size_t i = 0; i < found_.names.size(); ++i)
      if (const std::string& name = found_.names[i]; !name.empty() && !found_.places.emplace(name, i).second)
        fail_in_column(file_, header_.number, name, "it twice", "it once");
    read_row_of_units();
    convert_units();
    convert_degrees_of_opensim();
    return std::move(found_);
  }

private:
  // the names, which may stand in a comment above the first row
  void find_header()
  {
    if (!reader_.next(header_))
      throw Failure(ExitCode::bad_data, "{}: found no line that names columns; expected one such as time,q0,...",
                    file_);
    const std::vector<std::string>& cells = header_.cells;
    const std::size_t numbers = count_numbers(header_);
    // a row has words, too, such as L and sole
    if (2 * numbers <= cells.size() || std::ranges::any_of(cells, names_time))
      return;
    std::optional<CsvLine> comment = reader_.comment();
    if (!comment || comment->cells.size() != cells.size() || std::ranges::none_of(comment->cells, names_time))
      throw Failure(ExitCode::bad_data,
                    "{}:{}: no header: the first line holds {}; expected the names of the columns, such as time,q0,...",
                    file_, header_.number, numbers == cells.size() ? "only numbers" : "a row of numbers");
    header_ = std::move(*comment);
    reader_.again();
    found_.assumptions.push_back(
        fmt::format("the names of the columns are those of the comment in line {}", header_.number));
  }

  // A name that is right comes before one with a unit, and that before one in another case: of two columns for one
  // quantity the other is a further column.
  void recognize_names()
  {
    using Normalize = std::string (*)(const std::string&);
    const std::array<Normalize, 3> forms{[](const std::string& cell) { return cell; },
                                         [](const std::string& cell) { return split_unit(cell).name; },
                                         [](const std::string& cell)
                                         {
                                           return lower_case(split_unit(cell).name);
                                         }};
    std::set<const KnownColumn*> taken;
    std::vector<std::string> renamed;
    for (std::size_t form = 0; form < forms.size(); ++form)
    {
      const bool any_case = form == 2;
      std::multimap<std::string, const KnownColumn*> known;
      for (const KnownColumn& column : known_)
        if (column.any_case || !any_case)
          known.emplace(any_case ? lower_case(column.name) : column.name, &column);
      std::set<const KnownColumn*> now;
      for (std::size_t i = 0; i < header_.cells.size(); ++i)
      {
        const std::string name = forms[form](header_.cells[i]);
        if (columns_[i] != nullptr || known.count(name) != 1)
          continue;
        const KnownColumn* const column = known.find(name)->second;
        if (taken.contains(column))
          continue;
        now.insert(column);
        columns_[i] = column;
        found_.names[i] = column->name;
        if (form > 0)
          units_[i] = split_unit(header_.cells[i]).unit;
        if (any_case)
          renamed.push_back(fmt::format("{} as {}", printable(split_unit(header_.cells[i]).name), column->name));
      }
      taken.merge(now);
    }
    if (!renamed.empty())
      found_.assumptions.push_back(fmt::format("names in another case are read: {}", listed(renamed, kMostListed)));
  }

  // "s;rad;rad" below the names
  void read_row_of_units()
  {
    CsvLine row;
    if (!reader_.next(row))
      return;
    if (count_numbers(row) > 0 || std::ranges::none_of(row.cells, is_unit, unit_in_cell))
    {
      reader_.again();
      return;
    }
    found_.assumptions.push_back(fmt::format("line {} is a row of units", row.number));
    for (std::size_t i = 0; i < std::min(row.cells.size(), columns_.size()); ++i)
    {
      const std::string unit = unit_in_cell(row.cells[i]);
      if (columns_[i] == nullptr || says_no_unit(unit))
        continue;
      if (units_[i] && plain_unit(*units_[i]) != plain_unit(unit))
        fail_in_column(file_, row.number, columns_[i]->name, fmt::format("unit {}", shown_unit(unit)),
                       fmt::format("{}, as beside its name", shown_unit(*units_[i])));
      units_[i] = unit;
      unit_lines_[i] = row.number;
    }
  }

  void convert_units()
  {
    std::vector<std::string> converted;
    for (std::size_t i = 0; i < columns_.size(); ++i)
    {
      if (columns_[i] == nullptr || !units_[i] || says_no_unit(*units_[i]) || columns_[i]->quantity == Quantity::word)
        continue;
      const KnownColumn& column = *columns_[i];
      const std::optional<double> factor = unit_factor(column.quantity, column.order, *units_[i]);
      if (!factor)
        fail_in_column(file_, unit_lines_[i], column.name, fmt::format("unit {}", shown_unit(*units_[i])),
                       expected_units(column.quantity));
      found_.factors[i] = *factor;
      if (*factor != 1.0)
        converted.push_back(fmt::format("{} from {}", column.name, shown_unit(*units_[i])));
    }
    if (!converted.empty())
      found_.assumptions.push_back(fmt::format("units are converted: {}", listed(converted, kMostListed)));
  }

  void convert_degrees_of_opensim()
  {
    const std::optional<OpenSimHeader>& opensim = reader_.text().opensim();
    if (!opensim)
      return;
    std::vector<std::string> angles;
    for (std::size_t i = 0; i < columns_.size(); ++i)
      if (columns_[i] != nullptr && columns_[i]->quantity == Quantity::angle && !units_[i])
      {
        angles.push_back(columns_[i]->name);
        if (opensim->degrees.value_or(false))
          found_.factors[i] = *unit_factor(Quantity::angle, 0, "deg");
      }
    if (angles.empty())
      return;
    if (!opensim->degrees)
      throw Failure(ExitCode::bad_data,
                    "{}:{}: found an OpenSim header that does not say the unit of angles; expected inDegrees=yes or "
                    "inDegrees=no above endheader",
                    file_, header_.number);
    if (*opensim->degrees)
      found_.assumptions.push_back(
          fmt::format("its OpenSim header says inDegrees=yes; converted to rad: {}", listed(angles, kMostListed)));
  }

  CsvReader& reader_;
  const std::string& file_;
  const std::vector<KnownColumn>& known_;
  CsvLine header_;
  ColumnNames found_;
  std::vector<const KnownColumn*> columns_;       // of each cell of the header: what it is, if it is known
  std::vector<std::optional<std::string>> units_; // likewise, if one is said
  std::vector<std::size_t> unit_lines_;           // where it is said
};

} // namespace

ColumnNames read_column_names(CsvReader& reader, const std::string& file, const std::vector<KnownColumn>& known)
{
  return NameReader(reader, file, known).read();
}

void fail_in_column(const std::string& file, std::size_t line, std::string_view column, std::string_view found,
                    std::string_view expected)
{
  throw Failure(ExitCode::bad_data, "{}:{}: column {}: found {}; expected {}", file, line,
                printable(std::string(column)), found, expected);
}

} // namespace torqued
