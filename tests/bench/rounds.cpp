#include "bench/rounds.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace torqued::bench
{

Spread spread_of(std::vector<double> rounds)
{
  if (rounds.empty())
    throw std::out_of_range("no rounds");
  std::sort(rounds.begin(), rounds.end());
  const std::size_t middle = rounds.size() / 2;
  return {rounds.front(), rounds.size() % 2 == 1 ? rounds[middle] : 0.5 * (rounds[middle - 1] + rounds[middle]),
          rounds.back()};
}

std::string rounded(double value)
{
  const double size = std::abs(value);
  return fmt::format("{:.{}f}", value, size >= 100.0 || size == 0.0 ? 0 : size >= 10.0 ? 1 : size >= 1.0 ? 2 : 3);
}

std::string words(const Promise& promise, double found)
{
  const std::string what = promise.against.empty() ? "" : fmt::format("{:.3f} x {}: ", found, promise.against);
  return fmt::format("{}{} {:.5g}, {}", what, promise.at_least ? "at least" : "at most", promise.bound,
                     Rounds::kept(promise, found) ? "kept" : "missed");
}

void Rounds::add(const std::string& group, const std::string& name, const std::string& unit, double value)
{
  const auto known =
      std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.group == group && row.name == name; });
  if (known != rows_.end())
    known->rounds.push_back(value);
  else
    rows_.push_back({group, name, unit, {value}});
}

void Rounds::promise(Promise promise)
{
  if (std::find(promises_.begin(), promises_.end(), promise) == promises_.end())
    promises_.push_back(std::move(promise));
}

const Row& Rounds::row(const std::string& group, const std::string& name) const
{
  const auto found =
      std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.group == group && row.name == name; });
  if (found == rows_.end())
    throw std::out_of_range(fmt::format("{}: {} was not measured", group, name));
  return *found;
}

double Rounds::median(const std::string& group, const std::string& name) const
{
  return spread_of(row(group, name).rounds).median;
}

double Rounds::ratio(const std::string& group, const std::string& name, const std::string& against) const
{
  const std::vector<double>& above = row(group, name).rounds;
  const std::vector<double>& below = row(group, against).rounds;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(above.size(), below.size()); ++i)
    ratios.push_back(above[i] / below[i]);
  return spread_of(ratios).median;
}

std::optional<double> Rounds::found(const Promise& promise) const
{
  try
  {
    return promise.against.empty() ? median(promise.group, promise.name)
                                   : ratio(promise.group, promise.name, promise.against);
  }
  catch (const std::out_of_range&)
  {
    return {};
  }
}

std::vector<std::string> Rounds::groups() const
{
  std::vector<std::string> groups;
  for (const Row& row : rows_)
    if (std::find(groups.begin(), groups.end(), row.group) == groups.end())
      groups.push_back(row.group);
  return groups;
}

std::string Rounds::table() const
{
  std::string text;
  for (const std::string& group : groups())
  {
    text += fmt::format("{}{}\n", text.empty() ? "" : "\n", group);
    for (const Row& row : rows_)
    {
      if (row.group != group)
        continue;
      const Spread spread = spread_of(row.rounds);
      const std::string line = fmt::format("  {:<26}{:>8} {:<9}{:>8} – {:<8} ", row.name, rounded(spread.median),
                                           row.unit, rounded(spread.least), rounded(spread.most));
      std::vector<std::string> promised;
      for (const Promise& promise : promises_)
        if (const auto value = found(promise); value && promise.group == group && promise.name == row.name)
          promised.push_back(words(promise, *value));
      text += promised.empty() ? line.substr(0, line.find_last_not_of(' ') + 1) : line + promised.front();
      text += '\n';
      for (std::size_t i = 1; i < promised.size(); ++i)
        text += fmt::format("{:65}{}\n", "", promised[i]);
    }
  }
  return text;
}

std::string Rounds::json() const
{
  nlohmann::ordered_json said{{"rows", nlohmann::ordered_json::array()}, {"promises", nlohmann::ordered_json::array()}};
  for (const Row& row : rows_)
    said["rows"].push_back({{"group", row.group},
                            {"name", row.name},
                            {"unit", row.unit},
                            {"median", spread_of(row.rounds).median},
                            {"rounds", row.rounds}});
  for (const Promise& promise : promises_)
  {
    const std::optional<double> value = found(promise);
    nlohmann::ordered_json one{{"group", promise.group}, {"name", promise.name}};
    if (!promise.against.empty())
      one["against"] = promise.against;
    one[promise.at_least ? "at_least" : "at_most"] = promise.bound;
    one["found"] = value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
    one["kept"] = value ? nlohmann::ordered_json(kept(promise, *value)) : nlohmann::ordered_json();
    said["promises"].push_back(std::move(one));
  }
  return said.dump(2) + "\n";
}

} // namespace torqued::bench
