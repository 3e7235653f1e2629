#include "client/answer_table.h"
#include "client/offline.h"
#include "client/subcommands.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <vector>

namespace torqued
{

namespace
{

// What feet do together, by a short name.
std::string_view phase_name(const Support& support)
{
  const Contact leading = support.of(support.leading), trailing = support.of(support.trailing());
  if (leading == Contact::none && trailing == Contact::none)
    return "flight";
  if (leading == Contact::none || trailing == Contact::none)
    return "SSP";
  if (leading == Contact::sole && trailing == Contact::sole)
    return "flat";
  return trailing == Contact::sole ? "DSP1" : leading == Contact::sole ? "DSP2" : "points";
}

// What one method makes of a motion.
struct Outcome
{
  std::string method;
  std::vector<double> jumps; // N m, of each kind of change
  double peak = 0.0;         // N m
  double effort = 0.0;       // ∫ Σ τ² dt, N² m² s
  int answered = 0, rejected = 0;
  int double_support = 0, held = 0, relaxed = 0; // answered samples: all; no foot slips, lifts or tips; RELAXED
};

// The changes of contacts in a motion: kinds in the order in which they come.
struct Changes
{
  std::vector<std::string> kinds;
  std::vector<int> at;      // of each sample: the kind of change that it begins; −1 for none
  std::int64_t longest = 0; // µs between the samples before and after a change
};

Changes find_changes(const std::vector<DesiredState>& states)
{
  Changes changes;
  changes.at.assign(states.size(), -1);
  for (std::size_t i = 1; i < states.size(); ++i)
  {
    if (states[i].support.contact == states[i - 1].support.contact)
      continue;
    const std::string kind = fmt::format("{}→{}", phase_name(states[i - 1].support), phase_name(states[i].support));
    const auto known = std::find(changes.kinds.begin(), changes.kinds.end(), kind);
    changes.at[i] = static_cast<int>(known - changes.kinds.begin());
    if (known == changes.kinds.end())
      changes.kinds.push_back(kind);
    changes.longest = std::max(changes.longest, states[i].utime - states[i - 1].utime);
  }
  return changes;
}

Outcome run(const Robot& robot, const AnswerSettings& settings, const std::vector<DesiredState>& states,
            const Changes& changes, std::string name)
{
  Outcome outcome{std::move(name), std::vector<double>(changes.kinds.size(), 0.0)};
  StreamMemory memory;
  VectorJ before;
  bool follows = false;
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    DesiredState desired = states[i];
    desired.method = settings.methods.method;
    const Result<Answer> result = answer(robot, settings, desired, memory);
    const Answer* found = std::get_if<Answer>(&result);
    if (!found)
    {
      ++outcome.rejected;
      follows = false;
      continue;
    }
    ++outcome.answered;
    outcome.peak = std::max(outcome.peak, found->torque.cwiseAbs().maxCoeff());
    if (follows)
    {
      const double dt = 1e-6 * static_cast<double>(states[i].utime - states[i - 1].utime);
      outcome.effort += 0.5 * dt * (found->torque.squaredNorm() + before.squaredNorm());
      if (const int kind = changes.at[i]; kind >= 0)
        outcome.jumps[static_cast<std::size_t>(kind)] =
            std::max(outcome.jumps[static_cast<std::size_t>(kind)], (found->torque - before).cwiseAbs().maxCoeff());
    }
    if (desired.support.redundancy() > 0)
    {
      ++outcome.double_support;
      outcome.held += (found->flags & (flag::slips | flag::lifts | flag::tips)) == 0 ? 1 : 0;
      outcome.relaxed += (found->flags & flag::relaxed) != 0 ? 1 : 0;
    }
    before = found->torque;
    follows = true;
  }
  return outcome;
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
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
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

ExitCode compare(const OfflineOptions& options)
{
  const auto [config, robot, trajectory] = read_offline_input(options);
  std::vector<DesiredState> states;
  std::vector<std::byte> buffer;
  for (std::size_t i = 0; i < trajectory.states.size(); ++i)
  {
    const Result<DesiredState> desired = decode_desired_state(encode(trajectory.states[i], buffer), robot);
    if (const Refusal* refusal = std::get_if<Refusal>(&desired))
      throw Failure(ExitCode::bad_data, fmt::format("{}: {}", trajectory.place(i), refusal->detail()));
    states.push_back(std::get<DesiredState>(desired));
  }
  const Changes changes = find_changes(states);

  flush_denormals();
  std::vector<Outcome> outcomes;
  AnswerSettings settings = config.answers;
  for (const NamedMethod& known : kMethods)
  {
    settings.methods.method = known.method;
    if (known.method == Method::constrained && settings.methods.constrained.windows)
    {
      settings.methods.constrained.windows = false;
      outcomes.push_back(run(robot, settings, states, changes, fmt::format("{}, no windows", known.name)));
      settings.methods.constrained.windows = true;
    }
    outcomes.push_back(run(robot, settings, states, changes, std::string(known.name)));
  }

  std::vector<std::vector<std::string>> rows{{"method"}};
  for (const std::string& kind : changes.kinds)
    rows[0].push_back(kind);
  for (const char* column : {"peak", "∫τ²dt", "contacts held", "relaxed"})
    rows[0].emplace_back(column);
  for (const Outcome& outcome : outcomes)
  {
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(outcome.method);
    for (const double torque : outcome.jumps)
      row.push_back(outcome.answered > 0 ? jump(torque) : "-");
    row.push_back(outcome.answered > 0 ? fmt::format("{:.1f}", outcome.peak) : "-");
    row.push_back(outcome.answered > 0 ? fmt::format("{:.0f}", outcome.effort) : "-");
    row.push_back(share(outcome.held, outcome.double_support));
    row.push_back(share(outcome.relaxed, outcome.double_support));
  }
  const auto in_double_support =
      std::count_if(states.begin(), states.end(), [](const DesiredState& s) { return s.support.redundancy() > 0; });
  fmt::print("{}: {} samples, {} of them in double support\n\n", robot.name, states.size(), in_double_support);
  print(rows);
  fmt::print(
      "\nlargest jump of a torque where contacts change, N m, 0 below 1e-6, between samples up to {} µs apart; "
      "largest torque, N m;\nsum over the motors, N² m² s; share of double support in which no foot slips, lifts "
      "or tips; in which conditions gave way\n",
      changes.longest);
  for (const Outcome& outcome : outcomes)
    if (outcome.rejected > 0)
      note(fmt::format("{}: {} of {} samples were not answered; torquectl eval --method says why", outcome.method,
                       outcome.rejected, states.size()));
  return ExitCode::done;
}

} // namespace

Subcommand add_compare(CLI::App& torquectl)
{
  const auto options = std::make_shared<OfflineOptions>();
  CLI::App* app = torquectl.add_subcommand("compare", "what every method of double support makes of a motion");
  add_offline_options(*app, *options, "");
  app->add_option("--config", options->config, "the daemon's configuration file: weights and limits")
      ->type_name("FILE");
  app->footer(
      "Methods that samples ask for are not heeded. Where contacts change, a jump is the difference between two\n"
      "samples, so it is exact where both show the same instant, as in a walk of torquectl gait.\n\n"
      "Example:\n"
      "  torquectl gait --robot ck -o /tmp/walk.csv && torquectl compare /tmp/walk.csv --robot ck");
  return {app, [options]
          {
            return compare(*options);
          }};
}

} // namespace torqued
