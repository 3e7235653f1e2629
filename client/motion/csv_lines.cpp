#include "motion/csv_lines.h"

#include "motion/failure.h"

#include <algorithm>
#include <fmt/format.h>
#include <new>

namespace torqued
{

CsvReader::CsvReader(std::string_view bytes, const std::string& file)
    : text_(bytes, file), file_(file), lines_(text_.lines()), before_(lines_)
{
  if (csv_init(&parser_, CSV_STRICT | CSV_STRICT_FINI) != 0)
    throw std::bad_alloc();
  csv_set_delim(&parser_,
                static_cast<unsigned char>(text_.separator() == TableText::kBlanks ? '\t' : text_.separator()));
}

CsvReader::~CsvReader()
{
  csv_free(&parser_);
}

bool CsvReader::next(CsvLine& line)
{
  before_ = lines_;
  for (std::string_view text; lines_.next(text); before_ = lines_)
  {
    const bool foreign = !begun_ && is_foreign_comment(text);
    if (foreign || is_passed_over(text, text_.separator()))
    {
      foreign_comments_ += foreign ? 1 : 0;
      if (!begun_ && text.find_first_of("#%/") != std::string_view::npos)
      {
        comment_ = text;
        comment_number_ = lines_.number();
      }
      continue;
    }
    begun_ = true;
    line.number = lines_.number();
    split(text, line);
    return true;
  }
  return false;
}

void CsvReader::split(std::string_view text, CsvLine& line)
{
  if (text_.separator() == TableText::kBlanks)
  {
    tabbed_.clear();
    bool quoted = false;
    const std::size_t first = std::min(text.find_first_not_of(" \t"), text.size());
    for (const char c : text.substr(first, text.find_last_not_of(" \t") + 1 - first))
    {
      quoted ^= c == '"';
      const bool blank = !quoted && (c == ' ' || c == '\t');
      if (!blank || tabbed_.back() != '\t')
        tabbed_ += blank ? '\t' : c;
    }
    text = tabbed_;
  }
  line.cells.clear();
  const auto add_cell = [](void* cell, std::size_t size, void* cells)
  {
    static_cast<std::vector<std::string>*>(cells)->emplace_back(static_cast<const char*>(cell), size);
  };
  const bool read = csv_parse(&parser_, text.data(), text.size(), add_cell, nullptr, &line.cells) == text.size();
  if (!read || csv_fini(&parser_, add_cell, nullptr, &line.cells) != 0)
    throw Failure(ExitCode::bad_data,
                  fmt::format("{}:{}: column {}: found a quote out of place; expected a cell without quotes, or one in "
                              "quotes with \"\" for a quote inside",
                              file_, line.number, line.cells.size() + 1));
  if (text_.decimal_comma())
    for (std::string& cell : line.cells)
      if (is_number(cell, ','))
        std::replace(cell.begin(), cell.end(), ',', '.');
}

std::optional<CsvLine> CsvReader::comment()
{
  const std::size_t first = comment_.find_first_not_of("#%/ \t");
  if (first == std::string_view::npos)
    return std::nullopt;
  if (is_foreign_comment(comment_))
    --foreign_comments_;
  CsvLine line;
  line.number = comment_number_;
  for (const std::string_view cell : split_cells(comment_.substr(first), text_.separator()))
    line.cells.emplace_back(cell);
  return line;
}

std::vector<std::string> CsvReader::assumptions() const
{
  std::vector<std::string> all = text_.assumptions();
  if (foreign_comments_ > 0)
    all.push_back(fmt::format("{} line{} above the names of the columns begin{} with % or //; passed over as comments",
                              foreign_comments_, foreign_comments_ == 1 ? "" : "s", foreign_comments_ == 1 ? "s" : ""));
  return all;
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
