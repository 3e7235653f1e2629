#include "bus/bus.h"
#include "bus/daemons.h"
#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/status_json.h"
#include "commands/subcommands.h"
#include "motion/console.h"
#include "motion/files.h"
#include "study/answer_table.h"
#include "study/tally.h"
#include "text/printable.h"
#include "wire/command_fields.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace torqued
{

namespace
{

using Json = nlohmann::ordered_json;

struct EchoOptions
{
  std::string format = "table", lcm_url;
  std::optional<std::string> prefix;
  std::int64_t count = 0;
  bool status = false;
};

std::string sentence(const rejection_t& rejection)
{
  return fmt::format("utime {} was rejected, {}: {}\n", rejection.utime, reason_name(rejection.reason),
                     printable(rejection.detail));
}

std::string sentence(const status_t& status)
{
  return fmt::format("torqued {} is {}: {} received = {} answered + {} rejected + {} superseded; {} late; latency p50 "
                     "{:.0f} µs, p99 {:.0f} µs, max {:.0f} µs\n",
                     printable(status.version), state_name(status.state), status.received, status.answered,
                     status.rejected, status.superseded, status.late, status.latency_us_p50, status.latency_us_p99,
                     status.latency_us_max);
}

// One way to write what the daemon publishes. Every text ends its lines.
class Format
{
public:
  virtual ~Format() = default;
  virtual std::string header(const model_info_t& model) = 0;
  virtual std::string line(const torque_command_t& command) = 0;
  virtual std::string line(const rejection_t& rejection) = 0;
  virtual std::string line(const status_t& status) = 0;
};

// torques and what carries the robot, in columns for the eye
class Table : public Format
{
public:
  std::string header(const model_info_t& model) override
  {
    std::string line = fmt::format("{:>{}}", "utime", kTimeWidth);
    widths_.clear();
    for (const std::string& joint : model.joint_names)
    {
      widths_.push_back(std::max<int>(static_cast<int>(joint.size()), kNumberWidth));
      line += fmt::format("  {:>{}}", printable(joint), widths_.back());
    }
    for (const char* name : {"fzL", "fzR", "zmp"})
      line += fmt::format("  {:>{}}", name, kNumberWidth);
    return fmt::format("{}: torques N m, forces N, zmp m\n{}  method, flags\n", printable(model.name), line);
  }
  std::string line(const torque_command_t& command) override
  {
    std::string line = fmt::format("{:>{}}", command.utime, kTimeWidth);
    for (std::size_t joint = 0; joint < widths_.size(); ++joint)
      line += fmt::format("  {:>{}.3f}", command.torque[joint], widths_[joint]);
    for (const double number : {command.left.fz, command.right.fz})
      line += fmt::format("  {:>{}.2f}", number, kNumberWidth);
    return fmt::format("{}  {:>{}.4f}  {} {}\n", line, command.zmp, kNumberWidth, method_name(command.method),
                       fmt::join(flag_names(command.flags), " "));
  }
  std::string line(const rejection_t& rejection) override { return sentence(rejection); }
  std::string line(const status_t& status) override { return sentence(status); }

private:
  static constexpr int kTimeWidth = 16, kNumberWidth = 9;
  std::vector<int> widths_;
};

class Csv : public Format
{
public:
  std::string header(const model_info_t& model) override
  {
    std::vector<std::string> accelerations;
    for (std::int32_t i = 0; i < model.num_coordinates; ++i)
      accelerations.push_back(fmt::format("{}", i));
    floats_ = !model.base_names[0].empty();
    if (floats_)
      accelerations.insert(accelerations.end(), std::begin(model.base_names), std::end(model.base_names));
    const std::vector<std::string> columns = answer_columns(model.joint_names, accelerations);
    size_ = columns.size();
    return csv_line({"utime", "time"}, columns) + robot_lines(model.name, model.model_id);
  }
  std::string line(const torque_command_t& command) override
  {
    std::vector<double> accelerations = command.a;
    if (floats_)
      accelerations.insert(accelerations.end(), std::begin(command.base_a), std::end(command.base_a));
    return csv_line(times(command.utime), answer_cells(command, accelerations));
  }
  std::string line(const rejection_t& rejection) override
  {
    return csv_line(times(rejection.utime), rejected_cells(size_, reason_name(rejection.reason)));
  }
  std::string line(const status_t& status) override { return "# " + sentence(status); }

private:
  static std::vector<std::string> times(std::int64_t utime) { return {fmt::format("{}", utime), seconds_cell(utime)}; }
  std::size_t size_ = 0; // columns of an answer
  bool floats_ = false;
};

// one object per line, with the messages' field names
class JsonLines : public Format
{
public:
  std::string header(const model_info_t& model) override
  {
    joint_names_ = model.joint_names;
    return "";
  }
  std::string line(const torque_command_t& command) override
  {
    Json line{{"type", "torque_command"},        {"utime", command.utime},       {"stream_id", command.stream_id},
              {"sequence", command.sequence},    {"model_id", command.model_id}, {"settings_id", command.settings_id},
              {"compute_ns", command.compute_ns}};
    for_each_field(Field{line, joint_names_}, command);
    return text(line);
  }
  std::string line(const rejection_t& rejection) override
  {
    return text({{"type", "rejection"},
                 {"utime", rejection.utime},
                 {"stream_id", rejection.stream_id},
                 {"reason", reason_name(rejection.reason)},
                 {"detail", rejection.detail}});
  }
  std::string line(const status_t& status) override
  {
    Json object{{"type", "status"}};
    object.update(status_json(status));
    return text(object);
  }

private:
  static std::string text(const Json& object)
  {
    return object.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
  }
  // one field of an answer; torques by joint, in whatever way people read the others
  struct Field
  {
    Json& line;
    const std::vector<std::string>& joint_names;

    void operator()(const std::string& name, double number) { line[name] = number; }
    void operator()(const std::string& name, const std::vector<double>& numbers)
    {
      if (name != "torque")
      {
        line[name] = numbers;
        return;
      }
      line[name] = Json::object();
      for (std::size_t joint = 0; joint < joint_names.size(); ++joint)
        line[name][joint_names[joint]] = numbers[joint];
    }
    void operator()(const std::string& name, const double (&numbers)[2]) { line[name] = numbers; }
    void operator()(const std::string& name, const ground_reaction_t& foot)
    {
      for_each_number([&](const char* part, double number) { line[name][part] = number; }, foot);
    }
    void operator()(const std::string& name, std::int32_t flags) { line[name] = flag_names(flags); }
    void operator()(const std::string& name, std::int8_t method) { line[name] = method_name(method); }
  };

  std::vector<std::string> joint_names_;
};

// Writes each message as it comes, under the header of the robot it belongs to.
class Echo
{
public:
  Echo(const Bus& bus, Format& format) : bus_(bus), format_(format) { write_header(); }

  void hear_command(Bytes bytes)
  {
    torque_command_t command;
    if (!decode(bytes, command))
      return;
    if (command.model_id != model_id_ && command.model_id == bus_.model().model_id)
      write_header();
    if (command.model_id != model_id_ || command.torque.size() != num_joints_ || command.a.size() != num_coordinates_)
      return note_strangers();
    write(format_.line(command));
    ++count_;
  }
  void hear_rejection(Bytes bytes)
  {
    rejection_t rejection;
    if (!decode(bytes, rejection))
      return;
    write(format_.line(rejection));
    ++count_;
  }
  void hear_status(Bytes bytes)
  {
    status_t status;
    if (decode(bytes, status))
      write(format_.line(status));
  }
  // commands and rejections written
  std::int64_t count() const { return count_; }

private:
  void write(const std::string& text)
  {
    out_.write(text);
    out_.flush();
  }
  void write_header()
  {
    model_id_ = bus_.model().model_id;
    num_joints_ = bus_.model().joint_names.size();
    num_coordinates_ = bus_.model().absolute_names.size();
    write(format_.header(bus_.model()));
  }
  void note_strangers()
  {
    if (!strangers_noted_)
      note("commands for another robot than the one announced are not shown; is more than one daemon on this bus?");
    strangers_noted_ = true;
  }

  const Bus& bus_;
  Format& format_;
  OutputFile out_{"-"};
  std::int64_t model_id_ = 0, count_ = 0;
  std::size_t num_joints_ = 0, num_coordinates_ = 0;
  bool strangers_noted_ = false;
};

std::unique_ptr<Format> make_format(const std::string& name)
{
  if (name == "csv")
    return std::make_unique<Csv>();
  if (name == "json")
    return std::make_unique<JsonLines>();
  return std::make_unique<Table>();
}

ExitCode echo_bus(const EchoOptions& options)
{
  const Channels channels = channels_with(options.prefix);
  Bus bus(options.lcm_url);
  if (!bus.wait_for_model(channels))
    return ExitCode::done;
  const std::unique_ptr<Format> format = make_format(options.format);
  Echo echo(bus, *format);
  bus.subscribe(channels.command, [&echo](Bytes message) { echo.hear_command(message); });
  bus.subscribe(channels.rejected, [&echo](Bytes message) { echo.hear_rejection(message); });
  if (options.status)
    bus.subscribe(channels.status, [&echo](Bytes message) { echo.hear_status(message); });

  const std::int64_t enough = options.count > 0 ? options.count : std::numeric_limits<std::int64_t>::max();
  while (!bus.stopped() && echo.count() < enough)
    bus.wait(Bus::Clock::now() + std::chrono::hours(1));
  return ExitCode::done;
}

} // namespace

Subcommand add_echo(CLI::App& torquectl)
{
  const auto options = std::make_shared<EchoOptions>();
  CLI::App* app = torquectl.add_subcommand("echo", "print what the daemon publishes, until Ctrl-C");
  app->add_option("--format", options->format, "table, csv (all columns) or json (one object per line); default: table")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"table", "csv", "json"}));
  app->add_option("--count", options->count, "end after this many commands and rejections")
      ->type_name("N")
      ->check(check_positive);
  app->add_flag("--status", options->status, "print status messages, too");
  add_bus_option(*app, options->lcm_url);
  add_prefix_option(*app, options->prefix);
  app->footer("Example, while torqued runs on this bus and a client sends:\n"
              "  LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0' torquectl echo --count 10");
  return {app, options, echo_bus};
}

} // namespace torqued
