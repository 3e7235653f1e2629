#include "answer/answer.h"
#include "commands/offline.h"
#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/console.h"
#include "motion/files.h"
#include "study/answer_table.h"
#include "study/extent.h"
#include "study/motion_table.h"
#include "text/number.h"
#include "text/printable.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <map>
#include <memory>
#include <optional>

namespace torqued
{

namespace
{

struct NearestOptions
{
  OfflineOptions offline;
  std::map<std::string, std::string> given; // texts of the settings of [nearest], by option
};

// Goes through the settings of [nearest] as options: contact_damping is --contact-damping.
class NearestList : public SettingList
{
public:
  // the text that is given for an option; type, what: for --help
  using Given = std::function<std::optional<std::string>(const std::string& option, const std::string& type,
                                                         const std::string& what)>;

  explicit NearestList(Given given) : given_(std::move(given)) {}

  void boolean(std::string_view, bool&, std::string_view) override {}
  void number(std::string_view key, double& value, const Range& range, std::string_view what) override
  {
    const auto text = given(key, "NUMBER", what, number_cell(value));
    if (!text)
      return;
    const std::optional<double> number = number_in<double>(*text);
    if (!number || !range.holds(*number))
      fail(key, *text, range.expected);
    value = *number;
  }
  void number_or(std::string_view, std::optional<double>&, std::string_view, const Range&, std::string_view) override {}
  void three(std::string_view, Eigen::Vector3d&, std::string_view, std::string_view) override {}
  void weights(std::string_view, JointWeights&) override {}
  void word(std::string_view key, int& value, std::span<const std::string_view> words, std::string_view what) override
  {
    const auto text =
        given(key, fmt::format("{}", fmt::join(words, "|")), what, words[static_cast<std::size_t>(value)]);
    if (!text)
      return;
    const auto found = std::ranges::find(words, *text);
    if (found == words.end())
      fail(key, *text, fmt::format("one of: {}", fmt::join(words, ", ")));
    value = static_cast<int>(found - words.begin());
  }
  void table(std::string_view name) override { inside_ = name == "nearest"; }

private:
  static std::string option(std::string_view key)
  {
    std::string name = fmt::format("--{}", key);
    std::ranges::replace(name, '_', '-');
    return name;
  }
  std::optional<std::string> given(std::string_view key, const std::string& type, std::string_view what,
                                   std::string_view present) const
  {
    return inside_ ? given_(option(key), type, fmt::format("{}; default: the configuration's, {}", what, present))
                   : std::nullopt;
  }
  [[noreturn]] static void fail(std::string_view key, const std::string& text, std::string_view expected)
  {
    throw Failure(ExitCode::usage, "{}: found \"{}\"; expected {}", option(key), printable(text), expected);
  }

  const Given given_;
  bool inside_ = false;
};

void add_nearest_options(CLI::App& app, NearestOptions& options)
{
  NearestList add(
      [&](const std::string& option, const std::string& type, const std::string& what)
      {
        app.add_option_function<std::string>(
               option, [&options, option](const std::string& text) { options.given[option] = text; }, what)
            ->type_name(type);
        return std::nullopt;
      });
  AnswerSettings settings;
  list(settings, add);
}

void set_nearest(const NearestOptions& options, AnswerSettings& settings)
{
  NearestList set(
      [&options](const std::string& option, const std::string&, const std::string&)
      {
        const auto found = options.given.find(option);
        return found == options.given.end() ? std::nullopt : std::optional(found->second);
      });
  list(settings, set);
  settings.methods.infeasible = OnInfeasible::nearest;
}

// How far a motion was moved.
class Moves
{
public:
  // place: of the sample, for people
  void add(const Robot& robot, const DesiredState& asked, const Answer& answer, const std::string& place)
  {
    constexpr double rounding = 1e-9; // rad/s², m/s²
    const bool relative = asked.relative_a.size() > 0;
    const int n = robot.num_coordinates();
    const VectorQ before = relative ? asked.relative_a : VectorQ(asked.a.head(n));
    double largest = 0.0;
    const auto see = [&](Extent& extent, double change, const std::string& name)
    {
      extent.add(change, place, name);
      largest = std::max(largest, std::abs(change));
    };
    for (int i = 0; i < n; ++i)
      see(coordinates_, answer.a(i) - before(i),
          (relative ? robot.relative_names : robot.absolute_names)[static_cast<std::size_t>(i)]);
    if (asked.base_given && !robot.fixed_root())
      for (const int i : {0, 1})
        see(base_, answer.base_a(i) - asked.a(n + i), robot.base_names[static_cast<std::size_t>(i)]);
    ++answered_;
    moved_ += largest > rounding ? 1 : 0;
    if ((answer.flags & flag::relaxed) != 0 && ++relaxed_ == 1)
      first_relaxed_ = place;
  }

