#include "catch.h"
#include "run_torquectl.h"

#include "commands/robot_choice.h"
#include "motion/failure.h"
#include "motion/lcm_log.h"
#include "robot/files/load.h"
#include "wire/codec.h"

#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace robot_choice_test
{

using namespace torqued;

namespace
{

const std::string kShips = "ck, rk, six-link, compass, bip-itlag, human-subject01, rabbit";

// one second of standing upright: a motion of ck, rk and human-subject01 alike, which names none of them
std::string standing(const std::string& comments = "")
{
  std::string text = "time,contactL,contactR,load_transfer";
  for (const std::string order : {"", "d", "dd"})
    for (int i = 0; i < 7; ++i)
      text += fmt::format(",{}q{}", order, i);
  text += '\n' + comments;
  for (const char* time : {"0", "1"})
    text += fmt::format("{},sole,sole,0.5{}\n", time, ",0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0");
  return text;
}

// upright, feet off the ground, without a base: no sample can be answered
std::string flight()
{
  std::string text = standing();
  for (std::size_t at = 0; (at = text.find("sole", at)) != std::string::npos;)
    text.replace(at, 4, "none");
  return text;
}

// what follows the header: comment lines up to the first row
std::string comments_of(const std::string& csv)
{
  const std::size_t header = csv.find('\n') + 1;
  std::size_t end = header;
  while (end < csv.size() && csv[end] == '#')
    end = csv.find('\n', end) + 1;
  return csv.substr(header, end - header);
}

std::string lines_of(const std::string& robot)
{
  return fmt::format("# robot: {}\n# model_id: {}\n", robot, load_robot(robot).model_id);
}

// ck on the Moon, which does not ship
std::string moon_robot(const TemporaryFolder& folder, const std::string& name = "mine")
{
  std::string toml(shipped_robot_toml("ck"));
  toml.replace(toml.find("gravity = 9.81"), 14, "gravity = 1.62");
  toml.replace(toml.find("name = \"ck\""), 11, "name = \"" + name + "\"");
  return folder.write("mine.toml", toml);
}

// each subcommand that reads a motion, with words that make it work on this file
std::vector<std::vector<std::string>> readers(const TemporaryFolder& folder, const std::string& file)
{
  return {{"eval", file, "-o", folder.file("o.csv")},
          {"wrenches", file, "-o", folder.file("o.csv")},
          {"dynamics", file, "-o", folder.file("o.json")},
          {"project", file, "-o", folder.file("o.csv")},
          {"nearest", file, "-o", folder.file("o.csv")},
          {"report", file, "-o", folder.file("o.html")},
          {"compare", file}};
}

std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more)
{
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

} // namespace

TEST_CASE("every CSV that is written begins with its header, and names its robot below it", "[robot_choice]")
{
  const TemporaryFolder folder;
  for (const std::string robot : {"ck", "rk", "human-subject01"})
  {
    const std::string walk = folder.file("walk.csv"), log = folder.file("walk.lcm"), out = folder.file("out.csv");
    REQUIRE(run({"gait", "--robot", robot, "--steps", "1", "--rate", "20", "-o", walk}).code == 0);
    REQUIRE(run({"eval", walk, "-o", log}).code == 0);
    CHECK(comments_of(read_file(walk)).starts_with(lines_of(robot) + "# torquectl gait --robot " + robot));
    for (const auto& [words, header] :
         std::vector<std::pair<std::vector<std::string>, std::string>>{{{"eval", walk}, "utime,"},
                                                                       {{"wrenches", walk}, "utime,x_"},
                                                                       {{"project", walk}, "utime,"},
                                                                       {{"nearest", walk}, "utime,"},
                                                                       {{"export", log}, "utime,"}})
    {
      CAPTURE(words.front());
      REQUIRE(run(with(words, {"-o", out})).code == 0);
      CHECK(read_file(out).starts_with(header));
      CHECK(comments_of(read_file(out)).starts_with(lines_of(robot)));
    }
  }
}

TEST_CASE("the motions that ship begin with their header, and name a robot that ships as it is", "[robot_choice]")
{
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(TRAJECTORIES))
  {
    if (entry.path().extension() != ".csv")
      continue;
    ++files;
    const std::string text = read_file(entry.path());
    CAPTURE(entry.path());
    CHECK(text.starts_with("time,"));
    const NamedRobots named = robots_named_by(text, entry.path(), Channels());
    REQUIRE(named.robots.size() == 1);
    CHECK(comments_of(text).starts_with(lines_of(named.robots.front().name)));
  }
  CHECK(files == 4);
}

