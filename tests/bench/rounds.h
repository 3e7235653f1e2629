/// Measurements in interleaved rounds, and what they are compared with.
///
/// A machine is never the same twice. So everything is measured once per round, and of two numbers that are compared
/// the ratio is taken within each round; what is reported are medians over the rounds.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace torqued::bench
{

/// One line of the table: a quantity, in its unit, once per round.
struct Row
{
  std::string group, name;
  std::string unit; ///< "ns", "us", "MB", "1/s", …
  std::vector<double> rounds;
};

/// What a ratio of two rows, or a row itself, should be.
struct Promise
{
  std::string group, name; ///< the row
  std::string against;     ///< name of a row of the same group; empty: the row itself is compared with the bound
  double bound;
  bool at_least = false; ///< else at most

  bool operator==(const Promise&) const = default;
};

/// What is reported of a row's rounds.
struct Spread
{
  double least, median, most;
};

/// Throws std::out_of_range if there are none.
Spread spread_of(std::vector<double> rounds);

/// A number for people: about three digits, never an exponent.
std::string rounded(double value);

/// The promise, what was found, and whether it is kept, in one line.
std::string words(const Promise& promise, double found);

/// All rows, in the order in which they were first added.
class Rounds
{
public:
  void add(const std::string& group, const std::string& name, const std::string& unit, double value);
  /// Says that the row's ratio to another, or the row, is at most, or at least, this. Said again, it counts once.
  void promise(Promise promise);

  const std::vector<Row>& rows() const { return rows_; }
  const std::vector<Promise>& promises() const { return promises_; }
  /// In the order of their first rows.
  std::vector<std::string> groups() const;

  /// Median of the row. Throws std::out_of_range where there is none.
  double median(const std::string& group, const std::string& name) const;
  /// Median over the rounds of row / against. Throws as median() does.
  double ratio(const std::string& group, const std::string& name, const std::string& against) const;
  /// What the promise speaks of: a ratio, or a row's median; nothing if its rows were not measured.
  std::optional<double> found(const Promise& promise) const;
  static bool kept(const Promise& promise, double found)
  {
    return promise.at_least ? found >= promise.bound : found <= promise.bound;
  }

  std::string table() const;
  std::string json() const;

private:
  const Row& row(const std::string& group, const std::string& name) const;

  std::vector<Row> rows_;
  std::vector<Promise> promises_;
};

} // namespace torqued::bench
