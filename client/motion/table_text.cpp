#include "motion/table_text.h"

#include "motion/failure.h"
#include "motion/foreign_file.h"
#include "text/number.h"
#include "text/plain_text.h"
#include "text/printable.h"

#include <algorithm>
#include <array>
#include <csv.h>
#include <cuchar>
#include <fmt/format.h>
#include <locale>
#include <memory>
#include <new>

namespace torqued
{

namespace
{

constexpr std::array<char, 4> kSeparators{',', ';', '\t', '|'};
constexpr std::string_view kSpace = " \t";

// whether a line splits at a separator into the names of columns, or into numbers only
bool splits(std::string_view line, char separator)
{
  const std::vector<std::string> cells = split_cells(line, separator);
  const char decimal_sign = separator == ',' ? '.' : ',';
  if (std::ranges::any_of(cells, names_time))
    return cells.size() > 1;
  std::size_t numbers = 0;
  for (const std::string& cell : cells)
  {
    if (is_number(cell, '.') || is_number(cell, decimal_sign))
      ++numbers;
    else if (other_separator(cell, separator) || cell.find(' ') != std::string::npos)
      return false;
  }
  return numbers > 1 && 2 * numbers > cells.size();
}

enum class Order
{
  little_endian,
  big_endian
};

// the order of the bytes of UTF-16 text; nothing for other bytes
std::optional<Order> utf16_order(std::string_view bytes)
{
  if (bytes.starts_with("\xff\xfe"))
    return Order::little_endian;
  if (bytes.starts_with("\xfe\xff"))
    return Order::big_endian;
  // without a mark: nearly all characters of a table are ASCII, whose upper byte is zero
  const std::size_t pairs = std::min<std::size_t>(bytes.size() / 2, 512);
  std::array<std::size_t, 2> ascii{};
  for (std::size_t i = 0; i < 2 * pairs; ++i)
    if (bytes[i] == '\0' && bytes[i ^ 1U] > '\0')
      ++ascii[i % 2];
  for (const Order order : {Order::big_endian, Order::little_endian})
    if (const std::size_t upper = order == Order::big_endian ? 0 : 1; pairs > 1 && 10 * ascii[upper] >= 9 * pairs)
      return order;
  return std::nullopt;
}

// nothing for units that are no UTF-16
std::optional<std::string> utf8(std::string_view bytes, Order order)
{
  std::u16string units;
  units.reserve(bytes.size() / 2);
  const auto byte = [bytes](std::size_t at)
  {
    return static_cast<unsigned char>(bytes[at]);
  };
  const std::size_t upper = order == Order::big_endian ? 0 : 1;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2)
    units.push_back(static_cast<char16_t>(byte(i + upper) << 8U | byte(i + 1 - upper)));

  const auto& codec = std::use_facet<std::codecvt<char16_t, char8_t, std::mbstate_t>>(std::locale::classic());
  std::u8string text(3 * units.size(), u8'\0');
  std::mbstate_t state{};
  const char16_t* read = nullptr;
  char8_t* written = nullptr;
  if (codec.out(state, units.data(), units.data() + units.size(), read, text.data(), text.data() + text.size(),
                written) != std::codecvt_base::ok)
    return std::nullopt;
  return std::string(reinterpret_cast<const char*>(text.data()), static_cast<std::size_t>(written - text.data()));
}

// what a line of OpenSim's header says
void read_opensim_line(std::string_view line, OpenSimHeader& header)
{
  const std::string text = lower_case(line);
  const std::size_t sign = text.find('=');
  const std::string_view key = trimmed(std::string_view(text).substr(0, sign));
  const std::string_view value = sign == std::string::npos ? "" : trimmed(std::string_view(text).substr(sign + 1));
  if (key == "indegrees" && (value == "yes" || value == "no"))
    header.degrees = value == "yes";
  if (key == "angles are in degrees." || key == "angles are in radians.")
    header.degrees = key == "angles are in degrees.";
  if (key == "nrows")
    header.rows = number_in<std::size_t>(value);
}

} // namespace

bool LineCutter::next(std::string_view& line)
{
  if (at_ >= text_.size())
    return false;
  if (line_feed_ < at_ || number_ == 0)
    line_feed_ = std::min(text_.find('\n', at_), text_.size());
  line = text_.substr(at_, line_feed_ - at_);
  const std::size_t carriage_return = line.find('\r');
  line = line.substr(0, carriage_return);
  at_ += line.size() + 1;
  if (carriage_return != std::string_view::npos && at_ == line_feed_) // both together
    ++at_;
  ++number_;
  return true;
}