TEST_CASE("a motion that names its robot is answered for that one, as if it had been said", "[robot_choice]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("walk.csv"), said = folder.file("said.csv"), named = folder.file("named.csv");
  for (const std::string robot : {"ck", "rk", "human-subject01"})
  {
    REQUIRE(run({"gait", "--robot", robot, "--steps", "1", "--rate", "20", "-o", walk}).code == 0);
    REQUIRE(run({"eval", walk, "--robot", robot, "-o", said}).code == 0);
    const Run eval = run({"eval", walk, "-o", named});
    CHECK(eval.out.starts_with(robot + ": "));
    CHECK(eval.err == "");
    CHECK(read_file(named) == read_file(said));
  }
  // its name alone does, too
  const Run by_name = run({"eval", folder.write("s.csv", standing("# robot: rk\n")), "-o", named});
  CHECK(by_name.code == 0);
  CHECK(comments_of(read_file(named)) == lines_of("rk"));
}

TEST_CASE("a robot is never guessed", "[robot_choice]")
{
  const TemporaryFolder folder;
  const std::string file = folder.write("walk.csv", standing());
  for (const auto& words : readers(folder, file))
  {
    CAPTURE(words.front());
    const Run ended = run(words);
    CHECK(ended.code == 65);
    CHECK(ended.out == "");
    CHECK(ended.err == fmt::format("torquectl: {} does not name its robot: say --robot NAME|FILE (robots that ship: "
                                   "{})\n",
                                   file, kShips));
    CHECK(run(with(words, {"--robot", "ck"})).code == 0);
    if (words.front() != "project") // has no configuration
      CHECK(run(with(words, {"--config", folder.write("c.toml", "robot = \"rk\"")})).code == 0);
  }
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"gait", "-o", folder.file("g.csv")}, std::vector<std::string>{"model"}})
  {
    const Run ended = run(words);
    CHECK(ended.code == 64);
    CHECK(ended.err ==
          fmt::format("torquectl: no robot is said: say --robot NAME|FILE (robots that ship: {})\n", kShips));
  }
}

TEST_CASE("a motion that names another robot than the one that is said is refused", "[robot_choice]")
{
  const TemporaryFolder folder;
  const auto id = [](const std::string& robot)
  {
    return load_robot(robot).model_id;
  };
  const std::string remedy =
      "use the robot for which the motion was made or, to use the motion with another one, remove "
      "the comment lines \"# robot:\" and \"# model_id:\"";
  const std::string file = folder.write("s.csv", standing(lines_of("ck")));
  for (const auto& words : readers(folder, file))
  {
    CAPTURE(words.front());
    const Run ended = run(with(words, {"--robot", "rk"}));
    CHECK(ended.code == 65);
    CHECK(ended.err ==
          fmt::format("torquectl: {} names robot ck (model_id {}), but --robot says rk (model_id {}): {}\n", file,
                      id("ck"), id("rk"), remedy));
  }
  const auto error = [&](const std::string& csv, const std::vector<std::string>& words)
  {
    const std::string path = folder.write("m.csv", csv);
    const Run ended = run(with({"eval", path, "-o", folder.file("o.csv")}, words));
    return fmt::format("{} {}", ended.code, ended.err);
  };
  const std::string m = folder.file("m.csv");
  CHECK(error(standing(lines_of("ck")), {"--config", folder.write("c.toml", "robot = \"rk\"")}) ==
        fmt::format("65 torquectl: {} names robot ck (model_id {}), but the configuration says rk (model_id {}): {}\n",
                    m, id("ck"), id("rk"), remedy));
  // the flag wins over the configuration
  CHECK(error(standing(lines_of("ck")), {"--robot", "ck", "--config", folder.file("c.toml")}) == "0 ");
  // by its name, where there is no model_id
  CHECK(error(standing("# robot: ck\n"), {"--robot", "rk"}) ==
        fmt::format("65 torquectl: {} names robot ck, but --robot says rk (model_id {}): {}\n", m, id("rk"), remedy));
  CHECK(error(standing("# robot: ck\n"), {"--robot", "ck"}) == "0 ");
  // an older ck
  const std::string older = "# robot: ck\n# model_id: 77\n";
  const std::string changed = " (the robot has been changed since, or torqued has): ";
  CHECK(error(standing(older), {"--robot", "ck"}) ==
        fmt::format("65 torquectl: {} names robot ck (model_id 77), but --robot says ck (model_id {}){}{}\n", m,
                    id("ck"), changed, remedy));
  CHECK(error(standing(older), {}) ==
        fmt::format("65 torquectl: {} names robot ck (model_id 77), but the one that ships is ck (model_id {}){}{}\n",
                    m, id("ck"), changed, remedy));
  // one's own robot, before and after it is edited
  const std::string mine = moon_robot(folder);
  const std::string moon = fmt::format("# robot: mine\n# model_id: {}\n", id(mine));
  CHECK(error(standing(moon), {"--robot", mine}) == "0 ");
  CHECK(error(standing(moon), {}) ==
        fmt::format("65 torquectl: {} names robot mine (model_id {}), which does not ship; its masses are needed here: "
                    "say --robot FILE\n",
                    m, id(mine)));
  std::string toml = read_file(mine);
  toml.replace(toml.find("gravity = 1.62"), 14, "gravity = 1.63");
  folder.write("mine.toml", toml);
  CHECK(error(standing(moon), {"--robot", mine}).starts_with("65 torquectl: " + m + " names robot mine (model_id "));
  // a name is never a path
  CHECK(error(standing("# robot: " + mine + "\n"), {}).starts_with("65 torquectl: " + m + " names robot /"));
}

