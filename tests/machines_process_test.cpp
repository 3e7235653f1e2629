#include "catch.h"
#include "daemon_bench.h"
#include "logger.h"

#include <cstdlib>
#include <fmt/format.h>
#include <fstream>

namespace machines_process_test
{

using namespace torqued;

namespace
{

using namespace std::chrono_literals;

constexpr const char* kBus = "udpm://239.255.76.67:7667?ttl=1";

void shell(const std::string& command)
{
  CAPTURE(command);
  REQUIRE(std::system(command.c_str()) == 0);
}

// A machine on the same wire: a network of its own, with an interface that leads to this one's bridge.
class Machine
{
public:
  explicit Machine(int number) : keeper_({"unshare", "--net", "sleep", "300"}, folder_.file("out"))
  {
    // what `unshare` makes is there when it differs from this network
    const std::string mine = std::filesystem::read_symlink("/proc/self/ns/net").string();
    const auto until = std::chrono::steady_clock::now() + 5s;
    while (std::filesystem::read_symlink(network()).string() == mine && std::chrono::steady_clock::now() < until)
      std::this_thread::sleep_for(10ms);
    shell(fmt::format("ip link add wire{0} type veth peer name eth0 netns {1} && ip link set wire{0} master wires up",
                      number, keeper_.pid()));
    shell(fmt::format(
        "nsenter --net={} sh -c 'ip link set lo up && ip address add 10.76.67.{}/24 dev eth0 && ip link set "
        "eth0 up && ip route add 224.0.0.0/4 dev eth0'",
        network(), number));
  }

  // words that run a command there, on the bus of all machines
  std::vector<std::string> launcher() const
  {
    return {"env", fmt::format("LCM_DEFAULT_URL={}", kBus), "nsenter", "--net=" + network()};
  }
  std::vector<std::string> there(std::vector<std::string> command) const
  {
    const std::vector<std::string> words = launcher();
    command.insert(command.begin(), words.begin(), words.end());
    return command;
  }

private:
  std::string network() const { return fmt::format("/proc/{}/ns/net", keeper_.pid()); }

