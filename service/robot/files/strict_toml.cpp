#include "robot/files/strict_toml.h"

#include "text/printable.h"
#include "text/spelling.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <sstream>

namespace torqued
{

namespace
{

std::string shown_node(const toml::node& node)
{
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  return printable(text.str(), kLongestShown);
}

std::optional<double> finite_number(const toml::node& node)
{
  const std::optional<double> number = node.is_number() ? node.value<double>() : std::nullopt;
  return number && std::isfinite(*number) ? number : std::nullopt;
}

template <typename Value> std::optional<Value> exactly(const toml::node& node)
{
  return node.value_exact<Value>();
}

// numbers, row by row, or those of a diagonal
std::optional<Eigen::MatrixXd> square_matrix(const toml::node& node, std::size_t most)
{
  const toml::array* array = node.as_array();
  if (!array || array->size() > most)
    return {};
  const std::size_t size = array->size();
  const bool diagonal = size > 0 && (*array)[0].is_number();
  Eigen::MatrixXd value = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(size), static_cast<Eigen::Index>(size));
  for (std::size_t i = 0; i < size; ++i)
  {
    const toml::node& entry = (*array)[i];
    const toml::array* row = entry.as_array();
    if (!diagonal && (!row || row->size() != size))
      return {};
    for (std::size_t k = diagonal ? i : 0; k < (diagonal ? i + 1 : size); ++k)
    {
      const std::optional<double> number = finite_number(diagonal ? entry : (*row)[k]);
      if (!number)
        return {};
      value(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = *number;
    }
  }
  return value;
}

// The parser follows a dotted key, a.b.c, one call deeper for each dot, without a limit of its own.
void refuse_deep_keys(std::string_view text, const std::string& file)
{
  constexpr int deepest = 100;
  int line = 1;
  int dots = 0;
  for (const char c : text)
  {
    const bool part_of_key =
        std::isalnum(static_cast<unsigned char>(c)) || std::string_view("_- \t\"'").find(c) != std::string_view::npos;
    line += c == '\n' ? 1 : 0;
    dots = c == '.' ? dots + 1 : part_of_key ? dots : 0;
    if (dots > deepest)
      throw FileError(
          fmt::format("{}:{}: a key with more than {} dots; nothing here is nested that deep", file, line, deepest));
  }
}

} // namespace

toml::table parse_toml(std::string_view text, const std::string& file)
{
  refuse_deep_keys(text, file);
  try
  {
    return toml::parse(text, file);
  }
  catch (const toml::parse_error& error)
  {
    throw FileError(fmt::format("{}:{}: not TOML: {}", file, error.source().begin.line, error.description()));
  }
}

StrictTable::StrictTable(const toml::table& table, const std::string& file, std::string context)
    : table_(&table), file_(&file), context_(std::move(context))
{
}

void StrictTable::fail(std::string_view key, const std::string& message) const
{
  const toml::node* node = table_->get(key);
  const auto line = node ? node->source().begin.line : table_->source().begin.line;
  throw FileError(fmt::format("{}:{}: {}{}{}: {}", *file_, line, context_, context_.empty() ? "" : ": ",
                              printable(std::string(key), kLongestShown), message));
}

void StrictTable::wrong_type(std::string_view key, const toml::node& found, std::string_view expected) const
{
  fail(key, fmt::format("found {}; expected {}", shown_node(found), expected));
}

const toml::node* StrictTable::find(std::string_view key)
{
  asked_.emplace_back(key);
  return table_->get(key);
}

// a key that nobody asked for, and that may be meant
std::string StrictTable::slip_of(std::string_view key) const
{
  for (const auto& [found, node] : *table_)
    if (std::ranges::find(asked_, found.str()) == asked_.end() && resembles(found.str(), key))
      return fmt::format("; {} in line {} is not known here", printable(std::string(found.str())),
                         node.source().begin.line);
  return {};
}

template <typename Value, typename Convert>
Value StrictTable::read(std::string_view key, std::optional<Value> fallback, std::string_view expected,
                        const Convert& convert)
{
  const toml::node* node = find(key);
  if (!node && fallback)
    return *std::move(fallback);
  if (!node)
    fail(key, fmt::format("is missing; expected {}{}", expected, slip_of(key)));
  std::optional<Value> value = convert(*node);
  if (!value)
    wrong_type(key, *node, expected);
  return *std::move(value);
}

double StrictTable::number(std::string_view key, std::optional<double> fallback)
{
  return read(key, fallback, "a finite number", finite_number);
}

double StrictTable::magnitude(std::string_view key, std::optional<double> fallback)
{
  const double value = number(key, fallback);
  if (value < 0.0)
    fail(key, fmt::format("found {}; expected a number that is not negative", value));
  return value;
}

bool StrictTable::is_number(std::string_view key) const
{
  const toml::node* node = table_->get(key);
  return node && node->is_number();
}

std::string StrictTable::text(std::string_view key, std::optional<std::string> fallback)
{
  return read(key, std::move(fallback), "a text in quotes", exactly<std::string>);
}

bool StrictTable::boolean(std::string_view key, std::optional<bool> fallback)
{
  return read(key, fallback, "true or false", exactly<bool>);
}

Eigen::Vector2d StrictTable::vector(std::string_view key, std::optional<Eigen::Vector2d> fallback)
{
  const auto convert = [](const toml::node& node) -> std::optional<Eigen::Vector2d>
  {
    const toml::array* array = node.as_array();
    if (!array || array->size() != 2)
      return {};
    const std::optional<double> x = finite_number((*array)[0]), z = finite_number((*array)[1]);
    return x && z ? std::optional(Eigen::Vector2d(*x, *z)) : std::nullopt;
  };
  return read(key, fallback, "two finite numbers, [x, z]", convert);
}

Eigen::MatrixXd StrictTable::matrix(std::string_view key, std::size_t most)
{
  return read(key, std::optional(Eigen::MatrixXd()),
              fmt::format("up to {} finite numbers, or as many rows of as many numbers", most),
              [most](const toml::node& node) { return square_matrix(node, most); });
}

std::array<std::string, 2> StrictTable::two_texts(std::string_view key, std::array<std::string, 2> fallback)
{
  using Texts = std::array<std::string, 2>;
  const auto convert = [](const toml::node& node) -> std::optional<Texts>
  {
    const toml::array* array = node.as_array();
    if (!array || array->size() != 2 || !(*array)[0].is_string() || !(*array)[1].is_string())
      return {};
    return Texts{*(*array)[0].value<std::string>(), *(*array)[1].value<std::string>()};
  };
  return read(key, std::optional(std::move(fallback)), "two texts in quotes", convert);
}

int StrictTable::choice(std::string_view key, const std::vector<std::string_view>& words, std::optional<int> fallback)
{
  if (fallback && !has(key))
    return asked_.emplace_back(key), *fallback;
  const std::string word = text(key);
  const auto found = std::ranges::find(words, word);
  if (found == words.end())
    fail(key, fmt::format("found \"{}\"; expected one of: {}", printable(word, kLongestShown), fmt::join(words, ", ")));
  return static_cast<int>(found - words.begin());
}

std::optional<StrictTable> StrictTable::table(std::string_view key)
{
  const toml::node* node = find(key);
  if (!node)
    return {};
  if (!node->is_table())
    wrong_type(key, *node, fmt::format("a table, [{}]", key));
  return StrictTable(*node->as_table(), *file_, std::string(key));
}

std::vector<StrictTable> StrictTable::tables(std::string_view key, std::string_view context)
{
  std::vector<StrictTable> tables;
  const toml::node* node = find(key);
  if (!node)
    return tables;
  const toml::array* array = node->as_array();
  if (!array || !std::ranges::all_of(*array, [](const toml::node& n) { return n.is_table(); }))
    wrong_type(key, *node, fmt::format("tables, [[{}]]", key));
  for (const toml::node& member : *array)
    tables.emplace_back(*member.as_table(), *file_, fmt::format("{} {}", context, tables.size() + 1));
  return tables;
}

void StrictTable::finish() const
{
  for (const auto& [key, node] : *table_)
    if (const std::string_view name = key.str(); std::ranges::find(asked_, name) == asked_.end())
    {
      std::vector<std::string> known = asked_;
      std::ranges::sort(known);
      known.erase(std::unique(known.begin(), known.end()), known.end());
      fail(name, fmt::format("is not known here; known are: {}", fmt::join(known, ", ")));
    }
}

} // namespace torqued
