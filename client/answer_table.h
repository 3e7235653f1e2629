/// Answers as columns of a table: the one that torquectl's eval, export and echo write.
///
///   utime, tau_<actuator> for each actuator, fxL, fzL, momentL, sole_copL, fxR, fzR, momentR, sole_copR, zmp, flags,
///   dynamics_residual, contact_speed, contact_residual, method, rejected
///
/// Units and signs are those of torque_command_t. method is a name, "none" if nothing had to be chosen; rejected is
/// the reason's name, empty for an answer; all other cells of a rejected row but utime are empty. Numbers are as short
/// as they can be and still be read back as the same bits, so equal text means equal answers.
#pragma once

#include "wire/codec.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// A number, as short as it can be and still be read back as the same bits.
std::string number_cell(double number);

/// The columns' names after utime.
std::vector<std::string> answer_columns(const std::vector<std::string>& joint_names);

/// The cells after utime.
std::vector<std::string> answer_cells(const torque_command_t& command);
/// The cells after utime of a desired state that was not answered; why: a reason's name.
std::vector<std::string> rejected_cells(std::size_t num_joints, std::string_view why);

/// A method's name, or its number where it is none that we know.
std::string method_name(std::int8_t method);

/// The names of the bits that are set: "SLIPS", "TIPS".
std::vector<std::string> flag_names(std::int32_t flags);

/// One line of a CSV, with its end.
std::string csv_line(const std::vector<std::string>& cells);

} // namespace torqued
