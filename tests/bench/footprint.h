/// What the daemon takes: memory, time to start, room on the disk.
#pragma once

#include "bench/rounds.h"

namespace torqued::bench
{

/// One round. Throws std::runtime_error where the daemon does not answer.
void measure_footprint(Rounds& rounds, bool quick);

} // namespace torqued::bench
