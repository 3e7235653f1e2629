#include "catch.h"
#include "process.h"
#include "temporary_folder.h"

#include "daemon/multicast_receiver.h"
#include "motion/files.h"

#include <algorithm>
#include <arpa/inet.h>
#include <chrono>
#include <fmt/format.h>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <poll.h>
#include <random>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

namespace multicast_receiver_process_test
{

using namespace torqued;
using namespace std::chrono_literals;
using namespace std::string_literals;

namespace
{

using Clock = std::chrono::steady_clock;

// Sends datagrams as they are.
class Sender
{
public:
  Sender() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0))
  {
    const unsigned char ttl = 0;
    REQUIRE(setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) == 0);
  }
  ~Sender() { close(fd_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  void send(std::string_view datagram, const char* address = "239.255.76.67") const
  {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(7667);
    inet_pton(AF_INET, address, &to.sin_addr);
    sendto(fd_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }

private:
  int fd_;
};

std::string short_message(const std::string& channel, const std::string& payload)
{
  return "LC02\0\0\0\1"s + channel + '\0' + payload;
}

// A part of a long message: its number, size, and the part's offset in it, number, and how many parts there are.
std::string fragment(std::uint32_t number, std::uint32_t size, std::uint32_t offset, std::uint16_t part,
                     std::uint16_t parts, const std::string& bytes)
{
  std::string datagram = "LC03";
  const auto append = [&datagram](std::uint32_t value, int width)
  {
    for (int shift = 8 * (width - 1); shift >= 0; shift -= 8)
      datagram += static_cast<char>(value >> shift & 0xff);
  };
  append(number, 4);
  append(size, 4);
  append(offset, 4);
  append(part, 2);
  append(parts, 2);
  return datagram + bytes;
}

// A receiver and all that it hands over.
class Ear
{
public:
  explicit Ear(const std::vector<std::string>& channels, const std::string& url = "") : receiver_(read_bus_url(url))
  {
    for (const std::string& channel : channels)
      REQUIRE(
          receiver_.subscribe(channel, [this, channel](Bytes bytes) { heard.push_back(channel + "=" + text(bytes)); }));
  }

  MulticastReceiver& receiver() { return receiver_; }
  // whether there is something for the process to do, within some time
  bool wakes(std::chrono::milliseconds within)
  {
    pollfd fd{receiver_.fd(), POLLIN, 0};
    return receiver_.holds() || poll(&fd, 1, static_cast<int>(within.count())) > 0;
  }
  void drain()
  {
    while (wakes(50ms))
      receiver_.take();
  }

  std::vector<std::string> heard;

private:
  static std::string text(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

  MulticastReceiver receiver_;
};

// A torqued that no library of LCM's in this process listens to: what it is sent would end this process.
class Daemon
{
public:
  Daemon() : receiver_(read_bus_url(""))
  {
    REQUIRE(receiver_.subscribe("TORQUED_STATUS", [this](Bytes bytes) { CHECK(decode(bytes, status_.emplace())); }));
    REQUIRE(next_status());
  }

  Process& process() { return process_; }
  // a status that is published from now on; nothing if none comes
  std::optional<status_t> next_status()
  {
    drain();
    status_.reset();
    const auto until = Clock::now() + 5s;
    while (!status_ && Clock::now() < until)
      drain();
    return status_;
  }
  long resident_kilobytes()
  {
    const std::string text = read_file(fmt::format("/proc/{}/status", process_.pid()));
    return std::stol(text.substr(text.find("VmRSS:") + 6));
  }

private:
  void drain()
  {
    pollfd fd{receiver_.fd(), POLLIN, 0};
    while (receiver_.holds() || poll(&fd, 1, 10) > 0)
      receiver_.take();
  }

  TemporaryFolder folder_;
  Process process_{{TORQUED, "--robot", "ck"}, folder_.file("out")};
  std::optional<status_t> status_;
  MulticastReceiver receiver_;
};

} // namespace

TEST_CASE("what LCM publishes on the subscribed channels is heard, in order and whole", "[multicast_receiver_process]")
{
  const std::string longest(63, 'x');
  Ear ear({"A", "AB", "PREFIX/ABCDE", longest});
  lcm::LCM bus("udpm://239.255.76.67:7667?ttl=0");
  std::vector<std::string> sent;
  const auto publish = [&](const std::string& channel, const std::string& payload)
  {
    REQUIRE(bus.publish(channel, payload.data(), static_cast<unsigned>(payload.size())) == 0);
    sent.push_back(channel + "=" + payload);
  };
  publish("A", "");
  publish("AB", "\0\1\2"s);
  publish("PREFIX/ABCDE", std::string(300, 'p'));
  publish(longest, std::string(60'000, 'l'));
  for (int i = 0; i < 100; ++i) // more than one system call brings
    publish(i % 2 == 0 ? "A" : "AB", std::to_string(i));
  ear.drain();
  CHECK(ear.heard == sent);
  CHECK(ear.receiver().most_lost() == 0);
}

TEST_CASE("what is on no subscribed channel, or is no short message, does not wake the process",
          "[multicast_receiver_process]")
{
  Ear ear({"TORQUED_DESIRED"});
  const Sender sender;
  for (const std::string& channel : {"TORQUED_DESIRE"s, "TORQUED_DESIRED2"s, "XTORQUED_DESIRED"s, "torqued_desired"s,
                                     ""s, "TORQUED"s, std::string(63, 'T'), std::string(1000, 'T')})
    sender.send(short_message(channel, "payload"));
  for (const std::string& datagram :
       {""s, "L"s, "LC02"s, "LC02\0\0\0\1"s, "LC02\0\0\0\1TORQUED_DESIRED"s, "LC01\0\0\0\1TORQUED_DESIRED\0"s,
        "lc02\0\0\0\1TORQUED_DESIRED\0"s, "LC03\0\0\0\1TORQUED_DESIRED\0"s,
        fragment(1, 20, 0, 0, 2, "TORQUED_DESIRED\0abc"s), std::string(60'000, 'L')})
    sender.send(datagram);
  // nor what is sent to this machine's own address, or to another group on the port that another program has joined
  const std::string good = short_message("TORQUED_DESIRED", "good");
  sender.send(good, "127.0.0.1");
  const Ear other({"TORQUED_DESIRED"}, "udpm://239.255.76.68:7667?ttl=0");
  sender.send(good, "239.255.76.68");
  CHECK_FALSE(ear.wakes(100ms));

  sender.send(good);
  ear.drain();
  CHECK(ear.heard == std::vector<std::string>{"TORQUED_DESIRED=good"});
  CHECK(ear.receiver().most_lost() == 0); // the system counted them all
}

TEST_CASE("what finds no room is counted, and what was not meant is not", "[multicast_receiver_process]")
{
  const Sender sender;
  {
    // also where the first messages ever heard are the ones that were lost
    Ear ear({"MINE"}, "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=1");
    for (int i = 0; i < 3000; ++i)
      sender.send(short_message("MINE", std::string(300, 'x')));
    ear.drain();
    CHECK(ear.heard.size() < 3000);
    sender.send(short_message("MINE", ""));
    ear.drain();
    CHECK(ear.heard.size() + static_cast<std::size_t>(ear.receiver().most_lost()) == 3001);
  }
  Ear ear({"MINE"}, "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=50000");
  constexpr std::size_t flood = 3000;
  const auto send = [&](const std::string& channel, std::size_t times)
  {
    for (std::size_t i = 0; i < times; ++i)
      sender.send(short_message(channel, std::string(300, 'x')));
  };
  send("FOREIGN", flood);
  send("MINE", 5);
  ear.drain();
  CHECK(ear.heard.size() == 5);
  CHECK(ear.receiver().most_lost() == 0);

  send("MINE", flood);
  ear.drain();
  const std::size_t heard = ear.heard.size() - 5;
  CHECK(heard < flood);
  send("MINE", 1); // tells how many there were before it
  ear.drain();
  CHECK(static_cast<std::size_t>(ear.receiver().most_lost()) == flood - heard);

  send("FOREIGN", flood);
  send("MINE", 5);
  ear.drain();
  CHECK(static_cast<std::size_t>(ear.receiver().most_lost()) == flood - heard);
}

TEST_CASE("fragments, and names of channels without number, neither end torqued nor fill its memory",
          "[multicast_receiver_process]")
{
  Daemon daemon;
  const Sender sender;
  // a second part that would be written far behind the message's end, one that never ends, and one that comes twice
  for (const std::string& channel : {"TORQUED_DESIRED"s, "TORQUED_STATUS"s, "ANOTHER"s})
  {
    const std::string named = channel + '\0' + std::string(10, 'x');
    sender.send(fragment(77, 1000, 0, 0, 2, named));
    sender.send(fragment(77, 1000, 0xfffffff0, 1, 2, std::string(32, 'y')));
    for (std::uint32_t i = 0; i < 100; ++i)
      sender.send(fragment(1000 + i, 5'000'000, 0, 0, 100, named + std::string(50'000, 'z')));
    sender.send(fragment(78, 20, 0, 0, 2, named));
    sender.send(fragment(78, 20, 0, 0, 2, named));
  }
  REQUIRE(daemon.next_status());
  const long before = daemon.resident_kilobytes();
  for (int i = 0; i < 100'000; ++i)
  {
    sender.send(short_message(fmt::format("JUNK_{}", i), ""));
    if (i % 5000 == 0)
      REQUIRE(daemon.next_status());
  }
  std::mt19937_64 random(1);
  for (int i = 0; i < 20'000; ++i)
  {
    std::string datagram = random() % 2 == 0 ? "LC02\0\0\0\1TORQUED_DESIRED\0"s : "LC03"s;
    datagram.resize(datagram.size() - random() % 4);
    for (std::uint64_t size = random() % 40; size > 0; --size)
      datagram += static_cast<char>(random() & 0xff);
    sender.send(datagram);
    if (i % 500 == 0)
      REQUIRE(daemon.next_status());
  }
  const std::optional<status_t> status = daemon.next_status();
  REQUIRE(status);
  CHECK(status->received > 500);
  CHECK(status->received == status->rejected);
  CHECK(daemon.resident_kilobytes() - before < 1000);
  daemon.process().signal(SIGTERM);
  CHECK(daemon.process().wait() == 0);
}

} // namespace multicast_receiver_process_test
