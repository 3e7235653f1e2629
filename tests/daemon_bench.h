/// The daemon as a process, and a client of it. Requires a bus: tools/private-network.
#pragma once

#include "catch.h"
#include "decode_dynamics.h"
#include "process.h"
#include "temporary_folder.h"

#include "motion/files.h"
#include "wire/dynamics_codec.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace torqued
{

inline bool all_finite(const torque_command_t& command)
{
  const auto finite = [](double number)
  {
    return std::isfinite(number);
  };
  const auto reaction = [&](const ground_reaction_t& foot)
  {
    return finite(foot.fx) && finite(foot.fz) && finite(foot.moment) && finite(foot.cop) && finite(foot.friction_ratio);
  };
  return reaction(command.left) && reaction(command.right) && finite(command.zmp) &&
         finite(command.dynamics_residual) && finite(command.contact_speed) && finite(command.contact_residual) &&
         std::all_of(command.torque.begin(), command.torque.end(), finite);
}

/// A torqued of its own, and a client that hears all it says.
class Bench
{
public:
  using Clock = std::chrono::steady_clock;

  /// launcher: words before torqued, like those of env or prlimit. The process must be torqued itself in the end.
  /// errors: a file that takes what it prints on stderr; else output() has that, too.
  explicit Bench(std::vector<std::string> arguments = {}, const std::vector<std::string>& launcher = {},
                 const std::string& errors = "")
      : command_(launcher), errors_(errors)
  {
    REQUIRE(bus_.good());
    for (const std::string& channel :
         {channels_.command, channels_.rejected, channels_.status, channels_.model, channels_.dynamics})
      bus_.subscribeFunction(channel, &Bench::hear, this)->setQueueCapacity(10'000);
    command_.push_back(TORQUED);
    command_.insert(command_.end(), arguments.begin(), arguments.end());
    if (std::find(arguments.begin(), arguments.end(), "--robot") == arguments.end())
      command_.insert(command_.end(), {"--robot", "ck"});
    start();
  }

  /// Starts torqued, anew if it ran before: SIGKILL ends that one.
  void start()
  {
    torqued_.reset();
    model.reset();
    torqued_.emplace(command_, folder_.file("output"), errors_);
    CHECK(wait([&] { return model.has_value(); }));
  }

  Process& torqued() { return *torqued_; }
  std::string output() const { return read_file(folder_.file("output")); }

  static std::int64_t now()
  {
    return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()).count();
  }

  /// Hears messages until the condition holds; false if it does not within ten seconds.
  bool wait(const std::function<bool()>& condition)
  {
    const auto until = Clock::now() + std::chrono::seconds(10);
    while (!condition() && Clock::now() < until)
      bus_.handleTimeout(5);
    return condition();
  }

  /// Hears messages until then.
  void hear_until(Clock::time_point until)
  {
    while (Clock::now() < until)
      bus_.handleTimeout(1);
  }
  void hear_for(Clock::duration duration) { hear_until(Clock::now() + duration); }

  desired_state_t standing() const
  {
    desired_state_t desired{};
    desired.utime = now();
    desired.stream_id = kStream;
    desired.model_id = model->model_id;
    desired.left_contact = desired.right_contact = desired_state_t::SOLE;
    desired.load_transfer = 0.5;
    desired.num_coordinates = model->num_coordinates;
    desired.q.resize(static_cast<std::size_t>(model->num_coordinates));
    desired.v = desired.a = desired.q;
    return desired;
  }

  /// Desired states go by another bus from now on, which leads to the daemon's.
  void send_through(lcm::LCM& bus) { out_ = &bus; }

  void send(Bytes bytes) { out_->publish(channels_.desired, bytes.data(), static_cast<unsigned>(bytes.size())); }
  void send(const desired_state_t& desired)
  {
    sent.insert(desired.utime);
    std::vector<std::byte> buffer;
    send(encode(desired, buffer));
  }

  /// Sends a sample and waits for what comes of it.
  void send_one(const desired_state_t& desired)
  {
    const std::size_t before = disposed();
    send(desired);
    REQUIRE(wait([&] { return disposed() > before; }));
  }

  /// Sends a thousand samples a second for this long, and hears what comes.
  void stream(std::chrono::milliseconds duration)
  {
    const auto begin = Clock::now();
    auto last = begin;
    for (auto next = begin; next < begin + duration; next += std::chrono::milliseconds(1))
    {
      hear_until(next);
      send(standing());
      longest_pause = std::max(longest_pause, Clock::now() - last);
      last = Clock::now();
    }
  }

  /// Whether all commands that were heard answer samples of this client.
  bool followed_alone() const
  {
    return std::all_of(commands.begin(), commands.end(),
                       [](const torque_command_t& command) { return command.stream_id == kStream; });
  }

  void publish_bytes(const std::string& channel, Bytes bytes)
  {
    bus_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
  }
  template <typename Message> void publish(const std::string& channel, const Message& message)
  {
    std::vector<std::byte> buffer;
    publish_bytes(channel, encode(message, buffer));
  }

  void ask(std::int64_t request_id)
  {
    dynamics_request_t request{};
    request.request_id = request_id;
    request.want_regressor = 1;
    // what a fixed root, the only one without a base point, demands
    request.left_contact = model->base_names[0].empty() ? dynamics_request_t::SOLE : dynamics_request_t::NONE;
    request.num_coordinates = model->num_coordinates;
    request.q.resize(static_cast<std::size_t>(model->num_coordinates));
    request.v = request.a = request.q;
    publish(channels_.dynamics_request, request);
  }

  /// Waits for a status of now, when nothing is on its way any more.
  const status_t& settled_status()
  {
    hear_for(std::chrono::milliseconds(100));
    const std::size_t heard = statuses.size();
    REQUIRE(wait([&] { return statuses.size() > heard; }));
    return statuses.back();
  }

  /// How many samples were answered or rejected, as heard here.
  std::size_t disposed() const { return commands.size() + rejections.size(); }

  /// Ends the daemon and checks the account of all samples: as its last status gives it, and as it was heard here. All
  /// commands are finite, in order, each for another of the samples that were sent.
  void check_account()
  {
    torqued().signal(SIGTERM);
    REQUIRE(wait([&] { return !statuses.empty() && statuses.back().state == status_t::STOPPING; }));
    const status_t& last = statuses.back();
    CHECK(last.received == last.answered + last.rejected + last.superseded);
    CHECK(last.answered == static_cast<std::int64_t>(commands.size()));
    CHECK(last.rejected == static_cast<std::int64_t>(rejections.size()));
    CHECK(undecoded == 0);
    check_commands();
    CHECK(torqued().wait() == 0);
  }

  void check_commands() const
  {
    const auto later = [](const torque_command_t& a, const torque_command_t& b)
    {
      return a.stream_id == b.stream_id && a.utime >= b.utime;
    };
    CHECK(std::adjacent_find(commands.begin(), commands.end(), later) == commands.end());
    CHECK(std::all_of(commands.begin(), commands.end(), &all_finite));
    CHECK(std::all_of(commands.begin(), commands.end(),
                      [this](const torque_command_t& command) { return sent.count(command.utime) == 1; }));
  }

  /// Forgets commands, rejections and replies, which long runs would fill the memory with.
  void forget()
  {
    commands.clear();
    ages.clear();
    rejections.clear();
    dynamics.clear();
  }

  /// How many rejections were for this reason.
  std::size_t rejected(std::int32_t reason) const
  {
    return static_cast<std::size_t>(std::count_if(rejections.begin(), rejections.end(),
                                                  [reason](const rejection_t& rejection)
                                                  { return rejection.reason == reason; }));
  }

  Clock::duration longest_pause{}; ///< between two samples of stream()
  std::optional<model_info_t> model;
  std::vector<torque_command_t> commands;
  std::vector<std::int64_t> ages; ///< µs from a command's utime until it was heard here, one for each command
  std::vector<rejection_t> rejections;
  std::vector<status_t> statuses;
  std::vector<dynamics_t> dynamics;
  std::set<std::int64_t> sent; ///< the samples' utimes
  int undecoded = 0;           ///< messages of the daemon's that are none

private:
  static constexpr std::int64_t kStream = 77;

  static void hear(const lcm::ReceiveBuffer* buffer, const std::string& channel, Bench* bench)
  {
    bench->keep(received_bytes(buffer->data, buffer->data_size), channel);
  }

  void keep(Bytes bytes, const std::string& channel)
  {
    bool decoded = true;
    if (channel == channels_.command)
    {
      decoded = decode(bytes, commands.emplace_back());
      ages.push_back(now() - commands.back().utime);
    }
    else if (channel == channels_.rejected)
      decoded = decode(bytes, rejections.emplace_back());
    else if (channel == channels_.status)
      decoded = decode(bytes, statuses.emplace_back());
    else if (channel == channels_.dynamics)
      decoded = decode(bytes, dynamics.emplace_back());
    else if (model_info_t said; (decoded = decode(bytes, said)))
      model = said;
    undecoded += decoded ? 0 : 1;
  }

  Channels channels_;
  TemporaryFolder folder_;
  lcm::LCM bus_;
  lcm::LCM* out_ = &bus_;
  std::vector<std::string> command_;
  std::string errors_;
  std::optional<Process> torqued_;
};

} // namespace torqued
