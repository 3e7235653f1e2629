/// The line of a table that names its columns, and the units that are said beside or below the names.
#pragma once

#include "motion/csv_lines.h"
#include "motion/unit_names.h"

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// A column that a reader looks for.
struct KnownColumn
{
  std::string name;
  Quantity quantity = Quantity::word;
  int order = 0;        ///< of its derivative by time
  bool any_case = true; ///< whether a name in another case is this column, too
};

/// The columns of a table.
struct ColumnNames
{
  std::size_t line = 0;           ///< of the names
  std::vector<std::string> names; ///< of all columns: the known ones by their known name, the others as they are
  std::map<std::string, std::size_t> places; ///< of all that have a name, by it
  std::vector<double> factors;          ///< of each column: its numbers times this are in the units of its quantity
  std::vector<std::string> assumptions; ///< a sentence each
};

/// Reads the names, and the row of units below them if there is one. Names may differ from the known ones in case, and
/// units may follow them in brackets: "Time [ms]", "q0 (deg)". Names may stand in the last comment above the numbers.
/// Angles without a unit below an OpenSim header are in the unit that it says.
///
/// Throws Failure, bad_data, for a table without names, for a known name that is there twice, and for a unit that is
/// none of its quantity.
ColumnNames read_column_names(CsvReader& reader, const std::string& file, const std::vector<KnownColumn>& known);

/// Throws Failure, bad_data: "FILE:LINE: column NAME: found …; expected …".
[[noreturn]] void fail_in_column(const std::string& file, std::size_t line, std::string_view column,
                                 std::string_view found, std::string_view expected);

} // namespace torqued
