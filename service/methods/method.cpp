#include "methods/method.h"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <stdexcept>

namespace torqued
{

namespace
{

std::string numbered_names()
{
  std::string text = "DEFAULT (0)";
  for (const MethodRow& row : methods())
  {
    std::string name(row.name);
    for (char& c : name)
      c = c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    text += fmt::format("{}{} ({})", &row == &methods().back() ? " or " : ", ", name, static_cast<int>(row.method));
  }
  return text;
}

} // namespace

const std::string kMethodNumbers = numbered_names();

Range from_0_to(double most)
{
  return {0.0, most, fmt::format("0 to {}", most)};
}

Range not_negative()
{
  return {0.0, std::numeric_limits<double>::max(), "a number that is not negative"};
}

MethodSettings::MethodSettings() : all_(methods().size() + 1)
{
  for (const MethodRow& row : methods())
    if (row.settings)
      of_method(row.method) = row.settings();
}

void MethodSettings::list(SettingList& settings)
{
  for (const MethodRow& row : methods())
    if (row.list)
    {
      std::string table(row.name);
      std::replace(table.begin(), table.end(), '-', '_');
      settings.table(table);
      row.list(of_method(row.method), settings);
    }
}

std::vector<MethodRow> by_number(std::vector<MethodRow> rows)
{
  std::ranges::sort(rows, {}, &MethodRow::method);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (static_cast<std::size_t>(rows[i].method) != i + 1)
      throw std::logic_error(
          fmt::format("{} has the number {}; expected {}", rows[i].name, static_cast<int>(rows[i].method), i + 1));
  return rows;
}

std::vector<Method> all_methods()
{
  std::vector<Method> all;
  for (const MethodRow& row : methods())
    all.push_back(row.method);
  return all;
}

std::string_view name_of(Method method)
{
  for (const MethodRow& row : methods())
    if (row.method == method)
      return row.name;
  return "none";
}

Method method_named(std::string_view name)
{
  for (const MethodRow& row : methods())
    if (row.name == name)
      return row.method;
  return Method::none;
}

std::string method_names()
{
  std::string names;
  for (const MethodRow& row : methods())
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  return names;
}

} // namespace torqued
