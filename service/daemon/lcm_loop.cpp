#include "daemon/lcm_loop.h"

#include "answer/command.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <poll.h>
#include <spdlog/logger.h>
#include <time.h>

#ifndef TORQUED_VERSION
#error "TORQUED_VERSION comes from the build"
#endif

namespace torqued
{

namespace
{

constexpr std::int64_t kStatusPeriod = 100'000;  // µs
constexpr std::int64_t kModelPeriod = 2'000'000; // µs
constexpr std::int64_t kBusProof = 1'000'000;    // µs
// When so many of our own statuses in a row have not come back, the bus is broken.
constexpr int kDeaf = 5;
// After so many messages a cycle looks whether it shall end.
constexpr int kBetweenLooks = 32;
// A cycle takes messages for so long, µs, so that a flood keeps neither statuses nor watchdog from their turn, and a
// sample from its answer for no longer than kLongestWait: it would often be superseded meanwhile. Of a backlog only the
// newest counts: that is taken for longer, while each sample supersedes the one before, and whatever it holds if the
// process itself stood still.
constexpr std::int64_t kLongestIntake = 500;
constexpr std::int64_t kLongestWait = 100;
constexpr std::int64_t kLongestBacklog = 50'000;

// What is logged besides refusals, which are logged by the numbers of their reasons, from 1. A repeated one is logged
// once in a while, and counted.
constexpr std::size_t kBusTookNoMessage = 0;
constexpr std::size_t kOtherDaemon = 16;
constexpr std::int64_t kSecond = 1'000'000; // µs

std::int64_t nanoseconds(clockid_t clock)
{
  timespec now;
  clock_gettime(clock, &now);
  return std::int64_t{1'000'000'000} * now.tv_sec + now.tv_nsec;
}

std::int64_t monotonic_us()
{
  return nanoseconds(CLOCK_MONOTONIC) / 1000;
}

std::int64_t max_age_us(const Config& config)
{
  return std::llround(1e6 * config.max_age);
}

} // namespace

LcmLoop::LcmLoop(lcm::LCM& bus, Receiver& receiver, const Robot& robot, const Config& config, spdlog::logger& log,
                 Surroundings surroundings)
    : bus_(bus), receiver_(receiver), robot_(robot), config_(config), log_(log), surroundings_(std::move(surroundings)),
      channels_(config.prefix), parameters_(base_parameters(robot)), gate_(config.max_age), command_(), rejection_(),
      status_(), dynamics_(), start_(monotonic_us()), last_awake_(start_), drained_at_(start_), resumed_(start_)
{
  rejected_at_.fill(start_ - kSecond);
  const std::int64_t id = settings_id(config_.answers);
  status_.instance_id = random_id();
  status_.model_id = robot_.model_id;
  status_.settings_id = id;
  status_.version = TORQUED_VERSION;
  model_ = model_info(robot_, status_.instance_id, id, to_toml(config_));
  // all memory that messages can ever ask for
  command_.a.reserve(kMaxCoordinates);
  command_.torque.reserve(kMaxJoints);
  rejection_.detail.reserve(256);
  reserve(dynamics_, robot_, parameters_);
  encode(dynamics_, buffer_);
  encode(model_, buffer_);

  receiver_.subscribe(channels_.status, [this](Bytes message) { on_status(message); });
}

bool LcmLoop::listen()
{
  last_awake_ = monotonic_us();
  return receiver_.subscribe(channels_.desired, [this](Bytes message) { on_desired(message); }) &&
         receiver_.subscribe(channels_.dynamics_request, [this](Bytes message) { on_request(message); });
}

bool LcmLoop::prove_bus(int stop_fd)
{
  const std::int64_t until = monotonic_us() + kBusProof;
  publish_status(status_t::WAITING);
  std::array<pollfd, 2> fds{{{receiver_.fd(), POLLIN, 0}, {stop_fd, POLLIN, 0}}};
  while (statuses_away_ > 0 && (fds[1].revents & POLLIN) == 0 && monotonic_us() < until)
  {
    poll(fds.data(), fds.size(), receiver_.holds() ? 0 : 10);
    receiver_.take();
  }
  return statuses_away_ == 0;
}

void LcmLoop::run(int stop_fd)
{
  while (!cycle(1.0, stop_fd))
  {
  }
  publish_status(status_t::STOPPING);
}

bool LcmLoop::cycle(double timeout, int stop_fd)
{
  // wake up at least every max_age, so that an own stall is told from a silent sender
  const std::int64_t before = monotonic_us();
  notice_own_stall(before);
  const double until_status = 1e-6 * static_cast<double>(std::max<std::int64_t>(next_status_ - before, 0));
  const bool idle = requests_.count == 0 && !receiver_.holds();
  const double wait = idle ? std::min({timeout, config_.max_age, until_status}) : 0.0;
  const int wait_ms = static_cast<int>(std::ceil(1e3 * wait));
  std::array<pollfd, 2> fds{{{receiver_.fd(), POLLIN, 0}, {stop_fd, POLLIN, 0}}};
  poll(fds.data(), fds.size(), wait_ms);
  const std::int64_t begin = monotonic_us();
  notice_own_stall(begin, std::int64_t{1000} * wait_ms);
  if (drained_)
    drained_at_ = begin;

  bool takes = true, stood_still = false;
  std::int64_t from = begin;
  for (int taken = 1; takes && (fds[1].revents & POLLIN) == 0; ++taken)
  {
    const std::int64_t superseded = status_.superseded;
    drained_ = !receiver_.take();
    if (drained_)
      break;
    const std::int64_t now = monotonic_us();
    notice_own_stall(now);
    if (!stood_still && resumed_ >= before)
    {
      stood_still = true; // only once, or a starved process would take messages for ever
      from = std::max(begin, resumed_);
    }
    const bool backlog = stood_still || status_.superseded > superseded;
    takes = backlog ? now - from < kLongestBacklog
                    : now - from < kLongestIntake && (!pending_ || now - pending_arrival_ < kLongestWait);
    if (taken % kBetweenLooks == 0)
      poll(&fds[1], 1, 0);
  }
  answer_pending();
  answer_oldest_request();
  note_deafness();
  publish_status_and_model_when_due();
  return (fds[1].revents & POLLIN) != 0;
}

// Notes whether this process itself stood still since it last looked, beyond the time (µs) it meant to sleep.
void LcmLoop::notice_own_stall(std::int64_t now, std::int64_t asleep)
{
  const std::int64_t stood_still = now - last_awake_ - asleep;
  last_awake_ = now;
  if (static_cast<double>(stood_still) <= 1e6 * config_.max_age)
    return;
  gate_.pause(stood_still);
  resumed_ = now;
}

void LcmLoop::on_desired(Bytes message) noexcept
try
{
  dispose_of(message);
}
catch (const std::exception& error)
{
  log_.critical("a desired state was lost: {}", error.what());
}

void LcmLoop::dispose_of(Bytes message)
{
  const std::int64_t arrival = monotonic_us();
  notice_own_stall(arrival);
  last_arrival_ = arrival;
  note_losses(arrival);
  // what the present stream sends waits behind this
  if (static_cast<double>(arrival - drained_at_) > 1e6 * config_.max_age)
    gate_.note_loss(arrival);
  const Result<DesiredState> decoded = decode_desired_state(message, robot_);
  if (const Refusal* refusal = std::get_if<Refusal>(&decoded))
    return reject(read_sender(message), *refusal);
  const DesiredState& desired = std::get<DesiredState>(decoded);
  const Sender sender{desired.utime, desired.stream_id};
  if (const auto refusal = gate_.arrive(sender, arrival))
    return reject(sender, *refusal);

  if (config_.every_sample)
    return answer_sample(desired, arrival);
  if (pending_)
  {
    ++status_.superseded;
    ++status_.received;
  }
  pending_ = desired;
  pending_arrival_ = arrival;
}

// Where messages found no room, the present stream's may have been among them, and our own status: a bus that brings
// too much does carry messages.
void LcmLoop::note_losses(std::int64_t now)
{
  const std::int64_t lost = receiver_.most_lost();
  if (lost > status_.dropped_upper_bound && lost > 0)
  {
    gate_.note_loss(now);
    note_healthy();
  }
  status_.dropped_upper_bound = lost;
}

void LcmLoop::answer_pending()
{
  if (!pending_)
    return;
  const DesiredState desired = *pending_;
  pending_.reset();
  answer_sample(desired, pending_arrival_);
}

void LcmLoop::answer_sample(const DesiredState& desired, std::int64_t arrival)
{
  const Sender sender{desired.utime, desired.stream_id};
  // its age is that at its arrival, or when this process went on after it had stood still since
  notice_own_stall(monotonic_us());
  if (const auto refusal = gate_.accept(desired.utime, std::max(arrival, resumed_), !config_.every_sample))
    return reject(sender, *refusal);

  const std::int64_t begin = nanoseconds(CLOCK_MONOTONIC);
  StreamMemory memory = memory_;
  const Result<Answer> answered =
      answer(robot_, config_.answers, desired, memory, OwnClock{begin / 1000, max_age_us(config_)});
  const std::int64_t end = nanoseconds(CLOCK_MONOTONIC);
  if (const Refusal* refusal = std::get_if<Refusal>(&answered))
    return reject(sender, *refusal);

  fill(command_, std::get<Answer>(answered), robot_.model_id, status_.settings_id);
  command_.sequence = status_.answered + 1;
  command_.compute_ns = static_cast<std::int32_t>(std::min<std::int64_t>(end - begin, INT32_MAX));
  const bool late = static_cast<double>(monotonic_us() - arrival) > 1e6 * config_.deadline;
  command_.flags |= late ? flag::late : 0;
  const Bytes bytes = encode(command_, buffer_);

  // a last look at the clock: what stopped this process until now made the torques old
  const std::int64_t now = monotonic_us();
  notice_own_stall(now);
  if (!config_.every_sample && now - arrival > max_age_us(config_))
    return reject(sender,
                  Refusal(Reason::stale, "the answer was ready {} us after its sample had come; max_age is {} us",
                          now - arrival, max_age_us(config_)));
  send(channels_.command, bytes);
  memory_ = memory;
  status_.late += late ? 1 : 0;
  ++status_.answered;
  ++status_.received;
  latencies_.add(static_cast<double>(monotonic_us() - arrival));
}

void LcmLoop::reject(const Sender& sender, const Refusal& refusal)
{
  fill(rejection_, sender, refusal);
  if (may_publish_rejection())
    publish(channels_.rejected, rejection_);
  ++status_.rejected;
  ++status_.received;
  status_.last_reason = rejection_.reason;

  // cut, because spdlog allocates for lines of more than 250 characters; the rejection has all of it
  if (may_log(static_cast<std::size_t>(refusal.reason()), kSecond))
    log_.warn("rejected: {}: {:.170} ({} rejected so far)", name_of(refusal.reason()), refusal.detail(),
              status_.rejected);
}

// Whether fewer than kMostRejections have been published in the second before; then this one counts as published.
bool LcmLoop::may_publish_rejection()
{
  const std::int64_t now = monotonic_us();
  std::int64_t& oldest = rejected_at_[next_rejection_];
  if (now - oldest < kSecond)
    return false;
  oldest = now;
  next_rejection_ = (next_rejection_ + 1) % rejected_at_.size();
  return true;
}

// Whether this has not been logged for a while (µs); then it counts as logged now.
bool LcmLoop::may_log(std::size_t what, std::int64_t period)
{
  const std::int64_t now = monotonic_us();
  if (now < next_log_[what])
    return false;
  next_log_[what] = now + period;
  return true;
}

// A request waits until no desired state does; one too many is dropped, so that a flood costs no more than its
// reception.
void LcmLoop::on_request(Bytes message)
{
  if (requests_.count == requests_.ring.size())
    return;
  Requests::Request& request = requests_.ring[(requests_.oldest + requests_.count++) % requests_.ring.size()];
  request.size = std::min(message.size(), request.bytes.size());
  std::copy_n(message.begin(), request.size, request.bytes.begin());
}

void LcmLoop::answer_oldest_request()
{
  if (requests_.count == 0)
    return;
  const Requests::Request& request = requests_.ring[requests_.oldest];
  answer_dynamics(robot_, parameters_, Bytes(request.bytes.data(), request.size), dynamics_);
  requests_.oldest = (requests_.oldest + 1) % requests_.ring.size();
  --requests_.count;
  publish(channels_.dynamics, dynamics_);
}

void LcmLoop::on_status(Bytes message)
{
  const std::int64_t instance_id = read_status_instance(message);
  if (instance_id == status_.instance_id)
    note_healthy();
  else if (instance_id != 0 && may_log(kOtherDaemon, 10 * kSecond))
  {
    log_.error("another daemon, instance {}, publishes on {}, too: clients get two answers to each sample; stop one of "
               "them, or give it another --prefix",
               instance_id, channels_.status);
  }
}

// Once for each status, however often others repeat it.
void LcmLoop::note_healthy()
{
  if (statuses_away_ == 0)
    return;
  statuses_away_ = 0;
  surroundings_.on_healthy();
}

// Says when the bus stops carrying our messages back to us, and when it does so again.
void LcmLoop::note_deafness()
{
  const bool deaf = statuses_away_ > kDeaf;
  if (deaf == deaf_)
    return;
  deaf_ = deaf;
  if (deaf)
    log_.error("the bus does not bring back this daemon's own status any more: it is deaf until the bus is mended");
  else
    log_.warn("the bus carries messages again");
}

std::int8_t LcmLoop::state(std::int64_t now) const
{
  if (!gate_.following())
    return status_t::WAITING;
  return gate_.silent(now) ? status_t::STALE : status_t::RUNNING;
}

void LcmLoop::publish_status_and_model_when_due()
{
  const std::int64_t now = monotonic_us();
  if (now >= next_status_)
  {
    publish_status(state(now));
    next_status_ = now + kStatusPeriod;
  }
  if (now >= next_model_)
  {
    publish(channels_.model, model_);
    next_model_ = now + kModelPeriod;
  }
}

void LcmLoop::publish_status(std::int8_t state)
{
  const std::int64_t now = monotonic_us();
  const LatencyPercentiles latency = latencies_.take();
  status_.utime = nanoseconds(CLOCK_REALTIME) / 1000;
  status_.uptime_us = now - start_;
  status_.state = state;
  status_.conflicts = gate_.conflicts();
  note_losses(now);
  status_.dropped_logs = surroundings_.dropped_logs();
  status_.input_age_us = last_arrival_ < 0 ? -1 : now - last_arrival_;
  status_.latency_us_p50 = latency.p50;
  status_.latency_us_p90 = latency.p90;
  status_.latency_us_p99 = latency.p99;
  status_.latency_us_p999 = latency.p999;
  status_.latency_us_max = latency.max;
  ++statuses_away_;
  publish(channels_.status, status_);
}

template <typename Message> void LcmLoop::publish(const std::string& channel, const Message& message)
{
  send(channel, encode(message, buffer_));
}

void LcmLoop::send(const std::string& channel, Bytes bytes)
{
  if (bus_.publish(channel, bytes.data(), static_cast<unsigned int>(bytes.size())) != 0 &&
      may_log(kBusTookNoMessage, kSecond))
    log_.error("the bus did not take a message of {} bytes on {}", bytes.size(), channel);
}

} // namespace torqued
