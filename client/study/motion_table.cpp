#include "study/motion_table.h"

#include "motion/motion_columns.h"
#include "study/answer_table.h"

#include <Eigen/LU>
#include <fmt/format.h>
#include <iterator>

namespace torqued
{

MotionTable::MotionTable(const model_info_t& model) : model_(model)
{
  if (!model.base_names[0].empty())
    base_names_.assign(std::begin(model.base_names), std::end(model.base_names));
}

void MotionTable::see(const desired_state_t& state)
{
  relative_ = relative_ && state.coordinates == desired_state_t::RELATIVE;
  base_ = base_ || state.base == desired_state_t::GIVEN;
}

const std::vector<std::string>& MotionTable::coordinates() const
{
  return relative_ ? model_.relative_names : model_.absolute_names;
}

std::vector<std::string> MotionTable::coordinates_and_base() const
{
  std::vector<std::string> names = coordinates();
  names.insert(names.end(), base_names_.begin(), base_names_.end());
  return names;
}

std::vector<std::string> MotionTable::answer_names() const
{
  return answer_columns(model_.joint_names, coordinates_and_base());
}

std::vector<std::string> MotionTable::state_columns() const
{
  std::vector<std::string> columns = written_columns(base_ ? coordinates_and_base() : coordinates());
  columns.insert(columns.begin() + 1, "time");
  return columns;
}

std::string MotionTable::header() const
{
  return csv_line(state_columns(), answer_names());
}

std::string MotionTable::motion_header() const
{
  return csv_line(state_columns(), {"method"});
}

std::string MotionTable::line(const desired_state_t& state, const std::optional<double>& seconds,
                              const torque_command_t& answer) const
{
  std::vector<double> accelerations = in_columns(state, answer.a, false);
  for (std::size_t i = 0; i < base_names_.size(); ++i)
    accelerations.push_back(answer.base_a[i]);
  return csv_line(state_cells(state, seconds), answer_cells(answer, accelerations));
}

std::string MotionTable::line(const desired_state_t& state, const std::optional<double>& seconds,
                              std::string_view why) const
{
  return csv_line(state_cells(state, seconds), rejected_cells(answer_names().size(), why));
}

std::string MotionTable::motion_line(const desired_state_t& state, const std::optional<double>& seconds) const
{
  return csv_line(state_cells(state, seconds), {state.method == 0 ? "default" : method_name(state.method)});
}

std::vector<std::string> MotionTable::state_cells(const desired_state_t& state,
                                                  const std::optional<double>& seconds) const
{
  std::vector<std::string> cells{fmt::format("{}", state.utime),
                                 seconds ? number_cell(*seconds) : seconds_cell(state.utime)};
  const auto add_motion = [&](const std::vector<double>& angles, bool position, const double* base)
  {
    if (state.num_coordinates == model_.num_coordinates)
      for (const double number : in_columns(state, angles, position))
        cells.push_back(number_cell(number));
    else
      cells.resize(cells.size() + coordinates().size());
    for (std::size_t i = 0; base_ && i < base_names_.size(); ++i)
      cells.push_back(state.base == desired_state_t::GIVEN ? number_cell(base[i]) : "");
  };
  add_motion(state.q, true, state.base_q);
  add_motion(state.v, false, state.base_v);
  add_motion(state.a, false, state.base_a);
  cells.push_back(fmt::format("{}", state.left_contact));
  cells.push_back(fmt::format("{}", state.right_contact));
  cells.push_back(state.leading_foot == desired_state_t::LEFT    ? "L"
                  : state.leading_foot == desired_state_t::RIGHT ? "R"
                                                                 : fmt::format("{}", state.leading_foot));
  cells.push_back(number_cell(state.load_transfer));
  cells.push_back(number_cell(state.phase));
  return cells;
}

// Numbers in a state's coordinates as they stand in the columns. q_relative = A q_absolute + b is solved for the
// absolute angles, or their derivatives.
std::vector<double> MotionTable::in_columns(const desired_state_t& state, const std::vector<double>& numbers,
                                            bool position) const
{
  if (relative_ || state.coordinates != desired_state_t::RELATIVE)
    return numbers;
  const Eigen::Index n = model_.num_coordinates;
  Eigen::MatrixXd A(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    A.row(i) = Eigen::Map<const Eigen::RowVectorXd>(model_.A[static_cast<std::size_t>(i)].data(), n);
  Eigen::VectorXd right = Eigen::Map<const Eigen::VectorXd>(numbers.data(), n);
  if (position)
    right -= Eigen::Map<const Eigen::VectorXd>(model_.b.data(), n);
  const Eigen::VectorXd absolute = A.partialPivLu().solve(right);
  return {absolute.begin(), absolute.end()};
}

} // namespace torqued
