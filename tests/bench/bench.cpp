// What computations and the daemon cost, and what that is compared with: measured in interleaved rounds.

#include "bench/bus.h"
#include "bench/computations.h"
#include "bench/footprint.h"
#include "bench/logs.h"
#include "bench/page.h"
#include "bench/servers.h"

#include "motion/files.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <sysexits.h>

namespace
{

using namespace torqued;

struct Part
{
  const char* name;
  void (*measure)(bench::Rounds& rounds, bool quick);
};

constexpr Part kParts[] = {{"computations", bench::measure_computations},
                           {"round-trips", bench::measure_round_trips},
                           {"flood", bench::measure_flood},
                           {"many", bench::measure_many},
                           {"footprint", bench::measure_footprint},
                           {"logs", bench::measure_logs}};

// The processes of a measurement which are this program again; nothing if it is not one of them.
std::optional<int> serve(const std::vector<std::string>& words)
{
  if (words.size() == 2 && words[0] == "lcm-echo")
    return bench::lcm_echo(words[1]);
  if (words.size() == 3 && words[0] == "udp-echo")
    return bench::udp_echo(std::stoi(words[1]), std::stoi(words[2]));
  if (words.size() == 2 && words[0] == "read-log")
    return bench::read_log(words[1]);
  return {};
}

int measure(int argc, char** argv)
{
  CLI::App app{
      "bench measures computations, and the daemon on a bus of its own, in interleaved rounds, and prints medians over "
      "the rounds.\n"
      "To be run by tools/private-network.",
      "bench"};
  int number = 7;
  bool quick = false;
  std::vector<std::string> only;
  std::string json, page;
  std::vector<std::string> names;
  for (const Part& part : kParts)
    names.emplace_back(part.name);
  app.add_option("--rounds", number, "how many; default: 7")->check(CLI::PositiveNumber)->type_name("N");
  app.add_flag("--quick", quick, "so short that it tells nothing, to see that it runs");
  app.add_option("--only", only, fmt::format("parts to be measured: {}", CLI::detail::join(names, ", ")))
      ->check(CLI::IsMember(names))
      ->type_name("PART...");
  app.add_option("--json", json, "all rounds, as JSON")->type_name("FILE");
  app.add_option("--page", page, "medians and the spread of the rounds, as a page for any browser")->type_name("FILE");
  CLI11_PARSE(app, argc, argv);
  if (std::getenv("LCM_DEFAULT_URL") == nullptr)
  {
    fmt::print(stderr, "bench: there is no bus of its own; run it by tools/private-network\n");
    return EX_USAGE;
  }

  bench::Rounds rounds;
  for (int round = 0; round < number; ++round)
    for (const Part& part : kParts)
      if (only.empty() || std::find(only.begin(), only.end(), part.name) != only.end())
        part.measure(rounds, quick);
  fmt::print("{}", rounds.table());
  const auto write = [](const std::string& path, const std::string& text)
  {
    if (path.empty())
      return;
    OutputFile file(path);
    file.write(text);
    file.close();
  };
  write(json, rounds.json());
  write(page, bench::page(rounds));
  return EXIT_SUCCESS;
}

} // namespace

int main(int argc, char** argv)
try
{
  const std::optional<int> served = serve({argv + 1, argv + argc});
  return served ? *served : measure(argc, argv);
}
catch (const std::exception& error)
{
  fmt::print(stderr, "bench: {}\n", error.what());
  return EXIT_FAILURE;
}
