/// What the bus is measured against: processes that do as little as can be done. They are this program itself, by words
/// on its command line, and end with the one that started them.
#pragma once

#include "process.h"

#include <string>

namespace torqued::bench
{

/// The command lines of the servers.
std::vector<std::string> torqued_command(const std::string& url, std::vector<std::string> options = {});
std::vector<std::string> lcm_echo_command(const std::string& url);
std::vector<std::string> udp_echo_command(int hears, int sends_to);

/// Hears desired states by LCM, in the plainest way, and publishes the same bytes as commands. Returns when the bus is
/// broken: an exit code.
int lcm_echo(const std::string& url);
/// Sends back what comes, to another port. Throws std::system_error.
int udp_echo(int hears, int sends_to);

} // namespace torqued::bench
