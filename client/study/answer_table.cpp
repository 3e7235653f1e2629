#include "study/answer_table.h"

#include "methods/method_settings.h"
#include "motion/csv_lines.h"
#include "stance/checks.h"
#include "wire/command_fields.h"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued
{

std::string number_cell(double number)
{
  return fmt::format("{}", number);
}

std::string seconds_cell(std::int64_t microseconds)
{
  return number_cell(static_cast<double>(microseconds) / 1e6);
}

namespace
{

// The names of the columns of a field.
struct AnswerColumns
{
  const std::vector<std::string>& joints;
  const std::vector<std::string>& accelerations; // those of the base point among them
  std::vector<std::string> names;

  void operator()(std::string_view field, double) { names.emplace_back(field); }
  void operator()(std::string_view field, const std::vector<double>&)
  {
    const bool torque = field == "torque";
    for (const std::string& name : torque ? joints : accelerations)
      names.push_back((torque ? "tau_" : "a_") + name);
  }
  void operator()(std::string_view, const double (&)[2]) {} // stands among the accelerations
  void operator()(std::string_view field, const ground_reaction_t&)
  {
    for (const std::string name : {"fx", "fz", "moment", "sole_cop"})
      names.push_back(name + (field == "left" ? "L" : "R"));
  }
  void operator()(std::string_view field, std::int32_t)
  {
    names.emplace_back(field);
    names.emplace_back("flag_names");
  }
  void operator()(std::string_view field, std::int8_t) { names.emplace_back(field); }
};

// Their cells.
struct AnswerCells
{
  const std::vector<double>& accelerations;
  std::vector<std::string> cells;

  void operator()(std::string_view, double number) { cells.push_back(std::isnan(number) ? "" : number_cell(number)); }
  void operator()(std::string_view field, const std::vector<double>& numbers)
  {
    for (const double number : field == "torque" ? numbers : accelerations)
      (*this)(field, number);
  }
  void operator()(std::string_view, const double (&)[2]) {}
  void operator()(std::string_view field, const ground_reaction_t& foot)
  {
    for (const double number : {foot.fx, foot.fz, foot.moment, foot.cop})
      (*this)(field, number);
  }
  void operator()(std::string_view, std::int32_t flags)
  {
    cells.push_back(fmt::format("{}", flags));
    cells.push_back(fmt::format("{}", fmt::join(flag_names(flags), "|")));
  }
  void operator()(std::string_view, std::int8_t method) { cells.push_back(method_name(method)); }
};

} // namespace

std::vector<std::string> answer_columns(const std::vector<std::string>& joint_names,
                                        const std::vector<std::string>& accelerations)
{
  AnswerColumns columns{joint_names, accelerations, {}};
  const torque_command_t any{};
  for_each_field(columns, any);
  columns.names.emplace_back("rejected");
  return columns.names;
}

std::vector<std::string> answer_cells(const torque_command_t& command, const std::vector<double>& accelerations)
{
  AnswerCells cells{accelerations, {}};
  for_each_field(cells, command);
  cells.cells.emplace_back();
  return cells.cells;
}

std::vector<std::string> rejected_cells(std::size_t columns, std::string_view why)
{
  std::vector<std::string> cells(columns);
  cells.back() = why;
  return cells;
}

std::string method_name(std::int8_t method)
{
  const std::string_view name = name_of(static_cast<Method>(method));
  return method != 0 && name == name_of(Method::none) ? fmt::format("{}", method) : std::string(name);
}

std::vector<std::string> flag_names(std::int32_t flags)
{
  std::vector<std::string> names;
  for (const auto& [bit, name] : kFlagNames)
    if (flags & bit)
      names.emplace_back(name);
  return names;
}

std::string csv_line(std::vector<std::string> cells, const std::vector<std::string>& more)
{
  cells.insert(cells.end(), more.begin(), more.end());
  std::string line;
  for (const std::string& cell : cells)
  {
    if (&cell != &cells.front())
      line += ',';
    line += csv_cell(cell);
  }
  return line + '\n';
}

} // namespace torqued
