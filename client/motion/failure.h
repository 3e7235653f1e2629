/// How a subcommand ends when it cannot do what was asked.
#pragma once

#include <fmt/format.h>
#include <stdexcept>
#include <string>
#include <utility>

namespace torqued
{

/// torquectl's exit codes; those above 1 are named as in sysexits.h.
enum class ExitCode
{
  done = 0,
  failed = 1,
  usage = 64,
  bad_data = 65,
  no_bus = 69,
  bad_configuration = 78
};

/// What ends a subcommand before it is done: one line for the user, and the exit code that goes with it.
class Failure : public std::runtime_error
{
public:
  Failure(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  /// Its message as fmt::format() makes it.
  template <typename... Args>
  Failure(ExitCode code, fmt::format_string<Args...> format, Args&&... args)
      : Failure(code, fmt::format(format, std::forward<Args>(args)...))
  {
  }
  ExitCode code() const { return code_; }

private:
  ExitCode code_;
};

} // namespace torqued
