#include "bus/diagnosis.h"

#include "text/printable.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace torqued
{

namespace
{

constexpr const char* kWithinThisMachine =
    "sudo ip link set lo up multicast on; sudo ip route replace 224.0.0.0/4 dev lo";
constexpr const char* kAsRoot = "sudo --preserve-env=LCM_DEFAULT_URL \"$(command -v torquectl)\" doctor";

// What to type so that this bus is meant.
std::string set_url(const BusFacts& facts, const BusUrl& url)
{
  return fmt::format("{}'{}://{}:{}?ttl={}'",
                     facts.bus.set_by == "--lcm-url" ? "torquectl doctor --lcm-url " : "export LCM_DEFAULT_URL=",
                     url.provider == BusUrl::Provider::mpudpm ? "mpudpm" : "udpm", url.address, url.port, url.ttl);
}

const Interface* find(const BusFacts& facts, const std::string& name)
{
  const auto found = std::ranges::find(facts.interfaces, name, &Interface::name);
  return found == facts.interfaces.end() ? nullptr : &*found;
}

// An interface that leads to other machines; one that is up if there is any.
const Interface* outward(const BusFacts& facts)
{
  const Interface* found = nullptr;
  for (const Interface& one : facts.interfaces)
    if (!one.loopback && one.multicast && (found == nullptr || (one.up && !found->up)))
      found = &one;
  return found;
}

// How the bus's address gets a route to other machines.
std::string mend_outward(const BusFacts& facts, BusUrl url)
{
  if (const Interface* way_out = outward(facts))
    return fmt::format("sudo ip link set {0} up; sudo ip route replace 224.0.0.0/4 dev {0}", way_out->name);
  url.ttl = 0;
  return fmt::format("{}; {}", set_url(facts, url), kWithinThisMachine);
}

class Diagnosis
{
public:
  Diagnosis(const BusFacts& facts, const BusUrl& url) : facts_(facts), url_(url) {}

  std::vector<Finding> run()
  {
    if (url_.provider == BusUrl::Provider::tcpq)
      judge_server();
    else
      judge_multicast();
    judge_daemons();
    say(Finding::Grade::good, fmt::format("torquectl was built with LCM {}", facts_.lcm_version));
    return std::move(findings_);
  }

private:
  using Grade = Finding::Grade;

  void say(Grade grade, std::string text, std::string mend = "")
  {
    findings_.push_back({grade, std::move(text), std::move(mend)});
  }

  std::string who() const { return facts_.bus.set_by.empty() ? "by default" : "by " + facts_.bus.set_by; }

  void judge_server()
  {
    const std::string bus =
        fmt::format("{}, the bus is the server of LCM's at {} port {}", who(), url_.address, url_.port);
    if (facts_.socket_trouble.empty())
      say(Grade::good, bus + ", and it answers");
    else
      say(Grade::bad, fmt::format("{}, and it does not answer: {}", bus, facts_.socket_trouble),
          fmt::format("java -cp /usr/share/java/lcm.jar lcm.lcm.TCPService {}", url_.port));
  }

  void judge_multicast()
  {
    judge_ttl();
    if (judge_interface() && judge_socket())
      judge_message();
    judge_other_machines();
    judge_buffer();
  }

  void judge_ttl()
  {
    const std::string bus = fmt::format("{}, the bus is {} port {}, ttl {}", who(), url_.address, url_.port, url_.ttl);
    if (url_.ttl == 0)
      say(Grade::good, bus + ": it stays within this machine");
    else if (url_.ttl == 1)
      say(Grade::good, bus + ": it reaches the machines on the same network segment");
    else
    {
      BusUrl segment = url_;
      segment.ttl = 1;
      say(Grade::remark, bus + ": it passes routers, to machines that are nobody's business", set_url(facts_, segment));
    }
  }

  // Where messages go; false if nowhere.
  bool judge_interface()
  {
    if (!facts_.has_ip)
    {
      say(Grade::remark, "the program ip was not found, so interfaces and routes were not looked at",
          "sudo apt-get install iproute2");
      return true;
    }
    if (facts_.route.empty())
    {
      say(Grade::bad, fmt::format("no route leads to {}, so nothing can be sent", url_.address),
          url_.ttl == 0 ? kWithinThisMachine : mend_outward(facts_, url_));
      return false;
    }
    const Interface* interface = find(facts_, facts_.route);
    const bool loopback = interface != nullptr && interface->loopback;
    if (loopback && url_.ttl > 0)
      say(Grade::remark,
          fmt::format("messages go to {}, which leads to no other machine, although the ttl lets them", facts_.route),
          mend_outward(facts_, url_));
    else if (!loopback && url_.ttl == 0)
      say(Grade::remark,
          fmt::format("messages go by {}, although they stay within this machine: when it goes down, so does the bus",
                      facts_.route),
          kWithinThisMachine);
    else if (interface != nullptr && !interface->multicast)
      say(Grade::remark,
          fmt::format("messages go by {}, which lacks the flag MULTICAST: programs that look at it will not use it",
                      facts_.route),
          fmt::format("sudo ip link set {} multicast on", facts_.route));
    else
      say(Grade::good, fmt::format("messages go by {}", facts_.route));
    return true;
  }

  bool judge_socket()
  {
    if (facts_.socket_trouble.empty())
      return true;
    say(Grade::bad,
        fmt::format("port {} of {} cannot be used: {}; who has it:", url_.port, url_.address, facts_.socket_trouble),
        fmt::format("sudo ss --udp --listening --processes 'sport = :{}'", url_.port));
    return false;
  }

  void judge_message()
  {
    if (facts_.came_back)
      return say(Grade::good, "a message to this program itself came back: no firewall is in its way");
    const std::string what = facts_.send_trouble.empty()
                                 ? std::string("a message to this program itself did not come back")
                                 : fmt::format("no message can be sent ({})", facts_.send_trouble);
    if (!facts_.firewall)
      return say(Grade::bad, what + ": a firewall is in its way, or the interface; this user cannot see which rule",
                 facts_.is_root ? "sudo apt-get install nftables" : kAsRoot);
    if (facts_.firewall->empty())
      return say(Grade::bad, what + ", and no rule of nft's drops anything: look at the interface",
                 fmt::format("ip -statistics link show {}", facts_.route));
    std::string chains, mend;
    for (const DroppingChain& chain : *facts_.firewall)
    {
      const std::string name = fmt::format("{} {} {}", chain.family, chain.table, chain.chain);
      chains += (chains.empty() ? "" : ", ") + name;
      mend += fmt::format("{}sudo nft insert rule {} ip daddr {} accept", mend.empty() ? "" : "; ", name, url_.address);
    }
    say(Grade::bad, fmt::format("{}: the firewall is in its way, of which drop packets: {}", what, chains), mend);
  }

  // LCM's sockets take what comes to their port from any interface, whatever group or ttl it was sent by.
  void judge_other_machines()
  {
    const bool is_reached = !facts_.has_ip || std::ranges::any_of(facts_.interfaces, [](const Interface& one)
                                                                  { return one.up && !one.loopback; });
    if (url_.ttl > 0 || url_.provider != BusUrl::Provider::udpm || !is_reached || !facts_.came_back)
      return;
    const std::string what =
        fmt::format("ttl 0 holds back what is sent here, not what others send to port {}", url_.port);
    if (!facts_.firewall)
      say(Grade::remark, what + "; this user cannot see whether a firewall drops that",
          facts_.is_root ? "sudo apt-get install nftables" : kAsRoot);
    else if (facts_.keeps_others_out)
      say(Grade::good, fmt::format("a firewall keeps what other machines send off port {}", url_.port));
    else
      say(Grade::remark, what + ", and no rule of nft's drops that",
          fmt::format(
              "sudo nft add table inet torqued; sudo nft add chain inet torqued input '{{ type filter hook input "
              "priority 0; }}'; sudo nft add rule inet torqued input udp dport {} fib saddr type != local drop",
              url_.port));
  }

  void judge_buffer()
  {
    if (facts_.buffer_size == 0)
      return;
    // the system grants twice what a program asks for, and counts its own needs in that
    const std::int64_t granted = facts_.buffer_size / 2;
    if (url_.buffer_size && granted < *url_.buffer_size)
      return say(Grade::remark,
                 fmt::format("the bus asks for receive buffers of {} bytes, and gets {}", *url_.buffer_size, granted),
                 fmt::format("sudo sysctl --write net.core.rmem_max={}", *url_.buffer_size));
    if (facts_.buffer_messages == 0)
      return; // nothing reached it: what closes the bus, closes this way, too
    // a controller that asks and is answered a thousand times a second hears twice as many messages, its own among them
    constexpr int per_millisecond = 2, enough = 50; // ms
    const int lasts = facts_.buffer_messages / per_millisecond;
    const std::string holds = fmt::format(
        "a receive buffer has {} bytes and holds {} ms of samples and answers at 1 kHz", facts_.buffer_size, lasts);
    if (lasts >= enough)
      return say(Grade::good, holds);
    say(Grade::remark, holds + ": a process that is held up longer loses messages",
        "sudo sysctl --write net.core.rmem_max=2097152 net.core.rmem_default=2097152");
  }

  void judge_daemons()
  {
    std::set<std::string> judged;
    for (const Daemon& daemon : facts_.daemons)
    {
      if (!daemon.present() || !judged.insert(daemon.prefix).second)
        continue;
      const auto count = std::ranges::count_if(facts_.daemons, [&](const Daemon& other)
                                               { return other.present() && other.prefix == daemon.prefix; });
      const std::string channel = printable(daemon.prefix) + "TORQUED_STATUS";
      if (count == 1)
        say(Grade::good, fmt::format("one daemon on {}: torqued {}, {}", channel, printable(daemon.status.version),
                                     state_name(daemon.status.state)));
      else
        say(Grade::bad,
            fmt::format("{} daemons on {}: clients get {} answers to each sample; kill all but one, or give them "
                        "another --prefix",
                        count, channel, count),
            "pgrep --list-full --exact torqued");
    }
    if (!facts_.lcm_trouble.empty())
      say(Grade::bad, facts_.lcm_trouble);
    else if (judged.empty() && facts_.came_back)
      say(Grade::remark, "no daemon is heard on this bus, under any prefix", "torqued --robot ck");
  }

  const BusFacts& facts_;
  const BusUrl url_;
  std::vector<Finding> findings_;
};

} // namespace

std::vector<Finding> diagnose(const BusFacts& facts)
{
  if (const std::string fault = fault_between_processes(facts.bus); !fault.empty())
    return {{Finding::Grade::bad, fault, set_url(facts, BusUrl())}};
  return Diagnosis(facts, read_bus_url(facts.bus.url)).run();
}

} // namespace torqued
