/// The URL of an LCM bus over UDP multicast.
#pragma once

#include <optional>
#include <string>

namespace torqued
{

/// An LCM bus over UDP multicast.
struct BusUrl
{
  std::string address = "239.255.76.67";
  int port = 7667;
  int ttl = 0;                    ///< 0: messages do not leave this machine
  std::optional<int> buffer_size; ///< recv_buf_size, bytes, if it asks for one
};

/// Reads a URL as LCM does: udpm://[ADDRESS[:PORT]][?ttl=N&recv_buf_size=BYTES]; an empty one means LCM's default.
/// Throws std::invalid_argument with what is wrong.
BusUrl read_bus_url(const std::string& url);

/// The URL that LCM goes by where it is given this one: LCM_DEFAULT_URL instead of an empty one.
std::string effective_bus_url(const std::string& lcm_url);

} // namespace torqued
