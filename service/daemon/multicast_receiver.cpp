#include "daemon/multicast_receiver.h"

#include "wire/packet.h"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <linux/filter.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <string_view>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>

namespace torqued
{

namespace
{

constexpr std::size_t kLongestDatagram = 65'536;
// Bytes that the buffer shall have, as far as the system grants them: its default is that for one slow program. And
// those that it has at least: with room for less than some dozens of samples any of them might be the last that found
// some.
constexpr int kBuffer = 1 << 20;
constexpr int kLeastBuffer = 1 << 16;
// Where a datagram's payload begins for a filter, behind UDP's header.
constexpr std::uint32_t kPayload = 8;

template <typename Value> void set(int fd, int level, int option, const Value& value)
{
  if (setsockopt(fd, level, option, &value, sizeof value) != 0)
    throw std::system_error(errno, std::generic_category());
}

// A datagram in the buffer of a socket takes at most so many bytes of it: what stands before and after the payload, and
// what the system's allocator rounds up. Only one that comes in fragments of IP of less than 24 bytes takes more.
std::int64_t room_of(std::size_t size)
{
  return 2 * static_cast<std::int64_t>(size) + 2048;
}

std::uint32_t big_endian(std::string_view bytes)
{
  std::uint32_t number = 0;
  for (const char byte : bytes)
    number = number << 8 | static_cast<unsigned char>(byte);
  return number;
}

// Goes on behind the program if the bytes at this place are these. Each second instruction leaves it if not: its caller
// says by jf how far.
std::vector<sock_filter> compare(std::uint32_t at, std::string_view bytes)
{
  std::vector<sock_filter> program;
  while (!bytes.empty())
  {
    const std::size_t width = bytes.size() >= 4 ? 4 : bytes.size() >= 2 ? 2 : 1;
    const std::uint16_t size = width == 4 ? BPF_W : width == 2 ? BPF_H : BPF_B;
    program.push_back({static_cast<std::uint16_t>(BPF_LD | BPF_ABS | size), 0, 0, at});
    program.push_back({BPF_JMP | BPF_JEQ | BPF_K, 0, 0, big_endian(bytes.substr(0, width))});
    bytes.remove_prefix(width);
    at += static_cast<std::uint32_t>(width);
  }
  return program;
}

} // namespace

struct MulticastReceiver::Batch
{
  static constexpr std::size_t kMost = 32;

  Batch() : bytes(kMost * kLongestDatagram)
  {
    for (std::size_t i = 0; i < kMost; ++i)
    {
      parts[i] = {bytes.data() + i * kLongestDatagram, kLongestDatagram};
      messages[i].msg_hdr.msg_iov = &parts[i];
      messages[i].msg_hdr.msg_iovlen = 1;
      messages[i].msg_hdr.msg_control = controls[i].bytes.data();
    }
  }

  struct alignas(cmsghdr) Control
  {
    std::array<std::byte, CMSG_SPACE(sizeof(std::uint32_t))> bytes;
  };
  std::vector<std::byte> bytes;
  std::array<iovec, kMost> parts{};
  std::array<Control, kMost> controls{};
  std::array<mmsghdr, kMost> messages{};
};

MulticastReceiver::MulticastReceiver(const BusUrl& url)
    : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)), only_this_machine_(url.ttl == 0),
      batch_(std::make_unique<Batch>())
{
  if (fd_ < 0)
    throw std::system_error(errno, std::generic_category());
  try
  {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(url.port));
    inet_pton(AF_INET, url.address.c_str(), &address.sin_addr);
    set(fd_, SOL_SOCKET, SO_REUSEADDR, 1); // others on this machine listen, too
    set(fd_, SOL_SOCKET, SO_RCVBUF,
        url.buffer_size.value_or(0) > 0 ? std::max(*url.buffer_size, kLeastBuffer) : kBuffer);
    set(fd_, SOL_SOCKET, SO_RXQ_OVFL, 1);
    int room = 0;
    socklen_t size = sizeof room;
    getsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &room, &size);
    room_ = room / 4 * 3; // the system gives back what was read not before it is a fourth
    // nothing passes until a channel is subscribed to
    std::vector<sock_filter> program = filter();
    set(fd_, SOL_SOCKET, SO_ATTACH_FILTER, sock_fprog{static_cast<std::uint16_t>(program.size()), program.data()});
    // bound to the group's address, it hears what was sent there, and nothing that was sent to this machine's
    if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::system_error(errno, std::generic_category());
    ip_mreq membership{};
    membership.imr_multiaddr = address.sin_addr; // by the interface to which the route leads
    set(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, membership);
  }
  catch (...)
  {
    close(fd_);
    throw;
  }
}

MulticastReceiver::~MulticastReceiver()
{
  close(fd_);
}

