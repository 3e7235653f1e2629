/// What the system gives a process near motors: memory that stays, a thread that comes before others, processors.
#pragma once

#include "answer/config.h"

#include <string>

namespace torqued
{

/// Locks the memory of the process, and puts [scheduling] into effect for the calling thread. Threads that it starts
/// later inherit that, so start them before. What the system then says is in effect, for the log; empty if nothing is
/// asked for. Throws std::runtime_error with what was asked, what the system said, and the command that permits it.
std::string enter_real_time(const Config& config);

} // namespace torqued
