#include "catch.h"
#include "daemon_bench.h"

#include <cstdlib>
#include <fmt/format.h>

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
  Process logger(loggers.there({"lcm-logger", "--quiet", folder.file("log")}), folder.file("logger"));
  bench.hear_for(500ms);

  // from this machine
  for (int i = 0; i < 300; ++i)
    bench.send_one(bench.standing());
  CHECK(bench.commands.size() == 300);
  CHECK(bench.rejections.empty());
  bench.hear_for(150ms);

  // and torquectl from a fourth one, to a second daemon whose channels are its own
  const std::size_t before = bench.disposed();
  Process human(daemons.there({TORQUED, "--robot", "human-subject01", "--every-sample", "--prefix", "human/"}),
                folder.file("human"));
  Process send(clients.there({TORQUECTL, "send", TRAJECTORIES "/subject01-walk/walk.csv", "--prefix", "human/"}),
               folder.file("send"));
  CHECK(send.wait() == 0);
  const std::string said = read_file(folder.file("send"));
  CAPTURE(said);
  CHECK(said.find("447 of 447 samples answered, 0 lost, 0 rejected") != std::string::npos);
  CHECK(bench.disposed() == before);
  CHECK(bench.output().find("another daemon") == std::string::npos);
  CHECK(read_file(folder.file("human")).find("another daemon") == std::string::npos);

  bench.hear_for(300ms);
  logger.signal(SIGTERM);
  logger.wait();
  Process all(std::vector<std::string>{TORQUECTL, "export", folder.file("log"), "-o", folder.file("csv")},
              folder.file("out"));
  CHECK(all.wait() == 0);
  const std::string csv = read_file(folder.file("csv"));
  CHECK(std::count(csv.begin(), csv.end(), '\n') >= 300);
  Process human_too({TORQUECTL, "export", folder.file("log"), "--prefix", "human/", "-o", folder.file("human.csv")},
                    folder.file("out"));
  CHECK(human_too.wait() == 0);
  const std::string human_csv = read_file(folder.file("human.csv"));
  CHECK(std::count(human_csv.begin(), human_csv.end(), '\n') >= 447);
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

} // namespace machines_process_test
