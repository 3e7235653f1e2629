/// Which desired states may be answered: one stream at a time, in order, not too old.
#pragma once

#include "stance/refusal.h"
#include "wire/codec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace torqued
{

/// Follows one stream of desired states. Times are µs of a monotonic clock, which the caller reads.
///
/// A stream is followed until it has been silent, without an accepted sample, for 5 × max_age in which the process ran
/// and kept up, and no message was lost; a sample that waits for its answer keeps its stream. Only then is another
/// stream followed. Order and clock offset belong to a stream_id, for good: a stream that was silent, or left, goes on
/// where it was. Those of the last kRemembered streams that were left are kept; a stream counts once one of its samples
/// was accepted.
///
/// Age: the sender's clock and ours need not agree. A sample's delay is our arrival time minus its utime; its age is
/// its delay minus the smallest delay of its stream so far, which is forgotten no faster than clocks drift: kDrift of
/// the time that passes, and at most max_age / 2 from one sample to the next. So what comes late after a gap is late.
/// The first sample of a stream has no known age.
class StreamGate
{
public:
  /// Streams that were left and are remembered, besides the present one.
  static constexpr std::size_t kRemembered = 63;
  /// How much faster one clock may run than another: 1 in so many.
  static constexpr std::int64_t kDrift = 10'000;

  /// max_age: s.
  explicit StreamGate(double max_age);

  /// Takes note of a checked sample that has arrived. Refuses: other_stream, out_of_order.
  std::optional<Refusal> arrive(const Sender& sender, std::int64_t now);

  /// Accepts the last sample that arrived, which is about to be answered. With check_age, refuses: stale.
  /// arrival: when it arrived, or a later time if the process did not run in between.
  std::optional<Refusal> accept(std::int64_t utime, std::int64_t arrival, bool check_age);

  /// The process itself did not run for this long (µs): it counts as no one's silence.
  void pause(std::int64_t duration) { paused_ += duration; }

  /// Until now messages of any stream may have been lost, or may still wait: that counts as no one's silence.
  void note_loss(std::int64_t now) { lost_until_ = running(now); }

  bool following() const { return following_; }
  /// Whether the present stream has been silent for so long that another one would be followed, were no message lost.
  bool silent(std::int64_t now) const;
  /// Samples refused as other_stream since the start.
  std::int64_t conflicts() const { return conflicts_; }

private:
  struct Stream
  {
    std::int64_t id = 0;
    std::int64_t last_utime = 0;
    std::int64_t smallest_delay = 0; // with the drift of the clocks until drift_until
    std::int64_t drift_until = 0;
    std::int64_t last_accepted = 0; // running time
    bool accepted = false;          // whether ever
  };

  bool gives_way(std::int64_t now) const;
  Stream* remembered(std::int64_t id);
  void leave(Stream* taken_up);
  void forget(Stream& stream, std::int64_t now) const;
  std::int64_t running(std::int64_t now) const { return now - paused_; }

  std::int64_t max_age_;
  std::int64_t paused_ = 0;
  std::int64_t lost_until_ = std::numeric_limits<std::int64_t>::min() / 2;
  std::int64_t conflicts_ = 0;
  bool following_ = false;
  bool waiting_ = false; // a sample of the present stream waits for accept()
  Stream present_;
  std::array<Stream, kRemembered> left_;
  std::size_t num_left_ = 0;
};

} // namespace torqued
