#include "motion/console.h"

#include "text/printable.h"

#include <cstdio>
#include <fmt/format.h>

namespace torqued
{

void note(std::string_view line)
{
  fmt::print(stderr, "torquectl: note: {}\n", printable_line(line));
}

void note(const std::vector<std::string>& lines)
{
  for (const std::string& line : lines)
    note(line);
}

void print_summary(const std::string& output, std::string_view text)
{
  fmt::print(output == "-" ? stderr : stdout, "{}", printable_lines(text));
}

} // namespace torqued
