/// lcm-logger beside the test.
#pragma once

#include "process.h"

#include <filesystem>

namespace torqued
{

/// Writes what is on the bus to a file, from the moment its constructor returns: that waits until the logger has heard
/// something, such as a daemon's status. On a busy machine it may lose what others hear, as its socket holds little.
class Logger
{
public:
  /// launcher: words that start it elsewhere; output: a file that takes what it prints.
  Logger(const std::string& log, const std::string& output, std::vector<std::string> launcher = {})
  {
    std::filesystem::remove(log);
    for (const std::string& word : {std::string("lcm-logger"), std::string("--quiet"), log})
      launcher.push_back(word);
    process_.emplace(launcher, output);
    const auto size = [&log]
    {
      std::error_code none;
      const auto bytes = std::filesystem::file_size(log, none);
      return none ? 0 : bytes;
    };
    for (int i = 0; i < 1000 && size() == 0; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }

  void end(int signal = SIGTERM)
  {
    process_->signal(signal);
    process_->wait();
  }

private:
  std::optional<Process> process_;
};

} // namespace torqued
