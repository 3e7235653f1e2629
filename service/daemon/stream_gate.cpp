#include "daemon/stream_gate.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace torqued
{

namespace
{

using Limits = std::numeric_limits<std::int64_t>;

// a − b; a sender's clock may show anything
std::int64_t saturated_difference(std::int64_t a, std::int64_t b)
{
  std::int64_t difference;
  if (!__builtin_sub_overflow(a, b, &difference))
    return difference;
  return a < b ? Limits::min() : Limits::max();
}

} // namespace

StreamGate::StreamGate(double max_age) : max_age_(static_cast<std::int64_t>(std::llround(1e6 * max_age))) {}

bool StreamGate::silent(std::int64_t now) const
{
  return !waiting_ && running(now) - present_.last_accepted > 5 * max_age_;
}

bool StreamGate::gives_way(std::int64_t now) const
{
  return silent(now) && running(now) - lost_until_ > 5 * max_age_;
}

std::optional<Refusal> StreamGate::arrive(const Sender& sender, std::int64_t now)
{
  const bool is_present = following_ && sender.stream_id == present_.id;
  if (following_ && !is_present && !gives_way(now))
  {
    ++conflicts_;
    return Refusal(Reason::other_stream, "stream_id is {}; stream {} is followed until it has been silent for {} us",
                   sender.stream_id, present_.id, 5 * max_age_);
  }
  Stream* const known = is_present ? &present_ : remembered(sender.stream_id);
  if (known != nullptr && sender.utime <= known->last_utime)
    return Refusal(Reason::out_of_order,
                   "utime is {}; expected more than {}, that of this stream's sample before; a client that starts "
                   "anew, or whose clock was set back, takes a new stream_id",
                   sender.utime, known->last_utime);
  const std::int64_t delay = saturated_difference(now, sender.utime);
  if (!is_present)
  {
    const Stream next = known != nullptr ? *known : Stream{sender.stream_id, 0, delay, now, 0, false};
    leave(known);
    present_ = next;
    following_ = true;
  }
  forget(present_, now);
  present_.smallest_delay = std::min(present_.smallest_delay, delay);
  present_.last_utime = sender.utime;
  waiting_ = true;
  return {};
}

std::optional<Refusal> StreamGate::accept(std::int64_t utime, std::int64_t arrival, bool check_age)
{
  waiting_ = false;
  const std::int64_t age = saturated_difference(saturated_difference(arrival, utime), present_.smallest_delay);
  if (check_age && age > max_age_)
    return Refusal(Reason::stale, "the sample is {} us older than the freshest of its stream; max_age is {} us", age,
                   max_age_);
  present_.last_accepted = running(arrival);
  present_.accepted = true;
  return {};
}

StreamGate::Stream* StreamGate::remembered(std::int64_t id)
{
  Stream* const end = left_.data() + num_left_;
  Stream* const found = std::find_if(left_.data(), end, [id](const Stream& stream) { return stream.id == id; });
  return found == end ? nullptr : found;
}

// Remembers the present stream in place of the one that is taken up again, or of the one that was left first.
void StreamGate::leave(Stream* taken_up)
{
  if (!following_ || !present_.accepted)
  {
    if (taken_up != nullptr)
      *taken_up = left_[--num_left_];
    return;
  }
  if (taken_up == nullptr)
    taken_up =
        num_left_ < left_.size() ? &left_[num_left_++] : std::ranges::min_element(left_, {}, &Stream::last_accepted);
  *taken_up = present_;
}

// The smallest delay grows as fast as clocks may drift, but not by more than max_age / 2 at once.
void StreamGate::forget(Stream& stream, std::int64_t now) const
{
  const std::int64_t drift = (now - stream.drift_until) / kDrift;
  const std::int64_t most = max_age_ / 2;
  stream.drift_until = drift < most ? stream.drift_until + drift * kDrift : now;
  if (__builtin_add_overflow(stream.smallest_delay, std::min(drift, most), &stream.smallest_delay))
    stream.smallest_delay = Limits::max();
}

} // namespace torqued