TableText::TableText(std::string_view bytes, const std::string& file) : file_(file), lines_({})
{
  decode(bytes);
  lines_ = LineCutter(text_);
  read_opensim_header();
  if (!opensim_)
    if (const auto foreign = foreign_file(text_))
      throw Failure(ExitCode::bad_data, "{}: is {}; expected a table (CSV) or an LCM log", file_, *foreign);
  refuse_binary();
  find_separator();
  find_decimal_sign();
  if (separator_ == ',' && decimal_comma_)
    assumptions_.emplace_back("decimals are written by commas, in quotes");
  if (separator_ != ',')
    assumptions_.push_back(fmt::format("cells are separated by {}{}", name_of_separator(separator_),
                                       decimal_comma_ ? ", decimals by commas" : ""));
}

void TableText::decode(std::string_view bytes)
{
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  text_ = bytes.starts_with(byte_order_mark) ? bytes.substr(byte_order_mark.size()) : bytes;
  const std::optional<Order> order = utf16_order(bytes);
  if (!order || foreign_file(bytes)) // UTF-32 has the mark of UTF-16
    return;
  const std::size_t mark = bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff") ? 2 : 0;
  std::optional<std::string> decoded = utf8(bytes.substr(mark), *order);
  if (bytes.size() % 2 != 0 || !decoded)
    throw Failure(ExitCode::bad_data, "{}: is UTF-16 text that is cut or damaged; expected whole characters", file_);
  decoded_ = std::move(*decoded);
  text_ = decoded_;
  assumptions_.push_back(fmt::format("is UTF-16 text ({}-endian)", *order == Order::big_endian ? "big" : "little"));
}

void TableText::refuse_binary() const
{
  const std::size_t zero = text_.find('\0');
  const std::string_view head = text_.substr(0, std::min<std::size_t>(zero, 1024));
  const auto control = std::ranges::count_if(
      head, [](char c) { return (c >= '\0' && c < '\t') || (c > '\r' && c < ' ' && c != '\x1b'); });
  if (20 * static_cast<std::size_t>(control) > head.size() ||
      (zero != std::string_view::npos && head.find_first_of("\n\r") == std::string_view::npos))
    throw Failure(ExitCode::bad_data,
                  "{}: is binary, of no kind that is known here; expected a table (CSV) or an LCM log", file_);
  if (zero == std::string_view::npos)
    return;
  LineCutter lines(text_);
  std::string_view line;
  while (lines.next(line) && line.find('\0') == std::string_view::npos)
    ;
  fail(lines.number(), "found a byte of zero; expected text, which has none: the file is cut or damaged");
}

void TableText::read_opensim_header()
{
  constexpr std::size_t longest = 200; // lines
  OpenSimHeader header;
  LineCutter lines = lines_;
  std::string_view line;
  while (lines.number() < longest && lines.next(line))
  {
    line = trimmed(line, " \t,;");
    if (line.size() == 9 && lower_case(line) == "endheader")
    {
      opensim_ = header;
      lines_ = lines;
      return;
    }
    read_opensim_line(line, header);
  }
}

void TableText::find_separator()
{
  LineCutter lines = lines_;
  std::string_view line;
  do
    if (!lines.next(line))
      return;
  while (is_passed_over(line, ',') || is_foreign_comment(line));

  if (line.size() == 5 && lower_case(line).starts_with("sep="))
  {
    separator_ = line.back();
    if (std::ranges::find(kSeparators, separator_) == kSeparators.end())
      fail(lines.number(), fmt::format("found \"{}\"; expected sep= and a comma, a semicolon, a tab or a bar",
                                       printable(std::string(line))));
    lines_ = lines;
    return;
  }

  std::string possible;
  for (const char separator : kSeparators)
    if (splits(line, separator))
      possible += separator;
  if (possible.empty() && splits(line, kBlanks))
    possible = kBlanks;
  if (possible.empty()) // a line without the time: what holds its cells apart is only of use to the complaint
    possible = other_separator(line, '\0').value_or(',');
  separator_ = possible.front();
  if (possible.size() > 1)
    fail(lines.number(), fmt::format("found cells between {} and cells between {}; expected one separator throughout",
                                     name_of_separator(possible[0]), name_of_separator(possible[1])));
}