TEST_CASE("lines that name a robot are read wherever they stand, as spreadsheets and editors leave them",
          "[robot_choice]")
{
  const auto named = [](const std::string& text)
  {
    const NamedRobots found = robots_named_by(text, "f.csv", Channels());
    REQUIRE(found.robots.size() == 1);
    return fmt::format("{} {}", found.robots[0].name, found.robots[0].model_id.value_or(0));
  };
  CHECK(named("# robot: ck\n# model_id: -5\ntime,q0\n0,1\n") == "ck -5");
  CHECK(named("time,q0\r\n# robot: ck\r\n# model_id: -5\r\n0,1\r\n") == "ck -5");
  CHECK(named("time,q0\n# robot: ck,,,\n# model_id: -5,,,\n0,1\n") == "ck -5");
  CHECK(named("time;q0\n#robot:ck;\n  #  model_id:  -5  ;;\n0;1\n") == "ck -5");
  CHECK(named("time,q0\n0,1\n# model_id: 9223372036854775807\n# robot: a-b_1") == "a-b_1 9223372036854775807");
  CHECK(named("# robot: ck\n# robot: ck\n") == "ck 0");
  CHECK(robots_named_by("time,q0\n# a robot: ck\n0,1\n", "f.csv", Channels()).robots.empty());

  const auto error = [](const std::string& text)
  {
    try
    {
      robots_named_by(text, "f.csv", Channels());
      return std::string();
    }
    catch (const Failure& failure)
    {
      CHECK(failure.code() == ExitCode::bad_data);
      return std::string(failure.what());
    }
  };
  CHECK(error("# robot: ck\ntime\n# robot: rk\n") ==
        "f.csv:3: found \"# robot: rk\" after \"# robot: ck\"; expected one robot in a file");
  CHECK(error("# model_id: 1\n# model_id: 2\n") ==
        "f.csv:2: found \"# model_id: 2\" after \"# model_id: 1\"; expected one robot in a file");
  CHECK(error("time\n# robot: ,,\n") == "f.csv:2: robot: found nothing; expected its name");
  CHECK(error("# model_id: 0x1\n") ==
        "f.csv:1: model_id: found \"0x1\"; expected a whole number, as torquectl model prints it");
  CHECK(error("# model_id: 1\n") ==
        "f.csv: found a comment line \"# model_id:\" without a line \"# robot: NAME\"; expected both, or none");
}

