/// A program that runs beside the test.
#pragma once

#include <chrono>
#include <fcntl.h>
#include <optional>
#include <signal.h>
#include <spawn.h>
#include <stdexcept>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace torqued
{

/// Started by its constructor; killed, by its own process id, if it still runs when its owner goes.
class Process
{
public:
  /// output: a file that takes what it prints; errors: one for what it prints on stderr, if not the same.
  Process(std::vector<std::string> command, const std::string& output, const std::string& errors = "")
  {
    std::vector<char*> arguments;
    for (std::string& word : command)
      arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (errors.empty())
      posix_spawn_file_actions_adddup2(&actions, 1, 2);
    else
      posix_spawn_file_actions_addopen(&actions, 2, errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int error = posix_spawnp(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0)
      throw std::runtime_error("cannot start " + command[0]);
  }
  ~Process()
  {
    if (!ended_)
    {
      signal(SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  void signal(int number) const { kill(pid_, number); }

  /// Waits for its end, at whatever moment it comes: its exit code, or minus the signal that killed it.
  int wait_for_end()
  {
    if (int status = 0; !ended_ && waitpid(pid_, &status, 0) == pid_)
      note(status);
    return ended_.value_or(-1);
  }

  /// Its exit code, or minus the signal that killed it; nothing if it still runs after this time.
  std::optional<int> wait(std::chrono::milliseconds longest = std::chrono::seconds(30))
  {
    const auto until = std::chrono::steady_clock::now() + longest;
    while (!ended_ && std::chrono::steady_clock::now() < until)
    {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_)
        note(status);
      else
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return ended_;
  }

private:
  void note(int status) { ended_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status); }

  pid_t pid_ = -1;
  std::optional<int> ended_;
};

} // namespace torqued
