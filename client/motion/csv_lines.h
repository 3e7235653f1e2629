/// Lines of a table: cells between separators.
#pragma once

#include "motion/table_text.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// One line: its number in the file, from 1, and its cells without the spaces and quotes around them.
struct CsvLine
{
  std::size_t number = 0;
  std::vector<std::string> cells;
};

/// Reads a table line by line, as TableText finds it; passes over empty lines and comments (# first; above the first
/// line also % or //).
///
/// A cell may stand in double quotes, a quote inside is doubled; no cell goes on in the next line. Numbers with decimal
/// commas are given with decimal points.
class CsvReader
{
public:
  /// bytes: of the whole file; they must outlive the reader. file: the name used in complaints. Throws as TableText.
  CsvReader(std::string_view bytes, const std::string& file);

  /// Reads the next line; false at the end. Throws Failure, bad_data, for a quote that is not closed or not alone.
  bool next(CsvLine& line);
  /// The line that was read last is the next one once more.
  void again() { lines_ = before_; }
  /// The cells of the last comment above the first line, without the sign before it, to be read as the names of the
  /// columns; nothing if there is none.
  std::optional<CsvLine> comment();

  const TableText& text() const { return text_; }
  /// What was assumed so far; a sentence each.
  std::vector<std::string> assumptions() const;

private:
  void split(std::string_view text, CsvLine& line) const;

  TableText text_;
  std::string file_;
  LineCutter lines_, before_;
  std::string_view comment_;
  std::size_t comment_number_ = 0, foreign_comments_ = 0;
  bool begun_ = false;
};

/// A cell as it is written: in quotes if it holds anything that a reader could take for more than text.
std::string csv_cell(const std::string& text);

} // namespace torqued
