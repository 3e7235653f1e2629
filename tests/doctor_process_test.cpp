#include "catch.h"
#include "daemon_bench.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <memory>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>

namespace doctor_process_test
{

using namespace torqued;

namespace
{

using namespace std::chrono_literals;
using Json = nlohmann::json;

constexpr const char* kWithin = "udpm://239.255.76.67:7667?ttl=0";
constexpr const char* kSegment = "udpm://239.255.76.67:7667?ttl=1";
constexpr const char* kBus = "ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo";
constexpr const char* kWire =
    "ip link set lo up && ip link add wire type veth peer name other && ip link set other up && "
    "ip address add 10.76.67.1/24 dev wire";

// A machine made by these commands sees the doctor, follows those of its commands that concern network, firewall and
// URL, without sudo, and sees it again.
class Patient
{
public:
  Patient(const std::string& url, const std::string& commands)
      : machine_({"unshare", "--net", "sh", "-c",
                  fmt::format(
                      R"(export LCM_DEFAULT_URL='{url}'; {commands} || exit 99
{torquectl} doctor > {before}; echo "exit $?" >> {before}
sed -n -e 's/sudo //g' -e '/^      [$] \(ip\|nft\|export\)/s/^      [$] //p' {before} > {mend}
set -e; . {mend}
{torquectl} doctor > {after}; echo "exit $?" >> {after})",
                      fmt::arg("url", url), fmt::arg("commands", commands), fmt::arg("torquectl", TORQUECTL),
                      fmt::arg("before", folder_.file("before")), fmt::arg("mend", folder_.file("mend")),
                      fmt::arg("after", folder_.file("after")))},
                 folder_.file("output"))
  {
  }
  // Waits until both saids are over.
  void finish()
  {
    const std::optional<int> code = machine_.wait();
    CAPTURE(read_file(folder_.file("output")));
    REQUIRE(code == 0);
  }
  // what the doctor said, before its commands were followed and after it
  std::string before() const { return read_file(folder_.file("before")); }
  std::string after() const { return read_file(folder_.file("after")); }

private:
  TemporaryFolder folder_;
  Process machine_;
};

struct Said
{
  std::optional<int> code;
  std::string text;
};

Said run(const std::vector<std::string>& command)
{
  const TemporaryFolder folder;
  Process process(command, folder.file("out"));
  const std::optional<int> code = process.wait();
  return {code, read_file(folder.file("out"))};
}

bool contains(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

// The line with this in it; empty if there is none.
std::string line_with(const std::string& text, const std::string& part)
{
  const std::size_t at = text.find(part);
  if (at == std::string::npos)
    return "";
  const std::size_t before = text.rfind('\n', at);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return text.substr(begin, text.find('\n', at) - begin);
}

} // namespace

TEST_CASE("the doctor finds what is wrong with a machine's bus, and its commands mend it", "[doctor_process]")
{
  struct Case
  {
    std::string url, commands, finding;
    bool wrong;
  };
  const std::string nft = "nft add table inet own && nft add chain inet own in '{ type filter hook ";
  const std::vector<Case> cases{
      {kWithin, "true", "no route leads to 239.255.76.67", true},
      {kWithin, "ip link set lo up && ip route add 224.0.0.0/4 dev lo", "lo, which lacks the flag MULTICAST", false},
      {kWithin, std::string(kWire) + " && ip link set wire up && ip route add default dev wire",
       "by wire, although they stay within this machine", false},
      {kWithin, std::string(kBus) + " && " + kWire + " && ip link set wire up", "and no rule of nft's drops that",
       false},
      {"udpm://239.255.76.67:7668?ttl=0",
       std::string(kBus) + " && " + kWire + " && ip link set wire up && " + nft +
           "input priority 0; }' && nft add rule inet own in udp dport 7667 fib saddr type != local drop",
       "what others send to port 7668, and no rule of nft's drops that", false},
      {kWithin,
       std::string(kWire) + " && ip link set wire up && ip route add 224.0.0.0/4 dev wire && " + nft +
           "input priority 0; }' && nft add rule inet own in iifname != lo udp dport 7667 drop",
       "did not come back: the firewall is in its way, of which drop packets: inet own in", true},
      {kSegment, kBus, "which leads to no other machine", false},
      {kSegment, std::string(kBus) + " && " + kWire, "which leads to no other machine", false},
      {kSegment, kWire, "no route leads to 239.255.76.67", true},
      {"udpm://239.255.76.67:7667?ttl=5",
       std::string(kWire) + " && ip link set wire up && ip route add default dev wire", "it passes routers", false},
      {"udpm://239.255.76.67:7667?tll=0", kBus, "LCM knows no option \"tll\"", true},
      {"udpm://239.255.76.67", kBus, "the port is missing", true},
      {"udpm://239.255.76.67:7667?ttl=300", kBus, "ttl is \"300\"", true},
      {"memq://", kBus, "stays within this process, where nobody else hears it", true},
      {kWithin, kBus + (" && " + nft) + "input priority 0; policy drop; }'", "did not come back", true},
      {kWithin, kBus + (" && " + nft) + "input priority 0; }' && nft add rule inet own in udp dport 7667 drop",
       "did not come back: the firewall is in its way, of which drop packets: inet own in", true},
      {kWithin, kBus + (" && " + nft) + "output priority 0; }' && nft add rule inet own in udp dport 7667 reject",
       "the firewall is in its way", true},
  };
  std::vector<std::unique_ptr<Patient>> patients;
  for (const Case& one : cases)
    patients.push_back(std::make_unique<Patient>(one.url, one.commands));
  for (std::size_t i = 0; i < cases.size(); ++i)
  {
    CAPTURE(cases[i].url, cases[i].commands);
    patients[i]->finish();
    const std::string before = patients[i]->before(), after = patients[i]->after();
    CAPTURE(before, after);
    CHECK(line_with(before, cases[i].finding).substr(0, 5) == (cases[i].wrong ? "WRONG" : "note "));
    CHECK(contains(before, cases[i].wrong ? "exit 1\n" : "exit 0\n"));
    CHECK(contains(after, "came back: no firewall is in its way"));
    CHECK(contains(after, "exit 0\n"));
    CHECK_FALSE(contains(after, "WRONG"));
    CHECK_FALSE(contains(after, cases[i].finding));
  }
}

TEST_CASE("of a bus by LCM's server the doctor says whether that answers", "[doctor_process]")
{
  const auto doctor = [](int port)
  {
    return run({TORQUECTL, "doctor", "--lcm-url", fmt::format("tcpq://127.0.0.1:{}", port)});
  };
  const Said nobody = doctor(1);
  CAPTURE(nobody.text);
  CHECK(nobody.code == 1);
  CHECK(contains(nobody.text, "WRONG by --lcm-url, the bus is the server of LCM's at 127.0.0.1 port 1, and it does not "
                              "answer: Connection refused\n      $ java -cp"));
  // what takes connections and says nothing
  const int silent = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  REQUIRE(bind(silent, reinterpret_cast<sockaddr*>(&address), length) == 0);
  REQUIRE(listen(silent, 1) == 0);
  REQUIRE(getsockname(silent, reinterpret_cast<sockaddr*>(&address), &length) == 0);
  const Said other = doctor(ntohs(address.sin_port));
  CAPTURE(other.text);
  CHECK(other.code == 1);
  CHECK(contains(other.text, "what listens there is no server of LCM's"));
  // and LCM's own
  Process server({"java", "-cp", "/usr/share/java/lcm.jar", "lcm.lcm.TCPService", "7702"}, "/dev/null");
  Said said = doctor(7702);
  for (int i = 0; i < 20 && contains(said.text, "Connection refused"); ++i)
  {
    std::this_thread::sleep_for(200ms);
    said = doctor(7702);
  }
  server.signal(SIGTERM);
  server.wait();
  CAPTURE(said.text);
  CHECK(said.code == 0);
  CHECK(contains(said.text, "port 7702, and it answers"));
  CHECK(contains(said.text, "note  no daemon is heard on this bus"));
  close(silent);
}

TEST_CASE("the doctor names a port that another program keeps for itself", "[doctor_process]")
{
  const int own = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);
  REQUIRE(bind(own, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0);
  const Said said = run({TORQUECTL, "doctor"});
  close(own);
  CAPTURE(said.text);
  CHECK(said.code == 1);
  CHECK(contains(said.text, "Address already in use"));
}

TEST_CASE("doctor and status know no daemon, one, two with prefixes, and two on the same channels", "[doctor_process]")
{
  const auto doctor = []
  {
    return run({TORQUECTL, "doctor"});
  };
  const auto status = [](std::vector<std::string> arguments)
  {
    arguments.insert(arguments.begin(), {TORQUECTL, "status", "--once"});
    return run(arguments);
  };
  Said said = doctor();
  CHECK(said.code == 0);
  CHECK(contains(said.text, "no daemon is heard"));
  said = status({});
  CHECK(said.code == 69);
  CHECK(contains(said.text, "no daemon is heard on TORQUED_STATUS, with or without a prefix"));

  Bench bench;
  REQUIRE(bench.model);
  bench.stream(50ms);
  const std::string received = fmt::format("{:>13}", bench.settled_status().received);
  const TemporaryFolder folder;
  Process other({TORQUED, "--robot", "rk", "--prefix", "other/", "--every-sample"}, folder.file("other"));
  bench.hear_for(500ms);
  said = doctor();
  CAPTURE(said.text);
  CHECK(said.code == 0);
  const std::string as_text = said.text;
  CHECK(contains(said.text, "one daemon on TORQUED_STATUS: torqued"));
  CHECK(contains(said.text, "one daemon on other/TORQUED_STATUS: torqued"));
  said = status({});
  CAPTURE(said.text);
  CHECK(said.code == 0);
  CHECK(contains(said.text, "ck, 45.0 kg, 6 joints, method constrained, the newest sample"));
  CHECK(contains(said.text, "rk, 45.0 kg, 6 joints, method constrained, every sample"));
  CHECK(contains(said.text, "in all   " + received));
  CHECK_FALSE(contains(said.text, "WRONG"));
  said = status({"--prefix", "other/"});
  CHECK_FALSE(contains(said.text, "ck, "));
  CHECK(contains(said.text, "rk, "));
  CHECK(status({"--prefix", "nobody/"}).code == 69);

  // the same for scripts
  const Json daemons = Json::parse(status({"--json"}).text);
  REQUIRE(daemons.size() == 2);
  CHECK(daemons[0]["prefix"] == "");
  CHECK(daemons[0]["robot"] == "ck");
  CHECK(daemons[0]["received"] == bench.settled_status().received);
  CHECK(daemons[0]["instance_id"] == bench.settled_status().instance_id);
  CHECK(daemons[1]["prefix"] == "other/");
  CHECK(daemons[1]["state"] == "WAITING");
  CHECK(daemons[1]["per_second"]["received"] == 0.0);
  // a daemon's status has the fields and the names that echo shows
  CHECK(daemons[0]["last_reason"].is_null());
  CHECK(daemons[0]["latency_us_p50"].get<double>() <= daemons[0]["latency_us_max"].get<double>());
  const Json findings = Json::parse(run({TORQUECTL, "doctor", "--json"}).text);
  CHECK(findings.size() > 4);
  for (const Json& finding : findings)
    CHECK(contains(as_text, finding["text"].get<std::string>().substr(0, 20)));

  Process second({TORQUED, "--robot", "ck"}, folder.file("second"));
  bench.hear_for(500ms);
  said = doctor();
  CAPTURE(said.text);
  CHECK(said.code == 1);
  CHECK(contains(said.text, "WRONG 2 daemons on TORQUED_STATUS"));
  CHECK(contains(status({}).text, "WRONG: 2 daemons share these channels"));
}

TEST_CASE("on a terminal status is live until Ctrl-C", "[doctor_process]")
{
  Bench bench;
  REQUIRE(bench.model);
  const TemporaryFolder folder;
  const Said said = run({"script", "--quiet", "--return", "--command",
                         "timeout --preserve-status --signal INT 2 " TORQUECTL " status", "/dev/null"});
  CAPTURE(said.text);
  CHECK(said.code == 0);
  int pages = 0;
  for (std::size_t at = said.text.find("\x1b[H"); at != std::string::npos; at = said.text.find("\x1b[H", at + 1))
    ++pages;
  CHECK(pages >= 3); // four a second, on a machine that may be slow
  CHECK(contains(said.text, "WAITING"));
}

} // namespace doctor_process_test
