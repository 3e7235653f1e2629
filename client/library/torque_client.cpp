#include "library/torque_client.h"

#include "text/printable.h"
#include "wire/bus_url.h"
#include "wire/messages.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <poll.h>
#include <random>
#include <stdexcept>
#include <time.h>
#include <utility>

namespace torqued
{

namespace
{

// messages that LCM keeps: more than its thirty, so that a client that was busy for a while loses nothing
constexpr int kQueue = 10'000;

std::int64_t random_id()
{
  std::random_device random;
  return static_cast<std::int64_t>(std::uint64_t{random()} << 32 | random());
}

bool is_finite(double number)
{
  return std::isfinite(number);
}

// the first number that is not finite, by its name: "torque[3] is nan"; empty if there is none
std::string not_finite(const torque_command_t& command)
{
  const auto among = [](const std::string& name, const auto& numbers) -> std::string
  {
    const auto found = std::find_if_not(std::begin(numbers), std::end(numbers), is_finite);
    return found == std::end(numbers)
               ? ""
               : name + "[" + std::to_string(found - std::begin(numbers)) + "] is " + std::to_string(*found);
  };
  for (const std::string& found :
       {among("torque", command.torque), among("a", command.a), among("base_a", command.base_a)})
    if (!found.empty())
      return found;
  using Numbers = std::initializer_list<std::pair<const char*, double>>;
  for (const auto& [foot, reaction] : {std::pair("left.", &command.left), std::pair("right.", &command.right)})
    for (const auto& [name, number] : Numbers{{"fx", reaction->fx},
                                              {"fz", reaction->fz},
                                              {"moment", reaction->moment},
                                              {"cop", reaction->cop},
                                              {"friction_ratio", reaction->friction_ratio}})
      if (!is_finite(number))
        return std::string(foot) + name + " is " + std::to_string(number);
  for (const auto& [name, number] : Numbers{{"zmp", command.zmp},
                                            {"dynamics_residual", command.dynamics_residual},
                                            {"contact_speed", command.contact_speed},
                                            {"contact_residual", command.contact_residual},
                                            {"adjustment", command.adjustment}})
    if (!is_finite(number))
      return std::string(name) + " is " + std::to_string(number);
  return "";
}

// "ck (model_id 5)"
std::string shown_robot(const model_info_t& model)
{
  return printable(model.name) + " (model_id " + std::to_string(model.model_id) + ")";
}

// What to say when the bus does not work. Throws std::runtime_error if its URL says already that it does not.
std::string trouble_of(const std::string& lcm_url)
{
  if (const std::string fault = fault_of(choose_bus(lcm_url, "lcm_url")); !fault.empty())
    throw std::runtime_error("the LCM bus cannot be opened: " + fault);
  return bus_trouble(lcm_url);
}

} // namespace

TorqueClient::TorqueClient(const std::string& lcm_url, const std::string& prefix)
    : trouble_(trouble_of(lcm_url)), stream_id_(random_id()), lcm_(lcm_url)
{
  const Channels channels(prefix);
  desired_channel_ = channels.desired;
  command_channel_ = channels.command;
  rejected_channel_ = channels.rejected;
  model_channel_ = channels.model;
  if (!lcm_.good())
    throw std::runtime_error("the LCM bus cannot be opened: " + trouble_);
  // LCM hears itself first; where it does not, its subscription must not be touched
  if (lcm_.getFileno() < 0)
    throw std::runtime_error("the LCM bus does not carry messages, not even to this process itself: " + trouble_);
  for (const std::string* channel : {&command_channel_, &rejected_channel_, &model_channel_})
    lcm_.subscribeFunction(*channel, &TorqueClient::receive, this)->setQueueCapacity(kQueue);
}

void TorqueClient::receive(const lcm::ReceiveBuffer* buffer, const std::string& channel, TorqueClient* client) noexcept
try
{
  client->hear(buffer, channel);
}
catch (...)
{
  // nothing may leave a handler: LCM would abort the process at its next call
  client->thrown_ = std::current_exception();
}

// LCM takes channel names for regular expressions, so what is heard may be of another channel
void TorqueClient::hear(const lcm::ReceiveBuffer* buffer, const std::string& channel)
{
  const Bytes bytes = received_bytes(buffer->data, buffer->data_size);
  torque_command_t command;
  rejection_t rejection;
  model_info_t model;
  if (channel == command_channel_ && decode(bytes, command))
  {
    const auto [stream_id, utime] = std::pair(command.stream_id, command.utime);
    std::string wrong = objection(command);
    settle(stream_id, utime, wrong.empty() ? Reply(std::move(command)) : Discarded{utime, std::move(wrong)});
  }
  else if (channel == rejected_channel_ && decode(bytes, rejection))
  {
    const auto [stream_id, utime] = std::pair(rejection.stream_id, rejection.utime);
    settle(stream_id, utime, std::move(rejection));
  }
  else if (channel == model_channel_ && decode(bytes, model))
  {
    hear(std::move(model));
  }
}

void TorqueClient::hear(model_info_t model)
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
  const std::string number = not_finite(command);
  return number.empty() ? "" : "a number of the command is not finite: " + number;
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

bool TorqueClient::receive(Clock::time_point until)
{
  const auto left = std::max(until - Clock::now(), Clock::duration::zero());
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(left - seconds);
  const timespec timeout{static_cast<time_t>(seconds.count()), static_cast<long>(nanoseconds.count())};
  pollfd fd{lcm_.getFileno(), POLLIN, 0};
  if (ppoll(&fd, 1, &timeout, nullptr) <= 0)
    return false;
  if (lcm_.handle() != 0)
    throw std::runtime_error("the LCM bus cannot be read any more: " + trouble_);
  if (thrown_)
    std::rethrow_exception(std::exchange(thrown_, nullptr));
  return true;
}

bool TorqueClient::wait_for_model(Clock::duration patience)
{
  require_outside_callback("wait_for_model");
  const Clock::time_point until = Clock::now() + patience;
  while (!model_ && Clock::now() < until)
    receive(until);
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
  utime_ = std::max(
      utime_ + 1, std::int64_t{std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count()});
  desired.utime = utime_;
  desired.stream_id = stream_id_;
  desired.model_id = model_ ? model_->model_id : 0;
  if (callback_)
    outstanding_[utime_] = now + patience_;
  if (lcm_.publish(desired_channel_, &desired) != 0)
    throw std::runtime_error("the LCM bus takes no message: " + trouble_);
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
    receive(until);
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
  for (int i = 0; i < kQueue && receive(until); ++i)
    until = Clock::now(); // no more waiting, but all that is there
  give_up(Clock::now());
}

int TorqueClient::file_descriptor()
{
  return lcm_.getFileno();
}

} // namespace torqued
