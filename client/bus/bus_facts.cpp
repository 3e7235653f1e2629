#include "bus/bus_facts.h"

#include "wire/packet.h"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <set>
#include <span>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace torqued
{

namespace
{

using Json = nlohmann::ordered_json;

// What a program prints as JSON; null if it is not here, fails, or prints none. The folders are those where Debian
// keeps such programs, which not every user's PATH has.
Json ask(const std::string& command)
{
  const std::string line = "PATH=$PATH:/usr/sbin:/sbin " + command + " 2>/dev/null";
  std::FILE* const pipe = popen(line.c_str(), "r");
  if (pipe == nullptr)
    return {};
  std::string text;
  std::array<char, 4096> part;
  while (const std::size_t size = std::fread(part.data(), 1, part.size(), pipe))
    text.append(part.data(), size);
  if (pclose(pipe) != 0)
    return {};
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? Json() : json;
}

void look_at_interfaces(const BusUrl& url, BusFacts& facts)
{
  const Json links = ask("ip -json link show");
  facts.has_ip = links.is_array();
  if (!facts.has_ip)
    return;
  for (const Json& link : links)
  {
    const Json flags = link.value("flags", Json::array());
    const auto has = [&](const char* flag)
    {
      return std::ranges::find(flags, flag) != flags.end();
    };
    facts.interfaces.push_back({link.value("ifname", ""), has("UP"), has("MULTICAST"), has("LOOPBACK")});
  }
  const Json routes = ask("ip -json route get " + url.address);
  if (routes.is_array() && !routes.empty())
    facts.route = routes.front().value("dev", "");
}

bool drops(const Json& expressions)
{
  return std::ranges::any_of(expressions,
                             [](const Json& one) { return one.contains("drop") || one.contains("reject"); });
}

// Whether a rule drops what comes to a port over UDP, or all of it but for something: for what comes from this machine.
bool keeps_off(const Json& expressions, int port)
{
  const auto lets_port_through = [port](const Json& one)
  {
    if (!one.contains("match"))
      return false;
    const Json& match = one["match"];
    const Json left = match.value("left", Json()), right = match.value("right", Json());
    const Json payload = left.is_object() ? left.value("payload", Json()) : Json();
    const bool is_port = payload.is_object() && payload.value("field", "") == "dport" && right == port;
    const bool is_udp = right == "udp";
    return match.value("op", "") != "!=" && !is_port && !is_udp;
  };
  return drops(expressions) && std::ranges::none_of(expressions, lets_port_through);
}

// Chains of nft's whose packets could be ours, and that drop or reject some, or call others that do; and whether one
// keeps off what other machines send.
void look_at_firewall(int port, BusFacts& facts)
{
  const Json answer = ask("nft --json list ruleset");
  if (!answer.is_object() || !answer.contains("nftables"))
    return;
  const auto table_of = [](const Json& item)
  {
    return std::pair(item.value("family", ""), item.value("table", ""));
  };
  // which chain calls which is not followed: where one drops something, all of its table are under suspicion
  std::set<std::pair<std::string, std::string>> dropping_tables, guarding_tables;
  std::vector<DroppingChain> chains;
  for (const Json& item : answer["nftables"])
  {
    if (!item.contains("rule"))
      continue;
    const Json& rule = item["rule"];
    const Json expressions = rule.value("expr", Json::array());
    if (drops(expressions))
      dropping_tables.insert(table_of(rule));
    if (keeps_off(expressions, port))
      guarding_tables.insert(table_of(rule));
  }
  for (const Json& item : answer["nftables"])
  {
    if (!item.contains("chain"))
      continue;
    const Json& chain = item["chain"];
    const std::string hook = chain.value("hook", ""), name = chain.value("name", "");
    const std::string family = chain.value("family", "");
    const bool for_ip = family == "ip" || family == "inet" || family == "netdev";
    if (!for_ip || hook.empty() || hook == "forward")
      continue;
    const bool drops_the_rest = chain.value("policy", "") == "drop";
    if ((hook == "input" || hook == "ingress") && (drops_the_rest || guarding_tables.count(table_of(chain)) != 0))
      facts.keeps_others_out = true;
    if (drops_the_rest || dropping_tables.count(table_of(chain)) != 0)
      chains.push_back({family, chain.value("table", ""), name});
  }
  facts.firewall = std::move(chains);
}

class Socket
{
public:
  Socket() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~Socket()
  {
    if (fd_ >= 0)
      close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  int fd() const { return fd_; }
  template <typename Value> bool set(int level, int option, const Value& value)
  {
    return setsockopt(fd_, level, option, &value, sizeof(value)) == 0;
  }
  bool bind_to(sockaddr_in address) { return bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0; }
  bool send_to(sockaddr_in address, const std::string& bytes)
  {
    return sendto(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&address),
                  sizeof(address)) >= 0;
  }
  /// The next packet that waits; empty if none does.
  std::string receive()
  {
    std::array<char, 65536> packet;
    const ssize_t size = recv(fd_, packet.data(), packet.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(packet.data(), static_cast<std::size_t>(size)) : std::string();
  }

private:
  int fd_;
};

sockaddr_in socket_address(in_addr_t network_order, int port)
{
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = network_order;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

// Sends a message by the way that LCM's take, and waits until it comes back, for half a second.
void look_at_message(const BusUrl& url, BusFacts& facts)
{
  const in_addr_t group = inet_addr(url.address.c_str());
  Socket in, out;
  ip_mreq join{};
  join.imr_multiaddr.s_addr = group;
  if (!in.set(SOL_SOCKET, SO_REUSEADDR, 1) || !in.bind_to(socket_address(htonl(INADDR_ANY), url.port)) ||
      !in.set(IPPROTO_IP, IP_ADD_MEMBERSHIP, join) || out.fd() < 0)
  {
    facts.socket_trouble = std::strerror(errno);
    return;
  }
  // nobody listens to this channel
  const std::string mine = fmt::format("{:016x}", random_id());
  const std::vector<std::byte> bytes = make_packet(0, "TORQUECTL_DOCTOR", std::as_bytes(std::span(mine)));
  const std::string sent(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  out.set(IPPROTO_IP, IP_MULTICAST_TTL, static_cast<unsigned char>(url.ttl));
  if (!out.send_to(socket_address(group, url.port), sent))
  {
    facts.send_trouble = std::strerror(errno);
    return;
  }
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::milliseconds(500);
  while (!facts.came_back && Clock::now() < until)
  {
    pollfd fd{in.fd(), POLLIN, 0};
    if (poll(&fd, 1, 20) > 0)
      facts.came_back = in.receive() == sent;
  }
}

// Greets the bus's server as LCM does, and waits for its greeting for a second.
void look_at_server(const BusUrl& url, BusFacts& facts)
{
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const timeval patience{1, 0};
  setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience)); // connect() heeds it, too
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  const sockaddr_in address = socket_address(inet_addr(url.address.c_str()), url.port);
  const std::string greeting("\x28\x76\x17\xfb\x00\x00\x01\x00", 8), expected("\x28\x76\x17\xfa", 4);
  std::array<char, 8> answer{};
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
    facts.socket_trouble = errno == EINPROGRESS ? "nobody takes the connection" : std::strerror(errno);
  else if (send(fd, greeting.data(), greeting.size(), MSG_NOSIGNAL) < 0 ||
           recv(fd, answer.data(), answer.size(), MSG_WAITALL) < static_cast<ssize_t>(answer.size()) ||
           std::string(answer.data(), expected.size()) != expected)
    facts.socket_trouble = "what listens there is no server of LCM's";
  facts.came_back = facts.socket_trouble.empty();
  close(fd);
}

// Fills a buffer like that of LCM's sockets with messages of the size of ours, and counts them.
void look_at_buffer(const BusUrl& url, BusFacts& facts)
{
  Socket in, out;
  if (url.buffer_size)
    in.set(SOL_SOCKET, SO_RCVBUF, *url.buffer_size);
  socklen_t size = sizeof(facts.buffer_size);
  getsockopt(in.fd(), SOL_SOCKET, SO_RCVBUF, &facts.buffer_size, &size);
  sockaddr_in address = socket_address(htonl(INADDR_LOOPBACK), 0);
  in.bind_to(address);
  socklen_t length = sizeof(address);
  getsockname(in.fd(), reinterpret_cast<sockaddr*>(&address), &length);
  // one of each goes by for each sample: with seven coordinates and six motors some 300 bytes
  const std::string message(300, 'x');
  constexpr int most = 20'000;
  for (int i = 0; i < most && out.send_to(address, message); ++i)
  {
  }
  while (!in.receive().empty())
    ++facts.buffer_messages;
}

} // namespace

BusFacts look_at_bus(const std::string& lcm_url)
{
  BusFacts facts;
  facts.bus = choose_bus(lcm_url, "--lcm-url");
  facts.lcm_version = fmt::format("{}.{}.{}", LCM_MAJOR_VERSION, LCM_MINOR_VERSION, LCM_MICRO_VERSION);
  facts.is_root = geteuid() == 0;
  if (!fault_between_processes(facts.bus).empty())
    return facts;
  const BusUrl url = read_bus_url(facts.bus.url);
  if (url.provider == BusUrl::Provider::tcpq)
  {
    look_at_server(url, facts);
    return facts;
  }
  look_at_interfaces(url, facts);
  look_at_message(url, facts);
  look_at_firewall(url.port, facts);
  look_at_buffer(url, facts);
  return facts;
}

} // namespace torqued