bool MulticastReceiver::subscribe(const std::string& channel, Handler handler)
{
  subscriptions_.push_back({channel, std::move(handler)});
  std::vector<sock_filter> program = filter();
  const sock_fprog attached{static_cast<std::uint16_t>(program.size()), program.data()};
  return setsockopt(fd_, SOL_SOCKET, SO_ATTACH_FILTER, &attached, sizeof attached) == 0;
}

// A program of the system's for each datagram. What is looked for beyond a datagram's end refuses it.
std::vector<sock_filter> MulticastReceiver::filter() const
{
  constexpr sock_filter refuse{BPF_RET | BPF_K, 0, 0, 0};
  constexpr sock_filter take{BPF_RET | BPF_K, 0, 0, std::numeric_limits<std::uint32_t>::max()};
  std::vector<sock_filter> program{
      {BPF_LD | BPF_W | BPF_ABS, 0, 0, kPayload}, {BPF_JMP | BPF_JEQ | BPF_K, 1, 0, kPacketMagic}, refuse};
  if (only_this_machine_)
  {
    // a multicast that comes back to its own machine says so, or comes by the interface that leads nowhere else
    const auto ancillary = [](int what)
    {
      return static_cast<std::uint32_t>(SKF_AD_OFF + what);
    };
    program.insert(program.end(), {{BPF_LD | BPF_W | BPF_ABS, 0, 0, ancillary(SKF_AD_PKTTYPE)},
                                   {BPF_JMP | BPF_JEQ | BPF_K, 3, 0, PACKET_LOOPBACK},
                                   {BPF_LD | BPF_W | BPF_ABS, 0, 0, ancillary(SKF_AD_IFINDEX)},
                                   {BPF_JMP | BPF_JEQ | BPF_K, 1, 0, if_nametoindex("lo")},
                                   refuse});
  }
  for (const Subscription& subscription : subscriptions_)
  {
    const std::string_view with_zero(subscription.channel.c_str(), subscription.channel.size() + 1);
    std::vector<sock_filter> name = compare(kPayload + kPacketHeader, with_zero);
    // a channel's name is short, so that its end is within the reach of a jump
    for (std::size_t i = 1; i < name.size(); i += 2)
      name[i].jf = static_cast<std::uint8_t>(name.size() - i);
    name.push_back(take);
    program.insert(program.end(), name.begin(), name.end());
  }
  program.push_back(refuse);
  return program;
}

bool MulticastReceiver::take()
{
  if (next_ == read_)
  {
    // where the batch had room left, nothing waited any more, and what came since is for the next time
    const bool drained = 0 < read_ && read_ < Batch::kMost;
    if (drained)
      next_ = read_ = 0;
    if (drained || !read_batch())
      return false;
  }
  const mmsghdr& message = batch_->messages[next_++];
  const iovec& part = *message.msg_hdr.msg_iov;
  hand_over(Bytes(static_cast<const std::byte*>(part.iov_base), message.msg_len));
  return true;
}

bool MulticastReceiver::read_batch()
{
  if (read_ < Batch::kMost)
    waiting_ = 0;
  for (mmsghdr& message : batch_->messages)
    message.msg_hdr.msg_controllen = sizeof(Batch::Control::bytes);
  const int read = recvmmsg(fd_, batch_->messages.data(), Batch::kMost, MSG_DONTWAIT, nullptr);
  next_ = 0;
  read_ = static_cast<std::size_t>(std::max(read, 0));
  for (std::size_t i = 0; i < read_; ++i)
  {
    waiting_ += room_of(batch_->messages[i].msg_len);
    msghdr& header = batch_->messages[i].msg_hdr;
    std::uint32_t lost = lost_; // the system says nothing as long as that is zero
    for (cmsghdr* control = CMSG_FIRSTHDR(&header); control != nullptr; control = CMSG_NXTHDR(&header, control))
      if (control->cmsg_level == SOL_SOCKET && control->cmsg_type == SO_RXQ_OVFL)
        std::memcpy(&lost, CMSG_DATA(control), sizeof lost);
    count_lost(lost);
  }
  return read_ > 0;
}

// The system counts up to the moment when a message came. Between two messages it can have lost some only if the buffer
// may have been full meanwhile; else its filter refused them.
void MulticastReceiver::count_lost(std::uint32_t lost)
{
  const auto more = static_cast<std::int32_t>(lost - lost_); // the count wraps
  if (may_have_lost_)
    most_lost_ += std::max(more, 0);
  may_have_lost_ = waiting_ >= room_;
  lost_ = lost;
}

void MulticastReceiver::hand_over(Bytes datagram) const
{
  const std::optional<Packet> packet = read_packet(datagram);
  if (!packet)
    return;
  for (const Subscription& subscription : subscriptions_)
    if (packet->channel == subscription.channel)
      return subscription.handler(packet->message);
}

} // namespace torqued
