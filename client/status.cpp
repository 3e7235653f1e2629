#include "client/daemons.h"
#include "client/files.h"
#include "client/subcommands.h"
#include "wire/messages.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <unistd.h>

namespace torqued
{

namespace
{

using namespace std::chrono_literals;
using Clock = Bus::Clock;

struct Options
{
  std::string lcm_url;
  std::optional<std::string> prefix;
  bool once = false;
};

std::string nobody(const Options& options)
{
  return fmt::format("no daemon is heard on {}; is torqued running on this bus and network? torquectl doctor looks for "
                     "what is wrong. Here {}",
                     options.prefix ? Channels(*options.prefix).status : "TORQUED_STATUS, with or without a prefix",
                     bus_trouble(options.lcm_url));
}

// Hears for a second, for the rates, and longer where a daemon has not yet said which robot it computes, every two
// seconds.
ExitCode show_once(Bus& bus, const DaemonsHeard& heard, const Options& options)
{
  const auto begin = Clock::now();
  const auto complete = [&]
  {
    const std::vector<Daemon> daemons = heard.at(Clock::now());
    const auto has_model = [](const Daemon& daemon)
    {
      return daemon.model || !daemon.present();
    };
    return Clock::now() > begin + 1050ms && !daemons.empty() && std::all_of(daemons.begin(), daemons.end(), has_model);
  };
  while (!bus.stopped() && !complete() && Clock::now() < begin + 2200ms)
    bus.wait(std::min(begin + 2200ms, Clock::now() + 100ms));
  const std::vector<Daemon> daemons = heard.at(Clock::now());
  if (daemons.empty())
    throw Failure(ExitCode::no_bus, nobody(options));
  OutputFile("-").write(status_page(daemons));
  return ExitCode::done;
}

// Draws the page anew at the terminal's top, four times a second, until a signal.
ExitCode show_live(Bus& bus, const DaemonsHeard& heard, const Options& options)
{
  OutputFile out("-");
  while (!bus.stopped())
  {
    const auto next = Clock::now() + 250ms;
    while (!bus.stopped() && Clock::now() < next)
      bus.wait(next);
    const std::vector<Daemon> daemons = heard.at(Clock::now());
    out.write("\x1b[H\x1b[J" + (daemons.empty() ? nobody(options) + '\n' : status_page(daemons)) + "\nCtrl-C ends\n");
    out.flush();
  }
  return ExitCode::done;
}

ExitCode show_status(const Options& options)
{
  Config config;
  set_flag("--prefix", set_prefix, config, options.prefix);
  Bus bus(options.lcm_url);
  DaemonsHeard heard;
  subscribe(bus, options.prefix, heard);
  return options.once || isatty(STDOUT_FILENO) == 0 ? show_once(bus, heard, options) : show_live(bus, heard, options);
}

} // namespace

Subcommand add_status(CLI::App& torquectl)
{
  const auto options = std::make_shared<Options>();
  CLI::App* app =
      torquectl.add_subcommand("status", "how the daemons on the bus are: live on a terminal, until Ctrl-C; else once");
  app->add_flag("--once", options->once, "show it once, after a second or two of listening, and end");
  add_bus_option(*app, options->lcm_url);
  app->add_option("--prefix", options->prefix, "only the daemon with this before its channels; default: every daemon")
      ->type_name("TEXT");
  app->footer("Exit code 69 if it is to show once and no daemon is heard. Example:\n"
              "  LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0' torquectl status --once");
  return {app, [options]
          {
            return show_status(*options);
          }};
}

} // namespace torqued
