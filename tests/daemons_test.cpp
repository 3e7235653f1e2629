#include "catch.h"
#include "matchers.h"

#include "bus/daemons.h"
#include "commands/status_json.h"
#include "robot/files/load.h"

#include <algorithm>
#include <limits>

namespace daemons_test
{

using namespace torqued;

namespace
{

using namespace std::chrono_literals;
using Clock = DaemonsHeard::Clock;

const Clock::time_point kStart{};

// Counts as after so many samples, of which every tenth was rejected and every tenth superseded.
status_t status(std::int64_t instance, double uptime, std::int64_t samples)
{
  status_t status{};
  status.instance_id = instance;
  status.uptime_us = static_cast<std::int64_t>(1e6 * uptime);
  status.state = status_t::RUNNING;
  status.received = samples;
  status.rejected = status.superseded = samples / 10;
  status.answered = samples - status.rejected - status.superseded;
  status.version = "0.1.0";
  return status;
}

template <typename Message>
void hear(DaemonsHeard& heard, const Message& message, Clock::time_point when, const std::string& prefix = "")
{
  std::vector<std::byte> buffer;
  if constexpr (std::is_same_v<Message, status_t>)
    heard.hear_status(prefix, encode(message, buffer), when);
  else
    heard.hear_model(encode(message, buffer));
}

Clock::time_point at(double seconds)
{
  return kStart + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

bool contains(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("rates are those of the last second by the daemon's own clock", "[daemons]")
{
  // 500 samples a second at first, then 1000; statuses arrive late and in pairs, which changes nothing
  DaemonsHeard heard;
  for (int i = 0; i <= 40; ++i)
    hear(heard, status(1, 0.1 * i, i <= 20 ? 50 * i : 1000 + 100 * (i - 20)), at(0.2 * (i / 2) + 0.13));
  const std::vector<Daemon> daemons = heard.at(at(4.2));
  REQUIRE(daemons.size() == 1);
  REQUIRE(daemons[0].rates);
  // counts are whole tens
  CHECK(daemons[0].rates->received == Approx(1000.0).epsilon(1e-9));
  CHECK(daemons[0].rates->answered == Approx(800.0).epsilon(1e-9));
  CHECK(daemons[0].rates->rejected == Approx(100.0).epsilon(1e-9));
  CHECK(daemons[0].rates->superseded == Approx(100.0).epsilon(1e-9));
  CHECK(daemons[0].silent == Approx(0.07).margin(1e-6));
}

TEST_CASE("one status has no rates", "[daemons]")
{
  DaemonsHeard heard;
  hear(heard, status(1, 5.0, 100), kStart);
  CHECK_FALSE(heard.at(kStart).at(0).rates);
}

TEST_CASE("a daemon is present until it says that it stops, or is silent for a second", "[daemons]")
{
  DaemonsHeard heard;
  hear(heard, status(1, 5.0, 100), kStart);
  CHECK(heard.at(at(0.9)).at(0).present());
  CHECK_FALSE(heard.at(at(1.1)).at(0).present());
  CHECK(contains(status_page(heard.at(at(75.0))), "SILENT for 0:01:15"));

  status_t last = status(1, 5.1, 100);
  last.state = status_t::STOPPING;
  hear(heard, last, at(0.1));
  CHECK_FALSE(heard.at(at(0.2)).at(0).present());
  CHECK(contains(status_page(heard.at(at(0.6))), "ended 0.5 s ago, after 0:00:05"));
}

TEST_CASE("a restarted daemon takes the place of the one before; two that run are both shown, and named wrong",
          "[daemons]")
{
  DaemonsHeard heard;
  hear(heard, status(1, 5.0, 100), kStart);
  hear(heard, status(2, 0.1, 0), at(1.5));
  const std::vector<Daemon> restarted = heard.at(at(1.6));
  REQUIRE(restarted.size() == 1);
  CHECK(restarted[0].status.instance_id == 2);
  CHECK_FALSE(contains(status_page(restarted), "WRONG"));

  hear(heard, status(3, 0.1, 0), at(1.5));
  hear(heard, status(4, 0.1, 0), at(1.5), "left/");
  const std::vector<Daemon> two = heard.at(at(1.6));
  REQUIRE(two.size() == 3);
  const std::string page = status_page(two);
  CHECK(contains(page, "WRONG: 2 daemons share these channels"));
  CHECK(contains(page, "left/TORQUED_STATUS"));
  CHECK(page.find("WRONG") < page.find("left/")); // said of those whose channels they are

  // when all have ended, the one that was heard last stands for them
  hear(heard, status(2, 0.2, 0), at(1.8));
  const std::vector<Daemon> ended = heard.at(at(10.0));
  REQUIRE(ended.size() == 2);
  CHECK(ended[0].status.instance_id == 2);
  CHECK(ended[1].prefix == "left/");
}

TEST_CASE("the page shows counts, robot and settings", "[daemons]")
{
  DaemonsHeard heard;
  hear(heard, status(7, 3.0, 1234560), kStart);
  CHECK(contains(status_page(heard.at(kStart)), "it has not said yet which robot it computes"));

  const Robot robot = load_robot("ck");
  hear(heard, model_info(robot, 7, 1, "method = \"zmp-transition\"\nmax_age = 0.03\n"), kStart);
  const std::string page = status_page(heard.at(kStart));
  CHECK(contains(page, "ck, 45.0 kg, 6 joints, method zmp-transition, the newest sample if at most 30 ms old"));
  CHECK(contains(page, "RUNNING, up 0:00:03"));
  CHECK(contains(page, "1234560 =       987648 +       123456 +       123456"));
  CHECK_FALSE(contains(page, "WRONG"));

  hear(heard, model_info(robot, 7, 1, "every_sample = true\n"), kStart);
  CHECK(contains(status_page(heard.at(kStart)), "method constrained, every sample"));
  hear(heard, model_info(robot, 7, 1, "tomorrow = 1\n"), kStart);
  CHECK(contains(status_page(heard.at(kStart)), "settings that this torquectl cannot read"));
}

TEST_CASE("counts that do not add up are named wrong", "[daemons]")
{
  status_t lost = status(1, 3.0, 100);
  ++lost.received;
  DaemonsHeard heard;
  hear(heard, lost, kStart);
  CHECK(contains(status_page(heard.at(kStart)), "WRONG: the counts do not add up"));
}

TEST_CASE("whatever a stranger publishes as a status is shown as plain text, and fills no memory", "[daemons]")
{
  DaemonsHeard heard;
  status_t strange = status(1, 0.0, 0);
  strange.version = "\x1b[2J";
  strange.state = 77;
  strange.last_reason = -5;
  strange.uptime_us = strange.received = std::numeric_limits<std::int64_t>::min();
  strange.answered = strange.input_age_us = std::numeric_limits<std::int64_t>::max();
  strange.latency_us_p50 = std::numeric_limits<double>::quiet_NaN();
  hear(heard, strange, kStart);
  strange.uptime_us = std::numeric_limits<std::int64_t>::max();
  hear(heard, strange, kStart);
  const std::string page = status_page(heard.at(kStart));
  CHECK_FALSE(contains(page, "\x1b"));
  CHECK(contains(page, "77, up"));

  heard.hear_status("", Bytes(), kStart);
  heard.hear_model(Bytes());
  for (std::int64_t instance = 0; instance < 1000; ++instance)
    hear(heard, status(instance, 1.0, 0), at(1e-6 * static_cast<double>(instance)));
  const std::vector<Daemon> kept = heard.at(at(0.001));
  CHECK(kept.size() == 100);
  CHECK(std::all_of(kept.begin(), kept.end(), [](const Daemon& one) { return one.status.instance_id >= 900; }));
}

TEST_CASE("a status for scripts has the message's fields, and names for its state and last reason", "[daemons]")
{
  status_t said{};
  said.state = status_t::RUNNING;
  said.dropped_upper_bound = -1;
  said.latency_us_p999 = 12.5;
  nlohmann::ordered_json json = status_json(said);
  CHECK(json["state"] == "RUNNING");
  CHECK(json["dropped_upper_bound"] == -1);
  CHECK(json["latency_us_p999"] == 12.5);
  CHECK(json["last_reason"].is_null());
  said.last_reason = rejection_t::INFEASIBLE;
  CHECK(status_json(said)["last_reason"] == "INFEASIBLE");
}

} // namespace daemons_test
