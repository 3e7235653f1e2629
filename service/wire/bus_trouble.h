/// What to say when the bus does not work.
#pragma once

#include <string>

namespace torqued
{

/// Which bus was meant, who said so, and what LCM needs within one machine: for the end of a complaint.
/// lcm_url: empty where LCM's own default was asked for, which heeds LCM_DEFAULT_URL.
std::string bus_trouble(const std::string& lcm_url);

} // namespace torqued
