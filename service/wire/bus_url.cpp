#include "wire/bus_url.h"

#include "text/printable.h"

#include <arpa/inet.h>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

namespace torqued
{

namespace
{

using Provider = BusUrl::Provider;

constexpr const char* kExample = "udpm://239.255.76.67:7667?ttl=0";

std::string quoted(std::string_view text, std::size_t longest = kLongestShown)
{
  return "\"" + printable(text, longest) + "\"";
}

[[noreturn]] void refuse(const std::string& what, const std::string& right)
{
  throw std::invalid_argument(what + "; expected " + right);
}

// What stands before a sign; the text is left with what stands after it, or empty if the sign is not there.
std::string_view take_until(std::string_view& text, std::string_view signs)
{
  const std::size_t at = text.find_first_of(signs);
  const std::string_view taken = text.substr(0, at);
  text = at == std::string_view::npos ? std::string_view() : text.substr(at + 1);
  return taken;
}

// A number as LCM reads it: decimal, 0x and hexadecimal, or 0 and octal.
int read_number(const std::string& name, std::string_view text, int least, int most)
{
  const std::string digits(text);
  char* end = nullptr;
  errno = 0;
  const long number = std::strtol(digits.c_str(), &end, 0);
  if (digits.empty() || end != digits.c_str() + digits.size() || errno != 0 || number < least || number > most)
    refuse(name + " is " + quoted(text),
           "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  return static_cast<int>(number);
}

Provider read_provider(std::string_view name)
{
  constexpr std::string_view names[] = {"udpm", "mpudpm", "tcpq", "memq", "file"}; // in Provider's order
  for (int i = 0; i < 5; ++i)
    if (name == names[i])
      return static_cast<Provider>(i);
  refuse("LCM knows no " + quoted(name), std::string(kExample) + " or the like");
}

bool read_ipv4(std::string_view text, in_addr& address)
{
  return inet_aton(std::string(text).c_str(), &address) != 0;
}

void read_group(std::string_view target, BusUrl& bus)
{
  const bool has_port = target.find(':') != std::string_view::npos;
  const std::string_view text = take_until(target, ":");
  in_addr address{};
  if (!read_ipv4(text, address) || !IN_MULTICAST(ntohl(address.s_addr)))
    refuse("the address " + quoted(text) + " is no group of IPv4 multicast", "one from 224.0.0.0 to 239.255.255.255");
  bus.address = inet_ntoa(address);
  if (!has_port && bus.provider == Provider::udpm)
    refuse("the port is missing", "udpm://" + bus.address + ":7667 or the like");
  if (target.ends_with('/'))
    target.remove_suffix(1);
  if (has_port)
    bus.port = read_number("the port", target, 1, 65535);
}

void read_server(std::string_view target, BusUrl& bus)
{
  const bool has_port = target.find(':') != std::string_view::npos;
  const std::string_view text = take_until(target, ":");
  in_addr address{};
  if (text != "localhost" && !read_ipv4(text, address))
    refuse("the server is " + quoted(text) + ", and LCM takes any name for this machine",
           "its IPv4 address in figures");
  if (text != "localhost")
    bus.address = inet_ntoa(address);
  if (has_port)
    bus.port = read_number("the port", target, 1, 65535);
}

void read_options(std::string_view options, BusUrl& bus)
{
  while (!options.empty())
  {
    std::string_view value = take_until(options, "&?");
    const std::string_view name = take_until(value, "=");
    if (name == "ttl")
      bus.ttl = read_number("ttl", value, 0, 255);
    else if (name == "recv_buf_size")
      bus.buffer_size = read_number("recv_buf_size", value, 0, INT_MAX);
    else if (name == "nports" && bus.provider == Provider::mpudpm)
      read_number("nports", value, 1, 65535);
    else if (name != "transmit_only" && !name.empty())
      refuse("LCM knows no option " + quoted(name),
             bus.provider == Provider::mpudpm ? "ttl, recv_buf_size or nports" : "ttl or recv_buf_size");
  }
}

// Which bus it is, as the begin of a sentence.
std::string shown(const ChosenBus& bus)
{
  return bus.set_by.empty() ? "neither --lcm-url nor LCM_DEFAULT_URL is set, so LCM's default was tried"
                            : bus.set_by + " is " + quoted(bus.url, 300);
}

// What such a bus needs of machine and network.
std::string need_of(const BusUrl& bus)
{
  switch (bus.provider)
  {
  case Provider::tcpq:
    return "No server of LCM's answers at " + bus.address + " port " + std::to_string(bus.port) +
           ": start one there (java -cp /usr/share/java/lcm.jar lcm.lcm.TCPService " + std::to_string(bus.port) +
           "), or take another bus. ";
  case Provider::memq: return "Such a bus stays within one process. ";
  case Provider::file: return "Such a bus replays a log, or writes one. ";
  case Provider::udpm:
  case Provider::mpudpm: break;
  }
  return "";
}

} // namespace

BusUrl read_bus_url(const std::string& url)
{
  BusUrl bus;
  if (url.empty())
    return bus;
  const std::size_t at = url.find("://");
  if (at == std::string::npos)
    refuse("this is no URL of LCM's", std::string(kExample) + " or the like");
  bus.provider = read_provider(std::string_view(url).substr(0, at));
  std::string_view options = std::string_view(url).substr(at + 3);
  const std::string_view target = take_until(options, "?");
  switch (bus.provider)
  {
  case Provider::udpm:
  case Provider::mpudpm:
    if (!target.empty())
      read_group(target, bus);
    read_options(options, bus);
    break;
  case Provider::tcpq:
    bus.address = "127.0.0.1";
    bus.port = 7700;
    if (!target.empty())
      read_server(target, bus);
    break;
  case Provider::file:
    if (target.empty())
      refuse("the file's name is missing", "file:///home/me/walk.lcm or the like");
    break;
  case Provider::memq: break;
  }
  return bus;
}

ChosenBus choose_bus(const std::string& lcm_url, const std::string& given_by)
{
  if (!lcm_url.empty())
    return {lcm_url, given_by};
  const char* preset = std::getenv("LCM_DEFAULT_URL");
  return preset != nullptr && *preset != '\0' ? ChosenBus{preset, "LCM_DEFAULT_URL"} : ChosenBus{};
}

std::string fault_of(const ChosenBus& bus)
{
  try
  {
    read_bus_url(bus.url);
    return "";
  }
  catch (const std::invalid_argument& error)
  {
    return shown(bus) + ": " + error.what();
  }
}

std::string fault_between_processes(const ChosenBus& bus)
{
  const std::string fault = fault_of(bus);
  if (!fault.empty())
    return fault;
  const Provider provider = read_bus_url(bus.url).provider;
  if (provider == Provider::memq)
    return shown(bus) + ": such a bus stays within this process, where nobody else hears it; expected " + kExample +
           " or the like";
  if (provider == Provider::file)
    return shown(bus) + ": such a bus replays a log, or writes one, and nobody answers there; expected " + kExample +
           " or the like";
  return "";
}

std::string bus_trouble(const std::string& lcm_url, const std::string& given_by)
{
  const ChosenBus bus = choose_bus(lcm_url, given_by);
  const std::string fault = fault_of(bus);
  if (!fault.empty())
    return fault;
  return shown(bus) + ". " + need_of(read_bus_url(bus.url)) + "A bus within one machine is " + kExample +
         " and needs: sudo ip link set lo up multicast on; sudo ip route add 224.0.0.0/4 dev lo";
}

} // namespace torqued
