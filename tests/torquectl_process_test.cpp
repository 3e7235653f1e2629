#include "catch.h"
#include "process.h"
#include "temporary_folder.h"
#include "view_client.h"

#include "motion/files.h"
#include "robot/files/load.h"
#include "wire/codec.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

namespace torquectl_process_test
{

using namespace torqued;

namespace
{

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";

struct Run
{
  int code;
  std::string output;
};

// What torquectl prints, on both streams, and how it ends.
Run run(std::vector<std::string> arguments)
{
  const TemporaryFolder folder;
  arguments.insert(arguments.begin(), TORQUECTL);
  Process process(arguments, folder.file("output"));
  const int code = process.wait().value_or(-1000);
  return {code, read_file(folder.file("output"))};
}

std::unique_ptr<Process> torqued_for_the_walk(const TemporaryFolder& folder, std::vector<std::string> more = {})
{
  more.insert(more.begin(), {TORQUED, "--robot", "human-subject01"});
  return std::make_unique<Process>(more, folder.file("torqued"));
}

bool contains(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

std::size_t lines(const std::string& text)
{
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

} // namespace

TEST_CASE("send counts what became of every sample, and its exit code says whether all were answered",
          "[torquectl_process]")
{
  const TemporaryFolder folder;
  const auto torqued = torqued_for_the_walk(folder, {"--every-sample"});

  const Run all = run({"send", kWalk, "--rate", "500", "--json"});
  CAPTURE(all.output);
  CHECK(all.code == 0);
  const auto summary = nlohmann::json::parse(all.output.substr(all.output.find('{')));
  CHECK(summary["sent"] == 447);
  CHECK(summary["answered"] == 447);
  CHECK(summary["rejected"] == 0);
  CHECK(summary["lost"] == 0);
  const auto& round_trip = summary["round_trip_us"];
  CHECK(round_trip["p50"].get<std::int64_t>() > 0);
  CHECK(round_trip["p50"] <= round_trip["p90"]);
  CHECK(round_trip["p90"] <= round_trip["p99"]);
  CHECK(round_trip["p99"] <= round_trip["max"]);

  // one sample of three is refused; the pause lets torqued forget the stream before
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::string text = "time,contactL,contactR,load_transfer";
  for (const char* order : {"", "d", "dd"})
    for (int i = 0; i < 7; ++i)
      text += fmt::format(",{}q{}", order, i);
  for (const char* row : {"0,sole,sole,0.5", "0.01,sole,sole,2", "0.02,sole,sole,1"})
    text += fmt::format("\n{},0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0", row);
  const Run some = run({"send", folder.write("some.csv", text)});
  CAPTURE(some.output);
  CHECK(some.code == 1);
  CHECK(some.output.find("human-subject01: 2 of 3 samples answered, 0 lost, 1 rejected: OUT_OF_RANGE 1\n") !=
        std::string::npos);
  CHECK(some.output.find("some.csv:3: load_transfer is 2; expected 0 to 1\n") != std::string::npos);
}

TEST_CASE("send gets an answer to every sample, however near two are due, from a daemon that answers the newest",
          "[torquectl_process]")
{
  const TemporaryFolder folder;
  Process torqued({TORQUED, "--robot", "ck"}, folder.file("torqued"));
  // gait's, whose contacts change between frames: two samples 1 us apart, at any time from the frames around them
  const std::string walk = folder.file("walk.csv");
  REQUIRE(run({"gait", "--robot", "ck", "--steps", "2", "-o", walk}).code == 0);
  // and one that stands, in threes: the second is due when the first cannot be answered yet, the third 1 us later
  std::string text = "utime,contactL,contactR,load_transfer";
  for (const char* order : {"", "d", "dd"})
    for (int i = 0; i < 7; ++i)
      text += fmt::format(",{}q{}", order, i);
  for (int k = 0; k < 50; ++k)
    for (const int later : {0, 20, 21, 5'000, 10'000, 15'000})
      text += fmt::format("\n{},sole,sole,0.5,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0", 20'000 * k + later);
  const std::string threes = folder.write("threes.csv", text);

  for (const std::string& file : {walk, threes})
  {
    // a machine that stalls for milliseconds may lose a sample of any motion, but not one of each pair in every try
    std::int64_t fewest_lost = std::numeric_limits<std::int64_t>::max();
    for (int i = 0; i < 4 && fewest_lost > 0; ++i)
    {
      const Run sent = run({"send", file, "--json"});
      CAPTURE(sent.output);
      const auto summary = nlohmann::json::parse(sent.output.substr(sent.output.find('{')));
      REQUIRE(summary["sent"] >= 200);
      fewest_lost = std::min(fewest_lost, summary["lost"].get<std::int64_t>());
    }
    CAPTURE(file);
    CHECK(fewest_lost == 0);
  }
}

TEST_CASE("a daemon adjusts what cannot be had, and answers what nearest writes as it is", "[torquectl_process]")
{
  const TemporaryFolder folder;
  const std::string feasible = folder.file("feasible.csv"),
                    config = folder.write("c.toml", "infeasible = \"nearest\"\nrobot = \"human-subject01\"\n"
                                                    "every_sample = true\n[constrained]\nwindows = false\n"
                                                    "[nearest]\ncontacts = \"as-desired\"\n");
  REQUIRE(run({"nearest", kWalk, "--config", config, "-o", feasible}).code == 0);
  const Process torqued({TORQUED, "--config", config}, folder.file("torqued"));
  const std::string others = "CONTACT_ACCELERATION 447, INCONSISTENT 447\n";
  for (const auto& [file, flags] : {std::pair(kWalk, "flags: ADJUSTED 17, " + others), {feasible, "flags: " + others}})
  {
    const Run sent = run({"send", file, "--rate", "500"});
    CAPTURE(sent.output);
    CHECK(sent.code == 0);
    CHECK(contains(sent.output, flags));
    std::this_thread::sleep_for(std::chrono::milliseconds(300)); // torqued lets another stream take over
  }
}

TEST_CASE("send says when a daemon dies under it, and when there is none", "[torquectl_process]")
{
  const TemporaryFolder folder;
  auto torqued = torqued_for_the_walk(folder, {"--every-sample"});
  Process send({TORQUECTL, "send", kWalk, "--json", "--speed", "0.5"}, folder.file("send"), folder.file("send.err"));
  Process echo({TORQUECTL, "echo", "--count", "20", "--format", "csv"}, folder.file("echo"));
  REQUIRE(echo.wait() == 0); // the walk is under way
  torqued->signal(SIGKILL);
  torqued->wait();
  CHECK(send.wait() == 1);
  const auto summary = nlohmann::json::parse(read_file(folder.file("send")));
  CHECK(summary["sent"] == 447);
  CHECK(summary["answered"].get<int>() >= 20);
  CHECK(summary["lost"].get<int>() + summary["answered"].get<int>() == 447);

  const Run none = run({"send", kWalk});
  CHECK(none.code == 69);
  CHECK(none.output.find("torquectl: no daemon has said on TORQUED_MODEL within 5 s which robot it computes") !=
        std::string::npos);
}

TEST_CASE("echo prints each answer once, as a table, as CSV and as JSON lines", "[torquectl_process]")
{
  const TemporaryFolder folder;
  const auto torqued = torqued_for_the_walk(folder, {"--every-sample"});
  std::vector<std::unique_ptr<Process>> echoes;
  for (const char* format : {"table", "csv", "json"})
    echoes.push_back(
        std::make_unique<Process>(std::vector<std::string>{TORQUECTL, "echo", "--format", format, "--count", "10"},
                                  folder.file(format), folder.file("echo.err")));
  // they hear the walk from wherever they are ready
  CHECK(run({"send", kWalk, "--speed", "0.5"}).code == 0);
  for (const auto& echo : echoes)
    CHECK(echo->wait() == 0);

  const std::string csv = read_file(folder.file("csv"));
  CHECK(csv.starts_with("utime,time,tau_left_ankle,"));
  CHECK(csv.substr(0, csv.find('\n')).ends_with(",a_0,a_1,a_2,a_3,a_4,a_5,a_6,a_xH,a_zH,adjustment,method,rejected"));
  CHECK(lines(csv) == 13); // a header, two comments and the answers
  CHECK(lines(read_file(folder.file("table"))) >= 11);
  const std::string json = read_file(folder.file("json"));
  CHECK(lines(json) == 10);
  const auto first = nlohmann::json::parse(json.substr(0, json.find('\n')));
  CAPTURE(first.dump());
  CHECK(first["torque"].contains("left_ankle"));
  CHECK(first["a"].size() == 7);
  CHECK(first["base_a"].size() == 2);
  CHECK(first["adjustment"] == 0.0);
}

TEST_CASE("echo ends cleanly when it is interrupted", "[torquectl_process]")
{
  const TemporaryFolder folder;
  const auto torqued = torqued_for_the_walk(folder);
  Process echo({TORQUECTL, "echo", "--status", "--format", "json"}, folder.file("echo"), folder.file("echo.err"));
  for (int i = 0; i < 1000 && lines(read_file(folder.file("echo"))) < 3; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  CHECK(lines(read_file(folder.file("echo"))) >= 3);
  echo.signal(SIGINT);
  CHECK(echo.wait() == 0);
}

TEST_CASE("without a bus, and without a daemon, each subcommand that needs one says so", "[torquectl_process]")
{
  const std::vector<std::vector<std::string>> all{
      {"send", kWalk}, {"echo"}, {"view", "--port", "0"}, {"status", "--once"}};
  for (std::vector<std::string> words : all)
  {
    words.insert(words.end(), {"--lcm-url", "nonsense://"});
    const Run ended = run(words);
    CAPTURE(words, ended.output);
    CHECK(ended.code == 69);
    CHECK(ended.output.find("torquectl: the LCM bus cannot be opened: --lcm-url is \"nonsense://\": LCM knows no "
                            "\"nonsense\"; expected udpm://239.255.76.67:7667?ttl=0 or the like\n") !=
          std::string::npos);
  }
  const TemporaryFolder folder;
  std::vector<std::unique_ptr<Process>> waiting; // each waits some seconds
  for (std::vector<std::string> words : all)
  {
    words.insert(words.begin(), TORQUECTL);
    waiting.push_back(std::make_unique<Process>(words, folder.file(words[1])));
  }
  for (std::size_t i = 0; i < all.size(); ++i)
  {
    CHECK(waiting[i]->wait() == 69);
    const std::string said = read_file(folder.file(all[i][0]));
    CAPTURE(said);
    CHECK((said.find("is torqued running on this bus and network") != std::string::npos));
    CHECK((said.find("torquectl doctor looks for what is wrong") != std::string::npos));
  }
}

TEST_CASE("a robot that does not ship is shown as torqued says, and gets no other robot's motion",
          "[torquectl_process]")
{
  const TemporaryFolder folder;
  std::string toml(shipped_robot_toml("ck"));
  toml.replace(toml.find("gravity = 9.81"), 14, "gravity = 1.62");
  const std::string mine = folder.write("mine.toml", toml), walk = folder.file("walk.csv");
  Process torqued({TORQUED, "--robot", mine, "--every-sample"}, folder.file("torqued"));
  View view;
  const nlohmann::json robot = view.document()["robot"];
  CHECK(robot["links"].size() == 7);
  CHECK(std::abs(robot["weight"].get<double>() - 45.0 * 1.62) < 1e-9);
  view.process().signal(SIGINT);
  CHECK(view.process().wait() == 0);

  const std::int64_t id = load_robot(mine).model_id;
  const Run human = run({"send", kWalk});
  CHECK(human.code == 65);
  CHECK(contains(
      human.output,
      fmt::format("torquectl: {} names robot human-subject01 (model_id {}), but torqued computes ck (model_id {}): use "
                  "the robot for which the motion was made or, to use the motion with another one, remove the comment "
                  "lines \"# robot:\" and \"# model_id:\"\n",
                  kWalk, load_robot("human-subject01").model_id, id)));
  CHECK(run({"gait", "--robot", "ck", "--steps", "1", "-o", walk}).code == 0);
  CHECK(contains(run({"send", walk}).output, "(the robot has been changed since, or torqued has)"));
  CHECK(contains(run({"view", "--robot", "ck"}).output,
                 fmt::format("torquectl: torqued computes ck (model_id {}), but --robot says ck (model_id ", id)));
  // its own motion it answers, and echo says whose answers they are
  CHECK(run({"gait", "--robot", mine, "--steps", "1", "-o", walk}).code == 0);
  Process echo({TORQUECTL, "echo", "--format", "csv", "--count", "1"}, folder.file("echo.csv"));
  for (int i = 0; i < 1000 && read_file(folder.file("echo.csv")).empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  CHECK(run({"send", walk}).code == 0);
  CHECK(echo.wait() == 0);
  CHECK(read_file(folder.file("echo.csv")).find(fmt::format("\n# robot: ck\n# model_id: {}\n", id)) !=
        std::string::npos);
}

TEST_CASE("whatever a stranger says on the channels, no subcommand that listens ends", "[torquectl_process]")
{
  const TemporaryFolder folder;
  const auto torqued = torqued_for_the_walk(folder, {"--every-sample"});
  View view;
  std::vector<std::unique_ptr<Process>> echoes;
  const std::vector<std::string> formats{"table", "csv", "json"};
  for (const std::string& format : formats)
    echoes.push_back(std::make_unique<Process>(
        std::vector<std::string>{TORQUECTL, "echo", "--status", "--format", format}, folder.file(format)));
  Process send({TORQUECTL, "send", "--loop", kWalk}, folder.file("send"));
  for (const std::string& format : formats)
    REQUIRE(wait_for([&] { return lines(read_file(folder.file(format))) > 20; }));

  const Channels channels;
  lcm::LCM bus;
  constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  constexpr std::int64_t first = std::numeric_limits<std::int64_t>::min(),
                         last = std::numeric_limits<std::int64_t>::max();
  const std::string noise = "\x1b[2J\xff\xfe\"<script>\r\n";
  const model_info_t human = model_info(load_robot("human-subject01"), 1, 2, ""),
                     compass = model_info(load_robot("compass"), 1, 2, "settings = [[[");
  for (int round = 0; round < 100; ++round)
  {
    const double number = round % 4 == 0 ? nan : round % 4 == 1 ? infinity : round % 4 == 2 ? -1e308 : 1e-320;
    const std::int64_t time = round % 3 == 0 ? first : round % 3 == 1 ? last : 0;

    model_info_t model = round % 2 == 0 ? human : compass;
    if (round % 5 == 1)
      model.name = model.joint_names[0] = noise;
    if (round % 5 == 2)
    {
      model.model_id = round;
      model.joint_names.back() = std::string(5000, 'j');
    }
    if (round % 5 == 3)
    {
      model = compass; // under the daemon's id
      model.model_id = human.model_id;
    }
    if (round % 5 == 4)
      model.gravity = model.segment_widths[0] = model.foot_heels[0][0] = model.torque_limits[0] = number;
    bus.publish(channels.model, &model);

    torque_command_t command{};
    command.utime = time;
    command.stream_id = round % 2;
    command.model_id = round % 3 == 0 ? compass.model_id : human.model_id;
    command.method = static_cast<std::int8_t>(round % 2 == 0 ? -128 : 127);
    command.flags = round % 2 == 0 ? -1 : std::numeric_limits<std::int32_t>::min();
    command.zmp = command.left.fx = command.right.cop = command.base_a[0] = number;
    command.num_coordinates = round % 2 == 0 ? human.num_coordinates : round % 30;
    command.num_joints = round % 2 == 0 ? human.num_joints : round % 7;
    command.a.assign(static_cast<std::size_t>(command.num_coordinates), number);
    command.torque.assign(static_cast<std::size_t>(command.num_joints), number);
    bus.publish(channels.command, &command);

    rejection_t rejection{};
    rejection.utime = time;
    rejection.reason = round - 50;
    rejection.detail = noise;
    bus.publish(channels.rejected, &rejection);

    status_t status{};
    status.utime = status.uptime_us = status.received = status.input_age_us = time;
    status.instance_id = round;
    status.state = static_cast<std::int8_t>(round);
    status.last_reason = -round;
    status.latency_us_p50 = status.latency_us_max = number;
    status.version = noise;
    bus.publish(channels.status, &status);

    std::vector<std::byte> buffer;
    const Bytes cut = encode(model, buffer).first(static_cast<std::size_t>(round));
    for (const std::string& channel : {channels.model, channels.command, channels.rejected, channels.status})
      bus.publish(channel, cut.data(), static_cast<unsigned>(cut.size()));
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }

  CHECK(run({"status", "--once", "--json"}).code == 0);
  CHECK(view.get("/document").status == 200);
  // and go on with what the daemon says
  for (std::size_t i = 0; i < formats.size(); ++i)
  {
    CAPTURE(formats[i]);
    const std::size_t heard = lines(read_file(folder.file(formats[i])));
    CHECK(wait_for([&] { return lines(read_file(folder.file(formats[i]))) > heard + 20; }));
    echoes[i]->signal(SIGINT);
    CHECK(echoes[i]->wait() == 0);
  }
  CHECK(wait_for([&] { return view.robot() == "human-subject01"; }));
  view.process().signal(SIGINT);
  CHECK(view.process().wait() == 0);
  send.signal(SIGINT);
  const std::optional<int> code = send.wait();
  CHECK((code == 0 || code == 1)); // all were answered, or not
  CHECK(contains(read_file(folder.file("send")), "human-subject01: "));
}

} // namespace torquectl_process_test
