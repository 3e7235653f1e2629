#include "catch.h"
#include "logger.h"
#include "process.h"
#include "temporary_folder.h"

#include "motion/files.h"
#include "motion/lcm_log.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"
#include "study/measured.h"
#include "wire/codec.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace walk_process_test
{

using namespace torqued;

namespace
{

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";

int torquectl(std::vector<std::string> arguments, const std::string& output)
{
  arguments.insert(arguments.begin(), TORQUECTL);
  Process process(arguments, output);
  return process.wait().value_or(-1000);
}

std::vector<torque_command_t> commands(const std::string& log)
{
  std::vector<torque_command_t> result;
  const std::string bytes = read_file(log);
  LogReader reader(bytes);
  while (const auto record = reader.next())
    if (record->channel == Channels().command)
      REQUIRE(decode(record->data, result.emplace_back()));
  return result;
}

// the fields that the line computes, without those that the loop fills in
std::vector<std::byte> computed(torque_command_t command)
{
  command.sequence = 0;
  command.compute_ns = 0;
  command.flags &= ~torque_command_t::LATE;
  std::vector<std::byte> bytes;
  encode(command, bytes);
  return bytes;
}

// Sends the walk through a daemon of its own; returns what lcm-logger has written of the answers.
std::vector<torque_command_t> recorded_walk(const TemporaryFolder& folder, const std::string& log)
{
  Process torqued({TORQUED, "--robot", "human-subject01", "--method", "human-transition", "--every-sample"},
                  folder.file("torqued"));
  Logger logger(log, folder.file("logger"));
  const int sent = torquectl({"send", kWalk, "--speed", "2"}, folder.file("send"));
  CAPTURE(read_file(folder.file("send")));
  CHECK(sent == 0);
  CHECK(read_file(folder.file("send")).find("447 of 447 samples answered, 0 lost, 0 rejected") != std::string::npos);
  // the logger writes what it holds when it hears more: the daemon's status
  for (int i = 0; i < 250 && commands(log).size() < 447; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  torqued.signal(SIGTERM);
  CHECK(torqued.wait() == 0);
  logger.end();
  return commands(log);
}

} // namespace

TEST_CASE("a walk through the daemon is answered sample for sample, and evaluated offline it gives the same bits",
          "[walk_process]")
{
  const TemporaryFolder folder;
  const std::string log = folder.file("walk.lcm");
  std::vector<torque_command_t> live = recorded_walk(folder, log);
  // on a busy machine lcm-logger may lose what others hear: torquectl send has heard all answers each time
  for (int again = 0; again < 2 && live.size() < 447; ++again)
    live = recorded_walk(folder, log);
  REQUIRE(live.size() == 447);
  for (std::size_t i = 0; i < live.size(); ++i)
    REQUIRE(live[i].sequence == static_cast<std::int64_t>(i) + 1);

  const std::string again = folder.file("again.lcm");
  const int evaluated = torquectl(
      {"eval", log, "--robot", "human-subject01", "--method", "human-transition", "-o", again}, folder.file("eval"));
  CAPTURE(read_file(folder.file("eval")));
  REQUIRE(evaluated == 0);
  const std::vector<torque_command_t> offline = commands(again);
  REQUIRE(offline.size() == live.size());
  for (std::size_t i = 0; i < live.size(); ++i)
  {
    CAPTURE(i);
    CHECK(computed(live[i]) == computed(offline[i]));
  }

  // what came from the daemon agrees with the force plates as what torquectl compare computes: its answers are those
  const std::string json = folder.file("compare.json");
  REQUIRE(torquectl({"compare", kWalk, "--robot", "human-subject01", "--json", json}, folder.file("compare")) == 0);
  const auto compared = nlohmann::json::parse(read_file(json));
  const auto human = std::find_if(compared["methods"].begin(), compared["methods"].end(),
                                  [](const auto& method) { return method["method"] == "human-transition"; });
  REQUIRE(human != compared["methods"].end());
  const Robot robot = load_robot("human-subject01");
  const std::string text = read_file(kWalk);
  const Trajectory walk = parse_trajectory(text, kWalk, coordinate_names(robot), false, Channels());
  std::vector<DesiredState> states;
  std::vector<bool> double_support;
  std::vector<std::byte> buffer;
  for (const desired_state_t& state : walk.states)
  {
    states.push_back(std::get<DesiredState>(decode_desired_state(encode(state, buffer), robot)));
    double_support.push_back(state.left_contact != 0 && state.right_contact != 0);
  }
  const std::vector<Channel> channels = read_measured(text, kWalk, robot, states).channels;
  REQUIRE(channels.size() == 4 + 6 + 6);
  for (std::size_t k = 0; k < channels.size(); ++k)
  {
    const Channel& channel = channels[k];
    CAPTURE(channel.name, channel.published);
    std::vector<double> values;
    for (const torque_command_t& command : live)
    {
      const ground_reaction_t& foot = channel.side == Side::left ? command.left : command.right;
      values.push_back(channel.component == 0   ? foot.fx
                       : channel.component == 1 ? foot.fz
                                                : command.torque[static_cast<std::size_t>(channel.joint)]);
    }
    const auto& told = (*human)["measured"][k];
    CHECK(told["channel"] == channel.name);
    CHECK(agreement(channel, values, double_support).rms == told["double_support"]["rms"]);
  }

  // the exported table has a row for each sample of the walk
  const std::string csv = folder.file("walk.csv");
  REQUIRE(torquectl({"export", log, "-o", csv}, folder.file("export")) == 0);
  const std::string table = read_file(csv);
  CHECK(std::count(table.begin(), table.end(), '\n') >= 448);
}

} // namespace walk_process_test
