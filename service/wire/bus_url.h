/// The URL of an LCM bus: who sets it, what LCM makes of it, and what can be said against it before it is opened.
#pragma once

#include <optional>
#include <string>

namespace torqued
{

/// An LCM bus, as its URL says.
struct BusUrl
{
  enum class Provider
  {
    udpm,   ///< UDP multicast
    mpudpm, ///< the same, by a port for each channel
    tcpq,   ///< a server that passes messages on
    memq,   ///< within one process
    file    ///< a log, which is replayed or written
  };
  Provider provider = Provider::udpm;
  std::string address = "239.255.76.67"; ///< IPv4: the multicast group, or tcpq's server; memq, file: without meaning
  int port = 7667;                       ///< likewise
  int ttl = 0;                           ///< of multicast; 0: messages do not leave this machine
  std::optional<int> buffer_size;        ///< recv_buf_size, bytes, if it asks for one
};

/// Reads a URL as LCM does: udpm://[ADDRESS:PORT][?ttl=N&recv_buf_size=BYTES] or those of LCM's other providers; an
/// empty one means LCM's default. What LCM would misunderstand in silence, or look for in vain, is refused: throws
/// std::invalid_argument with what is wrong and what would be right.
BusUrl read_bus_url(const std::string& url);

/// Which bus is meant.
struct ChosenBus
{
  std::string url;    ///< empty: LCM's default
  std::string set_by; ///< "--lcm-url", "LCM_DEFAULT_URL", …; empty: nobody, it is the default
};

/// lcm_url: empty where none was given, which leaves it to LCM_DEFAULT_URL; given_by: who gave it, if it was given.
ChosenBus choose_bus(const std::string& lcm_url, const std::string& given_by);

/// What is wrong with the chosen bus, by its URL alone: which it is, who set it, and what would be right; empty if
/// nothing is.
std::string fault_of(const ChosenBus& bus);

/// The same for a process that wants to be heard by others: neither a queue within this process will do nor a log.
std::string fault_between_processes(const ChosenBus& bus);

/// What to say when the bus does not work: which bus was meant, who said so, and what it needs. For the end of a
/// complaint. lcm_url, given_by: as for choose_bus().
std::string bus_trouble(const std::string& lcm_url, const std::string& given_by = "lcm_url");

} // namespace torqued