TEST_CASE("a page is of one robot", "[robot_choice]")
{
  const TemporaryFolder folder;
  const std::string ck = folder.write("ck.csv", standing(lines_of("ck"))),
                    rk = folder.write("rk.csv", standing(lines_of("rk"))), none = folder.write("none.csv", standing()),
                    page = folder.file("page.html");
  const Run two = run({"report", ck, rk, "-o", page});
  CHECK(two.code == 65);
  CHECK(two.err ==
        fmt::format("torquectl: {} is of ck (model_id {}) and {} of rk (model_id {}); a page shows one robot: "
                    "make a page of each\n",
                    ck, load_robot("ck").model_id, rk, load_robot("rk").model_id));
  CHECK(run({"report", ck, rk, "--robot", "ck", "-o", page}).err.starts_with("torquectl: " + rk + " names robot rk"));
  CHECK(run({"report", ck, none, "-o", page}).err.starts_with("torquectl: " + none + " does not name its robot"));
  CHECK(run({"report", ck, "--measured", rk, "-o", page}).err.starts_with("torquectl: " + rk + " names robot rk"));
  CHECK_FALSE(std::filesystem::exists(page));
  CHECK(run({"report", ck, none, "--robot", "ck", "-o", page}).code == 0);
}

TEST_CASE("- is the standard output: the same bytes, and what is said of them on the other stream", "[robot_choice]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("walk.csv"), log = folder.file("walk.lcm");
  REQUIRE(run({"gait", "--robot", "ck", "--steps", "1", "--rate", "20", "-o", walk}).code == 0);
  REQUIRE(run({"eval", walk, "-o", log}).code == 0);
  auto all = readers(folder, walk);
  all.pop_back(); // compare prints tables
  all.push_back({"export", log, "-o", folder.file("o.csv")});
  all.push_back({"gait", "--robot", "ck", "--steps", "1", "-o", folder.file("o.csv")});
  for (std::vector<std::string> words : all)
  {
    CAPTURE(words.front());
    const Run to_file = run(words);
    REQUIRE(to_file.code == 0);
    const std::string written = read_file(words.back());
    words.back() = "-";
    const Run to_stream = run(words);
    CHECK(to_stream.code == 0);
    CHECK(to_stream.out == written);
    CHECK(to_stream.err == to_file.out + to_file.err);
    CHECK(to_stream.err != "");
  }
}

TEST_CASE("a motion of which nothing is answered is not a success", "[robot_choice]")
{
  const TemporaryFolder folder;
  const std::string file = folder.write("flight.csv", flight());
  const std::string first = file + ":2: base is FROM_CONTACT (0), but neither foot has contact";
  for (const std::string command : {"eval", "wrenches"})
  {
    const Run ended = run({command, file, "--robot", "ck", "-o", folder.file("o.csv")});
    CHECK(ended.code == 65);
    CHECK(ended.err.starts_with(
        fmt::format("torquectl: {}: no sample was answered: 2 rejected: NOT_SUPPORTED 2; the first: {}", file, first)));
    CHECK(rows(folder.file("o.csv")).size() == 3);
  }
  const Run dynamics = run({"dynamics", file, "--robot", "ck", "-o", folder.file("o.json")});
  CHECK(dynamics.code == 65);
  CHECK(dynamics.err.starts_with(fmt::format("torquectl: {}: all 2 samples were refused; the first: {}", file, first)));
  const Run report = run({"report", file, "--robot", "ck", "-o", folder.file("o.html")});
  CHECK(report.code == 65);
  CHECK(report.err ==
        "torquectl: no sample was answered; flight.csv: torqued: 0 of 2 samples answered, NOT_SUPPORTED 2\n");
}

TEST_CASE("a log of a robot that does not ship is shown and exported as the log says", "[robot_choice]")
{
  const TemporaryFolder folder;
  const std::string mine = moon_robot(folder), walk = folder.file("walk.csv"), log = folder.file("walk.lcm"),
                    page = folder.file("page.html"), csv = folder.file("out.csv");
  REQUIRE(run({"gait", "--robot", mine, "--steps", "1", "--rate", "50", "-o", walk}).code == 0);
  REQUIRE(run({"eval", walk, "--robot", mine, "-o", log}).code == 0);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"report", log, "-o", page}, std::vector<std::string>{"export", log, "-o", csv}})
  {
    const Run of_log = run(words);
    CHECK(of_log.code == 0);
    CHECK(of_log.err == "");
    const std::string written = read_file(words.back());
    REQUIRE(run(with(words, {"--robot", mine})).code == 0);
    CHECK(read_file(words.back()) == written);
  }
  // what is computed needs masses
  const std::string needs =
      fmt::format("torquectl: {} was recorded with robot mine (model_id {}), which does not ship; "
                  "its masses are needed here: say --robot FILE\n",
                  log, load_robot(mine).model_id);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"eval", log, "-o", csv}, std::vector<std::string>{"compare", log},
        std::vector<std::string>{"report", log, "--method", "constrained", "-o", page},
        std::vector<std::string>{"report", log, "--measured", walk, "-o", page}})
  {
    const Run ended = run(words);
    CHECK(ended.code == 65);
    CHECK(ended.err == needs);
  }
  CHECK(run({"eval", log, "--robot", mine, "-o", csv}).code == 0);
  // an earlier robot of a name that ships is one that does not
  const std::string earlier = moon_robot(folder, "ck");
  REQUIRE(run({"eval", log, "--robot", earlier, "-o", folder.file("ck.lcm")}).code == 0);
  CHECK(run({"report", folder.file("ck.lcm"), "-o", page}).code == 0);
  const Run changed = run({"eval", folder.file("ck.lcm"), "-o", csv});
  CHECK(changed.code == 65);
  CHECK(changed.err.find("but the one that ships is ck (model_id ") != std::string::npos);
}

