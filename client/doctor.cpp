#include "client/bus_facts.h"
#include "client/files.h"
#include "client/subcommands.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <fmt/format.h>
#include <memory>

namespace torqued
{

namespace
{

// Who publishes within a second, under any prefix.
std::vector<Daemon> listen(const std::string& lcm_url)
{
  Bus bus(lcm_url);
  DaemonsHeard heard;
  subscribe(bus, std::nullopt, heard);
  const auto until = Bus::Clock::now() + std::chrono::seconds(1);
  while (!bus.stopped() && Bus::Clock::now() < until)
    bus.wait(until);
  return heard.at(Bus::Clock::now());
}

ExitCode examine(const std::string& lcm_url)
{
  BusFacts facts = look_at_bus(lcm_url);
  // where not even the plain message came back, LCM would only search for its own for ten seconds
  if (facts.came_back)
    try
    {
      facts.daemons = listen(lcm_url);
    }
    catch (const Failure& failure)
    {
      facts.lcm_trouble = failure.what();
    }
  const std::vector<Finding> findings = diagnose(facts);

  OutputFile out("-");
  for (const Finding& finding : findings)
  {
    const char* grade = finding.grade == Finding::Grade::good     ? "ok   "
                        : finding.grade == Finding::Grade::remark ? "note "
                                                                  : "WRONG";
    out.write(fmt::format("{} {}\n", grade, finding.text));
    if (!finding.mend.empty())
      out.write(fmt::format("      $ {}\n", finding.mend));
  }
  const auto is_bad = [](const Finding& finding)
  {
    return finding.grade == Finding::Grade::bad;
  };
  return std::any_of(findings.begin(), findings.end(), is_bad) ? ExitCode::failed : ExitCode::done;
}

} // namespace

Subcommand add_doctor(CLI::App& torquectl)
{
  const auto lcm_url = std::make_shared<std::string>();
  CLI::App* app = torquectl.add_subcommand(
      "doctor", "what is wrong with this machine's LCM set-up, each finding with the command that mends it");
  add_bus_option(*app, *lcm_url);
  app->footer("Changes nothing. As root it also sees which rule of a firewall is in the way.\n"
              "Exit code: 0 if nothing is wrong, notes apart; else 1. Example:\n"
              "  LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0' torquectl doctor");
  return {app, [lcm_url]
          {
            return examine(*lcm_url);
          }};
}

} // namespace torqued
