#include "wire/bus_trouble.h"

#include <cstdlib>
#include <fmt/format.h>

namespace torqued
{

std::string bus_trouble(const std::string& lcm_url)
{
  const char* preset = std::getenv("LCM_DEFAULT_URL");
  const std::string who = !lcm_url.empty() ? fmt::format("lcm_url is \"{}\"", lcm_url)
                          : preset         ? fmt::format("LCM_DEFAULT_URL is \"{}\"", preset)
                                           : "neither --lcm-url nor LCM_DEFAULT_URL is set, so LCM's default was tried";
  return who + ". A bus within one machine is udpm://239.255.76.67:7667?ttl=0 and needs: "
               "sudo ip link set lo up multicast on; sudo ip route add 224.0.0.0/4 dev lo";
}

} // namespace torqued
