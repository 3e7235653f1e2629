#include "catch.h"
#include "decode_dynamics.h"

#include "daemon/lcm_loop.h"
#include "daemon/lcm_receiver.h"
#include "robot/files/load.h"

#include <chrono>
#include <cstring>
#include <memory>
#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>
#include <sstream>
#include <sys/eventfd.h>
#include <unistd.h>

namespace lcm_loop_test
{

using namespace torqued;

namespace
{

// LCM's, with losses as a test has them.
class LossyReceiver : public LcmReceiver
{
public:
  using LcmReceiver::LcmReceiver;
  std::int64_t most_lost() const override { return lost; }
  bool subscribe(const std::string& channel, Handler handler) override
  {
    return LcmReceiver::subscribe(channel,
                                  [this, channel, handler](Bytes bytes)
                                  {
                                    if (channel != "TORQUED_STATUS" || !loses_statuses)
                                      handler(bytes);
                                  });
  }

  std::int64_t lost = 0;
  bool loses_statuses = false;
};

// A loop and a listener on one bus inside this process.
class Bench
{
public:
  explicit Bench(const Config& config = {})
      : channels_(config.prefix), log_("test", sink_), loop_(bus_, receiver_, robot_, config, log_, surroundings())
  {
    for (const std::string& channel :
         {channels_.command, channels_.rejected, channels_.status, channels_.model, channels_.dynamics})
      bus_.subscribeFunction(channel, &Bench::hear, this);
    bus_.subscribeFunction("SLEEP", &Bench::sleep, this);
    loop_.listen();
  }

  const Robot& robot() const { return robot_; }
  LcmLoop& loop() { return loop_; }

  desired_state_t standing(std::int64_t utime, std::int64_t stream_id = 1) const
  {
    desired_state_t desired{};
    desired.utime = utime;
    desired.stream_id = stream_id;
    desired.left_contact = desired.right_contact = desired_state_t::SOLE;
    desired.num_coordinates = robot_.num_coordinates();
    desired.q.resize(7);
    desired.v = desired.a = desired.q;
    return desired;
  }

  void send(const desired_state_t& desired)
  {
    std::vector<std::byte> buffer;
    send(encode(desired, buffer));
  }
  void send(Bytes bytes) { bus_.publish(channels_.desired, bytes.data(), static_cast<unsigned>(bytes.size())); }

  void ask(std::int64_t request_id, std::int32_t num_coordinates = 7)
  {
    dynamics_request_t request{};
    request.request_id = request_id;
    request.num_coordinates = num_coordinates;
    request.q.resize(static_cast<std::size_t>(num_coordinates));
    request.v = request.a = request.q;
    std::vector<std::byte> buffer;
    const Bytes bytes = encode(request, buffer);
    bus_.publish(channels_.dynamics_request, bytes.data(), static_cast<unsigned>(bytes.size()));
  }

  // the process stands still for this long (µs) while the loop deals with its messages
  void send_sleep(int us) { bus_.publish("SLEEP", &us, sizeof us); }

  // lets the loop work until it has nothing more to do, and this listener has heard all it said
  void settle()
  {
    loop_.cycle(0.0);
    while (bus_.handleTimeout(0) > 0)
    {
    }
  }

  std::vector<torque_command_t> commands;
  std::vector<rejection_t> rejections;
  std::vector<status_t> statuses;
  std::vector<model_info_t> models;
  std::vector<dynamics_t> dynamics;
  int healthy = 0;
  std::string log() const { return lines_.str(); }
  lcm::LCM& bus() { return bus_; }
  LossyReceiver& receiver() { return receiver_; }

private:
  LcmLoop::Surroundings surroundings()
  {
    return {.dropped_logs = [] { return std::int64_t{5}; },
            .on_healthy =
                [this]
            {
              ++healthy;
            }};
  }
  static void sleep(const lcm::ReceiveBuffer* buffer, const std::string&, Bench*)
  {
    int us = 0;
    std::memcpy(&us, buffer->data, sizeof us);
    usleep(static_cast<useconds_t>(us));
  }
  static void hear(const lcm::ReceiveBuffer* buffer, const std::string& channel, Bench* bench)
  {
    bench->keep(Bytes(static_cast<const std::byte*>(buffer->data), buffer->data_size), channel);
  }

