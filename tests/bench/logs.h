/// Recorded traffic: answering a log, compared with just reading it.
#pragma once

#include "bench/rounds.h"

#include <string>

namespace torqued::bench
{

/// One round; the first one makes the log. Throws std::runtime_error where a process fails.
void measure_logs(Rounds& rounds, bool quick);

/// The process that torquectl eval is compared with: reads a log and decodes its desired states by what LCM brings.
/// Returns an exit code: not 0 if there are none.
int read_log(const std::string& log);

} // namespace torqued::bench
