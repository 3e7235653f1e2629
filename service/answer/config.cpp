#include "answer/config.h"

#include "robot/files/strict_toml.h"
#include "text/printable.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <sstream>
#include <stdexcept>

namespace torqued
{

namespace
{

constexpr std::array<std::string_view, 7> kLogLevels{"trace", "debug", "info", "warn", "error", "critical", "off"};
constexpr int kLastProcessor = 1023; // of the system's own sets
constexpr std::array<std::string_view, 3> kPolicies{"other", "fifo", "rr"};

void set_plain(std::string& text, const std::string& value)
{
  if (std::ranges::any_of(value, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }))
    throw std::invalid_argument(
        fmt::format("found \"{}\"; expected a text without control characters", printable(value)));
  text = value;
}

Range seconds(double longest)
{
  return {0.0, longest, fmt::format("a positive number of seconds, up to {:g}", longest), true};
}

// What is done with all settings of a configuration: with those of answers, and with texts.
class ConfigList : public SettingList
{
public:
  // set: sets the text, or throws std::invalid_argument with what would be right
  virtual void text(std::string_view key, const std::string& value, const std::function<void(const std::string&)>& set,
                    std::string_view what) = 0;
};

void list(Config& config, ConfigList& with)
{
  const auto plain = [](std::string& text)
  {
    return [&text](const std::string& value)
    {
      set_plain(text, value);
    };
  };
  const auto by = [&config](void (*set)(Config&, const std::string&))
  {
    return [&config, set](const std::string& value)
    {
      set(config, value);
    };
  };
  with.text("robot", config.robot, plain(config.robot),
            "a robot that ships, or a .toml or .urdf file; '': --robot must say it");
  with.text("lcm_url", config.lcm_url, plain(config.lcm_url), "'': LCM_DEFAULT_URL, or LCM's own default");
  with.text("prefix", config.prefix, by(set_prefix), "stands before each channel's name");
  with.text("log_level", config.log_level, by(set_log_level), fmt::format("{}", fmt::join(kLogLevels, ", ")));
  with.boolean("every_sample", config.every_sample, "answer all samples in order instead of the newest");
  with.boolean("lock_memory", config.lock_memory, "keep all memory of the process from being paged out");
  with.number("max_age", config.max_age, seconds(1.0),
              "s; five times this long without an accepted sample, and another stream may begin");
  with.number("deadline", config.deadline, seconds(3600.0), "s, arrival to publish");
  list(config.answers, with);
  Scheduling& scheduling = config.scheduling;
  with.table("scheduling");
  with.word("policy", scheduling.policy, kPolicies, "of the thread that answers: other (as it is started), fifo or rr");
  with.number_or("priority", scheduling.priority, "none",
                 {1.0, 99.0, "\"none\", or a whole number from 1 to 99", false, true}, "1 to 99, of fifo and rr");
  with.text(
      "cpus", scheduling.cpus,
      [&scheduling](const std::string& value)
      {
        processors(value);
        scheduling.cpus = value;
      },
      "processors of the thread that answers, as taskset lists them: '2', '2,3', '2-5'; '': all");
}

// Reads each setting from a TOML file. finish() refuses all that is not a setting.
class Reader : public ConfigList
{
public:
  explicit Reader(StrictTable& file) : file_(file) {}

