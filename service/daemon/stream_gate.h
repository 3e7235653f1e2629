/// Which desired states may be answered: one stream at a time, in order, not too old.
#pragma once

#include "torque/refusal.h"
#include "wire/codec.h"

#include <array>
#include <cstdint>
#include <optional>

namespace torqued
{

/// Follows one stream of desired states. Times are µs of a monotonic clock, which the caller reads.
///
/// A stream is followed from its first sample until it has been silent, without an accepted sample, for 5 × max_age;
/// then its clock offset, its order and its name are forgotten, and the next sample of whoever starts anew.
///
/// Age: the sender's clock and ours need not agree. A sample's delay is our arrival time minus its utime; its age is
/// its delay minus the smallest delay of the last 10 s, so the freshest sample seen lately counts as new. What waited
/// while the process itself did not run, and belongs to no stream whose delays are known, may be of any age: for
/// max_age after such a pause the samples of a stream that starts anew are stale.
class StreamGate
{
public:
  /// max_age: s.
  explicit StreamGate(double max_age);

  /// Takes note of a checked sample that has arrived. Refuses: other_stream, out_of_order.
  std::optional<Refusal> arrive(const Sender& sender, std::int64_t now);

  /// Accepts the last sample that arrived, which is about to be answered. With check_age, refuses: stale.
  /// arrival: when it arrived, or a later time if the process did not run in between.
  std::optional<Refusal> accept(std::int64_t utime, std::int64_t arrival, bool check_age);

  /// The process itself did not run for this long (µs), until now: stream, order and clock offset outlive it.
  void pause(std::int64_t duration, std::int64_t now)
  {
    paused_ += duration;
    resumed_ = now;
  }

  bool following() const { return following_; }
  /// Whether the stream has been silent for so long that the next sample starts anew.
  bool silent(std::int64_t now) const;
  /// Samples refused as other_stream since the start.
  std::int64_t conflicts() const { return conflicts_; }

private:
  // the smallest delay of each half second
  struct Window
  {
    std::int64_t number = -1;
    std::int64_t smallest_delay = 0;
  };
  static constexpr std::int64_t kWindow = 500'000;

  void remember_delay(std::int64_t delay, std::int64_t now);
  std::int64_t smallest_delay(std::int64_t now) const;
  std::int64_t running(std::int64_t now) const { return now - paused_; }

  std::int64_t max_age_;
  std::int64_t paused_ = 0;
  std::optional<std::int64_t> resumed_; // when the last pause ended
  bool following_ = false;
  std::int64_t stream_id_ = 0;
  std::int64_t last_utime_ = 0;
  std::int64_t began_ = 0;         // when the stream started anew
  std::int64_t last_accepted_ = 0; // running time
  std::int64_t conflicts_ = 0;
  std::array<Window, 20> windows_;
};

} // namespace torqued
