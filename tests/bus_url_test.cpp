#include "catch.h"

#include "wire/bus_url.h"
#include "wire/packet.h"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace bus_url_test
{

using namespace torqued;

namespace
{

using Provider = BusUrl::Provider;

constexpr const char* kGood = "udpm://239.255.76.67:7667?ttl=0";

std::string complaint(const std::string& url)
{
  try
  {
    read_bus_url(url);
    return "";
  }
  catch (const std::invalid_argument& error)
  {
    return error.what();
  }
}

// LCM_DEFAULT_URL for a while; nullptr: unset.
class Preset
{
public:
  explicit Preset(const char* url)
  {
    if (const char* before = std::getenv(kName))
      before_ = before;
    url != nullptr ? setenv(kName, url, 1) : unsetenv(kName);
  }
  ~Preset() { before_ ? setenv(kName, before_->c_str(), 1) : unsetenv(kName); }
  Preset(const Preset&) = delete;
  Preset& operator=(const Preset&) = delete;

private:
  static constexpr const char* kName = "LCM_DEFAULT_URL";
  std::optional<std::string> before_;
};

} // namespace

TEST_CASE("a URL is read as LCM reads it", "[bus_url]")
{
  struct Row
  {
    const char* url;
    Provider provider;
    const char* address;
    int port, ttl;
  };
  for (const Row& row : std::vector<Row>{
           {"", Provider::udpm, "239.255.76.67", 7667, 0},
           {"udpm://", Provider::udpm, "239.255.76.67", 7667, 0},
           {"udpm://?ttl=2", Provider::udpm, "239.255.76.67", 7667, 2},
           {"udpm://224.1.2.3:1234?recv_buf_size=100000&ttl=255&transmit_only=true", Provider::udpm, "224.1.2.3", 1234,
            255},
           {"udpm://239.255.19523:0x1df3", Provider::udpm, "239.255.76.67", 7667, 0},
           {"udpm://239.255.76.67:7667/?ttl=1", Provider::udpm, "239.255.76.67", 7667, 1},
           {"udpm://239.255.76.67:7667?&ttl=1?", Provider::udpm, "239.255.76.67", 7667, 1},
           {"udpm://239.255.76.67:7667?ttl=1&ttl=2", Provider::udpm, "239.255.76.67", 7667, 2},
           {"mpudpm://239.255.76.68?nports=5", Provider::mpudpm, "239.255.76.68", 7667, 0},
           {"tcpq://", Provider::tcpq, "127.0.0.1", 7700, 0},
           {"tcpq://localhost:7701", Provider::tcpq, "127.0.0.1", 7701, 0},
           {"tcpq://10.76.67.1", Provider::tcpq, "10.76.67.1", 7700, 0},
       })
  {
    CAPTURE(row.url);
    const BusUrl bus = read_bus_url(row.url);
    CHECK(bus.provider == row.provider);
    CHECK(bus.address == row.address);
    CHECK(bus.port == row.port);
    CHECK(bus.ttl == row.ttl);
  }
  CHECK(read_bus_url("udpm://?recv_buf_size=2097152").buffer_size == 2097152);
  CHECK_FALSE(read_bus_url(kGood).buffer_size);
  CHECK(read_bus_url("memq://").provider == Provider::memq);
  CHECK(read_bus_url("file:///home/me/walk.lcm?mode=w").provider == Provider::file);
}

TEST_CASE("what LCM misunderstands in silence or looks for in vain is refused with what would be right", "[bus_url]")
{
  const std::string example = "; expected udpm://239.255.76.67:7667?ttl=0 or the like";
  const auto number = [](const char* what, int least, int most)
  {
    return fmt::format("{}; expected a whole number from {} to {}", what, least, most);
  };
  const auto group = [](const char* what)
  {
    return fmt::format("the address \"{}\" is no group of IPv4 multicast; expected one from 224.0.0.0 to "
                       "239.255.255.255",
                       what);
  };
  for (const auto& [url, says] : std::vector<std::pair<std::string, std::string>>{
           {"239.255.76.67:7667", "this is no URL of LCM's" + example},
           {"udpm:", "this is no URL of LCM's" + example},
           {"UDPM://", "LCM knows no \"UDPM\"" + example},
           {" udpm://", "LCM knows no \" udpm\"" + example},
           {"http://x", "LCM knows no \"http\"" + example},
           {"udpm://239.255.76.67", "the port is missing; expected udpm://239.255.76.67:7667 or the like"},
           {"udpm://224.1.2.3?ttl=1", "the port is missing; expected udpm://224.1.2.3:7667 or the like"},
           {"udpm://239.255.76.67:", number("the port is \"\"", 1, 65535)},
           {"udpm://239.255.76.67:0", number("the port is \"0\"", 1, 65535)},
           {"udpm://239.255.76.67:port", number("the port is \"port\"", 1, 65535)},
           {"udpm://239.255.76.67:7667x", number("the port is \"7667x\"", 1, 65535)},
           {"udpm://239.255.76.67:70000", number("the port is \"70000\"", 1, 65535)},
           {"udpm://239.255.76.67:99999999999999999999", number("the port is \"99999999999999999999\"", 1, 65535)},
           {"mpudpm://239.255.76.67:0", number("the port is \"0\"", 1, 65535)},
           {"udpm://:7667", group("")},
           {"udpm://10.0.0.1:7667", group("10.0.0.1")},
           {"udpm://localhost:7667", group("localhost")},
           {"udpm://[ff02::1]:7667", group("[ff02")},
           {"udpm://239.255.76.67:7667?ttl=", number("ttl is \"\"", 0, 255)},
           {"udpm://239.255.76.67:7667?ttl", number("ttl is \"\"", 0, 255)},
           {"udpm://239.255.76.67:7667?ttl=300", number("ttl is \"300\"", 0, 255)},
           {"udpm://239.255.76.67:7667?ttl=256", number("ttl is \"256\"", 0, 255)},
           {"udpm://239.255.76.67:7667?ttl=-1", number("ttl is \"-1\"", 0, 255)},
           {"udpm://239.255.76.67:7667?ttl=0,recv_buf_size=9", number("ttl is \"0,recv_buf_size=9\"", 0, 255)},
           {"udpm://239.255.76.67:7667?recv_buf_size=2M", number("recv_buf_size is \"2M\"", 0, 2147483647)},
           {"udpm://239.255.76.67:7667?tll=1", "LCM knows no option \"tll\"; expected ttl or recv_buf_size"},
           {"mpudpm://?port=1", "LCM knows no option \"port\"; expected ttl, recv_buf_size or nports"},
           {"tcpq://robot:7700",
            "the server is \"robot\", and LCM takes any name for this machine; expected its IPv4 address in figures"},
           {"tcpq://127.0.0.1:99999", number("the port is \"99999\"", 1, 65535)},
           {"file://", "the file's name is missing; expected file:///home/me/walk.lcm or the like"},
       })
  {
    CAPTURE(url);
    CHECK(complaint(url) == says);
  }
  // whatever it is, it is shown without what a terminal obeys, and cut
  for (const std::string& much : {std::string(1'000'000, 'x'), "\x1b[2J" + std::string(1'000'000, ' ')})
    for (const char* before : {"", "udpm://", "udpm://239.255.76.67:", "udpm://?", "udpm://?ttl=", "tcpq://"})
    {
      const std::string fault = fault_of({before + much, "--lcm-url"});
      CHECK(fault.size() < 1000);
      CHECK(fault.size() > 10);
      CHECK(fault.find('\x1b') == std::string::npos);
    }
}

TEST_CASE("the bus is that which was given, else that of LCM_DEFAULT_URL, else LCM's default", "[bus_url]")
{
  const auto chosen = [](const char* preset, const char* given)
  {
    const Preset set(preset);
    const ChosenBus bus = choose_bus(given, "--lcm-url");
    return std::pair(bus.url, bus.set_by);
  };
  using Bus = std::pair<std::string, std::string>;
  CHECK(chosen("memq://", kGood) == Bus(kGood, "--lcm-url"));
  CHECK(chosen(kGood, "") == Bus(kGood, "LCM_DEFAULT_URL"));
  CHECK(chosen("", "") == Bus("", ""));
  CHECK(chosen(nullptr, "") == Bus("", ""));
}

TEST_CASE("a fault says which bus was meant and by whom; between processes a queue within one or a log will not do",
          "[bus_url]")
{
  CHECK(fault_of({kGood, "--lcm-url"}).empty());
  CHECK(fault_of({}).empty());
  CHECK(fault_of({"udpm://239.255.76.67", "LCM_DEFAULT_URL"}) ==
        "LCM_DEFAULT_URL is \"udpm://239.255.76.67\": the port is missing; expected udpm://239.255.76.67:7667 or the "
        "like");
  for (const char* within : {"memq://", "file:///home/me/walk.lcm"})
  {
    CHECK(fault_of({within, "--lcm-url"}).empty());
    const std::string fault = fault_between_processes({within, "--lcm-url"});
    CAPTURE(fault);
    CHECK(fault.starts_with(fmt::format("--lcm-url is \"{}\": such a bus ", within)));
    CHECK(fault.ends_with("; expected udpm://239.255.76.67:7667?ttl=0 or the like"));
  }
  for (const char* between : {"", kGood, "mpudpm://", "tcpq://127.0.0.1:7700"})
    CHECK(fault_between_processes({between, "--lcm-url"}).empty());
  CHECK_FALSE(fault_between_processes({"udpm://239.255.76.67", "--lcm-url"}).empty());
}

TEST_CASE("what is said of a bus that does not work fits the bus", "[bus_url]")
{
  CHECK(bus_trouble(kGood, "--lcm-url").starts_with(fmt::format("--lcm-url is \"{}\". A bus within", kGood)));
  CHECK(bus_trouble("tcpq://127.0.0.1:7701")
            .starts_with(
                "lcm_url is \"tcpq://127.0.0.1:7701\". No server of LCM's answers at 127.0.0.1 port 7701: start one"));
  CHECK(bus_trouble("udpm://239.255.76.67")
            .ends_with("the port is missing; expected udpm://239.255.76.67:7667 or the like"));
  const Preset none("");
  CHECK(bus_trouble("").starts_with("neither --lcm-url nor LCM_DEFAULT_URL is set, so LCM's default was tried. A bus"));
}

TEST_CASE("a packet is what LCM sends for a short message, and nothing else is one", "[bus_url]")
{
  using namespace std::string_literals;
  const auto bytes_of = [](const std::string& text)
  {
    return std::as_bytes(std::span(text));
  };
  const std::string expected = "LC02\x01\x02\x03\x04"
                               "CHANNEL\0payload\0."s;
  const std::string payload = "payload\0."s;
  const std::vector<std::byte> made = make_packet(0x01020304, "CHANNEL", bytes_of(payload));
  CHECK(std::string(reinterpret_cast<const char*>(made.data()), made.size()) == expected);
  const std::optional<Packet> read = read_packet(made);
  REQUIRE(read);
  CHECK(read->channel == "CHANNEL");
  CHECK(std::equal(read->message.begin(), read->message.end(), bytes_of(payload).begin(), bytes_of(payload).end()));
  const std::string empty = "LC02\0\0\0\0C\0"s;
  REQUIRE(read_packet(bytes_of(empty)));
  CHECK(read_packet(bytes_of(empty))->message.empty());
  for (const std::string& none : {""s, "LC02"s, "LC02\0\0\0\0"s, "LC02\0\0\0\0CHANNEL"s, "LC03\0\0\0\0CHANNEL\0"s})
    CHECK(!read_packet(bytes_of(none)));
}

} // namespace bus_url_test
