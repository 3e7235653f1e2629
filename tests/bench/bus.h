/// The daemon on its bus, from a client's side.
#pragma once

#include "bench/rounds.h"

namespace torqued::bench
{

// Each measures one round, and with quick a short one that tells nothing. They throw std::runtime_error where a server
// does not answer at all.

/// Client to server and back at 100 Hz, at 1 kHz and one after the other: torqued, an echo by LCM, one by bare sockets.
void measure_round_trips(Rounds& rounds, bool quick);
/// What is lost of 20,000 samples in a second: by torqued --every-sample, and by the LCM echo.
void measure_flood(Rounds& rounds, bool quick);
/// Twenty daemons, each on a bus of its own with a thousand samples a second.
void measure_many(Rounds& rounds, bool quick);

} // namespace torqued::bench