  void keep(Bytes bytes, const std::string& channel)
  {
    const auto add = [&](auto& list)
    {
      list.emplace_back();
      REQUIRE(decode(bytes, list.back()));
    };
    if (channel == channels_.command)
      add(commands);
    else if (channel == channels_.rejected)
      add(rejections);
    else if (channel == channels_.status)
      add(statuses);
    else if (channel == channels_.model)
      add(models);
    else
      add(dynamics);
  }

  Channels channels_;
  Robot robot_ = load_robot("ck");
  lcm::LCM bus_{"memq://"};
  LossyReceiver receiver_{bus_};
  std::ostringstream lines_;
  std::shared_ptr<spdlog::sinks::sink> sink_ = std::make_shared<spdlog::sinks::ostream_sink_st>(lines_);
  spdlog::logger log_;
  LcmLoop loop_;
};

Config every_sample()
{
  Config config;
  config.every_sample = true;
  return config;
}

std::vector<std::int64_t> utimes(const std::vector<torque_command_t>& commands)
{
  std::vector<std::int64_t> result;
  for (const torque_command_t& command : commands)
    result.push_back(command.utime);
  return result;
}

} // namespace

TEST_CASE("with every_sample each good sample is answered once, in order, after the bad ones are rejected",
          "[lcm_loop]")
{
  Bench bench(every_sample());
  std::vector<std::byte> buffer;
  Bytes whole = encode(bench.standing(10), buffer);
  bench.send(whole.first(whole.size() - 3));
  bench.send(bench.standing(20));
  desired_state_t unknown = bench.standing(30);
  unknown.left_contact = 9;
  bench.send(unknown);
  bench.send(bench.standing(40));
  bench.send(bench.standing(40));
  bench.send(bench.standing(50, 2));
  bench.settle();

  CHECK(utimes(bench.commands) == std::vector<std::int64_t>{20, 40});
  CHECK(bench.commands[0].sequence == 1);
  CHECK(bench.commands[1].sequence == 2);
  CHECK(bench.commands[0].model_id == bench.robot().model_id);
  CHECK(bench.commands[0].method == desired_state_t::CONSTRAINED);
  REQUIRE(bench.rejections.size() == 4);
  CHECK(bench.rejections[0].reason == rejection_t::UNDECODABLE);
  CHECK(bench.rejections[0].utime == 10);
  CHECK(bench.rejections[1].reason == rejection_t::OUT_OF_RANGE);
  CHECK(bench.rejections[1].utime == 30);
  CHECK(bench.rejections[2].reason == rejection_t::OUT_OF_ORDER);
  CHECK(bench.rejections[3].reason == rejection_t::OTHER_STREAM);
  CHECK(bench.rejections[3].stream_id == 2);
}

TEST_CASE("newest wins: of the samples that wait only the last good one is answered", "[lcm_loop]")
{
  Config patient;
  patient.max_age = 1.0; // longer than the machine's own pauses
  Bench bench(patient);
  for (std::int64_t utime = 1000; utime <= 20'000; utime += 1000)
    bench.send(bench.standing(utime));
  desired_state_t bad = bench.standing(21'000);
  bad.q[3] = NAN;
  bench.send(bad);                       // does not supersede
  bench.send(bench.standing(22'000, 9)); // another stream: does not either
  bench.settle();
  CHECK(utimes(bench.commands) == std::vector<std::int64_t>{20'000});
  CHECK(bench.rejections.size() == 2);

  // the next status accounts for all of them
  usleep(110'000);
  bench.settle();
  REQUIRE_FALSE(bench.statuses.empty());
  const status_t& status = bench.statuses.back();
  CHECK(status.received == 22);
  CHECK(status.answered == 1);
  CHECK(status.rejected == 2);
  CHECK(status.superseded == 19);
  CHECK(status.conflicts == 1);
  CHECK(status.last_reason == rejection_t::OTHER_STREAM);
  CHECK(status.state == status_t::RUNNING);
  CHECK(status.dropped_logs == 5);
  CHECK(status.dropped_upper_bound == 0);
  CHECK(status.input_age_us >= 100'000);
}

TEST_CASE("a sample that took longer than max_age is stale, unless every sample is wanted", "[lcm_loop]")
{
  for (const bool every : {false, true})
  {
    Config config;
    config.every_sample = every;
    config.max_age = 0.2; // so much that the machine's own pauses are no stalls
    Bench bench(config);
    bench.send(bench.standing(1'000'000));
    bench.settle();
    for (int i = 0; i < 6; ++i)
    {
      usleep(50'000);
      bench.loop().cycle(0.0);
    }
    bench.send(bench.standing(1'001'000));
    bench.settle();
    CHECK(bench.commands.size() == (every ? 2u : 1u));
    CHECK(bench.rejections.size() == (every ? 0u : 1u));
    if (!every)
      CHECK(bench.rejections[0].reason == rejection_t::STALE);
  }
}

TEST_CASE("the bus is proven, model and status come at the start, and STOPPING last", "[lcm_loop]")
{
  Config config;
  config.prefix = "test/";
  Bench bench(config);
  CHECK(bench.loop().prove_bus());
  bench.settle();
  REQUIRE(bench.models.size() == 1);
  CHECK(bench.models[0].name == "ck");
  CHECK(bench.models[0].settings == to_toml(config));
  REQUIRE(bench.statuses.size() >= 1);
  CHECK(bench.statuses[0].state == status_t::WAITING);
  CHECK(bench.statuses[0].input_age_us == -1);
  CHECK(bench.statuses[0].instance_id == bench.models[0].instance_id);
  CHECK(bench.statuses[0].instance_id != 0);

  const int stop = eventfd(1, 0);
  bench.loop().run(stop);
  close(stop);
  bench.settle();
  const auto stopping = std::count_if(bench.statuses.begin(), bench.statuses.end(),
                                      [](const status_t& status) { return status.state == status_t::STOPPING; });
  CHECK(stopping == 1);
}

TEST_CASE("an answer that took longer than the deadline is marked late, and counted", "[lcm_loop]")
{
  Bench bench;
  bench.send(bench.standing(1000));
  bench.send_sleep(3000);
  bench.settle();
  REQUIRE(bench.commands.size() == 1);
  CHECK((bench.commands[0].flags & torque_command_t::LATE) != 0);
  usleep(110'000);
  bench.settle();
  CHECK(bench.statuses.back().late == 1);

  Config config;
  config.deadline = 10.0;
  Bench relaxed(config);
  relaxed.send(relaxed.standing(1000));
  relaxed.send_sleep(3000);
  relaxed.settle();
  REQUIRE(relaxed.commands.size() == 1);
  CHECK((relaxed.commands[0].flags & torque_command_t::LATE) == 0);
}

TEST_CASE("after an own stall no old sample is answered, and the stream is not given away", "[lcm_loop]")
{
  // the stall lies between two messages that one cycle deals with
  Bench bench;
  bench.send(bench.standing(1'000'000));
  bench.settle();
  REQUIRE(bench.commands.size() == 1);
  bench.send(bench.standing(1'001'000));
  bench.send_sleep(300'000);
  bench.send(bench.standing(1'002'000));
  bench.send(bench.standing(5'000'000, 9));
  bench.settle();
  CHECK(bench.commands.size() == 1);
  REQUIRE(bench.rejections.size() == 2);
  CHECK(bench.rejections[0].reason == rejection_t::OTHER_STREAM);
  CHECK(bench.rejections[1].reason == rejection_t::STALE);
  CHECK(bench.rejections[1].utime == 1'002'000);
}

TEST_CASE("a sample that waited through an own stall is as old as the stall", "[lcm_loop]")
{
  for (const bool others : {false, true})
  {
    Bench bench;
    bench.send(bench.standing(1'000'000));
    bench.settle();
    bench.send(bench.standing(1'001'000)); // arrives in time, and then nothing moves for 50 ms
    bench.send_sleep(50'000);
    if (others)
      bench.send(bench.standing(5'000'000, 9)); // what comes after the stall makes it no newer
    bench.settle();
    CHECK(bench.commands.size() == 1);
    REQUIRE(bench.rejections.size() == (others ? 2 : 1));
    CHECK(bench.rejections.back().reason == rejection_t::STALE);
  }
}

TEST_CASE("while messages are lost no other stream takes over, and the status says how many", "[lcm_loop]")
{
  Bench bench;
  bench.send(bench.standing(1000));
  bench.settle();
  const auto try_other = [&](bool loses)
  {
    for (int i = 0; i < 30; ++i)
    {
      usleep(5000);
      bench.receiver().lost += loses ? 1 : 0;
      bench.send(bench.standing(1000 + i, 9));
      bench.settle();
    }
  };
  try_other(true);
  CHECK(bench.commands.size() == 1);
  CHECK(bench.rejections.size() == 30);
  CHECK(bench.statuses.back().dropped_upper_bound > 10);
  try_other(false);
  CHECK(bench.commands.size() > 1);
}

TEST_CASE("while the loop does not keep up no other stream takes over", "[lcm_loop]")
{
  Bench bench;
  bench.send(bench.standing(1000));
  bench.settle();
  // two and a half times as much as another stream waits for, none of it a stall
  for (int i = 0; i < 125; ++i)
  {
    bench.send_sleep(2000);
    bench.send(bench.standing(1000 + i, 9));
  }
  for (int i = 0; i < 1000 && bench.rejections.size() < 125; ++i)
    bench.loop().cycle(0.0);
  CHECK(bench.commands.size() == 1);
  CHECK(bench.rejections.size() == 125);

  for (int i = 0; i < 30; ++i)
  {
    usleep(5000);
    bench.send(bench.standing(2000 + i, 9));
    bench.settle();
  }
  CHECK(bench.commands.size() > 1);
}

TEST_CASE("a status of our own that is lost among others is no deafness, and a repeated one no second health",
          "[lcm_loop]")
{
  const auto publish_statuses = [](Bench& bench, int times, bool loses)
  {
    for (int i = 0; i < times; ++i)
    {
      usleep(101'000);
      bench.receiver().lost += loses ? 1 : 0;
      bench.settle();
      bench.settle();
    }
  };
  Bench bench;
  bench.receiver().loses_statuses = true;
  publish_statuses(bench, 8, true);
  CHECK(bench.healthy >= 7);
  CHECK(bench.log().find("deaf") == std::string::npos);
  publish_statuses(bench, 8, false);
  CHECK(bench.log().find("deaf") != std::string::npos);

  bench.receiver().loses_statuses = false;
  publish_statuses(bench, 2, false);
  const int healthy = bench.healthy;
  std::vector<std::byte> buffer;
  const Bytes bytes = encode(bench.statuses.back(), buffer);
  for (int i = 0; i < 50; ++i)
    bench.bus().publish("TORQUED_STATUS", bytes.data(), static_cast<unsigned>(bytes.size()));
  bench.settle();
  CHECK(bench.healthy <= healthy + 1);
}

TEST_CASE("at most a thousand rejections a second are published, and all are counted", "[lcm_loop][slow]")
{
  Bench bench;
  desired_state_t bad = bench.standing(10);
  bad.method = 99;
  std::vector<std::byte> buffer;
  const Bytes bytes = encode(bad, buffer);
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 3000; ++i)
    bench.send(bytes);
  bench.settle();
  const auto lasted = std::chrono::steady_clock::now() - begin;
  CHECK(bench.rejections.size() >= 1000);
  if (lasted < std::chrono::seconds(1))
    CHECK(bench.rejections.size() == 1000);

  usleep(1'001'000);
  for (int i = 0; i < 10; ++i)
    bench.send(bytes);
  const std::size_t before = bench.rejections.size();
  bench.settle();
  CHECK(bench.rejections.size() == before + 10);
  usleep(110'000);
  bench.settle();
  CHECK(bench.statuses.back().rejected == 3010);
  CHECK(bench.statuses.back().received == 3010);
}

TEST_CASE("a flood of what is no sample delays neither answers nor statuses", "[lcm_loop][slow]")
{
  std::vector<std::byte> buffer;
  const auto junk = [&](const Bench& bench)
  {
    return encode(bench.standing(5), buffer).first(50);
  };
  {
    // a sample is answered in its cycle, while thousands of messages wait behind it; sending them takes a while, in
    // which this process does not look up, and which is no stall as long as max_age is longer
    Config patient;
    patient.max_age = 1.0;
    Bench bench(patient);
    bench.send(bench.standing(1000));
    for (int i = 0; i < 9000; ++i)
      bench.send(junk(bench));
    bench.loop().cycle(0.0);
    int waited = 0;
    while (bench.bus().handleTimeout(0) > 0)
      ++waited;
    CHECK(utimes(bench.commands) == std::vector<std::int64_t>{1000});
    CHECK(waited > 5000);
  }

  // more comes than is taken, and yet statuses do not wait for its end
  Bench bench;
  const auto begin = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() < begin + std::chrono::milliseconds(450))
  {
    for (int i = 0; i < 2000; ++i)
      bench.send(junk(bench));
    bench.loop().cycle(0.0);
  }
  while (bench.bus().handleTimeout(0) > 0)
  {
  }
  CHECK(bench.statuses.size() >= 3);
  CHECK(bench.healthy > 0);
}

TEST_CASE("a signal is heard in the middle of a backlog", "[lcm_loop]")
{
  Bench bench;
  const int stop = eventfd(1, 0);
  for (std::int64_t utime = 1000; utime <= 5'000'000; utime += 1000)
    bench.send(bench.standing(utime));
  CHECK(bench.loop().cycle(0.0, stop));
  close(stop);
  int waited = 0;
  while (bench.bus().handleTimeout(0) > 0)
    ++waited;
  CHECK(waited >= 5000);
}

TEST_CASE("of a backlog of half a second only the newest is answered", "[lcm_loop]")
{
  Bench bench;
  for (std::int64_t utime = 1000; utime <= 500'000; utime += 1000)
    bench.send(bench.standing(utime));
  bench.settle();
  CHECK(utimes(bench.commands) == std::vector<std::int64_t>{500'000});
  CHECK(bench.rejections.empty());
}

TEST_CASE("the status tells latency, silence and whose status it is", "[lcm_loop]")
{
  Bench bench(every_sample());
  bench.settle(); // the first status is out
  for (std::int64_t utime = 1; utime <= 5; ++utime)
    bench.send(bench.standing(utime));
  bench.settle();
  REQUIRE(bench.commands.size() == 5);
  for (const torque_command_t& command : bench.commands)
    CHECK(command.compute_ns > 0);
  usleep(110'000);
  bench.settle();
  const status_t running = bench.statuses.back();
  CHECK(running.latency_us_max > 0.0);
  CHECK(running.latency_us_p50 <= running.latency_us_p90);
  CHECK(running.latency_us_p999 <= running.latency_us_max);
  CHECK(running.uptime_us >= 110'000);
  CHECK(running.last_reason == 0);
  CHECK(running.model_id == bench.robot().model_id);

  // silent for more than 5 max_age, in small steps: this is the sender's silence, not a stall of our own
  for (int i = 0; i < 1000 && bench.statuses.back().state != status_t::STALE; ++i)
  {
    usleep(5000);
    bench.settle();
  }
  CHECK(bench.statuses.back().state == status_t::STALE);
  CHECK(bench.statuses.back().latency_us_max == 0.0);
}

TEST_CASE("requests for the equation of motion are answered, and none delays a desired state", "[lcm_loop]")
{
  Bench bench;
  bench.ask(1);
  bench.ask(2, 8);
  bench.ask(3, 300); // too long for any request of this robot
  for (int i = 0; i < 3; ++i)
    bench.settle();
  REQUIRE(bench.dynamics.size() == 3);
  for (const dynamics_t& reply : bench.dynamics)
    CHECK((reply.error == "") == (reply.request_id == 1));

  // a hundred at once: the desired state among them waits for no answer to a request but one in each cycle that takes
  // messages; sixteen requests wait, the others are dropped, but where more than one cycle takes them, there is room
  // for as many more
  bench.dynamics.clear();
  for (int i = 0; i < 50; ++i)
    bench.ask(100 + i);
  bench.send(bench.standing(1000));
  for (int i = 50; i < 100; ++i)
    bench.ask(100 + i);
  std::size_t cycles = 0;
  for (; cycles < 20 && bench.commands.empty(); ++cycles)
    bench.settle();
  CHECK(utimes(bench.commands) == std::vector<std::int64_t>{1000});
  CHECK(bench.dynamics.size() <= cycles);
  for (int i = 0; i < 40; ++i)
    bench.settle();
  CHECK(bench.dynamics.size() >= 16);
  CHECK(bench.dynamics.size() < 16 + 2 * cycles);
  bench.ask(300);
  bench.settle();
  CHECK(bench.dynamics.back().request_id == 300);

  // requests are no desired states
  usleep(110'000);
  bench.settle();
  CHECK(bench.statuses.back().received == 1);
}

TEST_CASE("each status of our own that comes back is a healthy cycle; one of another daemon is named in the log",
          "[lcm_loop]")
{
  Bench bench;
  bench.settle(); // publishes a status
  bench.settle(); // hears it
  CHECK(bench.healthy == 1);

  std::vector<std::byte> buffer;
  const auto say = [&](std::int64_t instance_id)
  {
    status_t status{};
    status.instance_id = instance_id;
    status.version = "9";
    const Bytes bytes = encode(status, buffer);
    bench.bus().publish("TORQUED_STATUS", bytes.data(), static_cast<unsigned>(bytes.size()));
    bench.settle();
  };
  say(4711);
  const std::string said = bench.log();
  CHECK(said.find("another daemon, instance 4711, publishes on TORQUED_STATUS, too") != std::string::npos);
  say(4711);
  say(4712);
  CHECK(bench.log() == said); // and not again at once
  CHECK(bench.healthy == 1);
}

TEST_CASE("a repeated refusal is logged once a second, in no more than spdlog keeps without allocating", "[lcm_loop]")
{
  Config config;
  config.robot = "ck";
  Bench bench(config);
  desired_state_t unknown = bench.standing(10);
  unknown.method = 99;
  for (int i = 0; i < 50; ++i)
    bench.send(unknown);
  bench.settle();
  REQUIRE(bench.rejections.size() == 50);
  const std::string log = bench.log();
  CHECK(std::count(log.begin(), log.end(), '\n') == 1);
  CHECK(log.find("rejected: UNKNOWN_METHOD: method is 99; expected ") != std::string::npos);
  CHECK(bench.rejections[0].detail.size() > 170); // so that it would be longer
  CHECK(log.size() < 250 + std::string("[2026-01-01 00:00:00.000] [test] [warning] ").size());
}

} // namespace lcm_loop_test
