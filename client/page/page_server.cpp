#include "page/page_server.h"

#include "motion/failure.h"

#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <fmt/format.h>
#include <map>
#include <microhttpd.h>
#include <netinet/in.h>
#include <new>
#include <string_view>
#include <strings.h>
#include <sys/socket.h>
#include <utility>

namespace torqued
{

namespace
{

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr const char* kAddress = "127.0.0.1";
constexpr auto kFresh = 100ms;
// connections that are on their way out beside those that are kept
constexpr unsigned kMargin = 50;
constexpr unsigned kIdle = 10;                  // s, after which a connection is closed
constexpr std::size_t kRequestSize = 16 * 1024; // bytes, the most that a request's line and headers take

} // namespace

// libmicrohttpd calls everything here but constructor and destructor in its one thread.
class PageServer::Implementation
{
public:
  Implementation(std::vector<Page> pages, int port)
  {
    for (Page& page : pages)
      pages_.push_back({std::move(page), nullptr, {}});
    MHD_add_response_header(not_allowed_.get(), "Allow", "GET, HEAD");

    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    daemon_ = MHD_start_daemon(MHD_USE_EPOLL_INTERNAL_THREAD, 0, nullptr, nullptr, &Implementation::handle, this,
                               MHD_OPTION_SOCK_ADDR, &address, MHD_OPTION_CONNECTION_LIMIT, kMostConnections + kMargin,
                               MHD_OPTION_CONNECTION_TIMEOUT, kIdle, MHD_OPTION_CONNECTION_MEMORY_LIMIT, kRequestSize,
                               MHD_OPTION_NOTIFY_CONNECTION, &Implementation::count, this, MHD_OPTION_END);
    if (!daemon_)
      throw Failure(ExitCode::failed,
                    "--port: {} of {} cannot be had, is another program there? 0 takes any that is free", port,
                    kAddress);
    port_ = MHD_get_daemon_info(daemon_, MHD_DAEMON_INFO_BIND_PORT)->port;
  }
  ~Implementation() { MHD_stop_daemon(daemon_); }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  int port() const { return port_; }

private:
  struct Destroy
  {
    void operator()(MHD_Response* response) const { MHD_destroy_response(response); }
  };
  using Response = std::unique_ptr<MHD_Response, Destroy>;

  static Response make_response(const std::string& text, const char* type)
  {
    // libmicrohttpd copies the text, and does not write to it
    Response response(
        MHD_create_response_from_buffer(text.size(), const_cast<char*>(text.data()), MHD_RESPMEM_MUST_COPY));
    if (!response)
      throw std::bad_alloc();
    for (const auto& [name, value] :
         {std::pair("Content-Type", type), std::pair("Cache-Control", "no-store"), std::pair("Connection", "close")})
      MHD_add_response_header(response.get(), name, value);
    return response;
  }

  struct Served
  {
    Page page;
    Response response;
    Clock::time_point made;
  };

  static MHD_Result handle(void* self, MHD_Connection* connection, const char* path, const char* method, const char*,
                           const char*, std::size_t*, void**) noexcept
  {
    try
    {
      const auto [status, response] = static_cast<Implementation*>(self)->answer(connection, path, method);
      return MHD_queue_response(connection, status, response);
    }
    catch (const std::exception&)
    {
      return MHD_NO; // closes this connection
    }
  }

  std::pair<unsigned, MHD_Response*> answer(MHD_Connection* connection, std::string_view path, std::string_view method)
  {
    if (!addresses_this_machine(connection))
      return {MHD_HTTP_FORBIDDEN, forbidden_.get()};
    if (method != MHD_HTTP_METHOD_GET && method != MHD_HTTP_METHOD_HEAD)
      return {MHD_HTTP_METHOD_NOT_ALLOWED, not_allowed_.get()};
    for (Served& served : pages_)
      if (served.page.path == path)
        return {MHD_HTTP_OK, fresh(served)};
    return {MHD_HTTP_NOT_FOUND, not_found_.get()};
  }

  bool addresses_this_machine(MHD_Connection* connection) const
  {
    std::vector<std::string> hosts;
    const auto keep = [](void* found, MHD_ValueKind, const char* name, const char* value) noexcept
    {
      if (strcasecmp(name, MHD_HTTP_HEADER_HOST) == 0)
        static_cast<std::vector<std::string>*>(found)->emplace_back(value ? value : "");
      return MHD_YES;
    };
    MHD_get_connection_values(connection, MHD_HEADER_KIND, keep, &hosts);
    return hosts.size() == 1 && (hosts.front() == fmt::format("{}:{}", kAddress, port()) ||
                                 hosts.front() == fmt::format("localhost:{}", port()));
  }

  static MHD_Response* fresh(Served& served)
  {
    if (const auto now = Clock::now(); !served.response || now - served.made > kFresh)
    {
      served.response = make_response(served.page.text(), served.page.type.c_str());
      served.made = now;
    }
    return served.response.get();
  }

  // Keeps those that are open by the order in which they came. A connection's context is its number in that order.
  static void count(void* self, MHD_Connection* connection, void** context,
                    MHD_ConnectionNotificationCode code) noexcept
  {
    auto& [open, number] = static_cast<Implementation*>(self)->connections_;
    if (code == MHD_CONNECTION_NOTIFY_CLOSED)
    {
      open.erase(reinterpret_cast<std::uintptr_t>(*context));
      return;
    }
    *context = reinterpret_cast<void*>(++number);
    open[number] = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    if (open.size() > kMostConnections)
    {
      // the library then finds it closed by the other side
      shutdown(open.begin()->second, SHUT_RDWR);
      open.erase(open.begin());
    }
  }

  struct Connections
  {
    std::map<std::uintptr_t, MHD_socket> open;
    std::uintptr_t last = 0;
  };

  std::vector<Served> pages_;
  Response forbidden_ = make_response("torquectl view answers only to 127.0.0.1 and localhost\n", "text/plain");
  Response not_allowed_ = make_response("only GET is answered here\n", "text/plain");
  Response not_found_ = make_response("there is no such page here\n", "text/plain");
  Connections connections_;
  std::atomic<int> port_ = -1;
  MHD_Daemon* daemon_ = nullptr;
};

PageServer::PageServer(std::vector<Page> pages, int port)
    : implementation_(std::make_unique<Implementation>(std::move(pages), port))
{
}

PageServer::~PageServer() = default;

int PageServer::port() const
{
  return implementation_->port();
}

} // namespace torqued
