/// Latencies of a status period, and their percentiles.
#pragma once

#include <array>
#include <cstddef>

namespace torqued
{

/// µs; all 0 without samples. Percentiles by nearest rank.
struct LatencyPercentiles
{
  double p50 = 0.0, p90 = 0.0, p99 = 0.0, p999 = 0.0, max = 0.0;
};

/// Collects latencies without allocating: all of the first 2¹⁴ of a period, and of any number the largest.
class Latencies
{
public:
  void add(double us);
  /// The percentiles of what was added since the last call, and starts a new period.
  LatencyPercentiles take();

private:
  std::array<double, 1 << 14> samples_;
  std::size_t count_ = 0;
  double max_ = 0.0;
};

} // namespace torqued
