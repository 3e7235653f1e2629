#include "bus/bus_facts.h"
#include "commands/options.h"
#include "commands/subcommands.h"
#include "motion/files.h"
#include "text/printable.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace torqued
{

namespace
{

using Json = nlohmann::ordered_json;

struct DoctorOptions
{
  std::string lcm_url;
  bool json = false;
};

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

std::string_view grade(const Finding& finding)
{
  constexpr std::array<std::string_view, 3> names{"ok", "note", "wrong"};
  return names[static_cast<std::size_t>(finding.grade)];
}

std::string as_text(const std::vector<Finding>& findings)
{
  std::string text;
  for (const Finding& finding : findings)
  {
    text += fmt::format("{:<5} {}\n", finding.grade == Finding::Grade::bad ? "WRONG" : grade(finding), finding.text);
    if (!finding.mend.empty())
      text += fmt::format("      $ {}\n", finding.mend);
  }
  return text;
}

std::string as_json(const std::vector<Finding>& findings)
{
  Json list = Json::array();
  for (const Finding& finding : findings)
    list.push_back({{"grade", grade(finding)}, {"text", finding.text}, {"mend", finding.mend}});
  return list.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

ExitCode examine(const DoctorOptions& options)
{
  BusFacts facts = look_at_bus(options.lcm_url);
  // where not even the plain message came back, LCM would only search for its own for ten seconds
  if (facts.came_back)
    try
    {
      facts.daemons = listen(options.lcm_url);
    }
    catch (const BusError& error)
    {
      facts.lcm_trouble = error.what();
    }
  const std::vector<Finding> findings = diagnose(facts);

  OutputFile out("-");
  out.write(options.json ? as_json(findings) : printable_lines(as_text(findings)));
  return std::ranges::count(findings, Finding::Grade::bad, &Finding::grade) > 0 ? ExitCode::failed : ExitCode::done;
}

} // namespace

Subcommand add_doctor(CLI::App& torquectl)
{
  const auto options = std::make_shared<DoctorOptions>();
  CLI::App* app = torquectl.add_subcommand(
      "doctor", "what is wrong with this machine's LCM set-up, each finding with the command that mends it");
  app->add_flag("--json", options->json, "the findings as JSON: grade (ok, note, wrong), text, mend");
  add_bus_option(*app, options->lcm_url);
  app->footer("Changes nothing. As root it also sees which rule of a firewall is in the way, and\n"
              "whether one keeps off what other machines send.\n"
              "Exit code: 0 if nothing is wrong, notes apart; else 1.\n\n"
              "Example:\n"
              "  LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0' torquectl doctor");
  return {app, options, examine};
}

} // namespace torqued
