/// torquectl view as a process, and who asks it over HTTP. Requires a bus: tools/private-network.
#pragma once

#include "catch.h"
#include "process.h"
#include "temporary_folder.h"

#include "motion/files.h"

#include <algorithm>
#include <arpa/inet.h>
#include <chrono>
#include <fmt/format.h>
#include <memory>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace torqued
{

/// Whether the condition holds within ten seconds.
template <typename Condition> bool wait_for(const Condition& condition)
{
  for (int i = 0; i < 1000 && !condition(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return condition();
}

/// A connection to a port of this machine.
class Connection
{
public:
  using Clock = std::chrono::steady_clock;

  explicit Connection(int port, const char* machine = "127.0.0.1") : socket_(socket(AF_INET, SOCK_STREAM, 0))
  {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, machine, &address.sin_addr);
    open_ = connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Connection()
  {
    if (socket_ >= 0)
      close(socket_);
  }
  Connection(Connection&& other) noexcept : socket_(std::exchange(other.socket_, -1)), open_(other.open_) {}
  Connection& operator=(Connection&&) = delete;

  /// Whether it was accepted.
  bool open() const { return open_; }

  /// As much as the other side takes at once.
  void send(std::string_view text) const { ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT); }
  /// All of it, as long as the other side takes it.
  void send_all(std::string_view text) const
  {
    while (!text.empty())
    {
      const ssize_t sent = ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
      if (sent <= 0)
        return;
      text.remove_prefix(static_cast<std::size_t>(sent));
    }
  }

  /// What comes until the other side closes, or until then.
  std::string receive(Clock::duration longest = std::chrono::seconds(20)) const
  {
    const auto until = Clock::now() + longest;
    std::string text;
    for (;;)
    {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
      pollfd fd{socket_, POLLIN, 0};
      if (left <= 0 || poll(&fd, 1, static_cast<int>(left)) <= 0)
        return text;
      char buffer[1 << 16];
      const ssize_t count = recv(socket_, buffer, sizeof buffer, 0);
      if (count <= 0)
        return text;
      text.append(buffer, static_cast<std::size_t>(count));
    }
  }

private:
  int socket_;
  bool open_ = false;
};

/// What a server answers.
struct HttpAnswer
{
  int status = 0; ///< 0: nothing came
  std::string head, body;
};

class View
{
public:
  struct Run
  {
    int code;
    std::string errors;
  };
  /// What it says on stderr, and how it ends by itself.
  static Run end_of(const std::vector<std::string>& options)
  {
    View view(options, false);
    const int code = view.process().wait().value_or(-1000);
    return {code, view.errors()};
  }

  /// Waits until it serves.
  explicit View(std::vector<std::string> options = {}, bool wait = true)
  {
    if (std::find(options.begin(), options.end(), "--port") == options.end())
      options.insert(options.begin(), {"--port", "0"});
    options.insert(options.begin(), {TORQUECTL, "view"});
    process_ = std::make_unique<Process>(options, folder_.file("view"), folder_.file("errors"));
    if (wait)
      REQUIRE(serves());
  }

  bool serves() const
  {
    return wait_for([&] { return read_file(folder_.file("view")).ends_with("\n"); });
  }
  Process& process() { return *process_; }
  int port() const
  {
    const std::string said = read_file(folder_.file("view"));
    return std::stoi(said.substr(said.find("127.0.0.1:") + 10));
  }
  std::string errors() const { return read_file(folder_.file("errors")); }

  std::string host() const { return fmt::format("Host: 127.0.0.1:{}\r\n", port()); }

  /// Asks with a request's lines, each of them ended.
  HttpAnswer ask(const std::string& lines) const
  {
    const Connection connection(port());
    connection.send_all(lines + "\r\n");
    const std::string text = connection.receive();
    const std::size_t end = text.find("\r\n\r\n");
    if (!text.starts_with("HTTP/1.") || end == std::string::npos)
      return {};
    return {std::stoi(text.substr(9)), text.substr(0, end + 2), text.substr(end + 4)};
  }
  HttpAnswer get(const std::string& path) const { return ask(fmt::format("GET {} HTTP/1.1\r\n{}", path, host())); }
  nlohmann::json document() const
  {
    const HttpAnswer answer = get("/document");
    REQUIRE(answer.status == 200);
    return nlohmann::json::parse(answer.body);
  }
  std::string robot() const { return document()["robot"]["name"].get<std::string>(); }

private:
  TemporaryFolder folder_;
  std::unique_ptr<Process> process_;
};

} // namespace torqued
