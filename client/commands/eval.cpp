#include "answer/answer_message.h"
#include "commands/offline.h"
#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/files.h"
#include "motion/lcm_log.h"
#include "study/motion_table.h"
#include "study/tally.h"

#include <CLI/CLI.hpp>

#include <fmt/format.h>
#include <memory>
#include <optional>

namespace torqued
{

namespace
{

// Writes answers as rows of a CSV, or as the log that lcm-logger would have recorded: model, desired states, answers.
class AnswerWriter
{
public:
  AnswerWriter(const std::string& path, const Robot& robot, const Config& config, const DesiredMessages& motion)
      : channels_(config.prefix), seconds_(motion.seconds), model_id_(robot.model_id)
  {
    const model_info_t model = model_info(robot, 0, settings_id(config.answers), to_toml(config));
    if (path.ends_with(".lcm"))
    {
      log_.emplace(path);
      log_->write(channels_.model, read_sender(motion.messages.front()).utime, encode(model, buffer_));
      return;
    }
    table_.emplace(model);
    for (const Bytes message : motion.messages)
    {
      decode(message, state_);
      table_->see(state_);
    }
    csv_.emplace(path);
    csv_->write(table_->header());
    csv_->write(robot_lines(robot.name, robot.model_id));
  }

  // the next desired state of the motion, whose answer follows
  void heard(std::int64_t utime, Bytes desired)
  {
    decode(desired, state_);
    if (log_)
    {
      state_.model_id = model_id_; // whoever reads the log can tell whose motion it is
      return log_->write(channels_.desired, utime, encode(state_, buffer_));
    }
    time_ = seconds_.empty() ? std::nullopt : std::optional(seconds_[next_++]);
  }

  void write(const torque_command_t& command)
  {
    if (log_)
      log_->write(channels_.command, command.utime, encode(command, buffer_));
    else
      csv_->write(table_->line(state_, time_, command));
  }

  void write(const rejection_t& rejection)
  {
    if (log_)
      log_->write(channels_.rejected, rejection.utime, encode(rejection, buffer_));
    else
      csv_->write(table_->line(state_, time_, reason_name(rejection.reason)));
  }

  void close()
  {
    if (log_)
      log_->close();
    else
      csv_->close();
  }

private:
  const Channels channels_;
  const std::vector<double> seconds_; // of the motion, as they were read; none of a log
  std::optional<MotionTable> table_;
  std::optional<OutputFile> csv_;
  desired_state_t state_;
  std::size_t next_ = 0;
  std::optional<double> time_;
  std::optional<LogWriter> log_;
  std::int64_t model_id_;
  std::vector<std::byte> buffer_;
};

// what the daemon would publish for one desired state after another
Tally evaluate(const Robot& robot, const AnswerSettings& settings, const DesiredMessages& desired, AnswerWriter& writer)
{
  const std::int64_t id = settings_id(settings);
  StreamMemory memory;
  Tally tally;
  Reply reply;
  flush_denormals();
  for (std::size_t i = 0; i < desired.messages.size(); ++i)
  {
    const Bytes message = desired.messages[i];
    writer.heard(read_sender(message).utime, message);
    if (answer_message(robot, settings, id, message, memory, reply))
    {
      tally.answer(reply.command.flags);
      reply.command.sequence = tally.answered;
      writer.write(reply.command);
    }
    else
    {
      tally.reject(reply.rejection.reason, fmt::format("{}: {}", desired.place(i), reply.rejection.detail));
      writer.write(reply.rejection);
    }
  }
  return tally;
}

ExitCode eval(const OfflineOptions& options)
{
  require_ending(options.out, {".csv", ".lcm"});
  const auto [config, robot, desired] = read_offline_input(options);

  AnswerWriter writer(options.out, robot, config, desired);
  const Tally tally = evaluate(robot, config.answers, desired, writer);
  writer.close();
  print_answered(options, robot, desired, tally);
  return ExitCode::done;
}

} // namespace

Subcommand add_eval(CLI::App& torquectl)
{
  const auto options = std::make_shared<OfflineOptions>();
  CLI::App* app = torquectl.add_subcommand("eval", "answer a trajectory without a bus: the same bits as the daemon's");
  add_offline_options(*app, *options,
                      "where the answers go: .csv, one row each, or .lcm, a log of desired states and answers; - is "
                      "the CSV on the standard output");
  add_answer_options(*app, *options);
  app->footer(
      "A row of the CSV holds a desired state and its answer, so it can be read as a trajectory again, as what export\n"
      "writes can; its column `method` then asks for the methods that answered.\n"
      "Rejected samples have a row that says so. The exit code is 0 if any sample was answered, 65 if none was.\n\n"
      "Example, in the source directory:\n"
      "  torquectl eval client/trajectories/subject01-walk/walk.csv --robot human-subject01 -o /tmp/answers.csv");
  return {app, options, eval};
}

} // namespace torqued
