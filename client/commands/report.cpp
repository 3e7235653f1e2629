#include "commands/offline.h"
#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "methods/method_settings.h"
#include "motion/console.h"
#include "motion/files.h"
#include "motion/lcm_log.h"
#include "page/report_page.h"
#include "study/answer_table.h"
#include "study/recorded.h"
#include "study/tally.h"
#include "text/printable.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <memory>
#include <optional>
#include <set>

namespace torqued
{

namespace
{

struct ReportOptions
{
  std::vector<std::string> files, methods;
  std::string out, robot, config, measured;
  std::optional<std::string> prefix;
  double from = 0.0, to = INFINITY;
  Differentiation differentiation;
};

// One file: its bytes, and how they were read.
struct Input
{
  std::string file, bytes;
  NamedRobots named;
  Trajectory trajectory;
};

// A motion's samples, each with its place among the trajectory's states.
struct Samples
{
  std::vector<DesiredState> states;
  std::vector<std::size_t> places;
};

// The robot of all inputs, for drawing: a page shows one. What is said is loaded once, so that its notes come once.
Robot find_robot(const std::vector<Input>& inputs, const SaidRobot& said)
{
  const Robot robot = choose_drawn_robot(said, inputs.front().named);
  for (const Input& input : inputs)
    if (!said.name_or_path.empty())
      require_same_robot(input.named, robot.name, robot.model_id, said.by);
    else if (const Robot other = choose_drawn_robot(said, input.named); other.model_id != robot.model_id)
      throw Failure(ExitCode::bad_data,
                    "{} is of {} (model_id {}) and {} of {} (model_id {}); a page shows one robot: make a page of each",
                    inputs.front().file, robot.name, robot.model_id, input.file, other.name, other.model_id);
  return robot;
}

// Of several streams the one with the most samples: their clocks have nothing to do with one another.
std::int64_t longest_stream(const Trajectory& trajectory)
{
  std::map<std::int64_t, std::size_t> counts;
  for (const desired_state_t& state : trajectory.states)
    ++counts[state.stream_id];
  const auto longest = std::ranges::max_element(counts, {}, [](const auto& count) { return count.second; });
  if (counts.size() > 1)
    note(fmt::format(
        "{}: holds {} streams of desired states; the page shows the longest, stream_id {}, {} of {} samples",
        trajectory.file, counts.size(), longest->first, longest->second, trajectory.states.size()));
  return longest->first;
}

// What a page can show: samples that make sense for this robot, of one stream, in the order of time, from --from to
// --to.
Samples choose_samples(const Robot& robot, const Trajectory& trajectory, double from, double to)
{
  const std::int64_t stream = longest_stream(trajectory);
  Samples samples;
  std::vector<std::byte> buffer;
  std::optional<std::int64_t> first, last;
  std::size_t unusable = 0, unordered = 0;
  std::string complaint;
  for (std::size_t i = 0; i < trajectory.states.size(); ++i)
  {
    const desired_state_t& state = trajectory.states[i];
    if (state.stream_id != stream)
      continue;
    const Result<DesiredState> desired = decode_desired_state(encode(state, buffer), robot);
    if (const Refusal* refusal = std::get_if<Refusal>(&desired))
    {
      if (unusable++ == 0)
        complaint = fmt::format("{}: {}", trajectory.place(i), refusal->detail());
      continue;
    }
    first = first.value_or(state.utime);
    if (last && state.utime <= *last)
    {
      ++unordered;
      continue;
    }
    last = state.utime;
    const double seconds = 1e-6 * static_cast<double>(state.utime - *first);
    if (seconds < from || seconds > to)
      continue;
    samples.states.push_back(std::get<DesiredState>(desired));
    samples.places.push_back(i);
  }
  if (!last)
    throw Failure(ExitCode::bad_data, "{}: no sample can be shown with {}; the first: {}", trajectory.file, robot.name,
                  complaint);
  if (samples.states.empty())
    throw Failure(ExitCode::usage, "--from {} --to {}: {} holds no sample there; expected times between 0 and {:.3f} s",
                  from, to, trajectory.file, 1e-6 * static_cast<double>(*last - *first));
  if (unusable > 0)
    note(fmt::format("{} of the samples of {} make no sense for {} and are not shown; the first: {}", unusable,
                     trajectory.file, robot.name, complaint));
  if (unordered > 0)
    note(fmt::format("{} of the samples of {} are not later than the one before and are not shown", unordered,
                     trajectory.file));
  return samples;
}

// what the daemon answered; nothing if the log holds no answers
std::optional<ReportRun> recorded_run(const Input& input, const Samples& samples, const Robot& robot,
                                      const Channels& channels)
{
  RecordedAnswers answers(input.bytes, input.file, channels, robot.model_id);
  note(answers.notes());
  if (answers.empty())
    return std::nullopt;
  ReportRun run;
  std::set<std::string> methods;
  for (const std::size_t i : samples.places)
  {
    const desired_state_t& state = input.trajectory.states[i];
    const std::optional<RecordedAnswer> answer = answers.next(state);
    const auto* command = answer ? std::get_if<torque_command_t>(&answer->message) : nullptr;
    const auto* rejection = answer ? std::get_if<rejection_t>(&answer->message) : nullptr;
    if (!command)
    {
      ++run.unanswered[rejection ? reason_name(rejection->reason) : "NO_ANSWER"];
      run.answers.emplace_back();
      run.times.push_back({NAN, NAN});
      continue;
    }
    require_fit(*command, robot.num_coordinates(), robot.num_joints(), robot.name, input.trajectory.place(i));
    run.answers.emplace_back(to_answer(*command));
    run.times.push_back(
        {1e-3 * command->compute_ns, static_cast<double>(answer->timestamp - input.trajectory.heard[i])});
    if (command->method != 0)
      methods.insert(method_name(command->method));
  }
  // answers of torquectl eval took no time
  if (std::ranges::none_of(run.times, [](const AnswerTime& time) { return time.compute_us > 0.0; }))
    run.times.clear();
  run.name = methods.empty() ? "as recorded" : fmt::format("as recorded, {}", fmt::join(methods, ", "));
  return run;
}

// what the daemon would answer, as answer_motion() does
ReportRun evaluated_run(const Robot& robot, const AnswerSettings& settings, const std::vector<DesiredState>& states,
                        const std::optional<Method>& by)
{
  Answered answered = answer_motion(robot, settings, states, by);
  std::set<std::string_view> methods;
  for (const std::optional<Answer>& answer : answered.answers)
    if (answer && answer->method != Method::none)
      methods.insert(name_of(answer->method));
  const std::string used = methods.empty() ? "torqued" : fmt::format("{}", fmt::join(methods, ", "));
  return {by ? std::string(name_of(*by)) : used, std::move(answered.answers), {}, std::move(answered.refused)};
}

// AnswerRows of what was measured, by sample of a motion.
using AnswerRows = std::vector<std::optional<std::size_t>>;

// The rows of the motion that was sent: those whose coordinates are the same numbers as a sample's.
AnswerRows rows_sent(const std::vector<DesiredState>& rows, const std::vector<DesiredState>& states,
                     const std::string& file)
{
  const auto pose = [](const DesiredState& state)
  {
    return std::vector<double>(state.q.begin(), state.q.end() - (state.base_given ? 0 : 2));
  };
  std::map<std::vector<double>, std::vector<std::size_t>> by_pose;
  for (std::size_t i = 0; i < rows.size(); ++i)
    by_pose[pose(rows[i])].push_back(i);
  AnswerRows sent;
  std::optional<std::size_t> last;
  for (const DesiredState& state : states)
  {
    const auto found = by_pose.find(pose(state));
    if (found == by_pose.end())
    {
      sent.emplace_back();
      continue;
    }
    // of equal poses the next one after the row before; after the last row the motion begins again
    const std::vector<std::size_t>& equal = found->second;
    const auto next = last ? std::ranges::upper_bound(equal, *last) : equal.begin();
    last = next == equal.end() ? equal.front() : *next;
    sent.push_back(last);
  }
  const auto found = std::ranges::count_if(sent, [](const auto& row) { return row.has_value(); });
  if (found == 0)
    throw Failure(ExitCode::bad_data,
                  "{}: no row has the coordinates of a sample of the motion; expected the CSV that was sent, with "
                  "columns of what was measured",
                  file);
  if (found < static_cast<std::ptrdiff_t>(states.size()))
    note(fmt::format("{}: {} of {} samples have no row with the same coordinates", file,
                     static_cast<std::ptrdiff_t>(states.size()) - found, states.size()));
  return sent;
}

Measured choose(Measured measured, const AnswerRows& rows)
{
  const auto choose_values = [&rows](std::vector<double>& values)
  {
    std::vector<double> chosen;
    for (const std::optional<std::size_t>& row : rows)
      chosen.push_back(row ? values[*row] : NAN);
    values = std::move(chosen);
  };
  for (Channel& channel : measured.channels)
    choose_values(channel.values);
  for (std::vector<double>& plate : measured.plates)
    if (!plate.empty())
      choose_values(plate);
  return measured;
}

// What was measured along a motion: as --measured says, else as its own columns do.
Measured find_measured(const Input& input, const Samples& samples, const Robot& robot, const ReportOptions& options,
                       const Channels& channels)
{
  if (options.measured.empty())
    return input.trajectory.from_log ? Measured{}
                                     : choose(read_measured(input.bytes, input.trajectory.file, robot,
                                                            decode_all(robot, encode_all(input.trajectory))),
                                              AnswerRows(samples.places.begin(), samples.places.end()));
  const std::string bytes = read_file(options.measured);
  require_same_robot(robots_named_by(bytes, options.measured, channels), robot.name, robot.model_id,
                     fmt::format("{} is of", input.file));
  const Trajectory trajectory =
      parse_trajectory(bytes, options.measured, coordinate_names(robot), options.differentiation, channels);
  note(notes(trajectory));
  const std::vector<DesiredState> states = decode_all(robot, encode_all(trajectory));
  const Measured measured = read_measured(bytes, options.measured, robot, states);
  if (measured.channels.empty())
    throw Failure(
        ExitCode::bad_data,
        "{}: found no column of what was measured; expected FxL, FzL, ML, FxR, FzR, MR, or pub_ankleL and so on",
        options.measured);
  return choose(measured, rows_sent(states, samples.states, options.measured));
}

std::ptrdiff_t num_answered(const ReportRun& run)
{
  return std::ranges::count_if(run.answers, [](const std::optional<Answer>& answer) { return answer.has_value(); });
}

// "constrained: 445 of 447 samples answered, INFEASIBLE 2; rms from the plates 42.8 N forward, 42.0 N upward"
std::string summary(const ReportMotion& motion, const ReportRun& run)
{
  std::string line = fmt::format("{}: {} of {} samples answered", run.name, num_answered(run), run.answers.size());
  for (const auto& [reason, count] : run.unanswered)
    line += fmt::format(", {} {}", reason, count);
  const std::vector<bool> all(run.answers.size(), true);
  std::array<double, 2> rms{}; // forward, upward; mean of both feet
  for (const Channel& channel : motion.measured.channels)
    if (channel.component >= 0)
      rms[static_cast<std::size_t>(channel.component)] +=
          0.5 * agreement(channel, values_of(channel, run.answers), all).rms;
  if (rms[1] > 0.0)
    line += fmt::format("; rms from the plates {:.1f} N forward, {:.1f} N upward", rms[0], rms[1]);
  return line;
}

ExitCode report(const ReportOptions& options)
{
  for (const std::string& file : options.files)
    require_other_file(file, options.out);
  Config config = options.config.empty() ? Config() : read_config(options.config);
  set_flag("--prefix", set_prefix, config, options.prefix);
  std::vector<Method> methods;
  for (const std::string& name : options.methods)
  {
    set_flag("--method", set_method, config, name);
    methods.push_back(config.answers.methods.method);
  }
  const Channels channels(config.prefix);

  std::vector<Input> inputs;
  for (const std::string& file : options.files)
  {
    std::string bytes = read_file(file);
    NamedRobots named = robots_named_by(bytes, file, channels);
    inputs.push_back({file, std::move(bytes), std::move(named), {}});
  }
  const SaidRobot said = said_robot(options.robot, config.robot);
  const Robot robot = find_robot(inputs, said);
  for (Input& input : inputs)
    input.trajectory =
        parse_trajectory(input.bytes, input.file, coordinate_names(robot), options.differentiation, channels);
  check_fits(config, robot);

  flush_denormals();
  std::vector<ReportMotion> motions;
  for (const Input& input : inputs)
  {
    note(notes(input.trajectory));
    const Samples samples = choose_samples(robot, input.trajectory, options.from, options.to);
    ReportMotion& motion = motions.emplace_back();
    motion.source = std::filesystem::path(input.trajectory.file).filename().string();
    motion.states = samples.states;
    if (input.trajectory.from_log)
      if (std::optional<ReportRun> run = recorded_run(input, samples, robot, channels))
        motion.runs.push_back(std::move(*run));
    if (said.name_or_path.empty() && (motion.runs.empty() || !methods.empty() || !options.measured.empty()))
      choose_robot(said, input.named); // refuses what can only be drawn: all that follows computes with masses
    motion.measured = find_measured(input, samples, robot, options, channels);
    for (const Method method : methods)
      motion.runs.push_back(evaluated_run(robot, config.answers, motion.states, method));
    if (motion.runs.empty())
      motion.runs.push_back(evaluated_run(robot, config.answers, motion.states, std::nullopt));
    if (inputs.size() > 1)
      for (ReportRun& run : motion.runs)
        run.name = fmt::format("{}: {}", std::filesystem::path(input.trajectory.file).stem().string(), run.name);
  }
  OutputFile out(options.out);
  out.write(report_page(fmt::format("{} – {}", motions.front().source, robot.name), report_document(robot, motions)));
  out.close();
  std::string summaries;
  bool answered = false;
  for (const ReportMotion& motion : motions)
    for (const ReportRun& run : motion.runs)
    {
      summaries += fmt::format("{}: {}\n", motion.source, summary(motion, run));
      answered = answered || num_answered(run) > 0;
    }
  print_summary(options.out, summaries);
  if (!answered)
    throw Failure(ExitCode::bad_data, "no sample was answered; {}: {}", motions.front().source,
                  summary(motions.front(), motions.front().runs.front()));
  return ExitCode::done;
}

} // namespace

Subcommand add_report(CLI::App& torquectl)
{
  const auto options = std::make_shared<ReportOptions>();
  CLI::App* app = torquectl.add_subcommand(
      "report", "a page that shows a motion walk, with its torques and ground reactions, in any browser");
  app->add_option("FILE", options->files, "logs that lcm-logger recorded, or trajectory CSVs")
      ->type_name("")
      ->required();
  app->add_option("-o,--output", options->out, "the page, one file that needs no network; - for the standard output")
      ->type_name("PAGE.html")
      ->required();
  add_robot_option(*app, options->robot, kRobotOfFile);
  app->add_option(
         "--method", options->methods,
         fmt::format("answer anew by this method, whatever the samples ask for; once for each method to compare: {}",
                     method_names()))
      ->type_name("NAME")
      ->allow_extra_args(false);
  app->add_option("--config", options->config, "the daemon's configuration file, for what is answered anew")
      ->type_name("FILE");
  app->add_option(
         "--measured", options->measured,
         "the CSV that was sent, with columns of what was measured; default: the columns of FILE, if it is a CSV")
      ->type_name("CSV");
  app->add_option("--from", options->from, "begin there, s since the first sample")->type_name("S")->check(check_time);
  app->add_option("--to", options->to, "end there, s since the first sample")->type_name("S")->check(check_time);
  add_prefix_option(*app, options->prefix);
  add_differentiation_options(*app, options->differentiation);
  app->footer(
      "Of a log the page shows what the daemon answered; of a CSV, or with --method, what it would answer, as eval "
      "does.\n"
      "Several files of one robot, or methods, are laid over one another. A robot that does not ship is drawn as the "
      "log\n"
      "says; only --method and --measured need its file (--robot). The exit code is 65 if no sample was answered. "
      "Columns of what was measured: torquectl compare --help.\n"
      "A motion of more than 36000 samples is thinned for drawing: no peak is lost, figures are those of all samples,\n"
      "and --from and --to choose a stretch to be shown in full.\n\n"
      "Example, in the source directory:\n"
      "  torquectl report client/trajectories/subject01-walk/walk.csv --robot human-subject01 \\\n"
      "    --method human-transition --method constrained -o /tmp/walk.html");
  return {app, options, report};
}

} // namespace torqued
