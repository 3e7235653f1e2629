/// What torquectl says to its user beside its output.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace torqued
{

/// Tells the user, in one line on stderr, something that does not end the program.
void note(std::string_view line);
void note(const std::vector<std::string>& lines);

/// Prints what a subcommand says at its end: on stdout, or on stderr if its output, "-", goes to stdout.
void print_summary(const std::string& output, std::string_view text);

} // namespace torqued
