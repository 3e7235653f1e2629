#include "daemon/stream_gate.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace torqued
{

namespace
{

// a − b; a sender's clock may show anything
std::int64_t saturated_difference(std::int64_t a, std::int64_t b)
{
  std::int64_t difference;
  if (!__builtin_sub_overflow(a, b, &difference))
    return difference;
  return a < b ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
}

} // namespace

StreamGate::StreamGate(double max_age) : max_age_(static_cast<std::int64_t>(std::llround(1e6 * max_age))) {}

bool StreamGate::silent(std::int64_t now) const
{
  return running(now) - last_accepted_ > 5 * max_age_;
}

std::optional<Refusal> StreamGate::arrive(const Sender& sender, std::int64_t now)
{
  if (following_ && silent(now))
    following_ = false;
  if (following_ && sender.stream_id != stream_id_)
  {
    ++conflicts_;
    return Refusal(Reason::other_stream, "stream_id is {}; stream {} is followed until it has been silent for {} us",
                   sender.stream_id, stream_id_, 5 * max_age_);
  }
  if (following_ && sender.utime <= last_utime_)
    return Refusal(Reason::out_of_order, "utime is {}; expected more than {}, that of the sample before", sender.utime,
                   last_utime_);
  if (!following_)
  {
    following_ = true;
    stream_id_ = sender.stream_id;
    began_ = now;
    last_accepted_ = running(now);
    windows_.fill({});
  }
  last_utime_ = sender.utime;
  remember_delay(saturated_difference(now, sender.utime), now);
  return {};
}

std::optional<Refusal> StreamGate::accept(std::int64_t utime, std::int64_t arrival, bool check_age)
{
  const std::int64_t delay = saturated_difference(arrival, utime);
  const std::int64_t age = saturated_difference(delay, smallest_delay(arrival));
  if (check_age && age > max_age_)
    return Refusal(Reason::stale, "the sample is {} us older than the freshest of the last 10 s; max_age is {} us", age,
                   max_age_);
  if (check_age && resumed_ && began_ >= *resumed_ && arrival - *resumed_ <= max_age_)
    return Refusal(
        Reason::stale,
        "the stream starts {} us after the daemon itself stood still, so the sample may be of any age; expected "
        "more than {} us, max_age",
        arrival - *resumed_, max_age_);
  last_accepted_ = running(arrival);
  return {};
}

void StreamGate::remember_delay(std::int64_t delay, std::int64_t now)
{
  const std::int64_t number = running(now) / kWindow;
  Window& window = windows_[static_cast<std::size_t>(number) % windows_.size()];
  window = {number, window.number == number ? std::min(window.smallest_delay, delay) : delay};
}

std::int64_t StreamGate::smallest_delay(std::int64_t now) const
{
  const std::int64_t newest = running(now) / kWindow;
  std::int64_t smallest = std::numeric_limits<std::int64_t>::max();
  for (const Window& window : windows_)
    if (window.number >= 0 && window.number > newest - static_cast<std::int64_t>(windows_.size()))
      smallest = std::min(smallest, window.smallest_delay);
  return smallest;
}

} // namespace torqued
