#include "catch.h"
#include "process.h"
#include "temporary_folder.h"

#include "client/files.h"
#include "wire/codec.h"

#include <algorithm>
#include <fmt/format.h>
#include <httplib.h>
#include <memory>
#include <nlohmann/json.hpp>

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

TEST_CASE("send gets an answer to both of two samples 1 us apart, from a daemon that answers the newest",
          "[torquectl_process]")
{
  const TemporaryFolder folder;
  Process torqued({TORQUED, "--robot", "ck"}, folder.file("torqued"));
  const std::string walk = folder.file("walk.csv");
  REQUIRE(run({"gait", "--robot", "ck", "--steps", "2", "-o", walk}).code == 0);
  const Run sent = run({"send", walk, "--json"});
  CAPTURE(sent.output);
  const auto summary = nlohmann::json::parse(sent.output.substr(sent.output.find('{')));
  CHECK(summary["sent"] > 200);
  CHECK(summary["answered"] == summary["sent"]);
  CHECK(summary["lost"] == 0);
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
  CHECK(csv.starts_with("utime,tau_left_ankle,"));
  CHECK(lines(csv) == 11);
  CHECK(lines(read_file(folder.file("table"))) >= 11);
  const std::string json = read_file(folder.file("json"));
  CHECK(lines(json) == 10);
  const auto first = nlohmann::json::parse(json.substr(0, json.find('\n')));
  CAPTURE(first.dump());
  CHECK(first.dump().find("left_ankle") != std::string::npos);
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
    CHECK(ended.output.find("torquectl: the LCM bus cannot be opened: lcm_url is \"nonsense://\". A bus within one "
                            "machine is udpm://239.255.76.67:7667?ttl=0 and needs: sudo ip link") != std::string::npos);
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
  }
}

TEST_CASE("view outlives its daemon, and shows the next one's robot", "[torquectl_process]")
{
  const TemporaryFolder folder;
  auto torqued = std::make_unique<Process>(std::vector<std::string>{TORQUED, "--robot", "ck"}, folder.file("ck"));
  Process view({TORQUECTL, "view", "--port", "0"}, folder.file("view"));
  const auto wait_for = [](const auto& condition)
  {
    for (int i = 0; i < 1000 && !condition(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return condition();
  };
  const auto said = [&]
  {
    return read_file(folder.file("view"));
  };
  REQUIRE(wait_for([&] { return said().find("127.0.0.1:") != std::string::npos && said().ends_with("\n"); }));
  const std::string text = said();
  httplib::Client browser("127.0.0.1", std::stoi(text.substr(text.find("127.0.0.1:") + 10)));
  const auto robot = [&]() -> std::string
  {
    const auto answer = browser.Get("/document");
    return answer ? nlohmann::json::parse(answer->body)["robot"]["name"].get<std::string>() : "";
  };
  CHECK(robot() == "ck");
  torqued->signal(SIGKILL);
  torqued->wait();
  CHECK(robot() == "ck");
  torqued = std::make_unique<Process>(std::vector<std::string>{TORQUED, "--robot", "rk"}, folder.file("rk"));
  CHECK(wait_for([&] { return robot() == "rk"; }));
  CHECK(browser.Get("/nothing")->status == 404);
  view.signal(SIGINT);
  CHECK(view.wait() == 0);
}
