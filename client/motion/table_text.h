/// Tables as people and programs write them: text in an encoding, cells between separators.
///
/// Known by their first bytes and lines: UTF-8 and UTF-16, with or without a byte order mark; line ends of all systems;
/// cells between commas, semicolons, tabs, bars, or spaces; decimal commas where cells have another separator; the
/// line "sep=;" of a spreadsheet; OpenSim's header, which ends with the line endheader.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// Cuts a text into lines at line feeds, carriage returns, or both together.
class LineCutter
{
public:
  explicit LineCutter(std::string_view text) : text_(text) {}

  /// The next line, without its end; false after the last.
  bool next(std::string_view& line);
  /// The number of the last line, from 1.
  std::size_t number() const { return number_; }

private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_feed_ = 0; // the first at or after at_, once it is looked for
  std::size_t number_ = 0;
};

/// What the header of an OpenSim file (.mot, .sto) says.
struct OpenSimHeader
{
  std::optional<bool> degrees;     ///< inDegrees: whether angles are in degrees; nothing if it does not say
  std::optional<std::size_t> rows; ///< nRows
};

/// The text of a table, and how its cells are to be read.
class TableText
{
public:
  static constexpr char kBlanks = ' '; ///< as a separator: one or more spaces and tabs

  /// bytes: of the whole file; they must outlive this. file: the name used in complaints.
  ///
  /// Throws Failure, bad_data, for bytes that are no text, for other kinds of files by their names, and for separators
  /// or decimal signs that are mixed.
  TableText(std::string_view bytes, const std::string& file);
  TableText(const TableText&) = delete;
  TableText& operator=(const TableText&) = delete;

  /// Behind the last line that is no part of the table.
  const LineCutter& lines() const { return lines_; }
  char separator() const { return separator_; }
  bool decimal_comma() const { return decimal_comma_; }
  const std::optional<OpenSimHeader>& opensim() const { return opensim_; }
  /// What was assumed; a sentence each.
  const std::vector<std::string>& assumptions() const { return assumptions_; }

private:
  void decode(std::string_view bytes);
  void refuse_binary() const;
  void read_opensim_header();
  void find_separator();
  void find_decimal_sign();
  [[noreturn]] void fail(std::size_t line, const std::string& what) const;

  std::string file_;
  std::string decoded_; // if text_ is not the file's bytes
  std::string_view text_;
  LineCutter lines_;
  char separator_ = ',';
  bool decimal_comma_ = false;
  std::optional<OpenSimHeader> opensim_;
  std::vector<std::string> assumptions_;
};

/// Whether a line of a table is one to pass over: empty, a comment (# first), or no more than separators.
bool is_passed_over(std::string_view line, char separator);
/// Whether a line above the names is a comment in another language: % or // first.
bool is_foreign_comment(std::string_view line);

/// "commas", "tabs": the name of a separator, in the plural.
std::string_view name_of_separator(char separator);

/// The one other separator that a text holds outside quotes and brackets; nothing if there is none.
std::optional<char> other_separator(std::string_view text, char separator);

/// A line's cells, without the spaces and quotes around them. whole: set to whether every quote is closed and in its
/// place; if not, the cells end before the first that is not.
std::vector<std::string> split_cells(std::string_view line, char separator, bool* whole = nullptr);

/// Whether a cell names the time of a row, time or utime, with or without a unit in brackets.
bool names_time(std::string_view cell);

/// Whether a cell is a number, with this sign before its decimals or without any; nan and inf are numbers.
bool is_number(std::string_view cell, char decimal_sign);

} // namespace torqued
