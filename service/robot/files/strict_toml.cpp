#include "robot/files/strict_toml.h"

#include "text/printable.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <limits>
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

double StrictTable::number(std::string_view key, std::optional<double> fallback)
{
  const toml::node* node = find(key);
  if (!node && fallback)
    return *fallback;
  if (!node)
    fail(key, "is missing; expected a number");
  if (!node->is_number())
    wrong_type(key, *node, "a number");
  const double value = *node->value<double>();
  if (!std::isfinite(value))
    wrong_type(key, *node, "a finite number");
  return value;
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
  const toml::node* node = find(key);
  if (!node && fallback)
    return *fallback;
  if (!node)
    fail(key, "is missing; expected a text");
  if (!node->is_string())
    wrong_type(key, *node, "a text in quotes");
  return *node->value<std::string>();
}

bool StrictTable::boolean(std::string_view key, std::optional<bool> fallback)
{
  const toml::node* node = find(key);
  if (!node && fallback)
    return *fallback;
  if (!node)
    fail(key, "is missing; expected true or false");
  if (!node->is_boolean())
    wrong_type(key, *node, "true or false");
  return *node->value<bool>();
}

Eigen::Vector2d StrictTable::vector(std::string_view key, std::optional<Eigen::Vector2d> fallback)
{
  const toml::node* node = find(key);
  if (!node && fallback)
    return *fallback;
  if (!node)
    fail(key, "is missing; expected two numbers, [x, z]");
  const toml::array* array = node->as_array();
  if (!array || array->size() != 2 || !(*array)[0].is_number() || !(*array)[1].is_number())
    wrong_type(key, *node, "two numbers, [x, z]");
  const Eigen::Vector2d value(*(*array)[0].value<double>(), *(*array)[1].value<double>());
  if (!value.allFinite())
    wrong_type(key, *node, "two finite numbers, [x, z]");
  return value;
}

Eigen::MatrixXd StrictTable::matrix(std::string_view key, Eigen::Index most)
{
  const toml::node* node = find(key);
  if (!node)
    return {};
  const std::string expected = fmt::format("up to {} finite numbers, or as many rows of as many numbers", most);
  const toml::array* array = node->as_array();
  if (!array || static_cast<Eigen::Index>(array->size()) > most)
    wrong_type(key, *node, expected);
  const auto size = static_cast<Eigen::Index>(array->size());
  Eigen::MatrixXd value = Eigen::MatrixXd::Zero(size, size);
  const bool diagonal = size > 0 && (*array)[0].is_number();
  const auto read = [&](const toml::node& entry)
  {
    const double number = entry.is_number() ? *entry.value<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(number))
      wrong_type(key, *node, expected);
    return number;
  };
  for (Eigen::Index i = 0; i < size; ++i)
  {
    const toml::node& entry = (*array)[static_cast<std::size_t>(i)];
    if (diagonal)
    {
      value(i, i) = read(entry);
      continue;
    }
    const toml::array* row = entry.as_array();
    if (!row || static_cast<Eigen::Index>(row->size()) != size)
      wrong_type(key, *node, expected);
    for (Eigen::Index k = 0; k < size; ++k)
      value(i, k) = read((*row)[static_cast<std::size_t>(k)]);
  }
  return value;
}

std::array<std::string, 2> StrictTable::two_texts(std::string_view key, std::array<std::string, 2> fallback)
{
  const toml::node* node = find(key);
  if (!node)
    return fallback;
  const toml::array* array = node->as_array();
  if (!array || array->size() != 2 || !(*array)[0].is_string() || !(*array)[1].is_string())
    wrong_type(key, *node, "two texts in quotes");
  return {*(*array)[0].value<std::string>(), *(*array)[1].value<std::string>()};
}

int StrictTable::choice(std::string_view key, const std::vector<std::string_view>& words, std::optional<int> fallback)
{
  if (fallback && !has(key))
    return asked_.emplace_back(key), *fallback;
  const std::string word = text(key);
  const auto found = std::find(words.begin(), words.end(), word);
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
  if (!array || !std::all_of(array->begin(), array->end(), [](const toml::node& n) { return n.is_table(); }))
    wrong_type(key, *node, fmt::format("tables, [[{}]]", key));
  for (const toml::node& member : *array)
    tables.emplace_back(*member.as_table(), *file_, fmt::format("{} {}", context, tables.size() + 1));
  return tables;
}

void StrictTable::finish() const
{
  for (const auto& [key, node] : *table_)
    if (const std::string_view name = key.str(); std::find(asked_.begin(), asked_.end(), name) == asked_.end())
    {
      std::vector<std::string> known = asked_;
      std::sort(known.begin(), known.end());
      known.erase(std::unique(known.begin(), known.end()), known.end());
      fail(name, fmt::format("is not known here; known are: {}", fmt::join(known, ", ")));
    }
}

} // namespace torqued