TEST_CASE("a log is used with the robot of its model message, and with no other", "[robot_choice]")
{
  const TemporaryFolder folder;
  const std::string motion = folder.write("s.csv", standing()), both = folder.file("both.lcm"),
                    csv = folder.file("o.csv");
  LogWriter writer(both);
  std::vector<std::byte> buffer;
  // two daemons, one after the other, answer the same desired states
  for (const std::string robot : {"ck", "rk"})
  {
    const std::string log = folder.file(robot + ".lcm");
    REQUIRE(run({"eval", motion, "--robot", robot, "-o", log}).code == 0);
    const std::string bytes = read_file(log);
    LogReader reader(bytes);
    while (const auto record = reader.next())
      if (record->channel != "TORQUED_DESIRED" || robot == "ck")
        writer.write(std::string(record->channel), record->timestamp, record->data);
  }
  writer.close();
  const auto id = [](const std::string& robot)
  {
    return load_robot(robot).model_id;
  };

  const Run other = run({"eval", folder.file("ck.lcm"), "--robot", "rk", "-o", csv});
  CHECK(other.code == 65);
  CHECK(other.err ==
        fmt::format("torquectl: {0} was recorded with robot ck (model_id {1}), but --robot says rk (model_id "
                    "{2}): use the robot with which it was recorded or, to use its motion with another one, "
                    "remove the comment lines \"# robot:\" and \"# model_id:\" of torquectl export {0} -o "
                    "CSV\n",
                    folder.file("ck.lcm"), id("ck"), id("rk")));

  for (const std::string command : {"export", "report"})
  {
    const Run unsaid = run({command, both, "-o", csv});
    CHECK(unsaid.code == 65);
    CHECK(unsaid.err ==
          fmt::format("torquectl: {} was recorded with robot ck (model_id {}) and rk (model_id {}): say by "
                      "--robot which one is meant\n",
                      both, id("ck"), id("rk")));
  }
  // a log whose samples are another robot's, and that holds no answers of the one that is said, is not exported
  const std::string unanswered = folder.file("unanswered.lcm");
  {
    const std::string bytes = read_file(folder.file("ck.lcm"));
    LogWriter samples(unanswered);
    LogReader reader(bytes);
    while (const auto record = reader.next())
      if (record->channel == "TORQUED_DESIRED")
        samples.write(std::string(record->channel), record->timestamp, record->data);
    samples.close();
  }
  CHECK(run({"export", unanswered, "--robot", "ck", "-o", csv}).code == 0);
  const Run foreign = run({"export", unanswered, "--robot", "rk", "-o", csv});
  CHECK(foreign.code == 65);
  CHECK(foreign.err == fmt::format("torquectl: {}: found desired states for model_id {}; expected {}, that of rk: they "
                                   "are another robot's\n",
                                   unanswered, id("ck"), id("rk")));

  // of each robot its own answers
  for (const auto& [robot, stranger] : {std::pair<std::string, std::string>{"ck", "rk"}, {"rk", "ck"}})
  {
    const std::string alone = folder.file("alone.csv");
    const Run said = run({"export", both, "--robot", robot, "-o", csv});
    CHECK(said.err == fmt::format("torquectl: note: {}: 2 commands are for another robot (model_id {}, not {}) and are "
                                  "left out\n",
                                  both, id(stranger), id(robot)));
    REQUIRE(run({"export", folder.file(robot + ".lcm"), "-o", alone}).code == 0);
    CHECK(read_file(csv) == read_file(alone));
  }
}

} // namespace robot_choice_test
