#include "bench/servers.h"

#include "bench/packets.h"
#include "bench/sample.h"

#include <lcm/lcm-cpp.hpp>
#include <sys/prctl.h>

namespace torqued::bench
{

namespace
{

const char* const kSelf = "/proc/self/exe";

} // namespace

std::vector<std::string> torqued_command(const std::string& url, std::vector<std::string> options)
{
  std::vector<std::string> command{TORQUED, "--robot", kRobot, "--lcm-url", url};
  command.insert(command.end(), options.begin(), options.end());
  return command;
}

std::vector<std::string> lcm_echo_command(const std::string& url)
{
  return {kSelf, "lcm-echo", url};
}

std::vector<std::string> udp_echo_command(int hears, int sends_to)
{
  return {kSelf, "udp-echo", std::to_string(hears), std::to_string(sends_to)};
}

int lcm_echo(const std::string& url)
{
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  lcm_t* lcm = lcm_create(url.c_str());
  if (lcm == nullptr)
    return EXIT_FAILURE;
  static const Channels channels;
  const auto echo = [](const lcm_recv_buf_t* buffer, const char*, void*)
  {
    lcm_publish(buffer->lcm, channels.command.c_str(), buffer->data, buffer->data_size);
  };
  lcm_subscription_t* subscription = lcm_subscribe(lcm, channels.desired.c_str(), echo, nullptr);
  lcm_subscription_set_queue_capacity(subscription, 10'000);
  while (lcm_handle(lcm) == 0)
  {
  }
  return EXIT_FAILURE;
}

int udp_echo(int hears, int sends_to)
{
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  Packets packets(hears, sends_to);
  while (true)
    packets.send(packets.receive());
}

} // namespace torqued::bench
