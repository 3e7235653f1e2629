/// The daemon as a process, and a client of it. Requires a bus: tools/private-network.
#pragma once

#include "catch.h"
#include "process.h"
#include "temporary_folder.h"

#include "client/files.h"
#include "wire/dynamics_codec.h"

#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <string>
#include <vector>

namespace torqued
{

/// A torqued of its own, and a client that hears all it says.
class Bench
{
public:
  using Clock = std::chrono::steady_clock;

  /// launcher: words before torqued, like those of env or prlimit. The process must be torqued itself in the end.
  /// errors: a file that takes what it prints on stderr; else output() has that, too.
  explicit Bench(std::vector<std::string> arguments = {}, const std::vector<std::string>& launcher = {},
                 const std::string& errors = "")
  {
    REQUIRE(bus_.good());
    for (const std::string& channel :
         {channels_.command, channels_.rejected, channels_.status, channels_.model, channels_.dynamics})
      bus_.subscribeFunction(channel, &Bench::hear, this)->setQueueCapacity(10'000);
    arguments.insert(arguments.begin(), TORQUED);
    arguments.insert(arguments.begin(), launcher.begin(), launcher.end());
    torqued_.emplace(arguments, folder_.file("output"), errors);
    CHECK(wait([&] { return model.has_value(); }));
  }

  Process& torqued() { return *torqued_; }
  std::string output() const { return read_file(folder_.file("output")); }

  /// Hears messages until the condition holds; false if it does not within ten seconds.
  bool wait(const std::function<bool()>& condition)
  {
    const auto until = Clock::now() + std::chrono::seconds(10);
    while (!condition() && Clock::now() < until)
      bus_.handleTimeout(5);
    return condition();
  }

  /// Hears messages for this long.
  void hear_for(Clock::duration duration)
  {
    const auto until = Clock::now() + duration;
    while (Clock::now() < until)
      bus_.handleTimeout(1);
  }

  static std::int64_t now()
  {
    return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()).count();
  }

  desired_state_t standing() const
  {
    desired_state_t desired{};
    desired.utime = now();
    desired.stream_id = 77;
    desired.model_id = model->model_id;
    desired.left_contact = desired.right_contact = desired_state_t::SOLE;
    desired.load_transfer = 0.5;
    desired.num_coordinates = model->num_coordinates;
    desired.q.resize(static_cast<std::size_t>(model->num_coordinates));
    desired.v = desired.a = desired.q;
    return desired;
  }

  void send(Bytes bytes) { bus_.publish(channels_.desired, bytes.data(), static_cast<unsigned>(bytes.size())); }
  void send(const desired_state_t& desired) { publish(channels_.desired, desired); }

  template <typename Message> void publish(const std::string& channel, const Message& message)
  {
    std::vector<std::byte> buffer;
    const Bytes bytes = encode(message, buffer);
    bus_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
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

  std::optional<model_info_t> model;
  std::vector<torque_command_t> commands;
  std::vector<rejection_t> rejections;
  std::vector<status_t> statuses;
  std::vector<dynamics_t> dynamics;

private:
  static void hear(const lcm::ReceiveBuffer* buffer, const std::string& channel, Bench* bench)
  {
    bench->keep(Bytes(static_cast<const std::byte*>(buffer->data), buffer->data_size), channel);
  }

  void keep(Bytes bytes, const std::string& channel)
  {
    bool decoded = true;
    if (channel == channels_.command)
      decoded = decode(bytes, commands.emplace_back());
    else if (channel == channels_.rejected)
      decoded = decode(bytes, rejections.emplace_back());
    else if (channel == channels_.status)
      decoded = decode(bytes, statuses.emplace_back());
    else if (channel == channels_.dynamics)
      decoded = decode(bytes, dynamics.emplace_back());
    else
      decoded = decode(bytes, model.emplace());
    undecoded_ += decoded ? 0 : 1;
  }

  Channels channels_;
  TemporaryFolder folder_;
  lcm::LCM bus_;
  std::optional<Process> torqued_;

public:
  int undecoded_ = 0;
};

} // namespace torqued
