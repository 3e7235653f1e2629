#include "library/torque_client.h"

#include "text/printable.h"
#include "wire/command_fields.h"
#include "wire/lcm_bus.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace torqued
{

namespace
{

// Finds the first number that is not finite, by its name: "torque[3] is nan".
struct NotFinite
{
  std::string found; // empty if all are finite

  void operator()(const char* name, double number) { one(name, number); }
  void operator()(const char* name, const std::vector<double>& numbers) { among(name, numbers); }
  void operator()(const char* name, const double (&numbers)[2]) { among(name, numbers); }
  void operator()(const char* name, const ground_reaction_t& foot)
  {
    for_each_number([&](const char* part, double number) { one(std::string(name) + "." + part, number); }, foot);
  }
  void operator()(const char*, std::int32_t) {} // flags
  void operator()(const char*, std::int8_t) {}  // method

private:
  void one(const std::string& name, double number)
  {
    if (found.empty() && !std::isfinite(number))
      found = name + " is " + std::to_string(number);
  }
  template <typename Numbers> void among(const std::string& name, const Numbers& numbers)
  {
    int i = 0;
    for (const double number : numbers)
      one(name + "[" + std::to_string(i++) + "]", number);
  }
};

// "ck (model_id 5)"
std::string shown_robot(const model_info_t& model)
{
  return printable(model.name) + " (model_id " + std::to_string(model.model_id) + ")";
}

} // namespace

TorqueClient::TorqueClient(const std::string& lcm_url, const std::string& prefix)
    : bus_(std::make_unique<LcmBus>(lcm_url, "lcm_url")), stream_id_(random_id())
{
  const Channels channels(prefix);
  desired_channel_ = channels.desired;
  bus_->subscribe(
      channels.command,
      [this](Bytes bytes)
      {
        torque_command_t command;
        if (!decode(bytes, command))
          return;
        const auto [stream_id, utime] = std::pair(command.stream_id, command.utime);
        std::string wrong = objection(command);
        settle(stream_id, utime, wrong.empty() ? Reply(std::move(command)) : Discarded{utime, std::move(wrong)});
      });
  bus_->subscribe(channels.rejected,
                  [this](Bytes bytes)
                  {
                    rejection_t rejection;
                    if (!decode(bytes, rejection))
                      return;
                    const auto [stream_id, utime] = std::pair(rejection.stream_id, rejection.utime);
                    settle(stream_id, utime, std::move(rejection));
                  });
  bus_->subscribe(channels.model,
                  [this](Bytes bytes)
                  {
                    if (model_info_t model; decode(bytes, model))
                      hear_model(std::move(model));
                  });
}

TorqueClient::~TorqueClient() = default;

void TorqueClient::hear_model(model_info_t model)
{
  if (!flaw_of(model).empty())
    return;
  if (!model_)
  {
    model_ = std::move(model);
  }
  else if (model.model_id != model_->model_id)
  {
    other_model_ = std::move(model);
  }
  else
  {
    // the same robot: no more than what may differ between daemons
    model_->instance_id = model.instance_id;
    model_->settings_id = model.settings_id;
    model_->settings = std::move(model.settings);
  }
}

// why a command is none for the robot that this client goes by; empty if it is
std::string TorqueClient::objection(const torque_command_t& command) const
{
  if (!model_)
    return "torques came before any daemon has said which robot it computes, so that nothing says whose they are; "
           "wait_for_model() waits until one has";
  if (command.model_id != model_->model_id)
  {
    const bool is_known = other_model_ && other_model_->model_id == command.model_id;
    return "the torques are those of " +
           (is_known ? shown_robot(*other_model_)
                     : "a robot that was not named (model_id " + std::to_string(command.model_id) + ")") +
           "; this client goes by " + shown_robot(*model_);
  }
  if (command.num_joints != model_->num_joints || command.num_coordinates != model_->num_coordinates)
    return "the command has " + std::to_string(command.num_joints) + " torques and " +
           std::to_string(command.num_coordinates) + " accelerations; expected " + std::to_string(model_->num_joints) +
           " and " + std::to_string(model_->num_coordinates) + ", those of " + shown_robot(*model_);
  NotFinite check;
  for_each_field(check, command);
  return check.found.empty() ? "" : "a number of the command is not finite: " + check.found;
}

void TorqueClient::require_outside_callback(const char* function) const
{
  if (calling_back_)
    throw std::logic_error(std::string("TorqueClient::") + function +
                           "() was called within the callback of on_reply(), which may publish() but not wait for more "
                           "replies; call it after the callback has returned");
}

void TorqueClient::settle(std::int64_t stream_id, std::int64_t utime, Reply reply)
{
  if (stream_id != stream_id_)
    return;
  if (utime == asked_)
  {
    asked_ = 0;
    reply_ = std::move(reply);
  }
  else if (outstanding_.erase(utime) > 0 && callback_)
  {
    struct Calling
    {
      bool& now;
      explicit Calling(bool& flag) : now(flag) { now = true; }
      ~Calling() { now = false; }
    };
    const Calling calling(calling_back_);
    callback_(reply);
  }
}

void TorqueClient::give_up(Clock::time_point now)
{
  // the callback may publish: what it publishes is later than `now`
  while (!outstanding_.empty() && outstanding_.begin()->second <= now)
    settle(stream_id_, outstanding_.begin()->first, Silence{outstanding_.begin()->first});
}

bool TorqueClient::wait_for_model(Clock::duration patience)
{
  require_outside_callback("wait_for_model");
  const Clock::time_point until = Clock::now() + patience;
  while (!model_ && Clock::now() < until)
    bus_->wait(until);
  return model_.has_value();
}

desired_state_t TorqueClient::standing() const
{
  desired_state_t desired{};
  desired.left_contact = desired.right_contact = desired_state_t::SOLE;
  desired.load_transfer = desired.phase = 0.5;
  desired.num_coordinates = model_->num_coordinates;
  desired.q.resize(static_cast<std::size_t>(model_->num_coordinates));
  desired.v = desired.a = desired.q;
  return desired;
}

void TorqueClient::publish(desired_state_t& desired)
{
  const auto n = static_cast<std::size_t>(std::max(desired.num_coordinates, std::int32_t{0}));
  if (desired.num_coordinates < 0 || desired.q.size() != n || desired.v.size() != n || desired.a.size() != n)
    throw std::invalid_argument("num_coordinates is " + std::to_string(desired.num_coordinates) +
                                ", and q, v, a have " + std::to_string(desired.q.size()) + ", " +
                                std::to_string(desired.v.size()) + ", " + std::to_string(desired.a.size()) +
                                " numbers; expected as many in each");
  const Clock::time_point now = Clock::now();
  utime_ = std::max(utime_ + 1, microseconds(now));
  desired.utime = utime_;
  desired.stream_id = stream_id_;
  desired.model_id = model_ ? model_->model_id : 0;
  if (callback_)
    outstanding_[utime_] = now + patience_;
  bus_->publish(desired_channel_, encode(desired, buffer_));
}

Reply TorqueClient::ask(desired_state_t& desired, Clock::duration patience)
{
  require_outside_callback("ask");
  const Clock::time_point until = Clock::now() + patience;
  publish(desired);
  outstanding_.erase(desired.utime);
  asked_ = desired.utime;
  reply_.reset();
  while (!reply_ && Clock::now() < until)
  {
    bus_->wait(until);
    give_up(Clock::now());
  }
  asked_ = 0;
  return reply_ ? *std::exchange(reply_, std::nullopt) : Silence{desired.utime};
}

void TorqueClient::restart()
{
  stream_id_ = random_id();
}

void TorqueClient::on_reply(std::function<void(const Reply&)> callback, Clock::duration patience)
{
  require_outside_callback("on_reply");
  callback_ = std::move(callback);
  patience_ = patience;
}

void TorqueClient::handle(Clock::duration at_most)
{
  require_outside_callback("handle");
  Clock::time_point until = Clock::now() + at_most;
  if (!outstanding_.empty())
    until = std::min(until, outstanding_.begin()->second);
  for (int i = 0; i < LcmBus::kQueue && bus_->wait(until); ++i)
    until = Clock::now(); // no more waiting, but all that is there
  give_up(Clock::now());
}

int TorqueClient::file_descriptor()
{
  return bus_->file_descriptor();
}

} // namespace torqued
