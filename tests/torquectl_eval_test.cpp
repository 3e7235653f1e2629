#include "catch.h"
#include "methods/method_settings.h"

#include "daemon/lcm_loop.h"
#include "daemon/lcm_receiver.h"
#include "motion/files.h"
#include "motion/lcm_log.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"
#include "robot/files/robot_files.h"
#include "run_torquectl.h"
#include "study/answer_table.h"

#include <algorithm>
#include <array>
#include <cfenv>
#include <cstdio>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <spdlog/logger.h>
#include <sstream>
#include <stdio_ext.h>
#include <unistd.h>

namespace torquectl_eval_test
{

using namespace torqued;

namespace
{

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";

// the answer in the last cells of a row
std::vector<std::string> answer_in(const std::vector<std::string>& row, const std::vector<std::string>& like)
{
  return {row.end() - static_cast<std::ptrdiff_t>(like.size()), row.end()};
}

// of a floating robot's answer, in the coordinates that were sent
std::vector<std::string> cells_of(const torque_command_t& command)
{
  std::vector<double> accelerations = command.a;
  accelerations.insert(accelerations.end(), {command.base_a[0], command.base_a[1]});
  return answer_cells(command, accelerations);
}

// the column of that name, its rows in order
std::vector<std::string> column(const std::vector<std::vector<std::string>>& table, const std::string& name)
{
  const auto at = std::find(table[0].begin(), table[0].end(), name) - table[0].begin();
  std::vector<std::string> cells;
  for (std::size_t i = 1; i < table.size(); ++i)
    cells.push_back(table[i].at(static_cast<std::size_t>(at)));
  return cells;
}

std::string bytes_of(const desired_state_t& state)
{
  std::vector<std::byte> buffer;
  const Bytes bytes = encode(state, buffer);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// a CSV without the comment lines that name its robot
std::string without_robot(std::string text)
{
  for (const char* line : {"\n# robot:", "\n# model_id:"})
    if (const std::size_t at = text.find(line); at != std::string::npos)
      text.erase(at, text.find('\n', at + 1) - at);
  return text;
}

Trajectory read_walk(const Robot& robot)
{
  return parse_trajectory(read_file(kWalk), kWalk, coordinate_names(robot), false, Channels());
}

// The daemon's own loop, on a bus inside this process, that answers every sample.
class Daemon
{
public:
  explicit Daemon(const Robot& robot) : loop_(bus_, receiver_, robot, every_sample(), log_, {})
  {
    bus_.subscribeFunction("TORQUED_COMMAND", &Daemon::hear, this);
    loop_.listen();
  }
  std::map<std::int64_t, torque_command_t> answers; // by utime

  void send(const desired_state_t& state)
  {
    const std::string bytes = bytes_of(state);
    bus_.publish("TORQUED_DESIRED", bytes.data(), static_cast<unsigned int>(bytes.size()));
    loop_.cycle(0.0);
    while (bus_.handleTimeout(0) > 0)
    {
    }
  }

private:
  static Config every_sample()
  {
    Config config;
    config.every_sample = true;
    config.deadline = 10.0; // LATE depends on the machine
    return config;
  }
  static void hear(const lcm::ReceiveBuffer* buffer, const std::string&, Daemon* daemon)
  {
    torque_command_t command;
    if (decode({static_cast<const std::byte*>(buffer->data), buffer->data_size}, command))
      daemon->answers[command.utime] = command;
  }

  lcm::LCM bus_{"memq://"};
  LcmReceiver receiver_{bus_};
  spdlog::logger log_{"test"};
  LcmLoop loop_;
};

} // namespace

TEST_CASE("eval answers the measured walk, one row for each of its rows", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const Robot robot = load_robot("human-subject01");
  const std::string out = folder.file("answers.csv");
  const Run eval = run({"eval", kWalk, "--robot", "human-subject01", "-o", out});
  CHECK(eval.code == 0);
  CHECK(eval.err == "");
  CHECK(eval.out ==
        "human-subject01: 447 of 447 samples answered, 0 rejected\nflags: CONTACT_ACCELERATION 447, INCONSISTENT 447, "
        "RELAXED 2, TIPS 17\n");

  const auto table = rows(out);
  const Trajectory walk = read_walk(robot);
  REQUIRE(table.size() == 1 + walk.states.size());
  CHECK(fmt::format("{}", fmt::join(table[0], ",")) ==
        "utime,time,q0,q1,q2,q3,q4,q5,q6,xH,zH,dq0,dq1,dq2,dq3,dq4,dq5,dq6,dxH,dzH,ddq0,ddq1,ddq2,ddq3,ddq4,ddq5,ddq6,"
        "ddxH,ddzH,contactL,contactR,leading,load_transfer,phase,tau_left_ankle,tau_left_knee,tau_left_hip,"
        "tau_right_hip,tau_right_knee,tau_right_ankle,fxL,fzL,momentL,sole_copL,fxR,fzR,momentR,sole_copR,zmp,flags,"
        "flag_names,dynamics_residual,contact_speed,contact_residual,a_q0,a_q1,a_q2,a_q3,a_q4,a_q5,a_q6,a_xH,a_zH,"
        "adjustment,method,rejected");
  for (std::size_t i = 0; i < walk.states.size(); ++i)
    REQUIRE(table[1 + i][0] == fmt::format("{}", walk.states[i].utime));
  for (const std::string name : {"q0", "q3", "xH", "zH"})
    CHECK(column(table, "a_" + name) == column(table, "dd" + name));
  const std::vector<std::string> adjustment = column(table, "adjustment");
  CHECK(std::count(adjustment.begin(), adjustment.end(), "0") == 447);
  const std::vector<std::string> flags = column(table, "flags"), names = column(table, "flag_names");
  const std::map<std::string, std::string> known{{"2112", "INCONSISTENT|CONTACT_ACCELERATION"},
                                                 {"2116", "TIPS|INCONSISTENT|CONTACT_ACCELERATION"},
                                                 {"2144", "RELAXED|INCONSISTENT|CONTACT_ACCELERATION"}};
  for (std::size_t i = 0; i < flags.size(); ++i)
    REQUIRE(names[i] == known.at(flags[i]));

  // the table is the same motion again
  const Trajectory again = parse_trajectory(read_file(out), out, coordinate_names(robot), false, Channels());
  CHECK(again.seconds == walk.seconds);
  REQUIRE(again.states.size() == walk.states.size());
  for (std::size_t i = 0; i < walk.states.size(); ++i)
  {
    desired_state_t expected = walk.states[i];
    expected.method = again.states[i].method; // that which answered
    REQUIRE(bytes_of(again.states[i]) == bytes_of(expected));
  }
  const std::string second = folder.file("again.csv");
  REQUIRE(run({"eval", out, "--robot", "human-subject01", "-o", second}).code == 0);
  CHECK(rows(second) == table);
}

TEST_CASE("a table's times are those that were read, beside µs", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const std::string out = folder.file("out.csv");
  const auto evaluated = [&](const std::string& first, const std::string& times)
  {
    std::string text = first;
    for (const std::string order : {"", "d", "dd"})
      for (int i = 0; i < 7; ++i)
        text += fmt::format(",{}q{}", order, i);
    text += fmt::format(",contactL,contactR\n{},0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,2,0\n", times);
    REQUIRE(run({"eval", folder.write("in.csv", text), "--robot", "ck", "-o", out}).code == 0);
    const auto row = rows(out).at(1);
    return row[0] + "," + row[1];
  };
  CHECK(evaluated("time", "0.0333333333") == "33333,0.0333333333");
  CHECK(evaluated("utime", "33333") == "33333,0.033333");
  CHECK(evaluated("utime,time", "1700000000033333,0.25") == "1700000000033333,0.25");
}

TEST_CASE("accelerations are in the coordinates of the table", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const std::string log_file = folder.file("log.lcm"), out = folder.file("out.csv");
  const Robot robot = load_robot("human-subject01");
  const Trajectory walk = read_walk(robot);
  const bool mixed = GENERATE(false, true);
  std::vector<std::byte> buffer;
  LogWriter log(log_file);
  for (std::size_t i = 0; i < 5; ++i)
  {
    desired_state_t state = walk.states[i];
    if (i < 4 || !mixed)
    {
      state.coordinates = desired_state_t::RELATIVE;
      for (std::vector<double>* numbers : {&state.q, &state.v, &state.a})
      {
        Eigen::Map<Eigen::VectorXd> angles(numbers->data(), 7);
        angles = (robot.A * angles).eval();
      }
    }
    log.write("TORQUED_DESIRED", 0, encode(state, buffer));
  }
  log.close();
  REQUIRE(run({"eval", log_file, "--robot", "human-subject01", "-o", out}).code == 0);
  const auto table = rows(out);
  for (const std::string& name : mixed ? robot.absolute_names : robot.relative_names)
    CHECK(column(table, "a_" + name) == column(table, "dd" + name));
  CHECK(column(table, "a_xH") == column(table, "ddxH"));
}

TEST_CASE("a sample of another robot has a row without a motion", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const std::string log_file = folder.file("log.lcm"), out = folder.file("out.csv");
  desired_state_t state{};
  state.utime = 5;
  state.num_coordinates = 2;
  state.q = state.v = state.a = {1.0, 2.0};
  std::vector<std::byte> buffer;
  LogWriter log(log_file);
  log.write("TORQUED_DESIRED", 0, encode(state, buffer));
  log.close();
  REQUIRE(run({"eval", log_file, "--robot", "ck", "-o", out}).code == 65); // nothing was answered
  const auto table = rows(out);
  REQUIRE(table[1].size() == table[0].size());
  CHECK(column(table, "utime") == std::vector<std::string>{"5"});
  CHECK(column(table, "q0") == std::vector<std::string>{""});
  CHECK(column(table, "rejected") == std::vector<std::string>{"WRONG_SIZE"});
}

TEST_CASE("eval gives the bits that the daemon's loop publishes, as CSV and as messages", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const Robot robot = load_robot("human-subject01");
  const std::string csv = folder.file("answers.csv"), lcm = folder.file("answers.lcm");
  REQUIRE(run({"eval", kWalk, "--robot", "human-subject01", "-o", csv}).code == 0);
  REQUIRE(run({"eval", kWalk, "--robot", "human-subject01", "-o", lcm}).code == 0);

  Daemon daemon(robot);
  for (const desired_state_t& state : read_walk(robot).states)
    daemon.send(state);
  REQUIRE(daemon.answers.size() == 447);

  const auto table = rows(csv);
  const std::string bytes = read_file(lcm);
  LogReader log(bytes);
  std::int64_t sequence = 0;
  while (const auto record = log.next())
  {
    torque_command_t command;
    if (record->channel != "TORQUED_COMMAND")
      continue;
    REQUIRE(decode(record->data, command));
    CHECK(record->timestamp == command.utime);
    CHECK(command.sequence == ++sequence);
    CHECK(command.compute_ns == 0);
    CHECK(command.stream_id == 1);
    const std::vector<std::string>& row = table[static_cast<std::size_t>(sequence)];
    CHECK(row[0] == fmt::format("{}", command.utime));
    REQUIRE(answer_in(row, cells_of(command)) == cells_of(command));

    // what only the loop knows: time
    torque_command_t published = daemon.answers.at(command.utime);
    published.flags &= ~torque_command_t::LATE;
    CHECK(published.model_id == command.model_id);
    CHECK(published.settings_id == command.settings_id);
    REQUIRE(cells_of(published) == cells_of(command));
  }
  CHECK(log.skipped() == 0);
  CHECK(sequence == 447);

  // the log is whole: exported, it is the table again
  const std::string exported = folder.file("exported.csv");
  REQUIRE(run({"export", lcm, "-o", exported}).code == 0);
  CHECK(rows(exported) == table);
}

TEST_CASE("eval computes without denormal numbers, as the daemon does", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  std::string text = "time,contactL,contactR";
  for (const std::string order : {"", "d", "dd"})
    for (int i = 0; i < 7; ++i)
      text += fmt::format(",{}q{}", order, i);
  text += "\n0,2,0,0,0,0,0,0,0,0,1e-310,0,0,0,0,0,0,0,0,0,0,0,0,0\n";
  const std::string out = folder.file("out.csv");
  // earlier cases have left this thread without them
  std::fesetenv(FE_DFL_ENV);
  REQUIRE(run({"eval", folder.write("in.csv", text), "--robot", "ck", "-o", out}).code == 0);
  const auto table = rows(out);
  const auto contact_speed = std::find(table[0].begin(), table[0].end(), "contact_speed") - table[0].begin();
  CHECK(table[1][static_cast<std::size_t>(contact_speed)] == "0");
}

TEST_CASE("eval says which samples were rejected and why, and answers the others", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  std::string text = "time,contactL,contactR,load_transfer,method";
  for (const std::string order : {"", "d", "dd"})
    for (int i = 0; i < 7; ++i)
      text += fmt::format(",{}q{}", order, i);
  for (const char* row :
       {"0,sole,sole,0.5,default", "1,sole,sole,2,default", "2,none,none,0,default", "3,sole,sole,1,77"})
    text += fmt::format("\n{}{}", row, ",0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0");
  const std::string in = folder.write("in.csv", text);
  const std::string csv = folder.file("out.csv"), lcm = folder.file("out.lcm");

  const Run eval = run({"eval", in, "--robot", "ck", "-o", csv});
  CHECK(eval.code == 0);
  CHECK(eval.out ==
        fmt::format("ck: 1 of 4 samples answered, 3 rejected: OUT_OF_RANGE 1, UNKNOWN_METHOD 1, "
                    "NOT_SUPPORTED 1\n"
                    "  OUT_OF_RANGE, first: {0}:3: load_transfer is 2; expected 0 to 1\n"
                    "  UNKNOWN_METHOD, first: {0}:5: method is 77; expected {1}\n"
                    "  NOT_SUPPORTED, first: {0}:4: base is FROM_CONTACT (0), but neither foot has contact: in "
                    "flight the base must be GIVEN (1)\n",
                    in, kMethodNumbers));
  const auto table = rows(csv);
  REQUIRE(table.size() == 5);
  CHECK(table[1].back() == "");
  const std::size_t size = cells_of({}).size() + 6 + 7;
  for (const auto& [row, reason] : {std::pair(2, "OUT_OF_RANGE"), {3, "NOT_SUPPORTED"}, {4, "UNKNOWN_METHOD"}})
  {
    const auto& found = table[static_cast<std::size_t>(row)];
    const std::vector<std::string> expected = rejected_cells(size, reason);
    CHECK(answer_in(found, expected) == expected);
    CHECK(found[0] == fmt::format("{}000000", row - 1));
    CHECK(found.size() == table[0].size());
  }
  CHECK(column(table, "load_transfer") == std::vector<std::string>{"0.5", "2", "0", "1"});

  REQUIRE(run({"eval", in, "--robot", "ck", "-o", lcm, "--prefix", "left/"}).code == 0);
  const std::string bytes = read_file(lcm);
  LogReader log(bytes);
  std::vector<std::string> channels, reasons;
  while (const auto record = log.next())
  {
    channels.emplace_back(record->channel);
    if (rejection_t rejection; decode(record->data, rejection))
    {
      CHECK(rejection.stream_id == 1);
      CHECK(rejection.utime == record->timestamp);
      reasons.push_back(fmt::format("{} {}", rejection.reason, rejection.detail));
    }
  }
  CHECK(channels == std::vector<std::string>{"left/TORQUED_MODEL", "left/TORQUED_DESIRED", "left/TORQUED_COMMAND",
                                             "left/TORQUED_DESIRED", "left/TORQUED_REJECTED", "left/TORQUED_DESIRED",
                                             "left/TORQUED_REJECTED", "left/TORQUED_DESIRED", "left/TORQUED_REJECTED"});
  REQUIRE(reasons.size() == 3);
  CHECK(reasons[0] == "5 load_transfer is 2; expected 0 to 1");
}

TEST_CASE("eval takes the daemon's configuration, and flags win over it", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const std::string config = folder.write("c.toml", "robot = \"human-subject01\"\nconsistency = \"refuse\"\n");
  const std::string out = folder.file("out.csv");
  const std::string nameless = folder.write("walk.csv", without_robot(read_file(kWalk)));
  CHECK(run({"eval", nameless, "--config", config, "-o", out})
            .out.starts_with("human-subject01: 0 of 447 samples answered, 447 rejected: INCONSISTENT 447\n"));
  CHECK(run({"eval", nameless, "--config", config, "--robot", "ck", "-o", out}).out.starts_with("ck: "));
}

TEST_CASE("an exported log reads back as the same desired states, beside their answers", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const std::string log_file = folder.file("log.lcm"), csv = folder.file("log.csv"), again = folder.file("again.csv");
  const Robot robot = load_robot("human-subject01");
  Trajectory walk = read_walk(robot);
  Daemon daemon(robot);
  std::vector<std::byte> buffer;
  LogWriter log(log_file);
  log.write("TORQUED_MODEL", 0, encode(model_info(robot, 1, 1, ""), buffer));
  for (std::size_t i = 0; i < walk.states.size(); ++i)
  {
    desired_state_t& state = walk.states[i];
    // ask in double support for the method that will answer: the CSV keeps the one that did
    if (state.left_contact && state.right_contact)
      state.method = desired_state_t::LINEAR_TRANSITION;
    state.q[3] *= 1.0 + 1e-16 * static_cast<double>(i);
    daemon.send(state);
    log.write("TORQUED_DESIRED", state.utime, encode(state, buffer));
    if (i == 5)
      continue;
    if (i == 7)
    {
      rejection_t rejection{state.utime, state.stream_id, rejection_t::STALE, "late"};
      log.write("TORQUED_REJECTED", state.utime, encode(rejection, buffer));
      continue;
    }
    log.write("TORQUED_COMMAND", state.utime, encode(daemon.answers.at(state.utime), buffer));
  }
  log.close();

  const Run exported = run({"export", log_file, "-o", csv});
  CHECK(exported.code == 0);
  CHECK(exported.err == "");
  CHECK(
      exported.out ==
      fmt::format(
          "human-subject01: 445 of 447 samples answered, 1 without an answer, 1 rejected: "
          "STALE 1\nflags: CONTACT_ACCELERATION 445, INCONSISTENT 445, TIPS 20\n  STALE, first: {}: record 14: late\n",
          log_file));

  // the desired states
  const Trajectory read = parse_trajectory(read_file(csv), csv, coordinate_names(robot), false, Channels());
  REQUIRE(read.states.size() == walk.states.size());
  for (std::size_t i = 0; i < read.states.size(); ++i)
  {
    desired_state_t expected = walk.states[i];
    if (i == 5 || i == 7)
      expected.method = desired_state_t::DEFAULT;
    REQUIRE(bytes_of(read.states[i]) == bytes_of(expected));
  }

  // their answers
  const auto table = rows(csv);
  const std::size_t answer_size = cells_of(daemon.answers.begin()->second).size();
  for (std::size_t i = 0; i < walk.states.size(); ++i)
  {
    const std::vector<std::string> found(table[1 + i].end() - static_cast<std::ptrdiff_t>(answer_size),
                                         table[1 + i].end());
    REQUIRE(found == (i == 5   ? rejected_cells(answer_size, "NO_ANSWER")
                      : i == 7 ? rejected_cells(answer_size, "STALE")
                               : cells_of(daemon.answers.at(walk.states[i].utime))));
  }

  // evaluated again, they are the same answers
  REQUIRE(run({"eval", csv, "--robot", "human-subject01", "-o", again}).code == 0);
  const auto answered_again = rows(again);
  for (std::size_t i = 8; i < walk.states.size(); ++i)
  {
    torque_command_t expected = daemon.answers.at(walk.states[i].utime);
    expected.flags &= ~torque_command_t::LATE;
    REQUIRE(answer_in(answered_again[1 + i], cells_of(expected)) == cells_of(expected));
  }
}

TEST_CASE("export joins answers to desired states by stream and time, in the order of the log", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const std::string log_file = folder.file("log.lcm"), csv = folder.file("log.csv");
  const Robot robot = load_robot("ck");
  desired_state_t state{};
  state.num_coordinates = 7;
  state.q.resize(7);
  state.v = state.a = state.q;
  torque_command_t command{};
  command.num_coordinates = 7;
  command.a.resize(7);
  command.model_id = robot.model_id;
  command.num_joints = 6;
  command.torque.resize(6);
  std::vector<std::byte> buffer;
  LogWriter log(log_file);
  const auto write_state = [&](std::int64_t stream_id, std::int64_t utime)
  {
    state.stream_id = stream_id;
    state.utime = utime;
    log.write("TORQUED_DESIRED", 0, encode(state, buffer));
  };
  const auto write_answer = [&](std::int64_t stream_id, std::int64_t utime, std::int32_t flags)
  {
    command.stream_id = stream_id;
    command.utime = utime;
    command.flags = flags;
    log.write("TORQUED_COMMAND", 0, encode(command, buffer));
  };
  write_answer(2, 10, 1); // heard before its desired state
  write_state(1, 10);
  write_state(2, 10);
  write_state(1, 10); // a repeat, which is rejected
  write_state(1, 5);
  write_answer(1, 5, 2);
  write_answer(1, 10, 4);
  rejection_t rejection{10, 1, rejection_t::OUT_OF_ORDER, ""};
  log.write("TORQUED_REJECTED", 0, encode(rejection, buffer));

  SECTION("with a model in the log")
  {
    log.write("TORQUED_MODEL", 0, encode(model_info(robot, 1, 1, ""), buffer));
    log.close();
    REQUIRE(run({"export", log_file, "-o", csv}).code == 0);
    std::string found;
    const auto table = rows(csv);
    const auto flags =
        static_cast<std::size_t>(std::find(table[0].begin(), table[0].end(), "flags") - table[0].begin());
    for (std::size_t i = 1; i < table.size(); ++i)
      found += fmt::format("{}:{}{} ", table[i][0], table[i][flags], table[i].back());
    CHECK(found == "10:4 10:1 10:OUT_OF_ORDER 5:2 ");
  }
  SECTION("without a model in the log the names come from --robot")
  {
    log.close();
    const Run nameless = run({"export", log_file, "-o", csv});
    CHECK(nameless.code == 65);
    CHECK(nameless.err ==
          fmt::format("torquectl: {} holds no model_info_t, which would name its robot: say --robot NAME|FILE (robots "
                      "that ship: ck, rk, six-link, compass, bip-itlag, human-subject01, rabbit)\n",
                      log_file));
    CHECK(run({"export", log_file, "-o", csv, "--robot", "ck"}).code == 0);
    const Run out = run({"export", log_file, "-o", "-", "--robot", "ck"});
    CHECK(out.out == read_file(csv));
  }
}

TEST_CASE("relative coordinates are exported as they are, and as absolute ones among those", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const std::string log_file = folder.file("log.lcm"), csv = folder.file("log.csv");
  const Robot robot = load_robot("human-subject01");
  const std::vector<desired_state_t> walk = read_walk(robot).states;
  const bool mixed = GENERATE(false, true);
  model_info_t model = model_info(robot, 1, 1, "");
  Eigen::Map<Eigen::VectorXd> b(model.b.data(), 7);
  b << 0.1, 0.2, 0.3, -0.4, -0.5, 0.6, 0.7;
  std::vector<std::byte> buffer;
  LogWriter log(log_file);
  log.write("TORQUED_MODEL", 0, encode(model, buffer));
  for (std::size_t i = 0; i < 3; ++i)
  {
    desired_state_t state = walk[i];
    if (i < 2 || !mixed)
    {
      state.coordinates = desired_state_t::RELATIVE;
      for (std::vector<double>* numbers : {&state.q, &state.v, &state.a})
      {
        Eigen::Map<Eigen::VectorXd> angles(numbers->data(), 7);
        angles = (robot.A * angles).eval();
      }
      Eigen::Map<Eigen::VectorXd>(state.q.data(), 7) += b;
    }
    log.write("TORQUED_DESIRED", 0, encode(state, buffer));
  }
  log.close();
  REQUIRE(run({"export", log_file, "-o", csv}).code == 0);
  const Trajectory read = parse_trajectory(read_file(csv), csv, coordinate_names(robot), false, Channels());
  for (std::size_t i = 0; i < 3; ++i)
  {
    CHECK(read.states[i].coordinates == (mixed ? desired_state_t::ABSOLUTE : desired_state_t::RELATIVE));
    Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(read.states[i].q.data(), 7);
    if (!mixed)
      q = robot.A_inverse * (q - b);
    // sums of a few angles of size 1
    for (int j = 0; j < 7; ++j)
      CHECK_THAT(q(j), Catch::Matchers::WithinAbs(walk[i].q[static_cast<std::size_t>(j)], 1e-15));
  }
}

TEST_CASE("what cannot be done ends with its exit code and one line", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const std::string out = folder.file("out.csv"), bad_config = folder.write("c.toml", "colour = 1\n");
  const std::string bad_walk = folder.write("w.csv", "time\n0\n");
  struct Row
  {
    std::vector<std::string> words;
    int code;
    std::string err;
  };
  const std::vector<Row> table{
      {{}, 64, "a subcommand is required; torquectl --help lists what there is"},
      {{"evaluate"}, 64, "\"evaluate\" is not known here; torquectl --help lists what there is"},
      {{"eval"}, 64, "FILE is required; torquectl eval --help says what is right"},
      {{"eval", kWalk, "-o", "x.txt"}, 64, "-o: found \"x.txt\"; expected a name that ends in .csv or .lcm, or -"},
      {{"eval", kWalk, "-o", kWalk}, 64, fmt::format("{0} would be written over {0}, which is read", kWalk)},
      {{"eval", kWalk, "-o", out, "--method", "x"},
       64,
       "--method: found \"x\"; expected one of: pseudo-inverse, linear-transition, internal-wrench, torso-wrench, "
       "tracked-reaction, tracked-internal, constrained, zmp-transition, human-transition"},
      {{"eval", kWalk, "-o", out, "--prefix", "a.*"},
       64,
       "--prefix: found \"a.*\"; expected at most 32 letters, digits, _, - or /"},
      {{"wrenches", kWalk, "-o", "x.txt"}, 64, "-o: found \"x.txt\"; expected a name that ends in .csv, or -"},
      {{"dynamics", kWalk, "-o", out},
       64,
       "-o: found \"" + out + "\"; expected a name that ends in .json or .jsonl, or -"},
      {{"model", "--robot", "ck", "--toml-for", "ck.toml"},
       64,
       "--toml-for: expected a name that ends in .urdf; torquectl model --help says what is right"},
      {{"model", "--robot", "bip-itlag", "--toml-for", "b.urdf"},
       78,
       "link 'pelvis' is parallel to the world; a URDF cannot say that, and this robot has none"},
      {{"dynamics", kWalk, "-o", out, "--coordinates", "rel"},
       64,
       "--coordinates: rel not in {absolute,relative}; torquectl dynamics --help says what is right"},
      {{"send", kWalk, "--rate", "0"},
       64,
       "--rate: found \"0\"; expected a positive number; torquectl send --help says what is right"},
      {{"eval", folder.file("none"), "-o", out},
       65,
       folder.file("none") + ": cannot be read: No such file or directory"},
      {{"eval", bad_walk, "--robot", "ck", "-o", out},
       65,
       bad_walk +
           ":1: column contactL: found no column contactL, contactR; expected what carries at each foot: 0 to 3, or "
           "none, heel, sole, toe"},
      {{"export", kWalk, "-o", out}, 65, kWalk + ": is no LCM log; expected what lcm-logger wrote"},
      {{"send", folder.file("none")}, 65, folder.file("none") + ": cannot be read: No such file or directory"},
      {{"eval", kWalk, "-o", out, "--robot", "x"},
       78,
       "\"x\" is neither a robot that ships (ck, rk, six-link, compass, bip-itlag, human-subject01, rabbit) nor a "
       ".toml or .urdf file"},
      {{"model", "--robot", folder.file("x.toml")},
       78,
       folder.file("x.toml") + ": cannot be read: No such file or directory"},
      {{"eval", kWalk, "-o", folder.file("no/out.csv"), "--robot", "human-subject01"},
       1,
       folder.file("no/out.csv") + ": cannot be written: No such file or directory"},
      {{"eval", kWalk, "-o", folder.file("no/out.lcm"), "--robot", "human-subject01"},
       1,
       folder.file("no/out.lcm") + ": cannot be written: No such file or directory"},
  };
  for (const Row& row : table)
  {
    const Run ended = run(row.words);
    CHECK(ended.code == row.code);
    CHECK(ended.err == "torquectl: " + row.err + "\n");
    CHECK(ended.out == "");
  }
  const Run config = run({"eval", kWalk, "-o", out, "--config", bad_config});
  CHECK(config.code == 78);
  CHECK(config.err.starts_with("torquectl: " + bad_config + ":1: colour: "));
}

TEST_CASE("each subcommand that reads a motion says which file or column is wrong", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const std::string none = folder.file("none.csv");
  std::string text = read_file(kWalk);
  text.replace(text.find(",contactR"), 9, ",contactX");
  const std::string bad_column = folder.write("column.csv", text);
  text = read_file(kWalk);
  const std::size_t last = text.find_last_of('\n', text.size() - 2);
  text.replace(last + 1, text.find(',', last) - last - 1, "soon");
  const std::string bad_cell = folder.write("cell.csv", text);
  for (const auto& [name, extension] : std::vector<std::pair<std::string, std::string>>{{"eval", ".csv"},
                                                                                        {"compare", ""},
                                                                                        {"report", ".html"},
                                                                                        {"project", ".csv"},
                                                                                        {"nearest", ".csv"},
                                                                                        {"dynamics", ".json"},
                                                                                        {"wrenches", ".csv"}})
  {
    const std::string out = folder.file("out" + extension);
    const auto failure = [&, name = name, extension = extension](const std::string& file)
    {
      std::vector<std::string> words{name, file, "--robot", "human-subject01"};
      if (!extension.empty())
        words.insert(words.end(), {"-o", out});
      const Run ended = run(words);
      CHECK(ended.out == "");
      CHECK_FALSE(std::filesystem::exists(out));
      return fmt::format("{} {}", ended.code, ended.err);
    };
    CAPTURE(name);
    CHECK(failure(none) == fmt::format("65 torquectl: {}: cannot be read: No such file or directory\n", none));
    CHECK(failure(bad_column).starts_with(fmt::format("65 torquectl: {}:", bad_column)));
    CHECK(failure(bad_column).find("found no column contactR") != std::string::npos);
    CHECK(failure(bad_cell).find("found \"soon\"; expected") != std::string::npos);
  }
}

TEST_CASE("a full disk is not taken for success", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  for (const std::string name : {"full.csv", "full.lcm"})
  {
    std::filesystem::create_symlink("/dev/full", folder.file(name));
    const Run ended = run({"eval", kWalk, "--robot", "human-subject01", "-o", folder.file(name)});
    CHECK(ended.code == 1);
    CHECK(ended.err == fmt::format("torquectl: {}: cannot be written: No space left on device\n", folder.file(name)));
    CHECK(ended.out == "");
  }

  int code = 0;
  {
    const Capture out(stdout, "/dev/full");
    const Capture err(stderr, folder.file("err"));
    const std::array argv{"torquectl", "model", "--robot", "ck"};
    code = torquectl(static_cast<int>(argv.size()), argv.data());
    __fpurge(stdout);
  }
  std::clearerr(stdout);
  CHECK(code == 1);
  CHECK(read_file(folder.file("err")) == "torquectl: standard output: cannot be written: No space left on device\n");
}

TEST_CASE("every subcommand has help with an example", "[torquectl_eval]")
{
  // torquectl --help lists them, each in a line that begins with its name behind two spaces
  std::istringstream lines(run({"--help"}).out);
  std::string line;
  while (std::getline(lines, line) && line != "Subcommands:")
  {
  }
  int count = 0;
  while (std::getline(lines, line) && !line.empty())
  {
    if (line[2] == ' ') // its description goes on
      continue;
    ++count;
    const std::string name = line.substr(2, line.find(' ', 2) - 2);
    CAPTURE(name);
    const Run help = run({name, "--help"});
    CHECK(help.code == 0);
    CHECK(help.out.find("Example") != std::string::npos);
    CHECK(help.out.find("torquectl " + name + " ") != std::string::npos);
  }
  CHECK(count >= 14);
}

TEST_CASE("a robot's printed file is the robot, and its description names every link, coordinate and actuator",
          "[torquectl_eval]")
{
  const TemporaryFolder folder;
  for (const std::string_view name : shipped_robot_names())
  {
    const Robot robot = load_robot(std::string(name));
    const std::string file = folder.write("r.toml", run({"model", "--robot", std::string(name), "--toml"}).out);
    CHECK(load_robot(file).model_id == robot.model_id);
    CHECK(run({"model", "--robot", file, "--toml"}).out == read_file(file));

    const std::string description = run({"model", "--robot", file}).out;
    for (const Link& link : robot.links)
      CHECK(description.find("\n  " + link.name + " ") != std::string::npos);
    for (const Actuator& actuator : robot.actuators)
      CHECK(description.find("\n  " + actuator.name + " ") != std::string::npos);
    for (const std::string& coordinate : robot.relative_names)
      CHECK(description.find("\n  " + coordinate + " = ") != std::string::npos);
    CHECK(run({"model", "--list"}).out.find(std::string(name) + "\n") != std::string::npos);
  }
  const std::string rk = run({"model", "--robot", "rk"}).out;
  CHECK(rk.find("radii 0.035 m of the parent, 0.05 m of its own\n") != std::string::npos);
  CHECK(rk.find("between bar-parent, kappa 0.5882\n") != std::string::npos);
  CHECK(run({"model", "--robot", "rabbit"}).out.find("rotor inertia 0.83 kg m²\n") != std::string::npos);
  const std::string compass = run({"model", "--robot", "compass"}).out;
  CHECK(compass.find("\n  q1 = theta_s + 1.5708\n  q2 = theta_ns - theta_s - 3.14159\n") != std::string::npos);
  CHECK(compass.find("\nthe root, stance_foot, is fixed to the world\n") != std::string::npos);

  // what slides has newtons
  std::string itlag = run({"model", "--robot", "bip-itlag", "--toml"}).out;
  const std::string slide = "on = \"counterweight\"";
  REQUIRE(itlag.find(slide) != std::string::npos);
  itlag.replace(itlag.find(slide), slide.size(), "torque_limit = 30.0\nviscous = 1.5\nstick_velocity = 0.01\n" + slide);
  const std::string described = run({"model", "--robot", folder.write("i.toml", itlag)}).out;
  CHECK(described.find(" 30 N           none  viscous friction 1.5 N s/m, continuous below 0.01 m/s\n") !=
        std::string::npos);
}

TEST_CASE("a robot is printed as URDF, and what its URDF leaves out as TOML", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  const Robot robot = load_robot("rabbit");
  const Run urdf = run({"model", "--robot", "rabbit", "--urdf"});
  const std::string urdf_file = folder.write("rabbit.urdf", urdf.out);
  const Run toml = run({"model", "--robot", "rabbit", "--toml-for", "rabbit.urdf"});
  const std::string toml_file = folder.write("rabbit.toml", toml.out);
  CHECK(urdf.code == 0);
  CHECK(toml.code == 0);
  CHECK(load_robot(toml_file).model_id == robot.model_id);

  // a file that is not all of the robot is printed complete, as TOML
  for (const std::string& file : {toml_file, urdf_file})
  {
    const Run whole = run({"model", "--robot", file, "--toml"});
    CHECK(whole.out.find("urdf = ") == std::string::npos);
    CHECK(load_robot(folder.write("whole.toml", whole.out)).model_id == load_robot(file).model_id);
  }

  const Run none = run({"model", "--robot", "bip-itlag", "--urdf"});
  CHECK(none.code == 78);
  CHECK(none.out == "");
  CHECK(none.err ==
        "torquectl: link 'pelvis' is parallel to the world; a URDF cannot say that, and this robot has none\n");
  CHECK(run({"model", "--urdf", "--toml"}).code == 64);
}

TEST_CASE("what of a URDF is not read is said wherever the robot is loaded", "[torquectl_eval]")
{
  const TemporaryFolder folder;
  std::string urdf = to_urdf(load_robot("rabbit"));
  urdf.insert(urdf.find("</joint>"), "<dynamics damping=\"2\"/>");
  const std::string robot = folder.write("rabbit.urdf", urdf);
  const std::string motion = folder.write("nothing.csv", "time\n");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"model", "--robot", robot},
                                             {"model", "--robot", robot, "--toml"},
                                             {"eval", motion, "--robot", robot, "-o", folder.file("out.csv")},
                                             {"gait", "--robot", robot, "-o", folder.file("out.csv")}})
  {
    CAPTURE(words.front());
    CHECK(run(words).err.find("torquectl: note: " + robot + ":") == 0);
    CHECK(run(words).err.find("<dynamics damping=2> is not read: set viscous in the TOML\n") != std::string::npos);
  }
}

} // namespace torquectl_eval_test
