#include "study/answer_table.h"

#include "methods/torque_method.h"
#include "motion/csv_lines.h"

#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

namespace torqued
{

namespace
{

constexpr std::array kGroundColumns{"fx", "fz", "moment", "sole_cop"};

} // namespace

std::string number_cell(double number)
{
  return fmt::format("{}", number);
}

std::string seconds_cell(std::int64_t microseconds)
{
  return number_cell(static_cast<double>(microseconds) / 1e6);
}

std::vector<std::string> answer_columns(const std::vector<std::string>& joint_names,
                                        const std::vector<std::string>& accelerations)
{
  std::vector<std::string> columns;
  for (const std::string& joint : joint_names)
    columns.push_back("tau_" + joint);
  for (const char* side : {"L", "R"})
    for (const std::string name : kGroundColumns)
      columns.push_back(name + side);
  for (const char* name : {"zmp", "flags", "flag_names", "dynamics_residual", "contact_speed", "contact_residual"})
    columns.emplace_back(name);
  for (const std::string& name : accelerations)
    columns.push_back("a_" + name);
  for (const char* name : {"adjustment", "method", "rejected"})
    columns.emplace_back(name);
  return columns;
}

std::vector<std::string> answer_cells(const torque_command_t& command, const std::vector<double>& accelerations)
{
  std::vector<std::string> cells;
  const auto add = [&cells](double number)
  {
    cells.push_back(std::isnan(number) ? "" : number_cell(number));
  };
  for (const double torque : command.torque)
    add(torque);
  for (const ground_reaction_t* foot : {&command.left, &command.right})
    for (const double number : {foot->fx, foot->fz, foot->moment, foot->cop})
      add(number);
  add(command.zmp);
  cells.push_back(fmt::format("{}", command.flags));
  cells.push_back(fmt::format("{}", fmt::join(flag_names(command.flags), "|")));
  for (const double number : {command.dynamics_residual, command.contact_speed, command.contact_residual})
    add(number);
  for (const double number : accelerations)
    add(number);
  add(command.adjustment);
  cells.push_back(method_name(command.method));
  cells.emplace_back();
  return cells;
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
  constexpr std::array<std::pair<std::int32_t, const char*>, 13> known{
      {{flag::slips, "SLIPS"},
       {flag::lifts, "LIFTS"},
       {flag::tips, "TIPS"},
       {flag::over_torque, "OVER_TORQUE"},
       {flag::clamped, "CLAMPED"},
       {flag::relaxed, "RELAXED"},
       {flag::inconsistent, "INCONSISTENT"},
       {flag::late, "LATE"},
       {flag::over_rate, "OVER_RATE"},
       {flag::projected, "PROJECTED"},
       {flag::adjusted, "ADJUSTED"},
       {flag::contact_acceleration, "CONTACT_ACCELERATION"},
       {flag::prior, "PRIOR"}}};
  std::vector<std::string> names;
  for (const auto& [bit, name] : known)
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
