#include "client/answer_table.h"
#include "client/files.h"
#include "client/lcm_log.h"
#include "client/offline.h"
#include "client/robot_choice.h"
#include "client/subcommands.h"
#include "client/tally.h"

#include <CLI/CLI.hpp>

#include <fmt/format.h>
#include <memory>
#include <optional>

namespace torqued
{

namespace
{

// Writes answers as rows of a CSV, or as the log that lcm-logger would have recorded: model, desired states, answers.
// begin: of the motion, µs
class AnswerWriter
{
public:
  AnswerWriter(const std::string& path, const Robot& robot, const Config& config, std::int64_t begin)
      : channels_(config.prefix), num_joints_(robot.actuators.size())
  {
    if (path.ends_with(".lcm"))
    {
      log_.emplace(path);
      const model_info_t model = model_info(robot, 0, settings_id(config.answers), to_toml(config));
      log_->write(channels_.model, begin, encode(model, buffer_));
      return;
    }
    std::vector<std::string> joint_names;
    for (const Actuator& actuator : robot.actuators)
      joint_names.push_back(actuator.name);
    csv_.emplace(path);
    write_row("utime", answer_columns(joint_names));
    csv_->write(robot_lines(robot.name, robot.model_id));
  }

  void heard(std::int64_t utime, Bytes desired)
  {
    if (log_)
      log_->write(channels_.desired, utime, desired);
  }

  void write(const torque_command_t& command)
  {
    if (log_)
      log_->write(channels_.command, command.utime, encode(command, buffer_));
    else
      write_row(fmt::format("{}", command.utime), answer_cells(command));
  }

  void write(const rejection_t& rejection)
  {
    if (log_)
      log_->write(channels_.rejected, rejection.utime, encode(rejection, buffer_));
    else
      write_row(fmt::format("{}", rejection.utime), rejected_cells(num_joints_, reason_name(rejection.reason)));
  }

  void close()
  {
    if (log_)
      log_->close();
    else
      csv_->close();
  }

private:
  void write_row(const std::string& utime, std::vector<std::string> cells)
  {
    cells.insert(cells.begin(), utime);
    csv_->write(csv_line(cells));
  }

  const Channels channels_;
  std::size_t num_joints_;
  std::optional<OutputFile> csv_;
  std::optional<LogWriter> log_;
  std::vector<std::byte> buffer_;
};

// the daemon's line for one desired state after another: bytes, checked state, answer or refusal
Tally answer_all(const Robot& robot, const AnswerSettings& settings, const DesiredMessages& desired,
                 AnswerWriter& writer)
{
  const std::int64_t id = settings_id(settings);
  StreamMemory memory;
  Tally tally;
  torque_command_t command{};
  rejection_t rejection{};
  flush_denormals();
  for (std::size_t i = 0; i < desired.messages.size(); ++i)
  {
    const Bytes message = desired.messages[i];
    const Sender sender = read_sender(message);
    writer.heard(sender.utime, message);
    const Result<DesiredState> state = decode_desired_state(message, robot);
    const Refusal* refusal = std::get_if<Refusal>(&state);
    const Result<Answer> answered =
        refusal ? Result<Answer>(*refusal) : answer(robot, settings, std::get<DesiredState>(state), memory);
    refusal = std::get_if<Refusal>(&answered);
    if (refusal)
    {
      fill(rejection, sender, *refusal);
      tally.reject(rejection.reason, fmt::format("{}: {}", desired.place(i), rejection.detail));
      writer.write(rejection);
    }
    else
    {
      fill(command, std::get<Answer>(answered), robot.model_id, id);
      tally.answer(command.flags);
      command.sequence = tally.answered;
      writer.write(command);
    }
  }
  return tally;
}

ExitCode eval(const OfflineOptions& options)
{
  if (!options.out.ends_with(".csv") && !options.out.ends_with(".lcm") && options.out != "-")
    throw Failure(ExitCode::usage,
                  fmt::format("-o: found \"{}\"; expected a name that ends in .csv or .lcm, or -", options.out));
  const auto [config, robot, desired] = read_offline_input(options);

  AnswerWriter writer(options.out, robot, config, read_sender(desired.messages.front()).utime);
  const Tally tally = answer_all(robot, config.answers, desired, writer);
  writer.close();
  print_summary(options.out,
                fmt::format("{}: {} of {} samples answered, {}\n{}{}", robot.name, tally.answered,
                            desired.messages.size(), tally.rejections(), tally.flag_line(), tally.first_of_each()));
  tally.require_answers(options.file);
  return ExitCode::done;
}

} // namespace

Subcommand add_eval(CLI::App& torquectl)
{
  const auto options = std::make_shared<OfflineOptions>();
  CLI::App* app = torquectl.add_subcommand("eval", "answer a trajectory without a bus: the same bits as the daemon's");
  add_offline_options(
      *app, *options,
      "where the answers go: .csv, one row each, or .lcm, a log of desired states and answers; - is the "
      "CSV on the standard output");
  add_answer_options(*app, *options);
  app->footer(
      "Rejected samples have a row that says so. The exit code is 0 if any sample was answered, 65 if none was.\n\n"
      "Example, in the source directory:\n"
      "  torquectl eval client/trajectories/subject01-walk/walk.csv --robot human-subject01 -o /tmp/answers.csv");
  return {app, [options]
          {
            return eval(*options);
          }};
}

} // namespace torqued