  TemporaryFolder folder_;
  Process keeper_;
};

// This machine, number 1, at the bridge between the others.
void join_wires()
{
  shell("ip link show wires > /dev/null 2>&1 || { ip link add wires type bridge mcast_snooping 0 && "
        "ip address add 10.76.67.1/24 dev wires && ip link set wires up && ip route replace 224.0.0.0/4 dev wires; }");
  setenv("LCM_DEFAULT_URL", kBus, 1);
}

} // namespace

TEST_CASE("daemon, client and logger on three machines: all is answered, and the log has all of it; two daemons with "
          "prefixes of their own share the bus",
          "[machines_process]")
{
  join_wires();
  const TemporaryFolder folder;
  const Machine daemons(2), loggers(3), clients(4);
  Bench bench({"--every-sample"}, daemons.launcher());
  REQUIRE(bench.model);
  Process human(daemons.there({TORQUED, "--robot", "human-subject01", "--every-sample", "--prefix", "human/"}),
                folder.file("human"));
  // how many answers the log has of a daemon with this prefix
  const auto logged = [&](const std::string& prefix)
  {
    Process exported(
        std::vector<std::string>{TORQUECTL, "export", folder.file("log"), "--prefix", prefix, "-o", folder.file("csv")},
        folder.file("out"));
    CHECK(exported.wait() == 0);
    std::ifstream csv(folder.file("csv"));
    std::ptrdiff_t lines = 0;
    for (std::string line; std::getline(csv, line);)
      lines += line.starts_with('#') ? 0 : 1;
    return lines - 1; // its heading
  };
  std::ptrdiff_t own = 0;
  std::ptrdiff_t humans = 0;
  // again, if the logger has lost what all others have heard
  for (int round = 0; round < 3 && !(own == 300 && humans == 447); ++round)
  {
    Logger logger(folder.file("log"), folder.file("logger"), loggers.launcher());
    // from this machine
    const std::size_t answered = bench.commands.size();
    for (int i = 0; i < 300; ++i)
      bench.send_one(bench.standing());
    CHECK(bench.commands.size() == answered + 300);
    CHECK(bench.rejections.empty());
    bench.hear_for(150ms);

    // and torquectl from a fourth one, to a second daemon whose channels are its own
    const std::size_t before = bench.disposed();
    Process send(clients.there({TORQUECTL, "send", TRAJECTORIES "/subject01-walk/walk.csv", "--prefix", "human/"}),
                 folder.file("send"));
    CHECK(send.wait() == 0);
    const std::string said = read_file(folder.file("send"));
    CAPTURE(said);
    CHECK(said.find("447 of 447 samples answered, 0 lost, 0 rejected") != std::string::npos);
    CHECK(bench.disposed() == before);
    bench.hear_for(1500ms); // the logger writes what it holds when it hears more: the next status
    logger.end();
    own = logged("");
    humans = logged("human/");
  }
  CHECK(own == 300);
  CHECK(humans == 447);
  CHECK(bench.output().find("another daemon") == std::string::npos);
  CHECK(read_file(folder.file("human")).find("another daemon") == std::string::npos);
  bench.check_account();
}

TEST_CASE("a daemon whose bus has ttl=0 hears no other machine, though they send to its group and by its wire",
          "[machines_process]")
{
  join_wires();
  const TemporaryFolder folder;
  const Machine other(5);
  Process eval({TORQUECTL, "eval", TRAJECTORIES "/subject01-walk/walk.csv", "-o", folder.file("walk.lcm")},
               folder.file("eval"));
  CAPTURE(read_file(folder.file("eval")));
  REQUIRE(eval.wait() == 0);
  for (const bool alone : {true, false})
  {
    CAPTURE(alone);
    Bench bench({"--lcm-url", fmt::format("udpm://239.255.76.67:7667?ttl={}", alone ? 0 : 1), "--every-sample",
                 "--robot", "human-subject01"});
    REQUIRE(bench.model);
    Process player(other.there({"lcm-logplayer", folder.file("walk.lcm")}), folder.file("player"));
    CHECK(player.wait() == 0);
    const std::int64_t received = bench.settled_status().received;
    CAPTURE(received, read_file(folder.file("player")));
    CHECK((alone ? received == 0 : received > 400));
    bench.hear_for(150ms);
    bench.send_one(bench.standing());
    CHECK(bench.settled_status().received == received + 1);
    CHECK(bench.statuses.back().answered > 0);
  }
}

TEST_CASE("what another machine sends to the port of a bus within this one is heard by LCM's clients, unless a rule "
          "drops it by "
          "where it comes from; one by its interface drops this machine's own",
          "[machines_process]")
{
  join_wires();
  const Machine other(5);
  setenv("LCM_DEFAULT_URL", "udpm://239.255.76.67:7667?ttl=0", 1);
  const auto set_rule = [](const std::string& rule)
  {
    shell("nft add table inet torqued && nft delete table inet torqued && nft add table inet torqued && "
          "nft add chain inet torqued input '{ type filter hook input priority 0; }' && "
          "nft add rule inet torqued input udp dport 7667 " +
          rule);
  };
  for (const std::string route : {"lo", "wires"})
  {
    CAPTURE(route);
    shell("ip link set lo up multicast on && ip route replace 224.0.0.0/4 dev " + route);
    set_rule("accept");
    Bench bench;
    REQUIRE(bench.model);
    const TemporaryFolder folder;
    // how many of ten messages a client of LCM's hears from the other machine; the daemon hears none
    lcm::LCM client;
    int heard = 0;
    client.subscribeFunction(
        "TORQUED_DESIRED", +[](const lcm::ReceiveBuffer*, const std::string&, int* count) { ++*count; }, &heard);
    const auto heard_by = [&](const std::string& address)
    {
      const std::int64_t before = bench.settled_status().received;
      while (client.handleTimeout(0) > 0)
      {
      }
      heard = 0;
      Process send(other.there({"python3", "-c",
                                fmt::format("import socket\ns = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)\n"
                                            "s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 1)\n"
                                            "for i in range(10):\n"
                                            "  s.sendto(b'LC02\\0\\0\\0\\0TORQUED_DESIRED\\0none', ('{}', 7667))\n",
                                            address)}),
                   folder.file("out"));
      REQUIRE(send.wait() == 0);
      bench.hear_for(200ms);
      while (client.handleTimeout(0) > 0)
      {
      }
      CHECK(bench.settled_status().received == before);
      return heard;
    };
    const auto answers_own = [&]
    {
      const std::size_t before = bench.commands.size();
      bench.send(bench.standing());
      bench.hear_for(200ms);
      return bench.commands.size() == before + 1;
    };
    CHECK(answers_own());
    CHECK(heard_by("10.76.67.1") == 10);
    CHECK(heard_by("239.255.76.67") == (route == "lo" ? 0 : 10));

    set_rule("fib saddr type != local drop");
    CHECK(heard_by("10.76.67.1") == 0);
    CHECK(heard_by("239.255.76.67") == 0);
    CHECK(answers_own());

    set_rule("iifname != lo drop");
    CHECK(answers_own() == (route == "lo"));
  }
  shell("nft delete table inet torqued");
}

} // namespace machines_process_test