void TableText::find_decimal_sign()
{
  // between commas, a cell with a comma is one in quotes
  if (text_.find(separator_ == ',' ? '"' : ',') == std::string_view::npos)
    return;
  struct Number
  {
    std::string text;
    std::size_t line = 0;
  };
  std::array<Number, 2> first; // with a comma, with a point
  constexpr std::array<char, 2> signs{',', '.'};
  LineCutter lines = lines_;
  std::string_view line;
  while (lines.next(line))
  {
    if (is_passed_over(line, separator_))
      continue;
    for (const std::string& cell : split_cells(line, separator_))
      for (std::size_t i = 0; i < 2; ++i)
        if (first[i].line == 0 && cell.find(signs[i]) != std::string::npos && is_number(cell, signs[i]))
          first[i] = {cell, lines.number()};
    if (first[0].line != 0 && first[1].line != 0)
      fail(lines.number(), fmt::format("found decimal commas (\"{}\" in line {}) and decimal points (\"{}\" in line "
                                       "{}); expected one of the two throughout",
                                       first[0].text, first[0].line, first[1].text, first[1].line));
  }
  decimal_comma_ = first[0].line != 0;
}

void TableText::fail(std::size_t line, const std::string& what) const
{
  throw Failure(ExitCode::bad_data, "{}:{}: {}", file_, line, what);
}

bool is_passed_over(std::string_view line, char separator)
{
  const std::size_t first = line.find_first_not_of(kSpace);
  if (first == std::string_view::npos || line[first] == '#')
    return true;
  return line[first] == separator &&
         std::ranges::all_of(line, [separator](char c) { return c == separator || c == ' ' || c == '\t'; });
}

bool is_foreign_comment(std::string_view line)
{
  line = trimmed(line);
  return line.starts_with('%') || line.starts_with("//");
}

std::string_view name_of_separator(char separator)
{
  switch (separator)
  {
  case ';': return "semicolons";
  case '\t': return "tabs";
  case '|': return "bars";
  case TableText::kBlanks: return "spaces";
  default: return "commas";
  }
}

std::optional<char> other_separator(std::string_view text, char separator)
{
  bool quoted = false;
  int brackets = 0;
  for (const char c : text)
  {
    quoted ^= c == '"';
    brackets += (c == '(' || c == '[') - (c == ')' || c == ']');
    const bool known = std::ranges::find(kSeparators, c) != kSeparators.end();
    if (known && !quoted && brackets <= 0 && c != separator && !(c == '\t' && separator == TableText::kBlanks))
      return c;
  }
  return std::nullopt;
}

std::vector<std::string> split_cells(std::string_view line, char separator, bool* whole)
{
  std::string tabbed; // the line with a tab for the blanks between two cells
  if (separator == TableText::kBlanks)
  {
    bool quoted = false;
    for (const char c : trimmed(line))
    {
      quoted ^= c == '"';
      const bool blank = !quoted && kSpace.find(c) != std::string_view::npos;
      if (!blank || tabbed.back() != '\t')
        tabbed += blank ? '\t' : c;
    }
    line = tabbed;
    separator = '\t';
  }
  csv_parser parser;
  if (csv_init(&parser, CSV_STRICT | CSV_STRICT_FINI) != 0)
    throw std::bad_alloc();
  const std::unique_ptr<csv_parser, void (*)(csv_parser*)> end(&parser, csv_free);
  csv_set_delim(&parser, static_cast<unsigned char>(separator));
  std::vector<std::string> cells;
  const auto add_cell = [](void* cell, std::size_t size, void* to)
  {
    static_cast<std::vector<std::string>*>(to)->emplace_back(static_cast<const char*>(cell), size);
  };
  const bool is_whole = csv_parse(&parser, line.data(), line.size(), add_cell, nullptr, &cells) == line.size() &&
                        csv_fini(&parser, add_cell, nullptr, &cells) == 0;
  if (whole != nullptr)
    *whole = is_whole;
  return cells;
}

bool names_time(std::string_view cell)
{
  const std::string name = lower_case(trimmed(cell.substr(0, cell.find_first_of("([")), " \t\""));
  return name == "time" || name == "utime";
}

bool is_number(std::string_view cell, char decimal_sign)
{
  if (cell.starts_with('+') || cell.starts_with('-'))
    cell.remove_prefix(1);
  if (const std::string word = cell.size() == 3 ? lower_case(cell) : ""; word == "nan" || word == "inf")
    return true;
  const auto digits = [&cell]
  {
    const std::size_t count = std::min(cell.find_first_not_of("0123456789"), cell.size());
    cell.remove_prefix(count);
    return count;
  };
  std::size_t count = digits();
  if (cell.starts_with(decimal_sign))
  {
    cell.remove_prefix(1);
    count += digits();
  }
  if (count == 0 || cell.empty())
    return count > 0;
  if (cell.front() != 'e' && cell.front() != 'E')
    return false;
  cell.remove_prefix(1);
  if (cell.starts_with('+') || cell.starts_with('-'))
    cell.remove_prefix(1);
  return digits() > 0 && cell.empty();
}

} // namespace torqued
