#include "wire/bus_url.h"

#include "robot/printable.h"

#include <arpa/inet.h>
#include <charconv>
#include <cstdlib>
#include <fmt/format.h>
#include <regex>
#include <stdexcept>

namespace torqued
{

namespace
{

int read_count(const std::string& name, const std::string& text, int most)
{
  int number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || rest != end || number < 0 || number > most)
    throw std::invalid_argument(
        fmt::format("{} is \"{}\"; expected a whole number from 0 to {}", name, printable(text), most));
  return number;
}

} // namespace

BusUrl read_bus_url(const std::string& url)
{
  BusUrl bus;
  if (url.empty())
    return bus;
  static const std::regex form(R"(([a-z]+)://([^:?]*)(?::([^?]*))?(?:\?(.*))?)");
  std::smatch part;
  if (!std::regex_match(url, part, form))
    throw std::invalid_argument(
        fmt::format("\"{}\" is no URL of LCM's; expected udpm://239.255.76.67:7667?ttl=0 or the "
                    "like",
                    printable(url)));
  if (part[1] != "udpm")
    throw std::invalid_argument(
        fmt::format("\"{}\" leads from process to process by no network that could be looked at; "
                    "expected udpm://239.255.76.67:7667?ttl=0 or the like",
                    printable(url)));
  if (part[2].length() > 0)
    bus.address = part[2];
  in_addr address{};
  if (inet_pton(AF_INET, bus.address.c_str(), &address) != 1 || !IN_MULTICAST(ntohl(address.s_addr)))
    throw std::invalid_argument(fmt::format("\"{}\" is no multicast address; expected one from 224.0.0.0 to "
                                            "239.255.255.255",
                                            printable(bus.address)));
  if (part[3].matched)
    bus.port = read_count("the port", part[3], 65535);
  static const std::regex ampersand("&");
  const std::string options = part[4];
  for (std::sregex_token_iterator option(options.begin(), options.end(), ampersand, -1), end; option != end; ++option)
  {
    const std::string text = *option;
    const std::string name = text.substr(0, text.find('='));
    const std::string value = name.size() < text.size() ? text.substr(name.size() + 1) : "";
    if (name == "ttl")
      bus.ttl = read_count(name, value, 255);
    else if (name == "recv_buf_size")
      bus.buffer_size = read_count(name, value, 1 << 30);
    else if (name != "transmit_only" && !text.empty())
      throw std::invalid_argument(fmt::format("LCM knows no option \"{}\"; it knows ttl, recv_buf_size and "
                                              "transmit_only",
                                              printable(name)));
  }
  return bus;
}

std::string effective_bus_url(const std::string& lcm_url)
{
  const char* const preset = std::getenv("LCM_DEFAULT_URL");
  return lcm_url.empty() && preset != nullptr ? preset : lcm_url;
}

} // namespace torqued
