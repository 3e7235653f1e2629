#include "commands/offline.h"
#include "commands/subcommands.h"
#include "methods/constrained.h"
#include "motion/console.h"
#include "motion/files.h"
#include "study/measured.h"
#include "study/outcome.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

namespace torqued
{

namespace
{

using Json = nlohmann::ordered_json;

struct CompareOptions
{
  OfflineOptions offline;
  std::string json;
};

// What one method makes of a motion.
struct MethodRun
{
  std::string method;
  Answered answered;
  Outcome outcome;
};

MethodRun run_method(const Robot& robot, const AnswerSettings& settings, const std::vector<DesiredState>& states,
                     const Changes& changes, std::string name)
{
  Answered answered = answer_motion(robot, settings, states, settings.methods.method);
  Outcome outcome = outcome_of(robot, states, answered.answers, changes);
  return {std::move(name), std::move(answered), std::move(outcome)};
}

int adjusted(const Outcome& outcome)
{
  const auto found = outcome.flagged.find(flag::adjusted);
  return found == outcome.flagged.end() ? 0 : found->second;
}

std::string share(int part, int whole)
{
  return whole == 0 ? "-" : fmt::format("{:.1f} %", 100.0 * part / whole);
}

// a jump; what is rounding is 0
std::string jump(double torque)
{
  return torque < 1e-6 ? "0" : torque < 0.01 ? fmt::format("{:.1g}", torque) : fmt::format("{:.2f}", torque);
}

// characters, not bytes, of UTF-8
std::size_t width(const std::string& text)
{
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

// a table that is Markdown, too
void print(const std::vector<std::vector<std::string>>& rows)
{
  std::vector<std::size_t> widths(rows.front().size(), 3);
  for (const auto& row : rows)
    for (std::size_t k = 0; k < row.size(); ++k)
      widths[k] = std::max(widths[k], width(row[k]));
  for (std::size_t i = 0; i < rows.size(); ++i)
  {
    std::string line = "|", rule = "|";
    for (std::size_t k = 0; k < widths.size(); ++k)
    {
      const std::string space(widths[k] - width(rows[i][k]), ' ');
      line += k == 0 ? fmt::format(" {}{} |", rows[i][k], space) : fmt::format(" {}{} |", space, rows[i][k]);
      rule += k == 0 ? fmt::format("{}|", std::string(widths[k] + 2, '-'))
                     : fmt::format("{}:|", std::string(widths[k] + 1, '-'));
    }
    fmt::print("{}\n", line);
    if (i == 0)
      fmt::print("{}\n", rule);
  }
}

// the part of a motion over which answers are compared with measurements
struct Part
{
  const char* key;
  const char* name;
  std::vector<bool> chosen; // by sample
};

// Rows of a table: what is compared, as a name and its values for a channel.
struct Compared
{
  std::string name;
  std::function<std::vector<double>(const Channel&)> values;
};

// the mean of both feet's agreement, for channels of one kind
std::string agreement_cell(const std::vector<const Channel*>& channels, const Compared& compared, const Part& part)
{
  const auto n = static_cast<double>(channels.size());
  Agreement mean;
  for (const Channel* channel : channels)
  {
    const Agreement one = agreement(*channel, compared.values(*channel), part.chosen);
    mean.rms += one.rms / n;
    mean.of_range += one.of_range / n;
    mean.correlation += one.correlation / n;
  }
  if (std::isnan(mean.of_range))
    return "-";
  return fmt::format("{:.1f}, {:.1f} %, {}", mean.rms, 100.0 * mean.of_range,
                     std::isnan(mean.correlation) ? "-" : fmt::format("{:.2f}", mean.correlation));
}

void print_agreement(const std::vector<Channel>& channels, bool published, const std::vector<Compared>& all,
                     const Part& part)
{
  std::vector<std::string> kinds;
  std::map<std::string, std::vector<const Channel*>> by_kind;
  for (const Channel& channel : channels)
    if (channel.published == published)
    {
      if (by_kind[channel.kind].empty())
        kinds.push_back(channel.kind);
      by_kind[channel.kind].push_back(&channel);
    }
  if (kinds.empty())
    return;
  std::vector<std::vector<std::string>> table{{"method"}};
  for (const std::string& kind : kinds)
    table[0].push_back(kind);
  for (const Compared& compared : all)
  {
    table.push_back({compared.name});
    for (const std::string& kind : kinds)
      table.back().push_back(agreement_cell(by_kind[kind], compared, part));
  }
  fmt::print("\nagainst {}, {}\n\n", published ? "the published joint moments" : "the force plates", part.name);
  print(table);
}

void print_agreements(const std::vector<Channel>& channels, const std::vector<MethodRun>& runs,
                      const std::vector<Part>& parts)
{
  if (channels.empty())
    return;
  std::vector<Compared> methods;
  for (const MethodRun& run : runs)
    methods.push_back({run.method, [&run](const Channel& channel)
                       {
                         return values_of(channel, run.answered.answers);
                       }});
  std::vector<Compared> plates_first = methods;
  const auto from_plates = [&channels](int joint)
  {
    return std::ranges::find_if(channels, [joint](const Channel& c) { return !c.published && c.joint == joint; });
  };
  if (from_plates(0) != channels.end())
    plates_first.insert(plates_first.begin(), {"from the plates", [from_plates](const Channel& channel)
                                               {
                                                 return from_plates(channel.joint)->values;
                                               }});
  for (const bool published : {false, true})
    for (const Part& part : parts)
      print_agreement(channels, published, published ? plates_first : methods, part);
  fmt::print(
      "\nrms of the difference (N, N m), its share of the measured range in the whole file, correlation; mean of both "
      "feet. Moments from the\nplates: inverse dynamics of this robot, bottom-up from the measured wrenches.\n");
}

// NaN is null
Json json(const Agreement& agreement)
{
  return {{"samples", agreement.samples},
          {"rms", agreement.rms},
          {"of_range", agreement.of_range},
          {"correlation", agreement.correlation}};
}

void write_json(const std::string& path, const Robot& robot, const std::vector<DesiredState>& states,
                const Changes& changes, const std::vector<MethodRun>& runs, const std::vector<Channel>& channels,
                const std::vector<Part>& parts)
{
  Json methods = Json::array();
  for (const MethodRun& run : runs)
  {
    const Outcome& outcome = run.outcome;
    Json jumps = Json::object();
    for (std::size_t kind = 0; kind < changes.kinds.size(); ++kind)
      jumps[changes.kinds[kind]] = outcome.jumps[kind];
    Json agreements = Json::array();
    for (const Channel& channel : channels)
    {
      agreements.push_back({{"channel", channel.name},
                            {"against", channel.published ? "published" : "plates"},
                            {"unit", channel.unit},
                            {"range", channel.range()}});
      for (const Part& part : parts)
        agreements.back()[part.key] = json(agreement(channel, values_of(channel, run.answered.answers), part.chosen));
    }
    methods.push_back({{"method", run.method},
                       {"answered", outcome.answered},
                       {"jumps", std::move(jumps)},
                       {"peak", outcome.peak},
                       {"effort", outcome.effort},
                       {"double_support", outcome.double_support},
                       {"held", outcome.held},
                       {"relaxed", outcome.relaxed},
                       {"adjusted", adjusted(outcome)},
                       {"measured", std::move(agreements)}});
  }
  OutputFile out(path);
  out.write(Json{{"robot", robot.name}, {"samples", states.size()}, {"methods", std::move(methods)}}.dump(1) + "\n");
  out.close();
}

void print_outcomes(const Changes& changes, const std::vector<MethodRun>& runs, bool nearest)
{
  std::vector<std::vector<std::string>> rows{{"method"}};
  for (const std::string& kind : changes.kinds)
    rows[0].push_back(kind);
  for (const char* column : {"peak", "∫τ²dt", "contacts held", "relaxed"})
    rows[0].emplace_back(column);
  if (nearest)
    rows[0].emplace_back("adjusted");
  for (const MethodRun& run : runs)
  {
    const Outcome& outcome = run.outcome;
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(run.method);
    for (const double torque : outcome.jumps)
      row.push_back(outcome.answered > 0 ? jump(torque) : "-");
    row.push_back(outcome.answered > 0 ? fmt::format("{:.1f}", outcome.peak) : "-");
    row.push_back(outcome.answered > 0 ? fmt::format("{:.0f}", outcome.effort) : "-");
    row.push_back(share(outcome.held, outcome.double_support));
    row.push_back(share(outcome.relaxed, outcome.double_support));
    if (nearest)
      row.push_back(share(adjusted(outcome), outcome.answered));
  }
  print(rows);
  fmt::print("\nlargest jump of a torque where contacts change, N m, 0 below 1e-6, between samples up to {} µs apart; "
             "largest torque, N m;\nsum over the motors, N² m² s; share of double support in which no foot slips, "
             "lifts or tips; in which conditions gave way{}\n",
             changes.longest, nearest ? ";\nshare of the motion that is answered by the nearest one" : "");
}

void require_answers(const std::string& file, const std::vector<MethodRun>& runs)
{
  if (std::ranges::any_of(runs, [](const MethodRun& run) { return run.outcome.answered > 0; }))
    return;
  std::string reasons;
  for (const auto& [reason, count] : runs.front().answered.refused)
    reasons += fmt::format(", {} {}", reason, count);
  throw Failure(ExitCode::bad_data,
                "{}: no sample was answered by any method: by {}{}; torquectl eval says what was refused", file,
                runs.front().method, reasons);
}

ExitCode compare(const CompareOptions& options)
{
  if (!options.json.empty())
    require_other_file(options.offline.file, options.json);
  const auto [config, robot, desired] = read_offline_input(options.offline);
  const std::vector<DesiredState> states = decode_all(robot, desired);
  const std::vector<Channel> channels =
      read_measured(read_file(options.offline.file), options.offline.file, robot, states).channels;
  const Changes changes = find_changes(states);

  flush_denormals();
  std::vector<MethodRun> runs;
  AnswerSettings settings = config.answers;
  for (const Method method : all_methods())
  {
    const std::string name(name_of(method));
    settings.methods.method = method;
    if (method == Method::constrained && settings.methods.of<Constrained>().windows)
    {
      settings.methods.of<Constrained>().windows = false;
      runs.push_back(run_method(robot, settings, states, changes, name + ", no windows"));
      settings.methods.of<Constrained>().windows = true;
    }
    runs.push_back(run_method(robot, settings, states, changes, name));
  }

  std::vector<Part> parts{{"double_support", "in double support", {}},
                          {"whole", "over the whole motion", std::vector<bool>(states.size(), true)}};
  for (const DesiredState& state : states)
    parts[0].chosen.push_back(state.support.of(Side::left) != Contact::none &&
                              state.support.of(Side::right) != Contact::none);

  if (options.json != "-")
  {
    const auto in_double_support = std::ranges::count(parts[0].chosen, true);
    fmt::print("{}: {} samples, {} of them in double support\n\n", robot.name, states.size(), in_double_support);
    print_outcomes(changes, runs, settings.methods.infeasible == OnInfeasible::nearest);
    print_agreements(channels, runs, parts);
  }
  if (!options.json.empty())
    write_json(options.json, robot, states, changes, runs, channels, parts);
  for (const MethodRun& run : runs)
    if (run.outcome.answered < static_cast<int>(states.size()))
      note(fmt::format("{}: {} of {} samples were not answered; torquectl eval --method says why", run.method,
                       states.size() - static_cast<std::size_t>(run.outcome.answered), states.size()));
  require_answers(options.offline.file, runs);
  return ExitCode::done;
}

} // namespace

Subcommand add_compare(CLI::App& torquectl)
{
  const auto options = std::make_shared<CompareOptions>();
  CLI::App* app = torquectl.add_subcommand(
      "compare", "what every method of double support makes of a motion, and how that agrees with measurements");
  add_offline_options(*app, options->offline, "");
  app->add_option("--config", options->offline.config, "the daemon's configuration file: weights and limits")
      ->type_name("FILE");
  app->add_option("--json", options->json, "all numbers, foot by foot, as JSON; - for the terminal, instead of tables")
      ->type_name("OUT");
  app->footer(
      "Methods that samples ask for are not heeded. Where contacts change, a jump is the difference between two\n"
      "samples, so it is exact where both show the same instant, as in a walk of torquectl gait.\n\n"
      "A CSV may hold what was measured along the motion: FxL, FzL, ML, FxR, FzR, MR (force plates: N, and N m about\n"
      "the ankles) and joint moments by others, pub_ankleL and so on, positive from the proximal on the distal\n"
      "segment. Nothing or nan where there is none. The exit code is 65 if no method answers any sample.\n\n"
      "Example, in the source directory:\n"
      "  torquectl compare client/trajectories/subject01-walk/walk.csv --robot human-subject01");
  return {app, options, compare};
}

} // namespace torqued
