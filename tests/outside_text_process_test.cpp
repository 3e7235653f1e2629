#include "catch.h"
#include "process.h"
#include "temporary_folder.h"

#include "motion/files.h"
#include "text/printable.h"
#include "wire/messages.h"

#include <algorithm>
#include <atomic>
#include <fmt/format.h>
#include <lcm/lcm-cpp.hpp>
#include <string>
#include <thread>
#include <vector>

namespace outside_text_process_test
{

using namespace torqued;

namespace
{

using namespace std::chrono_literals;

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";
// sets a title, clears the screen, colours by a C1 control, turns the order of letters, rings, and begins a line
const std::string kHostile = "\x1b]0;t\x07\x1b[2J\xc2\x9b"
                             "31m\xe2\x80\xae\x7f\xff\r\x08z\x1b[0m";
const std::string kLong(100'000, 'x');

// A line is as long as kLongestLine, with the program's name and the marks of what was left out.
constexpr std::size_t kLongest = kLongestLine + 200;

// What is wrong with a text on a terminal; empty if nothing is.
std::string trouble(std::string_view text)
{
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size();)
  {
    const Utf8Character character = first_character(text.substr(at));
    if (character.size == 0)
      return fmt::format("byte {} is no UTF-8", at);
    const bool is_end = character.code == '\n';
    if (!is_end && character.code != '\t' && !is_shown(character.code))
      return fmt::format("U+{:04X} at byte {}", character.code, at);
    line = is_end ? 0 : line + character.size;
    if (line > kLongest)
      return fmt::format("a line of more than {} bytes", kLongest);
    at += character.size;
  }
  return "";
}

// What a command says on both streams; what still runs after its patience, and has said something, is told to end.
std::string said_by(const std::vector<std::string>& command, std::chrono::milliseconds patience = 10s)
{
  const TemporaryFolder folder;
  Process process(command, folder.file("out"));
  if (!process.wait(patience))
  {
    for (int i = 0; i < 1000 && read_file(folder.file("out")).empty(); ++i)
      process.wait(10ms);
    process.signal(SIGTERM);
    process.wait();
  }
  return read_file(folder.file("out"));
}

void check_said(const std::vector<std::string>& command, std::chrono::milliseconds patience = 10s)
{
  const std::string said = said_by(command, patience);
  std::string shown;
  for (const std::string& word : command)
    shown += printable(word, 60) + " ";
  CAPTURE(shown, printable(said, 2000));
  CHECK_FALSE(said.empty());
  CHECK(trouble(said) == "");
}

} // namespace

TEST_CASE("what a command line says reaches the terminal without control characters, and cut", "[outside_text_process]")
{
  REQUIRE(trouble(kHostile) != "");
  REQUIRE(trouble(kLong) != "");
  for (const std::string& text : {kHostile, kLong, kHostile + kLong, "line\n" + kHostile})
  {
    for (std::vector<std::string> words : std::vector<std::vector<std::string>>{
             {text},
             {"--" + text},
             {"eval", text},
             {"eval", kWalk, text},
             {"eval", kWalk, "--" + text},
             {"eval", kWalk, "--robot", text, "-o", "-"},
             {"eval", kWalk, "--robot", "ck", "-o", "/nowhere/" + text},
             {"eval", kWalk, "--robot", "ck", "-o", "-", "--method", text},
             {"eval", kWalk, "--robot", "ck", "-o", "-", "--config", text},
             {"eval", kWalk, "--robot", "ck", "-o", "-", "--differentiate", "--lowpass", text},
             {"compare", text, "--robot", text},
             {"export", text, "-o", text},
             {"report", text, "-o", text},
             {"gait", "--robot", "ck", "-o", "-", "--steps", text},
             {"gait", "--robot", text, "-o", "-"},
             {"model", "--robot", text},
             {"model", "--robot", "ck", "--toml-for", text},
             {"echo", "--format", text},
             {"echo", "--prefix", text},
             {"status", "--once", "--lcm-url", text},
             {"doctor", "--lcm-url", "udpm://" + text},
             {"send", text},
         })
    {
      words.insert(words.begin(), TORQUECTL);
      check_said(words);
    }
    for (const char* option :
         {"--robot", "--config", "--method", "--lcm-url", "--prefix", "--log-level", "--nonsense", "--every-sample"})
      check_said({TORQUED, option, text});
    check_said({TORQUED, "--robot", "ck", "--lcm-url", "udpm://239.255.76.67:7667?" + text});
  }
}

TEST_CASE("what files hold, and what they are called, reaches the terminal without control characters, and cut",
          "[outside_text_process]")
{
  const TemporaryFolder folder;
  const std::string robot = said_by({TORQUECTL, "model", "--robot", "ck", "--toml"});
  const std::string urdf = said_by({TORQUECTL, "model", "--robot", "ck", "--urdf"});
  const std::string name = "a" + kHostile.substr(0, 60);
  for (const std::string& text : {kHostile, kLong})
  {
    std::vector<std::string> tables{
        text + "\n0\n", "time," + text + "\n0,1\n",
        "time,q0,q1,q2,q3,q4,q5,q6,contactL,contactR\n0," + text + ",0,0,0,0,0,0,sole,sole\n",
        "time,q0,q1,q2,q3,q4,q5,q6,contactL,contactR\n# robot: " + text + "\n0,0,0,0,0,0,0,0,sole," + text + "\n",
        "time,q0 [" + text + "]\n0,1\n"};
    for (const std::string& table : tables)
    {
      const std::string file = folder.write(name + ".csv", table);
      check_said({TORQUECTL, "eval", file, "--robot", "ck", "-o", "-"});
      check_said({TORQUECTL, "eval", file, "-o", "-", "--differentiate"});
    }
    std::string quoted = text; // a text of TOML takes no control characters but as escapes
    if (text == kHostile)
      quoted = "\\u001b[2J\\u009b31m\\u202e\\u0007";
    for (const std::string& toml :
         {text, text + " = 1\n" + robot, "\"" + quoted + "\" = 1\n" + robot, "name = \"" + quoted + "\"\n",
          "source = \"" + quoted + "\"\n" + robot, robot + "\n[\"" + quoted + "\"]\n", "urdf = \"" + quoted + "\"\n"})
    {
      const std::string file = folder.write(name + ".toml", toml);
      check_said({TORQUECTL, "model", "--robot", file});
      check_said({TORQUED, "--robot", file}, 300ms);
      check_said({TORQUED, "--config", file, "--robot", "ck"}, 300ms);
    }
    const std::size_t link = urdf.find("<link");
    REQUIRE(link != std::string::npos);
    const auto inserted = [&](const std::string& part)
    {
      return urdf.substr(0, link) + part + urdf.substr(link);
    };
    for (const std::string& xml :
         {text, "<" + text + ">", inserted("<" + text + "/>"),
          inserted("<vendor a=\"" + text + "\">" + text + "</vendor>"), inserted("<link name=\"" + text + "\"/>"),
          inserted("<gazebo reference=\"" + text + "\"/>"),
          inserted("<joint name=\"" + text + "\" type=\"" + text + "\"/>"), urdf})
    {
      const std::string file = folder.write(name + ".urdf", xml);
      check_said({TORQUECTL, "model", "--robot", file});
      check_said({TORQUED, "--robot", file}, 300ms);
    }
  }
}

TEST_CASE("what other programs say on the bus reaches the terminal without control characters, and cut",
          "[outside_text_process]")
{
  std::atomic<bool> ends = false;
  std::thread others(
      [&]
      {
        lcm::LCM bus;
        status_t status{};
        model_info_t model{};
        rejection_t rejection{};
        for (int i = 0; !ends; ++i)
        {
          const std::string text = i % 2 == 0 ? kHostile : kLong.substr(0, 20'000);
          status.version = model.name = model.settings = rejection.detail = text;
          model.num_joints = model.num_links = 0;
          for (const std::string& prefix : {std::string(), kHostile.substr(0, 20)})
          {
            const Channels channels(prefix);
            bus.publish(channels.status, &status);
            bus.publish(channels.model, &model);
            bus.publish(channels.rejected, &rejection);
          }
          std::this_thread::sleep_for(20ms);
        }
      });
  check_said({TORQUECTL, "status", "--once"});
  check_said({TORQUECTL, "doctor"});
  check_said({TORQUECTL, "echo", "--status"}, 1000ms);
  check_said({TORQUECTL, "echo"}, 1000ms);
  check_said({TORQUECTL, "send", kWalk}, 1000ms);
  check_said({TORQUED, "--robot", "ck"}, 1000ms);
  ends = true;
  others.join();
}

} // namespace outside_text_process_test
