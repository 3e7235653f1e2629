#include "client/answer_table.h"

#include "client/csv_lines.h"

#include <array>
#include <fmt/format.h>
#include <utility>

namespace torqued
{

namespace
{

constexpr std::array kGroundColumns{"fx", "fz", "moment", "sole_cop"};
constexpr std::array kLastColumns{"zmp",    "flags",   "dynamics_residual", "contact_speed", "contact_residual",
                                  "method", "rejected"};

} // namespace

std::string number_cell(double number)
{
  return fmt::format("{}", number);
}

std::vector<std::string> answer_columns(const std::vector<std::string>& joint_names)
{
  std::vector<std::string> columns;
  for (const std::string& joint : joint_names)
    columns.push_back("tau_" + joint);
  for (const char* side : {"L", "R"})
    for (const std::string name : kGroundColumns)
      columns.push_back(name + side);
  columns.insert(columns.end(), kLastColumns.begin(), kLastColumns.end());
  return columns;
}

std::vector<std::string> answer_cells(const torque_command_t& command)
{
  std::vector<std::string> cells;
  for (const double torque : command.torque)
    cells.push_back(number_cell(torque));
  for (const ground_reaction_t* foot : {&command.left, &command.right})
    for (const double number : {foot->fx, foot->fz, foot->moment, foot->cop})
      cells.push_back(number_cell(number));
  cells.push_back(number_cell(command.zmp));
  cells.push_back(fmt::format("{}", command.flags));
  for (const double number : {command.dynamics_residual, command.contact_speed, command.contact_residual})
    cells.push_back(number_cell(number));
  cells.push_back(method_name(command.method));
  cells.emplace_back();
  return cells;
}

std::vector<std::string> rejected_cells(std::size_t num_joints, std::string_view why)
{
  std::vector<std::string> cells(num_joints + 2 * kGroundColumns.size() + kLastColumns.size());
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
  constexpr std::array<std::pair<std::int32_t, const char*>, 11> known{
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
       {flag::contact_acceleration, "CONTACT_ACCELERATION"}}};
  std::vector<std::string> names;
  for (const auto& [bit, name] : known)
    if (flags & bit)
      names.emplace_back(name);
  return names;
}

std::string csv_line(const std::vector<std::string>& cells)
{
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
