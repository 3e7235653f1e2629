#include "bus/bus.h"
#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/console.h"
#include "motion/files.h"
#include "motion/median.h"
#include "motion/trajectory.h"
#include "study/tally.h"
#include "text/printable.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <unistd.h>
#include <vector>

namespace torqued
{

namespace
{

using namespace std::chrono_literals;
using Clock = Bus::Clock;

constexpr Clock::duration kAnswerPatience = 1s; // an answer that takes longer counts as lost

struct SendOptions
{
  std::string file, lcm_url;
  std::optional<std::string> method, prefix;
  double speed = 1.0, rate = 0.0;
  bool loop = false, json = false;
  Differentiation differentiation;
};

// When each desired state is due, and when the next round of them begins; s since the first.
struct Schedule
{
  std::vector<double> due;
  double round = 0.0;
  double patience = 0.0; // s that each waits at most for the answer to the one before, counted from that one's sending
};

Schedule make_schedule(const Trajectory& trajectory, const SendOptions& options)
{
  const std::vector<desired_state_t>& states = trajectory.states;
  Schedule schedule;
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    if (options.rate > 0.0)
    {
      schedule.due.push_back(static_cast<double>(i) / options.rate);
      continue;
    }
    if (i > 0 && (states[i].stream_id != states[i - 1].stream_id || states[i].utime <= states[i - 1].utime))
      throw Failure(ExitCode::bad_data,
                    "{}: found utime {} of stream {} after utime {} of stream {}; expected one stream with rising "
                    "times, or --rate, which does not need them",
                    trajectory.place(i), states[i].utime, states[i].stream_id, states[i - 1].utime,
                    states[i - 1].stream_id);
    const double since_first = static_cast<double>(states[i].utime) - static_cast<double>(states[0].utime);
    schedule.due.push_back(1e-6 * since_first / options.speed);
  }

  // from the last to the next first as long as from the last but one to the last
  const std::size_t last = schedule.due.size() - 1;
  if (options.rate > 0.0)
    schedule.round = static_cast<double>(schedule.due.size()) / options.rate;
  else if (last > 0)
    schedule.round = 2.0 * schedule.due[last] - schedule.due[last - 1];
  else if (options.loop)
    throw Failure(ExitCode::usage, "--loop needs --rate: {} holds only one desired state", trajectory.file);
  // Samples in equal steps never wait. A daemon answers the newest sample that it has: of two that it finds waiting,
  // because they are due together or the first was sent late, it would pass over the first.
  if (last > 0)
    schedule.patience = 0.75 * median_step(schedule.due);
  return schedule;
}

// What became of the desired states of one stream.
class Ledger
{
public:
  explicit Ledger(std::int64_t stream_id) : stream_id_(stream_id) {}

  void sent(std::int64_t utime, const std::string& place)
  {
    outstanding_.emplace(utime, place);
    ++sent_;
  }
  void hear_command(Bytes bytes)
  {
    torque_command_t command;
    const std::int64_t now = microseconds(Clock::now());
    if (!decode(bytes, command) || command.stream_id != stream_id_ || outstanding_.erase(command.utime) == 0)
      return;
    tally_.answer(command.flags);
    if (round_trips_.size() < kMostRoundTrips)
      round_trips_.push_back(now - command.utime);
    else
      round_trips_[static_cast<std::size_t>(tally_.answered) % kMostRoundTrips] = now - command.utime;
  }
  void hear_rejection(Bytes bytes)
  {
    rejection_t rejection;
    if (!decode(bytes, rejection) || rejection.stream_id != stream_id_)
      return;
    const auto found = outstanding_.find(rejection.utime);
    if (found == outstanding_.end())
      return;
    tally_.reject(rejection.reason, fmt::format("{}: {}", found->second, printable(rejection.detail)));
    outstanding_.erase(found);
  }
  // gives up those that were sent at this time or before
  void give_up(std::int64_t utime)
  {
    const auto end = outstanding_.upper_bound(utime);
    lost_ += std::distance(outstanding_.begin(), end);
    outstanding_.erase(outstanding_.begin(), end);
  }

  bool all_settled() const { return outstanding_.empty(); }
  bool settled(std::int64_t utime) const { return !outstanding_.contains(utime); }
  std::size_t num_sent() const { return sent_; }
  std::int64_t num_lost() const { return lost_; }
  const Tally& tally() const { return tally_; }