  void boolean(std::string_view key, bool& value, std::string_view) override { value = in().boolean(key, value); }
  void number(std::string_view key, double& value, const Range& range, std::string_view) override
  {
    value = in().number(key, value);
    if (!range.holds(value))
      in().fail(key, fmt::format("found {}; expected {}", value, range.expected));
  }
  void number_or(std::string_view key, std::optional<double>& value, std::string_view word, const Range& range,
                 std::string_view what) override
  {
    if (in().is_number(key))
      number(key, value.emplace(), range, what);
    else if (const std::string found = in().text(key, std::string(word)); found != word)
      in().fail(key, fmt::format("found \"{}\"; expected {}", printable(found), range.expected));
    else if (in().has(key))
      value.reset();
  }
  void three(std::string_view key, Eigen::Vector3d& value, std::string_view expected, std::string_view) override
  {
    const Eigen::MatrixXd found = in().matrix(key, 3);
    if (found.size() == 0)
      return;
    if (found.rows() != 3 || !found.isDiagonal(0.0) || !(found.diagonal().minCoeff() > 0.0))
      in().fail(key, fmt::format("expected {}", expected));
    value = found.diagonal();
  }
  void weights(std::string_view key, JointWeights& value) override
  {
    const Eigen::MatrixXd W = in().matrix(key, kMaxJoints);
    const double size = W.size() > 0 ? W.cwiseAbs().maxCoeff() : 0.0;
    for (Eigen::Index i = 0; i < W.rows(); ++i)
      for (Eigen::Index k = 0; k < i; ++k)
        if (std::abs(W(i, k) - W(k, i)) > 1e-12 * size)
          in().fail(
              key, fmt::format("found {} in row {}, column {} and {} in row {}, column {}; expected a symmetric matrix",
                               W(i, k), i + 1, k + 1, W(k, i), k + 1, i + 1));
    if (W.size() > 0 && W.llt().info() != Eigen::Success)
      in().fail(key, "found a matrix that is not positive definite; expected one that is, such as positive numbers for "
                     "its diagonal");
    value = 0.5 * (W + W.transpose());
  }
  void word(std::string_view key, int& value, std::span<const std::string_view> words, std::string_view) override
  {
    value = in().choice(key, {words.begin(), words.end()}, value);
  }
  void text(std::string_view key, const std::string& value, const std::function<void(const std::string&)>& set,
            std::string_view) override
  {
    try
    {
      set(in().text(key, value));
    }
    catch (const std::invalid_argument& error)
    {
      in().fail(key, error.what());
    }
  }
  void table(std::string_view name) override
  {
    finish_table();
    table_ = file_.table(name);
    if (!table_)
      table_.emplace(none_, nowhere_);
  }

  // Complains about a setting of the last table.
  [[noreturn]] void fail(std::string_view key, const std::string& message) { in().fail(key, message); }

  void finish()
  {
    finish_table();
    file_.finish();
  }

private:
  void finish_table()
  {
    if (table_)
      table_->finish();
  }

  // what is read: the file itself, or the last table
  StrictTable& in() { return table_ ? *table_ : file_; }

  StrictTable& file_;
  std::optional<StrictTable> table_;
  // in place of a table that the file does not have: all settings stay as they are
  const toml::table none_;
  const std::string nowhere_;
};

// Writes each setting as a line of TOML, with what it means.
class Writer : public ConfigList
{
public:
  void boolean(std::string_view key, bool& value, std::string_view what) override
  {
    line(key, fmt::format("{}", value), what);
  }
  void number(std::string_view key, double& value, const Range&, std::string_view what) override
  {
    line(key, fmt::format("{}", value), what);
  }
  void number_or(std::string_view key, std::optional<double>& value, std::string_view word, const Range&,
                 std::string_view what) override
  {
    line(key, value ? fmt::format("{}", *value) : quoted(word), what);
  }
  void three(std::string_view key, Eigen::Vector3d& value, std::string_view, std::string_view what) override
  {
    line(key, fmt::format("[{}]", fmt::join(value, ", ")), what);
  }
  void weights(std::string_view key, JointWeights& W) override
  {
    std::vector<std::string> entries;
    for (Eigen::Index i = 0; i < W.rows(); ++i)
      entries.push_back(W.isDiagonal(0.0) ? fmt::format("{}", W(i, i))
                                          : fmt::format("[{}]", fmt::join(W.row(i), ", ")));
    line(key, fmt::format("[{}]", fmt::join(entries, ", ")),
         "of each motor's torque, or a symmetric positive definite matrix; []: all 1");
  }
  void word(std::string_view key, int& value, std::span<const std::string_view> words, std::string_view what) override
  {
    line(key, quoted(words[static_cast<std::size_t>(value)]), what);
  }
  void text(std::string_view key, const std::string& value, const std::function<void(const std::string&)>&,
            std::string_view what) override
  {
    line(key, quoted(value), what);
  }
  void table(std::string_view name) override { toml_ += fmt::format("\n[{}]\n", name); }

