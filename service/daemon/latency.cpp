#include "daemon/latency.h"

#include <algorithm>
#include <cmath>

namespace torqued
{

void Latencies::add(double us)
{
  max_ = std::max(max_, us);
  if (count_ < samples_.size())
    samples_[count_++] = us;
}

LatencyPercentiles Latencies::take()
{
  LatencyPercentiles result;
  const auto end = samples_.begin() + static_cast<std::ptrdiff_t>(count_);
  const auto percentile = [&](double share)
  {
    const auto rank = static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(count_))) - 1;
    std::nth_element(samples_.begin(), samples_.begin() + rank, end);
    return samples_[static_cast<std::size_t>(rank)];
  };
  if (count_ > 0)
    result = {percentile(0.5), percentile(0.9), percentile(0.99), percentile(0.999), max_};
  count_ = 0;
  max_ = 0.0;
  return result;
}

} // namespace torqued