  // of the round trips, µs: the smallest that at least this share does not exceed; nothing without answers
  std::optional<std::int64_t> percentile(double share) const
  {
    if (round_trips_.empty())
      return {};
    std::vector<std::int64_t> sorted = round_trips_;
    const auto rank = static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(sorted.size())));
    const auto nth = sorted.begin() + std::max<std::ptrdiff_t>(rank, 1) - 1;
    std::nth_element(sorted.begin(), nth, sorted.end());
    return *nth;
  }

private:
  static constexpr std::size_t kMostRoundTrips = 1'000'000; // the last ones

  std::int64_t stream_id_;
  std::map<std::int64_t, std::string> outstanding_; // by utime: where it stands in the file
  std::size_t sent_ = 0;
  std::int64_t lost_ = 0;
  Tally tally_;
  std::vector<std::int64_t> round_trips_;
};

// A line on the terminal that is rewritten at most ten times a second; nothing where stderr is no terminal.
class ProgressBar
{
public:
  ~ProgressBar()
  {
    if (shown_)
      fmt::print(stderr, "\r\033[K");
  }

  // share: of the present round
  void show(double share, const Ledger& ledger)
  {
    const auto now = Clock::now();
    if (!terminal_ || now < next_)
      return;
    constexpr int width = 30;
    next_ = now + 100ms;
    shown_ = true;
    fmt::print(stderr, "\r[{:<{}}] {:3.0f} %  {} sent, {} answered, {} rejected\033[K",
               std::string(static_cast<std::size_t>(width * share), '#'), width, 100.0 * share, ledger.num_sent(),
               ledger.tally().answered, ledger.tally().num_rejected());
  }

private:
  bool terminal_ = isatty(STDERR_FILENO) == 1;
  bool shown_ = false;
  Clock::time_point next_{};
};

void print_text(const std::string& robot, const Ledger& ledger)
{
  fmt::print("{}", ledger.tally().summary(robot, ledger.num_sent(), fmt::format("{} lost, ", ledger.num_lost())));
  if (ledger.num_lost() > 0)
    fmt::print("  lost: newer samples superseded them (torqued --every-sample answers all), or they did not arrive\n");
  if (const auto p50 = ledger.percentile(0.5))
    fmt::print("round trip: p50 {} µs, p90 {} µs, p99 {} µs, max {} µs\n", *p50, *ledger.percentile(0.9),
               *ledger.percentile(0.99), *ledger.percentile(1.0));
}

