/// What computations cost, by Google Benchmark.
#pragma once

#include "bench/rounds.h"

namespace torqued::bench
{

/// One round of all computations: ns of a desired state in single support and of each method in double support, of the
/// same inverse dynamics by other engines, of the sines and cosines alone, and of what else there is to compute.
void measure_computations(Rounds& rounds, bool quick);

} // namespace torqued::bench
