/// Looks at this machine for what a bus needs.
#pragma once

#include "bus/diagnosis.h"

namespace torqued
{

/// All but what LCM brings: daemons. lcm_url: empty for LCM's default, which heeds LCM_DEFAULT_URL. Asks the programs
/// ip and nft, and sends one message to itself; changes nothing. Where the URL cannot be read it looks at nothing else.
BusFacts look_at_bus(const std::string& lcm_url);

} // namespace torqued