  const std::string& toml() const { return toml_; }

private:
  void line(std::string_view key, std::string_view value, std::string_view what)
  {
    toml_ += fmt::format("{} = {}  # {}\n", key, value, what);
  }

  // in whatever quotes it needs
  static std::string quoted(std::string_view text)
  {
    std::ostringstream toml;
    toml << toml::value<std::string>(text);
    return toml.str();
  }

  std::string toml_ = "# configuration of torqued\n\n";
};

} // namespace

void set_method(Config& config, const std::string& name)
{
  const Method method = method_named(name);
  if (method == Method::none)
    throw std::invalid_argument(fmt::format("found \"{}\"; expected one of: {}", printable(name), method_names()));
  config.answers.methods.method = method;
}

void set_prefix(Config& config, const std::string& prefix)
{
  // LCM reads channel names as regular expressions; these characters stand for themselves
  const auto plain = [](char c)
  {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '/';
  };
  constexpr std::size_t longest = 32;
  if (prefix.size() > longest || !std::ranges::all_of(prefix, plain))
    throw std::invalid_argument(
        fmt::format("found \"{}\"; expected at most {} letters, digits, _, - or /", printable(prefix), longest));
  config.prefix = prefix;
}

void set_log_level(Config& config, const std::string& level)
{
  if (std::ranges::find(kLogLevels, level) == kLogLevels.end())
    throw std::invalid_argument(
        fmt::format("found \"{}\"; expected one of: {}", printable(level), fmt::join(kLogLevels, ", ")));
  config.log_level = level;
}

std::vector<int> processors(const std::string& list)
{
  const std::invalid_argument wrong(
      fmt::format("found \"{}\"; expected processors as taskset lists them, such as \"2\", \"2,3\" or \"2-5\", with "
                  "numbers from 0 to {}",
                  printable(list), kLastProcessor));
  const char* at = list.data();
  const char* const end = at + list.size();
  const auto number = [&]
  {
    int found = -1;
    const auto [rest, error] = std::from_chars(at, end, found);
    if (error != std::errc() || found < 0 || found > kLastProcessor)
      throw wrong;
    at = rest;
    return found;
  };
  std::vector<int> all;
  while (at != end)
  {
    const int first = number();
    const int last = at != end && *at == '-' ? (++at, number()) : first;
    if (last < first || (at != end && (*at++ != ',' || at == end)))
      throw wrong;
    for (int processor = first; processor <= last; ++processor)
      all.push_back(processor);
  }
  return all;
}

std::string_view name_of(Scheduling::Policy policy)
{
  return kPolicies[static_cast<std::size_t>(policy)];
}

Config read_config(const std::string& path)
{
  return read_config(read_text_file(path), path);
}

Config read_config(std::string_view text, const std::string& file)
{
  const toml::table document = parse_toml(text, file);
  StrictTable table(document, file);
  Config config;
  config.lcm_url_set_by = "lcm_url in " + file;
  Reader reader(table);
  list(config, reader);
  const auto& [policy, priority, cpus] = config.scheduling;
  if (policy == Scheduling::Policy::other && priority)
    reader.fail("priority", fmt::format("found {} with policy \"other\", which has none; expected policy = \"fifo\" or "
                                        "\"rr\" beside it, or no priority",
                                        *priority));
  if (policy != Scheduling::Policy::other && !priority)
    reader.fail("priority",
                fmt::format("found none with policy \"{}\"; expected a whole number from 1 to 99, such as 50",
                            name_of(policy)));
  reader.finish();
  return config;
}

void check_fits(const Config& config, const Robot& robot)
{
  if (const auto wrong = complaint(config.answers, robot))
    throw FileError("the configuration does not fit " + robot.name + ": " + *wrong);
}

std::string to_toml(Config config)
{
  Writer writer;
  list(config, writer);
  return writer.toml();
}

} // namespace torqued
