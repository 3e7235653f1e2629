/// A motion as lines of a CSV, each desired state beside its answer, as torquectl's eval and export write it, or alone,
/// as nearest does. It can be read as a trajectory again.
///
///   utime, time                  µs; s, as it was read, else utime in s
///   q0, …, dq0, …, ddq0, …       each coordinate by its name, with its derivatives: relative names if all states are
///                                RELATIVE, else absolute names, and RELATIVE states are converted
///   xH, zH, dxH, …               among them the base point, if any state has base GIVEN; empty where it is not
///   contactL, contactR           0 to 3, as in desired_state_t
///   leading                      L or R
///   load_transfer, phase         0 to 1
///   and the answer, answer_table.h; its accelerations are in the same coordinates
///   or, without answers, method: the one that the state asks for
#pragma once

#include "wire/messages.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

class MotionTable
{
public:
  explicit MotionTable(const model_info_t& model);

  /// Chooses the columns so that this state fits: once for each state, before all else.
  void see(const desired_state_t& state);

  /// The line that names the columns.
  std::string header() const;
  /// A state that was answered. seconds: its time as it was read. Requires: an answer for the model's robot.
  std::string line(const desired_state_t& state, const std::optional<double>& seconds,
                   const torque_command_t& answer) const;
  /// A state that was not, even one of another robot: its motion's cells are empty then. why: a reason's name.
  std::string line(const desired_state_t& state, const std::optional<double>& seconds, std::string_view why) const;

  /// The same of a motion without answers.
  std::string motion_header() const;
  std::string motion_line(const desired_state_t& state, const std::optional<double>& seconds) const;

private:
  const std::vector<std::string>& coordinates() const;
  std::vector<std::string> coordinates_and_base() const;
  std::vector<std::string> state_columns() const;
  std::vector<std::string> answer_names() const;
  std::vector<std::string> state_cells(const desired_state_t& state, const std::optional<double>& seconds) const;
  std::vector<double> in_columns(const desired_state_t& state, const std::vector<double>& numbers, bool position) const;

  model_info_t model_;
  std::vector<std::string> base_names_; // none if the root is fixed
  bool relative_ = true, base_ = false;
};

} // namespace torqued
