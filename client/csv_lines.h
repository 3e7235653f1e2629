/// Lines of comma-separated values.
#pragma once

#include <cstddef>
#include <csv.h>
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

/// Reads a text line by line; passes over empty lines, comments (# first) and a byte order mark.
///
/// A cell may stand in double quotes, a quote inside is doubled; no cell goes on in the next line.
class CsvReader
{
public:
  /// file: the name used in complaints. The text must outlive the reader.
  CsvReader(std::string_view text, const std::string& file);
  ~CsvReader();
  CsvReader(const CsvReader&) = delete;
  CsvReader& operator=(const CsvReader&) = delete;

  /// Reads the next line; false at the end. Throws Failure, bad_data, for a quote that is not closed or not alone.
  bool next(CsvLine& line);

private:
  std::string_view rest_;
  std::string file_;
  std::size_t number_ = 0;
  csv_parser parser_;
};

/// A cell as it is written: in quotes if it holds anything that a reader could take for more than text.
std::string csv_cell(const std::string& text);

} // namespace torqued
