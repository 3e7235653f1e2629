/// TOML read strictly: every key is asked for, every value is checked, and every complaint says file, line and key.
#pragma once

#include "robot/files/text_file.h"

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <toml++/toml.h>
#include <vector>

namespace torqued
{

/// Parses TOML. file: the name used in complaints. Throws FileError.
toml::table parse_toml(std::string_view text, const std::string& file);

/// One table of a TOML file that is being read. Ask for each key, then call finish(), which refuses all others.
///
/// Every function throws FileError if the value is missing (where no fallback is given), of the wrong type, or not in
/// its range. Numbers must be finite. The table and the file name must outlive the reader.
class StrictTable
{
public:
  /// context: how complaints name this table, e.g. "link 'left_shin'"; empty for the file itself.
  StrictTable(const toml::table& table, const std::string& file, std::string context = {});

  double number(std::string_view key, std::optional<double> fallback = {});
  /// A number that must not be negative.
  double magnitude(std::string_view key, std::optional<double> fallback = {});
  std::string text(std::string_view key, std::optional<std::string> fallback = {});
  bool boolean(std::string_view key, std::optional<bool> fallback = {});
  /// [x, z]
  Eigen::Vector2d vector(std::string_view key, std::optional<Eigen::Vector2d> fallback = {});
  /// A square matrix with up to `most` rows: [[…], …] row by row, or [a, b, …] for its diagonal; [] has no rows.
  Eigen::MatrixXd matrix(std::string_view key, std::size_t most);
  /// Exactly two words.
  std::array<std::string, 2> two_texts(std::string_view key, std::array<std::string, 2> fallback);
  /// One of the words given; returns its index.
  int choice(std::string_view key, const std::vector<std::string_view>& words, std::optional<int> fallback = {});

  bool has(std::string_view key) const { return table_->contains(key); }
  bool is_number(std::string_view key) const;
  /// A table of its own, if it is there.
  std::optional<StrictTable> table(std::string_view key);
  /// [[key]], empty if it is not there. Its members are called `context` and their number from 1.
  std::vector<StrictTable> tables(std::string_view key, std::string_view context);
  void set_context(std::string context) { context_ = std::move(context); }
  int line() const { return static_cast<int>(table_->source().begin.line); }

  /// Complains about a value of this table.
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;
  /// Refuses a table that holds a key that nobody asked for.
  void finish() const;

private:
  template <typename Value, typename Convert>
  Value read(std::string_view key, std::optional<Value> fallback, std::string_view expected, const Convert& convert);
  const toml::node* find(std::string_view key);
  std::string slip_of(std::string_view key) const;
  [[noreturn]] void wrong_type(std::string_view key, const toml::node& found, std::string_view expected) const;

  const toml::table* table_;
  const std::string* file_;
  std::string context_;
  std::vector<std::string> asked_;
};

} // namespace torqued
