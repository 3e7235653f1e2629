/// UDP multicast on bare sockets, within this machine, in LCM's format for short messages.
#pragma once

#include "wire/packet.h"

#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <linux/filter.h>
#include <optional>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>

namespace torqued::bench
{

inline constexpr const char* kGroup = "239.255.76.67";

/// The LCM bus at that port of the group, which does not leave this machine.
inline std::string url(int port)
{
  return std::string("udpm://") + kGroup + ":" + std::to_string(port) + "?ttl=0";
}

/// Hears one port of the group and sends to one. Throws std::system_error where the network does not allow that.
class Packets
{
public:
  Packets(int hears, int sends_to) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)), to_(address(sends_to))
  {
    const sockaddr_in here = address(hears);
    const ip_mreq group{here.sin_addr, {htonl(INADDR_ANY)}};
    const unsigned char ttl = 0;
    const int buffer = 1 << 21;
    set(SOL_SOCKET, SO_REUSEADDR, 1);
    set(SOL_SOCKET, SO_RCVBUF, buffer);
    set(IPPROTO_IP, IP_MULTICAST_TTL, ttl);
    set(IPPROTO_IP, IP_ADD_MEMBERSHIP, group);
    if (bind(fd_, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0)
      fail();
  }
  ~Packets() { close(fd_); }
  Packets(const Packets&) = delete;
  Packets& operator=(const Packets&) = delete;

  int fd() const { return fd_; }

  void send(Bytes packet)
  {
    if (sendto(fd_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_) < 0)
      fail();
  }
  /// Waits for a packet. The view lives until the next call.
  Bytes receive()
  {
    const ssize_t size = recv(fd_, buffer_.data(), buffer_.size(), 0);
    if (size < 0)
      fail();
    return Bytes(buffer_.data(), static_cast<std::size_t>(size));
  }

  /// From now on hears only messages whose channel has this character there; the others wake nobody.
  void filter(std::size_t place, char character)
  {
    const auto offset = static_cast<std::uint32_t>(8 + kPacketHeader + place); // 8: of UDP
    std::array<sock_filter, 4> program{
        {BPF_STMT(BPF_LD | BPF_B | BPF_ABS, offset),
         BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(character), 0, 1),
         BPF_STMT(BPF_RET | BPF_K, 0xffffffff), BPF_STMT(BPF_RET | BPF_K, 0)}};
    set(SOL_SOCKET, SO_ATTACH_FILTER, sock_fprog{program.size(), program.data()});
  }

  /// As LCM does.
  void publish(std::string_view channel, Bytes message) { send(make_packet(sequence_++, channel, message)); }
  /// What a short message carries; no bytes: it is none.
  static Bytes message_of(Bytes packet)
  {
    const std::optional<Packet> read = read_packet(packet);
    return read ? read->message : Bytes();
  }

private:
  static sockaddr_in address(int port)
  {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, kGroup, &result.sin_addr);
    return result;
  }
  template <typename Value> void set(int level, int option, const Value& value)
  {
    if (setsockopt(fd_, level, option, &value, sizeof value) != 0)
      fail();
  }
  [[noreturn]] static void fail() { throw std::system_error(errno, std::generic_category(), "UDP multicast"); }

  int fd_;
  sockaddr_in to_;
  std::uint32_t sequence_ = 0;
  std::array<std::byte, 65536> buffer_;
};

} // namespace torqued::bench