  std::string text(const Robot& robot) const
  {
    std::string lines =
        moved_ == 0
            ? "no acceleration was moved\n"
            : fmt::format("accelerations were moved in {} of {} samples, by up to\n", moved_, answered_) +
                  coordinates_.line("coordinates", coordinate_unit(robot, "/s^2")) + base_.line("base point", "m/s^2");
    if (relaxed_ > 0)
      lines += fmt::format(
          "RELAXED {}: a contact, a condition of a foot, or a window of constrained gave way; the first: {}\n",
          relaxed_, first_relaxed_);
    return lines;
  }

private:
  Extent coordinates_, base_;
  std::size_t answered_ = 0, moved_ = 0, relaxed_ = 0;
  std::string first_relaxed_;
};

ExitCode run_nearest(const NearestOptions& options)
{
  require_ending(options.offline.out, {".csv"});
  auto [config, robot, desired] = read_offline_input(options.offline);
  if (config.answers.project)
    throw Failure(ExitCode::bad_configuration,
                  "{}: project: found true; expected false, because positions and rates stay as they are here: "
                  "torquectl project moves them",
                  options.offline.config);
  AnswerSettings& settings = config.answers;
  set_nearest(options, settings);
  if (const auto wrong = complaint(settings, robot))
    throw Failure(ExitCode::usage, "the options do not fit {}: {}", robot.name, *wrong);
  const std::vector<DesiredState> states = decode_all(robot, desired);
  require_one_base(desired, states);

  MotionTable table(model_info(robot, 0, 0, ""));
  std::vector<desired_state_t> messages(states.size());
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    decode(desired.messages[i], messages[i]);
    table.see(messages[i]);
  }
  std::string text = table.motion_header() + robot_lines(robot.name, robot.model_id);
  StreamMemory memory;
  Tally tally;
  Moves moves;
  flush_denormals();
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    desired_state_t& message = messages[i];
    const std::optional<double> seconds = desired.seconds.empty() ? std::nullopt : std::optional(desired.seconds[i]);
    const Result<Answer> result = answer(robot, settings, states[i], memory);
    if (const Answer* found = std::get_if<Answer>(&result))
    {
      tally.answer(found->flags);
      moves.add(
          robot, states[i], *found,
          fmt::format("{} s, {}", seconds ? number_cell(*seconds) : seconds_cell(message.utime), desired.place(i)));
      message.a.assign(found->a.begin(), found->a.end());
      std::ranges::copy(found->base_a, message.base_a);
    }
    else
    {
      const Refusal& refusal = std::get<Refusal>(result);
      tally.reject(static_cast<std::int32_t>(refusal.reason()),
                   fmt::format("{}: {}", desired.place(i), refusal.detail()));
    }
    text += table.motion_line(message, seconds);
  }
  tally.require_answers(options.offline.file);
  OutputFile out(options.offline.out);
  out.write(text);
  out.close();
  print_summary(options.offline.out,
                tally.summary(robot.name, states.size()) + moves.text(robot) +
                    (tally.rejected.empty() ? "" : "rejected samples have the accelerations that were asked for\n"));
  return ExitCode::done;
}

} // namespace

Subcommand add_nearest(CLI::App& torquectl)
{
  const auto options = std::make_shared<NearestOptions>();
  CLI::App* app = torquectl.add_subcommand(
      "nearest", "move a motion's accelerations to the nearest ones that contacts and motors allow, and say how far");
  add_offline_options(*app, options->offline,
                      "the same motion with those accelerations, .csv; - is the standard output");
  add_answer_options(*app, options->offline);
  add_nearest_options(*app, *options);
  app->footer(
      "Sample by sample, as the daemon answers with infeasible = \"nearest\", whatever the configuration has there:\n"
      "no foot slips, lifts or tips, loaded ones rest, and motors keep their limits: torqued-nearest(7). Positions,\n"
      "rates and contacts stay as they are, so that each row is what can be had in that posture at those rates. What\n"
      "can be had already stays as it is; rejected samples keep the accelerations that were asked for. Evaluated with\n"
      "the same settings its accelerations stay, but for rounding; samples say ADJUSTED again where only a method's\n"
      "reactions have to change. Further columns of the file are left out. The exit code is 65 if no sample was\n"
      "answered.\n\n"
      "Example, in the source directory:\n"
      "  torquectl nearest client/trajectories/subject01-walk/walk.csv --contacts as-desired -o /tmp/feasible.csv");
  return {app, options, run_nearest};
}

} // namespace torqued
