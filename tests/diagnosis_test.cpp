#include "catch.h"

#include "bus/diagnosis.h"

#include <algorithm>

namespace diagnosis_test
{

using namespace torqued;

namespace
{

using Grade = Finding::Grade;

// A machine on which nothing is wrong, with a bus of its own.
BusFacts healthy()
{
  BusFacts facts;
  facts.bus.url = "udpm://239.255.76.67:7667?ttl=0";
  facts.bus.set_by = "LCM_DEFAULT_URL";
  facts.has_ip = true;
  facts.interfaces = {{"lo", true, true, true}, {"wlan0", false, true, false}, {"eth0", true, true, false}};
  facts.route = "lo";
  facts.came_back = true;
  facts.firewall.emplace();
  facts.keeps_others_out = true;
  facts.buffer_size = 4194304;
  facts.buffer_messages = 3000;
  facts.daemons = {Daemon{"", status_t{}, 0.05, {}, {}}};
  facts.daemons[0].status.version = "0.1.0";
  facts.lcm_version = "1.3.1";
  return facts;
}

// The findings that are not good.
std::vector<Finding> troubles(const BusFacts& facts)
{
  std::vector<Finding> findings = diagnose(facts);
  findings.erase(
      std::remove_if(findings.begin(), findings.end(), [](const Finding& one) { return one.grade == Grade::good; }),
      findings.end());
  return findings;
}

// What is wrong, if one thing is.
Finding trouble(const BusFacts& facts)
{
  const std::vector<Finding> all = troubles(facts);
  REQUIRE(all.size() == 1);
  return all[0];
}

bool contains(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("a URL that leads nowhere is what is wrong, and the command names one that does", "[diagnosis]")
{
  for (const char* bad : {"239.255.76.67:7667", "udpm://239.255.76.67", "udpm://239.255.76.67:7667?ttl=300", "memq://",
                          "file:///home/me/walk.lcm", "tcpq://robot:7700"})
  {
    CAPTURE(bad);
    BusFacts facts = healthy();
    facts.bus.url = bad;
    CHECK(trouble(facts).grade == Grade::bad);
    CHECK(trouble(facts).text == fault_between_processes(facts.bus));
    CHECK(trouble(facts).mend == "export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'");
  }
}

TEST_CASE("a bus of LCM's server is judged by whether that answers", "[diagnosis]")
{
  BusFacts facts = healthy();
  facts.bus.url = "tcpq://127.0.0.1:7701";
  CHECK(troubles(facts).empty());
  facts.came_back = false;
  facts.socket_trouble = "Connection refused";
  facts.daemons.clear();
  CHECK(trouble(facts).grade == Grade::bad);
  CHECK(contains(trouble(facts).text, "127.0.0.1 port 7701, and it does not answer: Connection refused"));
  CHECK(contains(trouble(facts).mend, "TCPService 7701"));
}

TEST_CASE("nothing is wrong with a healthy machine", "[diagnosis]")
{
  CHECK(troubles(healthy()).empty());

  BusFacts outside = healthy();
  outside.bus.url = "udpm://239.255.76.67:7667?ttl=1";
  outside.route = "eth0";
  CHECK(troubles(outside).empty());
}

TEST_CASE("without a route the address gets one: within this machine, or by an interface that leads out", "[diagnosis]")
{
  BusFacts facts = healthy();
  facts.route = "";
  facts.came_back = false;
  facts.socket_trouble = "No such device"; // what follows from it is not said, too
  CHECK(trouble(facts).grade == Grade::bad);
  CHECK(trouble(facts).mend == "sudo ip link set lo up multicast on; sudo ip route replace 224.0.0.0/4 dev lo");

  facts.bus.url = "udpm://239.255.76.67:7667?ttl=1";
  CHECK(trouble(facts).mend == "sudo ip link set eth0 up; sudo ip route replace 224.0.0.0/4 dev eth0");
  facts.interfaces[2].up = facts.interfaces[2].multicast = false;
  CHECK(trouble(facts).mend == "sudo ip link set wlan0 up; sudo ip route replace 224.0.0.0/4 dev wlan0");
  facts.interfaces.resize(1);
  CHECK(contains(trouble(facts).mend, "ttl=0"));
}

TEST_CASE("interface and ttl fit each other", "[diagnosis]")
{
  BusFacts facts = healthy();
  facts.route = "eth0";
  CHECK(trouble(facts).grade == Grade::remark);
  CHECK(contains(trouble(facts).text, "when it goes down, so does the bus"));

  facts = healthy();
  facts.bus.url = "udpm://239.255.76.67:7667?ttl=1";
  CHECK(contains(trouble(facts).text, "no other machine"));
  CHECK(contains(trouble(facts).mend, "dev eth0"));

  facts = healthy();
  facts.interfaces[0].multicast = false;
  CHECK(trouble(facts).mend == "sudo ip link set lo multicast on");

  facts = healthy();
  facts.route = "eth0";
  facts.bus.url = "udpm://239.255.76.67:7667?ttl=3";
  CHECK(trouble(facts).mend == "export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=1'");
  facts.bus.set_by = "--lcm-url";
  CHECK(trouble(facts).mend == "torquectl doctor --lcm-url 'udpm://239.255.76.67:7667?ttl=1'");

  facts = healthy();
  facts.has_ip = false;
  facts.interfaces.clear();
  facts.route = "";
  CHECK(trouble(facts).grade == Grade::remark);
  CHECK(contains(trouble(facts).mend, "iproute2"));
}

TEST_CASE("a firewall is named as far as this user sees it", "[diagnosis]")
{
  BusFacts facts = healthy();
  facts.came_back = false;
  facts.firewall.reset();
  facts.daemons.clear();
  CHECK(contains(trouble(facts).mend, "sudo --preserve-env=LCM_DEFAULT_URL"));
  facts.is_root = true;
  CHECK(contains(trouble(facts).mend, "nftables"));

  facts.firewall.emplace();
  CHECK(contains(trouble(facts).mend, "ip -statistics link show lo"));
  facts.firewall = {{"ip", "filter", "INPUT"}, {"inet", "own", "in"}};
  facts.send_trouble = "Operation not permitted";
  CHECK(contains(trouble(facts).text, "(Operation not permitted)"));
  CHECK(trouble(facts).mend == "sudo nft insert rule ip filter INPUT ip daddr 239.255.76.67 accept; "
                               "sudo nft insert rule inet own in ip daddr 239.255.76.67 accept");
}

TEST_CASE("a bus within this machine that other machines can reach has a note, with the rule that keeps them out",
          "[diagnosis]")
{
  BusFacts facts = healthy();
  facts.keeps_others_out = false;
  facts.bus.url = "udpm://239.255.76.67:7668?ttl=0";
  CHECK(trouble(facts).grade == Grade::remark);
  CHECK(contains(trouble(facts).text, "not what others send to port 7668, and no rule of nft's drops that"));
  CHECK(trouble(facts).mend == "sudo nft add table inet torqued; "
                               "sudo nft add chain inet torqued input '{ type filter hook input priority 0; }'; "
                               "sudo nft add rule inet torqued input udp dport 7668 fib saddr type != local drop");
  // what this user cannot see
  facts.firewall.reset();
  CHECK(trouble(facts).grade == Grade::remark);
  CHECK(contains(trouble(facts).text, "this user cannot see"));
  CHECK(contains(trouble(facts).mend, "sudo --preserve-env=LCM_DEFAULT_URL"));
  facts.is_root = true;
  CHECK(contains(trouble(facts).mend, "nftables"));
  // where no other machine is, or where others are meant to be heard
  facts.interfaces.resize(1);
  CHECK(troubles(facts).empty());
  facts = healthy();
  facts.keeps_others_out = false;
  facts.bus.url = "udpm://239.255.76.67:7667?ttl=1";
  facts.route = "eth0";
  CHECK(troubles(facts).empty());
}

TEST_CASE("a port that another program holds", "[diagnosis]")
{
  BusFacts facts = healthy();
  facts.socket_trouble = "Address already in use";
  facts.came_back = false;
  facts.daemons.clear();
  CHECK(trouble(facts).grade == Grade::bad);
  CHECK(contains(trouble(facts).mend, "sport = :7667"));
}

TEST_CASE("what LCM itself says is not lost", "[diagnosis]")
{
  BusFacts facts = healthy();
  facts.daemons.clear();
  facts.lcm_trouble = "the LCM bus cannot be opened";
  CHECK(trouble(facts).grade == Grade::bad);
  CHECK(trouble(facts).text == facts.lcm_trouble);
}

TEST_CASE("receive buffers hold 50 ms of a stream, and as much as the URL asks for", "[diagnosis]")
{
  BusFacts facts = healthy();
  facts.buffer_messages = 100; // a sample and its answer in each millisecond
  CHECK(troubles(facts).empty());
  facts.buffer_messages = 98;
  CHECK(trouble(facts).grade == Grade::remark);
  CHECK(contains(trouble(facts).text, "49 ms"));
  CHECK(contains(trouble(facts).mend, "net.core.rmem_default"));
  facts.buffer_messages = 0; // a firewall kept them from it, which says nothing about the buffer
  CHECK(troubles(facts).empty());

  facts = healthy();
  facts.bus.url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";
  CHECK(troubles(facts).empty());
  facts.buffer_size = 425984;
  CHECK(contains(trouble(facts).text, "2097152 bytes, and gets 212992"));
  CHECK(trouble(facts).mend == "sudo sysctl --write net.core.rmem_max=2097152");
}

TEST_CASE("daemons: none is remarkable, two on the same channels are wrong, two with prefixes of their own are not",
          "[diagnosis]")
{
  BusFacts facts = healthy();
  facts.daemons.clear();
  CHECK(trouble(facts).grade == Grade::remark);

  facts = healthy();
  facts.daemons.push_back(facts.daemons[0]);
  CHECK(trouble(facts).grade == Grade::bad);
  CHECK(contains(trouble(facts).text, "2 daemons on TORQUED_STATUS"));
  facts.daemons[1].prefix = "left/";
  CHECK(troubles(facts).empty());
  facts.daemons[1].prefix = "";
  facts.daemons[1].status.state = status_t::STOPPING;
  CHECK(troubles(facts).empty());
}

} // namespace diagnosis_test
