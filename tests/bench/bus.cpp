#include "bench/bus.h"

#include "bench/line.h"
#include "bench/servers.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <sched.h>
#include <sys/prctl.h>
#include <thread>
#include <time.h>

namespace torqued::bench
{

namespace
{

using namespace std::chrono_literals;

// Every server has a port of its own, so that none hears another's traffic.
constexpr int kTorqued = 7701, kLcmEcho = 7702, kUdpEcho = 7703, kUdpClient = 7704, kMany = 7710;
constexpr int kServers = 20; // of one kind at once, on ports from kMany on

double percentile(std::vector<double>& values, double share)
{
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

// Puts this thread, and what it starts from then on, on one core; on all again in the end. Where the scheduler once
// puts two processes, they stay, and whether that is one core or two makes more difference than what they do.
class Cores
{
public:
  Cores() { sched_getaffinity(0, sizeof all_, &all_); }
  ~Cores() { sched_setaffinity(0, sizeof all_, &all_); }
  Cores(const Cores&) = delete;
  Cores& operator=(const Cores&) = delete;

  /// nth: of those that there are, modulo their number.
  void use(int nth) const
  {
    cpu_set_t one;
    CPU_ZERO(&one);
    for (int core = 0, left = nth % CPU_COUNT(&all_); left >= 0; ++core)
      if (CPU_ISSET(core, &all_) && left-- == 0)
        CPU_SET(core, &one);
    sched_setaffinity(0, sizeof one, &one);
  }

private:
  cpu_set_t all_;
};

// A server, its client, and how long its replies took (µs).
struct Measured
{
  std::string name;
  Process server;
  std::unique_ptr<Line> line;
  std::vector<double> took;

  Measured(std::string its_name, const std::vector<std::string>& command)
      : name(std::move(its_name)), server(command, "/dev/null")
  {
  }

  void meet(std::unique_ptr<Line> its_line)
  {
    line = std::move(its_line);
    line->reach(name);
  }

  // Asks for that long, once per period; 0: as soon as the last one was answered. What is not answered took as long as
  // it was waited for.
  void ask(Clock::duration duration, Clock::duration period)
  {
    const auto begin = Clock::now();
    for (auto next = begin; next < begin + duration; next = std::max(next + period, Clock::now()))
    {
      std::this_thread::sleep_until(next);
      const auto sent = Clock::now();
      line->ask(microseconds(sent), sent + 100ms);
      took.push_back(std::chrono::duration<double, std::micro>(Clock::now() - sent).count());
    }
  }
};

std::unique_ptr<Line> torqued_line()
{
  return std::make_unique<LcmLine>(url(kTorqued), torque_command_t::getHash());
}

std::unique_ptr<Line> lcm_echo_line()
{
  return std::make_unique<LcmLine>(url(kLcmEcho), desired_state_t::getHash());
}

// torqued's account, the first that it gives from now on
status_t status_at(int port)
{
  lcm::LCM bus(url(port));
  std::optional<status_t> status;
  const auto hear = [](const lcm_recv_buf_t* buffer, const char*, void* heard)
  {
    status_t said;
    if (decode(received_bytes(buffer->data, buffer->data_size), said))
      *static_cast<std::optional<status_t>*>(heard) = said;
  };
  lcm_subscribe(bus.getUnderlyingLCM(), Channels().status.c_str(), hear, &status);
  for (int i = 0; i < 100 && !status; ++i)
    bus.handleTimeout(100);
  if (!status)
    throw std::runtime_error("torqued says no status");
  return *status;
}

// Sends samples, twenty per millisecond, and hears as many replies as come. Returns how many came.
int flood(Line& line, int samples)
{
  Sample sample;
  const std::int64_t first = microseconds(Clock::now());
  int heard = 0;
  const auto hear_until = [&](Clock::time_point until)
  {
    const auto message = line.hear(until);
    heard += message && line.is_reply(*message) && number_at(*message, kUtime) >= first ? 1 : 0;
    return message.has_value();
  };
  std::int64_t utime = first;
  auto next = Clock::now();
  for (int sent = 0; sent < samples; next += 1ms)
  {
    for (int i = 0; i < 20 && sent < samples; ++i, ++sent)
      line.send(sample.at(utime = std::max(utime + 1, microseconds(Clock::now()))));
    while (Clock::now() < next + 1ms)
      hear_until(next + 1ms);
  }
  while (hear_until(Clock::now() + 300ms))
  {
  }
  return heard;
}

// ns of processor time that a process has had so far
double processor_time(pid_t pid)
{
  clockid_t clock;
  timespec time{};
  if (clock_getcpuclockid(pid, &clock) == 0)
    clock_gettime(clock, &time);
  return 1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec);
}

// What twenty servers of one kind, each on a port of its own, made of a thousand samples per second each.
struct Served
{
  double sent;              // per second
  double answered;          // share of them, %
  std::vector<double> took; // µs
  double servers, client;   // cores that they kept busy
};

// command: of a server, by its port
Served serve_many(const std::function<std::vector<std::string>(int port)>& command, bool quick)
{
  constexpr Clock::duration period = 1ms;
  struct Server
  {
    Process process;
    Packets packets;
  };
  const Channels channels;
  Sample sample;
  std::vector<std::unique_ptr<Server>> servers;
  std::vector<pollfd> fds;
  std::vector<double> took;
  took.reserve(100'000);

  // Waits for replies until then, of servers from that one on; into took goes how long each was under way, µs.
  const auto hear = [&](Clock::time_point until, std::size_t first = 0)
  {
    const timespec left = Line::time_left(until);
    int ready = ppoll(fds.data() + first, fds.size() - first, &left, nullptr);
    for (std::size_t i = first; ready > 0 && i < fds.size(); ++i)
      if (fds[i].revents != 0)
      {
        --ready;
        const Bytes reply = Packets::message_of(servers[i]->packets.receive());
        took.push_back(static_cast<double>(microseconds(Clock::now()) - number_at(reply, kUtime)));
      }
  };
  const auto send = [&](Server& server)
  {
    server.packets.publish(channels.desired, sample.at(microseconds(Clock::now())));
  };

  for (int i = 0; i < kServers; ++i)
  {
    const int port = kMany + i;
    servers.push_back(std::unique_ptr<Server>(new Server{Process(command(port), "/dev/null"), Packets(port, port)}));
    Packets& packets = servers.back()->packets;
    packets.filter(channels.command.find("COMMAND"), 'C'); // its own samples, and statuses, come back, too
    fds.push_back({packets.fd(), POLLIN, 0});
    took.clear();
    for (int tries = 0; took.empty(); ++tries)
    {
      if (tries == 5000)
        throw std::runtime_error("one of twenty servers does not answer");
      send(*servers.back());
      hear(Clock::now() + 2ms, servers.size() - 1);
    }
  }
  while (const std::size_t late = took.size())
  {
    hear(Clock::now() + 50ms);
    if (took.size() == late)
      took.clear();
  }

  const auto processor_times = [&]
  {
    double sum = 0.0;
    for (const auto& server : servers)
      sum += processor_time(server->process.pid());
    return sum;
  };
  prctl(PR_SET_TIMERSLACK, 1);
  const double servers_before = processor_times(), client_before = processor_time(getpid());
  const auto begin = Clock::now(), end = begin + (quick ? 50ms : 2000ms);
  std::size_t sent = 0;
  // one after the other, evenly spread; a client that stood still does not send what it missed
  for (auto next = begin; next < end; next = std::max(next + period / kServers, Clock::now() - period))
  {
    while (Clock::now() < next)
      hear(next);
    send(*servers[sent++ % kServers]);
  }
  const double ns = std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
  const double servers_time = processor_times() - servers_before,
               client_time = processor_time(getpid()) - client_before;
  for (const auto until = Clock::now() + 100ms; Clock::now() < until;)
    hear(until);
  prctl(PR_SET_TIMERSLACK, 0);
  const auto all = static_cast<double>(sent);
  return {1e9 * all / ns, 100.0 * static_cast<double>(took.size()) / all, std::move(took), servers_time / ns,
          client_time / ns};
}

} // namespace

void measure_round_trips(Rounds& rounds, bool quick)
{
  struct Pace
  {
    const char* group;
    Clock::duration period, slice;
    std::vector<std::pair<const char*, double>> percentiles;
  };
  const std::vector<std::pair<const char*, double>> few{{"p50", 0.5}, {"p99", 0.99}};
  const std::vector<std::pair<const char*, double>> many{{"p50", 0.5}, {"p99", 0.99}, {"p99.9", 0.999}};
  const std::vector<Pace> paces{{"round trip, 100 Hz", 10ms, 100ms, few},
                                {"round trip, 1 kHz", 1ms, 500ms, many},
                                {"round trip, back to back", 0ms, 100ms, many}};
  const Cores cores;
  cores.use(1);
  Measured torqued("torqued", torqued_command(url(kTorqued)));
  Measured lcm_echo("LCM echo", lcm_echo_command(url(kLcmEcho)));
  Measured udp_echo("UDP echo", udp_echo_command(kUdpEcho, kUdpClient));
  cores.use(0);
  torqued.meet(torqued_line());
  lcm_echo.meet(lcm_echo_line());
  udp_echo.meet(std::make_unique<UdpLine>(kUdpClient, kUdpEcho));
  const std::array servers{&torqued, &lcm_echo, &udp_echo};

  for (const Pace& pace : paces)
  {
    // short slices of each in turn, so that what else the machine does meets all alike
    for (Measured* server : servers)
      server->took.clear();
    for (std::size_t slice = 0; slice < (quick ? 1 : 16); ++slice)
      for (std::size_t i = 0; i < servers.size(); ++i)
        servers[slice % 2 == 0 ? i : servers.size() - 1 - i]->ask(quick ? 20ms : pace.slice, pace.period);
    for (Measured* server : servers)
      for (const auto& [name, share] : pace.percentiles)
        rounds.add(pace.group, fmt::format("{} {}", server->name, name), "us", percentile(server->took, share));
    if (pace.period <= 1ms)
      for (const char* name : {"p50", "p99"})
        rounds.promise({pace.group, fmt::format("torqued {}", name), fmt::format("LCM echo {}", name), 1.10});
  }
}

void measure_flood(Rounds& rounds, bool quick)
{
  const std::string group = "20,000 samples/s";
  const int samples = quick ? 400 : 20'000;
  const auto percent = [samples](std::int64_t count)
  {
    return 100.0 * static_cast<double>(count) / samples;
  };
  rounds.add(group, "sent", "samples", samples);

  Measured echo("LCM echo", lcm_echo_command(url(kLcmEcho)));
  echo.meet(lcm_echo_line());
  const double echo_lost = percent(samples - flood(*echo.line, samples));
  Measured torqued("torqued", torqued_command(url(kTorqued), {"--every-sample"}));
  torqued.meet(torqued_line());
  const status_t before = status_at(kTorqued);
  const int heard = flood(*torqued.line, samples);
  const status_t after = status_at(kTorqued);

  const std::int64_t received = after.received - before.received;
  const std::int64_t disposed = after.answered + after.rejected - before.answered - before.rejected;
  const double lost = percent(samples - heard);
  rounds.add(group, "LCM echo: lost", "%", echo_lost);
  rounds.add(group, "torqued: lost", "%", lost);
  rounds.add(group, "  before it heard them", "%", percent(samples - received));
  rounds.add(group, "  by itself", "%", percent(received - disposed));
  rounds.add(group, "  on the way back", "%", percent(disposed - heard));
  rounds.add(group, "torqued: lost more", "% points", lost - echo_lost);
  rounds.promise({group, "torqued: lost more", "", 0.01});
  rounds.promise({group, "  by itself", "", 0.0});
}

void measure_many(Rounds& rounds, bool quick)
{
  const std::string group = "20 daemons, 1 kHz each";
  // every sample, because one that a newer one has overtaken is else dropped, however much time is left
  Served torqued = serve_many([](int port) { return torqued_command(url(port), {"--every-sample"}); }, quick);
  Served echo = serve_many([](int port) { return lcm_echo_command(url(port)); }, quick);
  for (const auto& [name, served] : {std::pair("torqued", &torqued), std::pair("LCM echo", &echo)})
  {
    if (served->took.empty())
      throw std::runtime_error("twenty servers answered nothing");
    const auto add = [&rounds, &group, name = name](const char* what, const char* unit, double value)
    {
      rounds.add(group, fmt::format("{} {}", name, what), unit, value);
    };
    const double per_answer = 1e6 * served->servers / (0.01 * served->answered * served->sent); // µs
    add("sent", "1/s", served->sent);
    add("answered", "%", served->answered);
    add("p50", "us", percentile(served->took, 0.5));
    add("p99", "us", percentile(served->took, 0.99));
    add("processor", "cores", served->servers);
    add("processor per answer", "us", per_answer);
    add("processor, client", "cores", served->client);
    add("on one core", "servers", 1e3 / per_answer);
  }
  rounds.promise({group, "torqued answered", "", 99.9, true});
  rounds.promise({group, "torqued sent", "", 0.95 * 1000.0 * kServers, true});
  rounds.promise({group, "torqued processor per answer", "LCM echo processor per answer", 1.3});
}

} // namespace torqued::bench
