#include "client/torque_client.h"

#include "wire/messages.h"

#include <algorithm>
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

} // namespace

TorqueClient::TorqueClient(const std::string& lcm_url, const std::string& prefix)
    : trouble_(bus_trouble(lcm_url)), stream_id_(random_id()), lcm_(lcm_url)
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
    settle(stream_id, utime, std::move(command));
  }
  else if (channel == rejected_channel_ && decode(bytes, rejection))
  {
    const auto [stream_id, utime] = std::pair(rejection.stream_id, rejection.utime);
    settle(stream_id, utime, std::move(rejection));
  }
  else if (channel == model_channel_ && decode(bytes, model))
  {
    model_ = std::move(model);
  }
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
  callback_ = std::move(callback);
  patience_ = patience;
}

void TorqueClient::handle(Clock::duration at_most)
{
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
