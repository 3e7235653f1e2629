#include "bus/daemons.h"
#include "commands/options.h"
#include "commands/status_json.h"
#include "commands/subcommands.h"
#include "motion/files.h"
#include "wire/bus_url.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace torqued
{

namespace
{

using namespace std::chrono_literals;
using Clock = Bus::Clock;

struct StatusOptions
{
  std::string lcm_url;
  std::optional<std::string> prefix;
  bool once = false, json = false;
};

using Json = nlohmann::ordered_json;

// each daemon's last status, what it computes, and its counts per second; nothing: null
Json describe(const std::vector<Daemon>& daemons)
{
  Json list = Json::array();
  for (const Daemon& daemon : daemons)
  {
    Json rates;
    if (daemon.rates)
      rates = {{"received", daemon.rates->received},
               {"answered", daemon.rates->answered},
               {"rejected", daemon.rates->rejected},
               {"superseded", daemon.rates->superseded}};
    Json& described = list.emplace_back(Json{{"prefix", daemon.prefix},
                                             {"present", daemon.present()},
                                             {"silent", daemon.silent},
                                             {"robot", daemon.model ? Json(daemon.model->name) : Json()},
                                             {"per_second", std::move(rates)}});
    described.update(status_json(daemon.status));
  }
  return list;
}

std::string nobody(const StatusOptions& options)
{
  return fmt::format("no daemon is heard on {}; is torqued running on this bus and network? torquectl doctor looks for "
                     "what is wrong. Here {}",
                     options.prefix ? Channels(*options.prefix).status : "TORQUED_STATUS, with or without a prefix",
                     bus_trouble(options.lcm_url, "--lcm-url"));
}

// Hears for a second, for the rates, and longer where a daemon has not yet said which robot it computes, every two
// seconds.
ExitCode show_once(Bus& bus, const DaemonsHeard& heard, const StatusOptions& options)
{
  const auto begin = Clock::now();
  const auto complete = [&]
  {
    const std::vector<Daemon> daemons = heard.at(Clock::now());
    return Clock::now() > begin + 1050ms && !daemons.empty() &&
           std::ranges::all_of(daemons, [](const Daemon& one) { return one.model || !one.present(); });
  };
  while (!bus.stopped() && !complete() && Clock::now() < begin + 2200ms)
    bus.wait(std::min(begin + 2200ms, Clock::now() + 100ms));
  const std::vector<Daemon> daemons = heard.at(Clock::now());
  if (daemons.empty())
    throw Failure(ExitCode::no_bus, nobody(options));
  OutputFile("-").write(options.json ? describe(daemons).dump(2, ' ', false, Json::error_handler_t::replace) + '\n'
                                     : status_page(daemons));
  return ExitCode::done;
}

// Draws the page anew at the terminal's top, four times a second, until a signal.
ExitCode show_live(Bus& bus, const DaemonsHeard& heard, const StatusOptions& options)
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

ExitCode show_status(const StatusOptions& options)
{
  channels_with(options.prefix); // refuses what can be none
  Bus bus(options.lcm_url);
  DaemonsHeard heard;
  subscribe(bus, options.prefix, heard);
  return options.once || options.json || isatty(STDOUT_FILENO) == 0 ? show_once(bus, heard, options)
                                                                    : show_live(bus, heard, options);
}

} // namespace

Subcommand add_status(CLI::App& torquectl)
{
  const auto options = std::make_shared<StatusOptions>();
  CLI::App* app =
      torquectl.add_subcommand("status", "how the daemons on the bus are: live on a terminal, until Ctrl-C; else once");
  app->add_flag("--once", options->once, "show it once, after a second or two of listening, and end");
  app->add_flag("--json", options->json, "the same once, as JSON: a list of daemons");
  add_bus_option(*app, options->lcm_url);
  app->add_option("--prefix", options->prefix, "only the daemon with this before its channels; default: every daemon")
      ->type_name("TEXT");
  app->footer("Exit code 69 if it is to show once and no daemon is heard.\n\n"
              "Example:\n"
              "  LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0' torquectl status --once");
  return {app, options, show_status};
}

} // namespace torqued
