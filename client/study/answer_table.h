/// Answers as columns of a table: the one that torquectl's eval, export and echo write.
///
///   tau_<actuator>                for each actuator, N m
///   fxL, fzL, momentL, sole_copL  ground on left foot: N, N m, m; and fxR, … on the right one
///   zmp                           m
///   flags, flag_names             a number, the sum of its bits; their names, joined by |, empty for 0
///   dynamics_residual, contact_speed, contact_residual
///   a_<coordinate>                accelerations that the torques produce, for each coordinate and, if the root floats,
///                                 the base point: rad/s², m/s²
///   adjustment                    rad/s²
///   method                        a name, "none" if nothing had to be chosen
///   rejected                      the reason's name, empty for an answer
///
/// Units and signs are those of torque_command_t. utime (µs) and time (s) stand before them, and in eval and export the
/// desired state, state_table.h. echo, which hears no desired states, does not know in which coordinates they were
/// sent: there, accelerations are numbered, a_0, a_1, …, in the message's order.
///
/// Of a rejected row all cells but the last are empty; so is an acceleration that a recorded answer does not say.
/// Numbers are as short as they can be and still be read back as the same bits, so equal text means equal answers.
#pragma once

#include <torqued/torque_command_t.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// A number, as short as it can be and still be read back as the same bits.
std::string number_cell(double number);

/// A time in µs as a number of s.
std::string seconds_cell(std::int64_t microseconds);

/// The names of an answer's columns. accelerations: of the coordinates and the base point, in the order of the cells.
std::vector<std::string> answer_columns(const std::vector<std::string>& joint_names,
                                        const std::vector<std::string>& accelerations);

/// An answer's cells. accelerations: under the columns' names; NaN: not known.
std::vector<std::string> answer_cells(const torque_command_t& command, const std::vector<double>& accelerations);
/// The cells of a desired state that was not answered; columns: how many there are; why: a reason's name.
std::vector<std::string> rejected_cells(std::size_t columns, std::string_view why);

/// A method's name, or its number where it is none that we know.
std::string method_name(std::int8_t method);

/// The names of the bits that are set: "SLIPS", "TIPS".
std::vector<std::string> flag_names(std::int32_t flags);

/// One line of a CSV, with its end: cells, then more.
std::string csv_line(std::vector<std::string> cells, const std::vector<std::string>& more = {});

} // namespace torqued
