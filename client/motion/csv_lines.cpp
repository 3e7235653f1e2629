#include "motion/csv_lines.h"

#include "motion/failure.h"

#include <algorithm>
#include <csv.h>
#include <fmt/format.h>

namespace torqued
{

CsvReader::CsvReader(std::string_view bytes, const std::string& file)
    : text_(bytes, file), file_(file), lines_(text_.lines()), before_(lines_)
{
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

void CsvReader::split(std::string_view text, CsvLine& line) const
{
  bool whole = false;
  line.cells = split_cells(text, text_.separator(), &whole);
  if (!whole)
    throw Failure(ExitCode::bad_data,
                  "{}:{}: column {}: found a quote out of place; expected a cell without quotes, or one in quotes with "
                  "\"\" for a quote inside",
                  file_, line.number, line.cells.size() + 1);
  if (text_.decimal_comma())
    for (std::string& cell : line.cells)
      if (is_number(cell, ','))
        std::ranges::replace(cell, ',', '.');
}

std::optional<CsvLine> CsvReader::comment()
{
  const std::size_t first = comment_.find_first_not_of("#%/ \t");
  if (first == std::string_view::npos)
    return std::nullopt;
  if (is_foreign_comment(comment_))
    --foreign_comments_;
  return CsvLine{comment_number_, split_cells(comment_.substr(first), text_.separator())};
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
