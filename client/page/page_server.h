/// Pages for the browsers of this machine, over HTTP.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace torqued
{

struct Page
{
  std::string path; ///< "/", "/document"
  std::string type; ///< Content-Type
  /// Makes what is served; called in the server's thread. What was made is served for the next 100 ms, so that many
  /// who ask neither cost much nor fill the memory.
  std::function<std::string()> text;
};

/// Serves pages at 127.0.0.1 alone, from a thread of its own, until its destructor, which waits for no connection.
///
/// Every connection is closed after one answer. At most kMostConnections are open: one more, and the oldest is closed.
/// So none waits for others, however slowly they send or read. Nothing but GET and HEAD is answered (405), no other
/// path (404), and nobody who does not address 127.0.0.1 or localhost by the Host header (403): another site's page
/// cannot read what is served, by whatever name it reaches this machine.
class PageServer
{
public:
  static constexpr unsigned kMostConnections = 100;

  /// port: 0 for any that is free. Throws Failure, failed, if it cannot be had.
  PageServer(std::vector<Page> pages, int port);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  int port() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace torqued