void print_json(const std::string& robot, const Ledger& ledger)
{
  nlohmann::ordered_json reasons = nlohmann::ordered_json::object();
  for (const auto& [reason, rejected] : ledger.tally().rejected)
    reasons[reason_name(reason)] = {{"count", rejected.count}, {"first", rejected.first}};
  nlohmann::ordered_json round_trip;
  if (ledger.percentile(0.5))
    round_trip = {{"p50", *ledger.percentile(0.5)},
                  {"p90", *ledger.percentile(0.9)},
                  {"p99", *ledger.percentile(0.99)},
                  {"max", *ledger.percentile(1.0)}};
  const nlohmann::ordered_json summary{{"robot", robot},
                                       {"sent", ledger.num_sent()},
                                       {"answered", ledger.tally().answered},
                                       {"rejected", ledger.tally().num_rejected()},
                                       {"lost", ledger.num_lost()},
                                       {"reasons", reasons},
                                       {"flags", ledger.tally().flags()},
                                       {"round_trip_us", round_trip}};
  fmt::print("{}\n", summary.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

// sends the desired states when they are due, with `loop` round after round, until the end or a signal
void send_all(Bus& bus, const Channels& channels, const Schedule& schedule, bool loop, Trajectory& trajectory,
              Ledger& ledger)
{
  const Clock::time_point start = Clock::now();
  Clock::time_point sent = start; // when the last one was
  std::vector<std::byte> buffer;
  std::int64_t utime = 0;
  ProgressBar progress;
  for (double round = 0.0; (round == 0.0 || loop) && !bus.stopped(); ++round)
    for (std::size_t i = 0; i < schedule.due.size(); ++i)
    {
      // within a year, which the clock can count, even if a tiny --speed makes the times infinite
      const double since_start = std::min(3e7, round * schedule.round + schedule.due[i]);
      const auto due = start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(since_start));
      do
      {
        bus.wait(due);
        progress.show(static_cast<double>(i) / static_cast<double>(schedule.due.size()), ledger);
      } while (!bus.stopped() && Clock::now() < due);
      const auto patience = sent + std::chrono::duration_cast<Clock::duration>(
                                       std::chrono::duration<double>(std::min(1.0, schedule.patience)));
      while (!bus.stopped() && !ledger.settled(utime) && Clock::now() < patience)
        bus.wait(patience);
      if (bus.stopped())
        return;

      desired_state_t& state = trajectory.states[i];
      sent = Clock::now();
      utime = std::max(utime + 1, microseconds(sent));
      state.utime = utime;
      ledger.sent(utime, trajectory.place(i));
      bus.publish(channels.desired, encode(state, buffer));
      ledger.give_up(microseconds(sent - kAnswerPatience));
    }
}

ExitCode send(const SendOptions& options)
{
  Config config;
  set_flag("--prefix", set_prefix, config, options.prefix);
  set_flag("--method", set_method, config, options.method);
  const Channels channels(config.prefix);
  const std::string bytes = read_file(options.file);
  Bus bus(options.lcm_url);
  if (!bus.wait_for_model(channels))
    throw Failure(ExitCode::failed, "stopped before anything was sent");
  const model_info_t robot = bus.model();

  require_same_robot(robots_named_by(bytes, options.file, channels), robot.name, robot.model_id, "torqued computes");
  Trajectory trajectory =
      parse_trajectory(bytes, options.file, coordinate_names(robot), options.differentiation, channels);
  note(notes(trajectory));
  const Schedule schedule = make_schedule(trajectory, options);

  // from here on they are states of this sender, for this daemon
  const std::int64_t stream_id = random_id();
  for (desired_state_t& state : trajectory.states)
  {
    state.stream_id = stream_id;
    state.model_id = robot.model_id;
    if (options.method)
      state.method = static_cast<std::int8_t>(config.answers.methods.method);
  }

  Ledger ledger(stream_id);
  bus.subscribe(channels.command, [&ledger](Bytes message) { ledger.hear_command(message); });
  bus.subscribe(channels.rejected, [&ledger](Bytes message) { ledger.hear_rejection(message); });
  send_all(bus, channels, schedule, options.loop, trajectory, ledger);

  const Clock::time_point end = Clock::now() + kAnswerPatience;
  while (!ledger.all_settled() && Clock::now() < end)
    bus.wait(end);
  ledger.give_up(INT64_MAX);
  if (options.json)
    print_json(printable(robot.name), ledger);
  else
    print_text(printable(robot.name), ledger);
  ledger.tally().require_answers(options.file);
  return ledger.tally().answered == static_cast<std::int64_t>(ledger.num_sent()) ? ExitCode::done : ExitCode::failed;
}

} // namespace

Subcommand add_send(CLI::App& torquectl)
{
  const auto options = std::make_shared<SendOptions>();
  CLI::App* app = torquectl.add_subcommand("send", "publish a trajectory as desired states, and count what comes back");
  app->add_option("FILE", options->file, "a trajectory CSV, or an LCM log of desired states")
      ->type_name("")
      ->required();
  CLI::Option* speed =
      app->add_option("--speed", options->speed, "how many times faster than the file's times; default: 1")
          ->type_name("X")
          ->check(check_positive);
  app->add_option("--rate", options->rate, "this many desired states per second, whatever the file's times")
      ->type_name("HZ")
      ->check(check_positive)
      ->excludes(speed);
  app->add_flag("--loop", options->loop, "begin again after the end, until Ctrl-C");
  add_differentiation_options(*app, options->differentiation);
  add_method_option(*app, options->method, "the method that all desired states ask for");
  add_bus_option(*app, options->lcm_url);
  add_prefix_option(*app, options->prefix);
  app->add_flag("--json", options->json, "print the summary as JSON");
  app->footer(
      "Coordinate names and model_id are those of the daemon that runs. A desired state without an answer within 1 s\n"
      "counts as lost: it was superseded by a newer one, or did not arrive. One that is due less than 3/4 of a median\n"
      "step after the one before (as where the contacts of a gait change) waits that long for that one's answer. Exit\n"
      "code 1 if any was lost or rejected, 65 if none was answered but some were rejected, or if FILE names another "
      "robot.\n\n"
      "Example, in the source directory, on a bus of this machine alone:\n"
      "  export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'\n"
      "  torqued --robot human-subject01 --every-sample & sleep 1\n"
      "  torquectl send client/trajectories/subject01-walk/walk.csv; kill $!");
  return {app, options, send};
}

} // namespace torqued
