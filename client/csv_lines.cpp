#include "client/csv_lines.h"

#include "client/failure.h"

#include <algorithm>
#include <fmt/format.h>
#include <new>

namespace torqued
{

CsvReader::CsvReader(std::string_view text, const std::string& file) : rest_(text), file_(file)
{
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (rest_.starts_with(byte_order_mark))
    rest_.remove_prefix(byte_order_mark.size());
  if (csv_init(&parser_, CSV_STRICT | CSV_STRICT_FINI) != 0)
    throw std::bad_alloc();
}

CsvReader::~CsvReader()
{
  csv_free(&parser_);
}

bool CsvReader::next(CsvLine& line)
{
  while (!rest_.empty())
  {
    const std::string_view text = rest_.substr(0, rest_.find('\n'));
    rest_.remove_prefix(std::min(text.size() + 1, rest_.size()));
    ++number_;
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos || text[first] == '#')
      continue;

    line.number = number_;
    line.cells.clear();
    const auto add_cell = [](void* cell, std::size_t size, void* cells)
    {
      static_cast<std::vector<std::string>*>(cells)->emplace_back(static_cast<const char*>(cell), size);
    };
    const bool read = csv_parse(&parser_, text.data(), text.size(), add_cell, nullptr, &line.cells) == text.size();
    if (!read || csv_fini(&parser_, add_cell, nullptr, &line.cells) != 0)
      throw Failure(
          ExitCode::bad_data,
          fmt::format("{}:{}: column {}: found a quote out of place; expected a cell without quotes, or one in "
                      "quotes with \"\" for a quote inside",
                      file_, number_, line.cells.size() + 1));
    return true;
  }
  return false;
}

std::string csv_cell(const std::string& text)
{
  if (text.find_first_of(",\"\n\r#") == std::string::npos && !text.starts_with(' ') && !text.ends_with(' '))
    return text;
  std::string cell(csv_write(nullptr, 0, text.data(), text.size()), '\0');
  csv_write(cell.data(), cell.size(), text.data(), text.size());
  return cell;
}

} // namespace torqued
