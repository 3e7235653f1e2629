#include "catch.h"
#include "matchers.h"

#include "motion/gait.h"
#include "page/live_motion.h"
#include "robot/files/load.h"
#include "stance/flags.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

namespace live_motion_test
{

using namespace torqued;
using namespace std::chrono_literals;

namespace
{

const LiveMotion::Clock::time_point kStart{};

// a walk's desired states, a hundredth of a second apart; its base follows from contact
std::vector<desired_state_t> walk(const Robot& robot)
{
  GaitOptions options = default_gait(robot);
  options.steps = 8;
  const Gait gait(robot, options);
  std::vector<desired_state_t> states;
  std::size_t phase = 0;
  for (int i = 0; 0.01 * i < gait.phases().back().end; ++i)
  {
    while (gait.phases()[phase].end < 0.01 * i)
      ++phase;
    const DesiredState wanted = gait.at(0.01 * i, gait.phases()[phase]);
    desired_state_t& state = states.emplace_back();
    state = {};
    state.utime = 10'000 * i;
    state.stream_id = 1;
    state.left_contact = static_cast<std::int8_t>(wanted.support.contact[0]);
    state.right_contact = static_cast<std::int8_t>(wanted.support.contact[1]);
    state.leading_foot = static_cast<std::int8_t>(wanted.support.leading);
    state.load_transfer = wanted.support.load_transfer;
    state.phase = wanted.support.phase;
    state.num_coordinates = 7;
    state.q.assign(wanted.q.begin(), wanted.q.begin() + 7);
    state.v.assign(wanted.v.begin(), wanted.v.begin() + 7);
    state.a.assign(wanted.a.begin(), wanted.a.begin() + 7);
  }
  return states;
}

torque_command_t answer_to(const desired_state_t& desired)
{
  static const std::int64_t model_id = load_robot("ck").model_id;
  torque_command_t command{};
  command.model_id = model_id;
  command.utime = desired.utime;
  command.stream_id = desired.stream_id;
  command.compute_ns = 7000;
  command.num_coordinates = 7;
  command.a = desired.a;
  command.num_joints = 6;
  command.torque.assign(6, 1e-3 * static_cast<double>(desired.utime));
  return command;
}

LiveMotion::Clock::time_point at(std::int64_t utime)
{
  return kStart + std::chrono::microseconds(utime);
}

} // namespace

TEST_CASE("view keeps the last seconds, with answers, rejections and what was superseded", "[live_motion]")
{
  LiveMotion live(load_robot("ck"), 1.0);
  CHECK(live.window(kStart).empty());
  const auto states = walk(live.robot());
  REQUIRE(states.size() > 400);
  for (std::size_t i = 0; i < 300; ++i)
  {
    live.hear(states[i], at(states[i].utime));
    if (i == 250)
    {
      rejection_t rejection{};
      rejection.utime = states[i].utime;
      rejection.stream_id = 1;
      rejection.reason = 11;
      live.hear(rejection);
    }
    else if (i != 260)
    {
      live.hear(answer_to(states[i]), at(states[i].utime) + 120us);
    }
  }
  const auto motions = live.window(at(states[299].utime));
  REQUIRE(motions.size() == 1);
  const ReportMotion& motion = motions[0];
  REQUIRE(motion.states.size() == 101);
  CHECK(mismatch(motion.start, 1.99, 1e-12) == "");
  CHECK(motion.states.back().utime == states[299].utime);
  const ReportRun& run = motion.runs.at(0);
  for (std::size_t i = 0; i < 101; ++i)
  {
    CAPTURE(i);
    const bool answered = i + 199 != 250 && i + 199 != 260;
    REQUIRE(run.answers[i].has_value() == answered);
    CHECK(std::isnan(run.times[i].delay_us) == !answered);
    if (!answered)
      continue;
    CHECK(run.answers[i]->torque(3) == 1e-3 * static_cast<double>(motion.states[i].utime));
    CHECK(run.times[i].compute_us == 7.0);
    CHECK(mismatch(run.times[i].delay_us, 120.0, 1e-9) == "");
  }
  CHECK(run.unanswered == std::map<std::string, std::int64_t>{{"UNDER_ACTUATED", 1}, {"NO_ANSWER", 1}});
}

TEST_CASE("view shows that an answer is the nearest that can be had, and what was asked for", "[live_motion]")
{
  LiveMotion live(load_robot("ck"), 1.0);
  const auto states = walk(live.robot());
  const auto shown = [&live]
  {
    return nlohmann::json::parse(report_document(live.robot(), live.window(kStart + 1h)))["motions"][0];
  };
  live.hear(states[0], at(states[0].utime));
  live.hear(answer_to(states[0]), at(states[0].utime));
  CHECK_FALSE(shown().contains("asked"));
  CHECK_FALSE(shown()["runs"][0]["frames"].contains("a_q3"));
  torque_command_t adjusted = answer_to(states[1]);
  adjusted.flags = flag::adjusted;
  adjusted.a[3] += 5.0;
  adjusted.adjustment = 5.0;
  live.hear(states[1], at(states[1].utime));
  live.hear(adjusted, at(states[1].utime));
  CHECK(shown()["runs"][0]["figures"]["flags"] == nlohmann::json{{"ADJUSTED", 1}});
  for (const auto& [name, same] : std::map<std::string, bool>{{"a_q2", true}, {"a_q3", false}})
    CHECK((shown()["asked"]["frames"][name] == shown()["runs"][0]["frames"][name]) == same);
  CHECK(shown()["asked"]["frames"]["a_xH"] == "AADAfwAAwH8="); // twice no number: the base follows from contact
}

TEST_CASE("the newest samples wait for their answers, but not for ever", "[live_motion]")
{
  LiveMotion live(load_robot("ck"), 1.0);
  const auto states = walk(live.robot());
  live.hear(states[0], kStart);
  live.hear(answer_to(states[0]), kStart);
  live.hear(states[1], kStart + 10ms);
  CHECK(live.window(kStart + 11ms).at(0).states.size() == 1);
  CHECK(live.window(kStart + 300ms).at(0).states.size() == 2);
}

TEST_CASE("the robot goes on walking while the window moves along", "[live_motion]")
{
  LiveMotion live(load_robot("ck"), 0.5);
  const auto states = walk(live.robot());
  const GaitOptions options = default_gait(live.robot());
  const double speed = options.step_length / options.step_time;
  std::optional<double> first;
  for (const desired_state_t& state : states)
  {
    live.hear(state, at(state.utime));
    if (state.utime % 50'000 != 0)
      continue;
    const auto motions = live.window(at(state.utime) + 1s);
    const DesiredState& last = motions.at(0).states.back();
    REQUIRE(last.base_given);
    first = first.value_or(last.q.tail<2>().x());
    // a steady walk, within the sway of a step
    CHECK(std::abs(last.q.tail<2>().x() - *first - speed * 1e-6 * static_cast<double>(state.utime)) < 0.05);
  }
}

TEST_CASE("view shows one stream at a time", "[live_motion]")
{
  LiveMotion live(load_robot("ck"), 1.0);
  auto states = walk(live.robot());
  for (std::size_t i = 0; i < 10; ++i)
    live.hear(states[i], at(states[i].utime));
  desired_state_t other = states[3];
  other.stream_id = 2;
  live.hear(other, at(states[9].utime) + 100ms);
  CHECK(live.window(at(0) + 1h).at(0).states.size() == 10);
  live.hear(other, at(states[9].utime) + 600ms); // the first has gone
  auto shown = live.window(at(0) + 1h).at(0);
  REQUIRE(shown.states.size() == 1);
  CHECK(shown.states[0].stream_id == 2);
  CHECK(shown.start == 0.0);
  live.hear(states[2], at(states[9].utime) + 1500ms); // it came back, its clock set back
  CHECK(live.window(at(0) + 1h).at(0).states.at(0).stream_id == 1);
}

TEST_CASE("what makes no sense for the robot is passed over", "[live_motion]")
{
  LiveMotion live(load_robot("ck"), 1.0);
  const auto states = walk(live.robot());
  desired_state_t wrong = states[0];
  wrong.phase = 2.0;
  live.hear(wrong, kStart);
  CHECK(live.window(kStart + 1h).empty());
  live.hear(states[0], kStart);
  torque_command_t of_another = answer_to(states[0]);
  of_another.num_joints = 2;
  of_another.torque.resize(2);
  live.hear(of_another, kStart);
  of_another = answer_to(states[0]);
  of_another.num_coordinates = 1;
  of_another.a.resize(1);
  live.hear(of_another, kStart);
  of_another = answer_to(states[0]);
  of_another.model_id += 1;
  live.hear(of_another, kStart);
  CHECK_FALSE(live.window(kStart + 1h).at(0).runs[0].answers[0]);
}

TEST_CASE("a live motion says how old its last answer is", "[live_motion]")
{
  LiveMotion live(load_robot("ck"), 1.0);
  const auto states = walk(live.robot());
  CHECK_FALSE(live.answer_age(kStart));
  live.hear(states[0], kStart);
  torque_command_t of_another = answer_to(states[0]);
  of_another.model_id += 1;
  live.hear(of_another, kStart + 1ms);
  CHECK_FALSE(live.answer_age(kStart + 2ms));
  live.hear(answer_to(states[0]), kStart + 3ms);
  CHECK(std::abs(live.answer_age(kStart + 3s).value() - 2.997) < 1e-9);
  live.hear(states[1], kStart + 2s); // and none to it
  CHECK(std::abs(live.answer_age(kStart + 3s).value() - 2.997) < 1e-9);
}

TEST_CASE("a live motion takes any times", "[live_motion]")
{
  LiveMotion live(load_robot("ck"), 1.0);
  auto states = walk(live.robot());
  constexpr std::int64_t first = std::numeric_limits<std::int64_t>::min(),
                         last = std::numeric_limits<std::int64_t>::max();
  states[0].utime = first;
  states[1].utime = last - 1;
  states[2].utime = last;
  for (const desired_state_t& state : {states[0], states[1], states[2]})
    live.hear(state, kStart);
  const auto shown = live.window(kStart + 1h).at(0);
  REQUIRE(shown.states.size() == 2);
  CHECK(shown.states[0].utime == last - 1);
  CHECK(shown.start == 1e-6 * 0x1p64);
}

} // namespace live_motion_test
