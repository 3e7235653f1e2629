/// What a fuzz target does when a promise is broken.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <string_view>

namespace torqued
{

/// Ends the process with a word on stderr unless this holds.
inline void require(bool holds, std::string_view what)
{
  if (holds)
    return;
  fmt::print(stderr, "broken promise: {}\n", what);
  std::abort();
}

} // namespace torqued
