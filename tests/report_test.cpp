#include "catch.h"
#include "matchers.h"
#include "run_torquectl.h"

#include "motion/gait.h"
#include "motion/lcm_log.h"
#include "motion/trajectory.h"
#include "page/report_page.h"
#include "robot/files/load.h"
#include "robot/files/robot_files.h"
#include "stance/contacts.h"
#include "study/answer_table.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace report_test
{

using namespace torqued;

namespace
{

using Json = nlohmann::json;

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";

// what a page shows
Json document(const std::string& path)
{
  const std::string page = read_file(path);
  const std::string begin = R"(<script type="application/json" id="report">)";
  const std::size_t from = page.find(begin);
  REQUIRE(from != std::string::npos);
  return Json::parse(page.substr(from + begin.size(), page.find("</script>", from) - from - begin.size()));
}

template <typename Number> std::vector<Number> decoded(const std::string& base64)
{
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : base64.substr(0, base64.find('=')))
  {
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    count += 6;
    if (count < 8)
      continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 255U);
  }
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(Number));
  return numbers;
}

std::vector<float> floats(const Json& text)
{
  return decoded<float>(text.get<std::string>());
}

// a CSV's columns by name; NaN for an empty cell and for a word
std::map<std::string, std::vector<double>> columns(const std::string& path)
{
  std::map<std::string, std::vector<double>> result;
  const auto lines = rows(path);
  for (std::size_t i = 1; i < lines.size(); ++i)
    for (std::size_t k = 0; k < lines[0].size(); ++k)
    {
      char* end = nullptr;
      const double number = std::strtod(lines[i][k].c_str(), &end);
      result[lines[0][k]].push_back(end == lines[i][k].c_str() || *end != '\0' ? NAN : number);
    }
  return result;
}

// "" if the numbers of a page are those of a table, rounded
std::string difference(const std::vector<float>& found, const std::vector<double>& expected)
{
  if (found.size() != expected.size())
    return fmt::format("{} numbers, expected {}", found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    if (std::bit_cast<std::uint32_t>(found[i]) != std::bit_cast<std::uint32_t>(static_cast<float>(expected[i])) &&
        !(std::isnan(found[i]) && std::isnan(expected[i])))
      return fmt::format("number {} is {}, expected {}", i, found[i], expected[i]);
  return "";
}

} // namespace

TEST_CASE("a robot without strokes is drawn from joint to joint", "[report]")
{
  const TemporaryFolder folder;
  std::string toml = to_toml(load_robot("ck"));
  for (std::size_t at; (at = toml.find("\ndraw")) != std::string::npos;)
    toml.erase(at, toml.find('\n', at + 1) - at);
  const std::string robot = folder.write("bare.toml", toml), walk = folder.file("walk.csv"),
                    page = folder.file("walk.html");
  REQUIRE(load_robot(robot).links[0].drawing.empty());
  REQUIRE(run({"gait", "--robot", robot, "-o", walk, "--steps", "1", "--rate", "20"}).code == 0);
  REQUIRE(run({"report", walk, "--robot", robot, "-o", page}).code == 0);
  const Json shown = document(page);
  for (const Json& link : shown["robot"]["links"])
  {
    CAPTURE(link["name"].get<std::string>());
    CHECK_FALSE(link["segments"].empty());
  }
}

TEST_CASE("what eval wrote can be shown and compared again: answers are no plates", "[report]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("walk.csv"), answers = folder.file("answers.csv"),
                    log = folder.file("answers.lcm");
  REQUIRE(run({"gait", "--robot", "ck", "-o", walk, "--steps", "1", "--rate", "50"}).code == 0);
  REQUIRE(run({"eval", walk, "-o", answers}).code == 0);
  for (const std::string command : {"report", "eval"})
    CHECK(run({command, answers, "-o", folder.file(command == "eval" ? "o.csv" : "o.html")}).code == 0);
  CHECK(run({"compare", answers}).code == 0);
  // a log that eval wrote names its robot in each desired state
  REQUIRE(run({"eval", walk, "-o", log}).code == 0);
  const Trajectory motion = parse_trajectory(read_file(log), log, {}, false, Channels());
  REQUIRE_FALSE(motion.states.empty());
  for (const desired_state_t& state : motion.states)
    CHECK(state.model_id == load_robot("ck").model_id);
}

TEST_CASE("a page shows what eval answers, and the robot where the motion has it", "[report]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("walk.csv"), page = folder.file("walk.html"),
                    answers = folder.file("answers.csv");
  REQUIRE(run({"gait", "--robot", "rk", "-o", walk, "--steps", "2", "--rate", "50"}).code == 0);
  REQUIRE(run({"eval", walk, "--robot", "rk", "-o", answers}).code == 0);
  const Run report = run({"report", walk, "--robot", "rk", "-o", page});
  CAPTURE(report.err);
  REQUIRE(report.code == 0);
  CHECK(report.err == "");
  CHECK(report.out == "walk.csv: constrained: 85 of 85 samples answered\n");

  const Json shown = document(page);
  CHECK(shown["robot"]["name"] == "rk");
  REQUIRE(shown["motions"].size() == 1);
  const Json& motion = shown["motions"][0];
  REQUIRE(motion["runs"].size() == 1);
  const Json& frames = motion["runs"][0]["frames"];
  CHECK_FALSE(motion["runs"][0].contains("curves"));
  auto expected = columns(answers);
  const auto contacts = columns(walk);
  const Robot robot = load_robot("rk");
  for (const char* foot : {"L", "R"})
    for (std::size_t i = 0; i < expected["utime"].size(); ++i)
      if (std::abs(expected[std::string("fz") + foot][i]) < kNoLoad * robot.weight())
        expected[std::string("sole_cop") + foot][i] = NAN; // without load there is none
  for (const auto& [name, column] : std::map<std::string, std::string>{{"tau_left_knee", "tau_left_knee"},
                                                                       {"tau_right_ankle", "tau_right_ankle"},
                                                                       {"fxL", "fxL"},
                                                                       {"fzR", "fzR"},
                                                                       {"copL", "sole_copL"},
                                                                       {"copR", "sole_copR"},
                                                                       {"flags", "flags"},
                                                                       {"contact_residual", "contact_residual"}})
  {
    CAPTURE(name);
    CHECK(difference(floats(frames[name]), expected[column]) == "");
  }
  const std::vector<double> times = decoded<double>(motion["time"].get<std::string>());
  CHECK(times.front() == 0.0);
  CHECK(mismatch(times.back(), 1e-6 * (expected["utime"].back() - expected["utime"].front()), 1e-12) == "");

  // every link's frame, from the file's own coordinates
  const std::vector<float> poses = floats(motion["poses"]);
  REQUIRE(poses.size() == 3 * 7 * times.size());
  const Trajectory trajectory = parse_trajectory(read_file(walk), walk, coordinate_names(robot), false, Channels());
  for (const std::size_t i : {0U, 33U, 84U})
    for (const Link& link : robot.links)
    {
      const desired_state_t& state = trajectory.states[i];
      VectorQ q(9);
      for (int k = 0; k < 7; ++k)
        q(k) = state.q[static_cast<std::size_t>(k)];
      q.tail<2>() << state.base_q[0], state.base_q[1];
      const Kinematics now = kinematics(robot.mechanism, q, VectorQ::Zero(9));
      const auto at = 3 * (7 * i + static_cast<std::size_t>(&link - robot.links.data()));
      const Eigen::Vector3d found(poses[at], poses[at + 1], poses[at + 2]);
      Eigen::Vector3d right;
      right << position(now, link.origin), q(link.coordinate);
      CHECK(mismatch(found, right, 1e-6) == ""); // 32-bit numbers
    }
}

TEST_CASE("a page's document names flags by bit, contacts by number, and the curves of its runs", "[report]")
{
  const TemporaryFolder folder;
  const std::string page = folder.file("walk.html");
  REQUIRE(run({"report", kWalk, "--robot", "human-subject01", "--to", "0.1", "-o", page}).code == 0);
  const Json shown = document(page);
  REQUIRE(shown["flags"].size() == 13);
  for (std::size_t bit = 0; bit < shown["flags"].size(); ++bit)
    CHECK(std::vector{shown["flags"][bit].get<std::string>()} == flag_names(1 << bit));
  CHECK(shown["contacts"] == Json{"none", "heel", "sole", "toe"});

  std::set<std::string> plotted;
  for (const Json& section : shown["sections"])
    for (const Json& curve : section["curves"])
      CHECK(plotted.insert(curve["name"]).second);
  std::set<std::string> columns{"compute_us", "delay_us"}; // of logs alone
  for (const char* coordinate : {"q0", "q1", "q2", "q3", "q4", "q5", "q6", "xH", "zH"})
    columns.insert(std::string("a_") + coordinate); // of motions that were moved
  for (const auto& [name, values] : shown["motions"][0]["runs"][0]["frames"].items())
    if (name != "flags")
      columns.insert(name);
  CHECK(plotted == columns);

  // from the hip down, left before right, with the motor's limits
  const Json& torques = shown["sections"][0]["curves"];
  REQUIRE(torques.size() == 6);
  CHECK(torques[0] == Json{{"name", "tau_left_hip"},
                           {"title", "left hip"},
                           {"unit", "N m"},
                           {"side", "left"},
                           {"group", "hip"},
                           {"bounds", Json::array()}});
  CHECK(torques[3]["title"] == "right knee");
  CHECK(torques[4]["title"] == "left ankle");
  const Json bounded = Json::parse(live_document(load_robot("ck")))["sections"][0]["curves"][1];
  CHECK(bounded["title"] == "right hip");
  CHECK(bounded["bounds"] == Json{150.0, -150.0});
  // a motor along a slide has a force
  const Json of_slide = Json::parse(live_document(load_robot("bip-itlag")))["sections"][0]["curves"][4];
  CHECK(of_slide["name"] == "tau_r");
  CHECK(of_slide["unit"] == "N");
  const Json sole = shown["sections"][1]["curves"][4];
  const Robot robot = load_robot("human-subject01");
  const Foot& foot = robot.foot(Side::left);
  CHECK(sole["title"] == "left foot: centre of pressure");
  CHECK(sole["bounds"] == Json{foot.heel_x(), foot.toe_x()});
}

TEST_CASE("a page shows the accelerations that were answered beside those that were asked for, where any differ",
          "[report]")
{
  const TemporaryFolder folder;
  const Robot robot = load_robot("ck");
  const std::string gait = folder.file("gait.csv"), log = folder.file("walk.lcm"), page = folder.file("walk.html"),
                    answers = folder.file("answers.csv"),
                    config = folder.write("c.toml", GENERATE("project = true", "infeasible = \"nearest\""));
  const bool relative = GENERATE(false, true);
  CAPTURE(read_file(config), relative);
  REQUIRE(run({"gait", "--robot", "ck", "-o", gait, "--steps", "1", "--rate", "50"}).code == 0);
  Trajectory motion = parse_trajectory(read_file(gait), gait, coordinate_names(robot), false, Channels());
  std::vector<std::vector<double>> asked(7);
  LogWriter writer(log);
  std::vector<std::byte> buffer;
  for (desired_state_t& state : motion.states)
  {
    for (std::size_t k = 0; k < 7; ++k)
    {
      state.a[k] += 3.0 * std::sin(static_cast<double>(state.utime) / 1e5 + static_cast<double>(k));
      asked[k].push_back(state.a[k]);
    }
    if (relative)
    {
      state.base = desired_state_t::FROM_CONTACT;
      state.coordinates = desired_state_t::RELATIVE;
      for (std::vector<double>* numbers : {&state.q, &state.v, &state.a})
      {
        Eigen::Map<Eigen::VectorXd> angles(numbers->data(), 7);
        angles = (robot.A * angles + (numbers == &state.q ? robot.b : VectorQ(0.0 * robot.b))).eval();
      }
    }
    writer.write("TORQUED_DESIRED", state.utime, encode(state, buffer));
  }
  writer.close();
  REQUIRE(run({"eval", log, "--robot", "ck", "--config", config, "-o", answers}).code == 0);
  REQUIRE(run({"report", log, "--robot", "ck", "--config", config, "-o", page}).code == 0);
  const Json shown = document(page);
  const Json& moved = shown["motions"][0];
  auto expected = columns(answers);
  for (std::size_t k = 0; k < 7; ++k)
  {
    CAPTURE(k);
    const std::string name = fmt::format("a_q{}", k);
    Eigen::VectorXd answered = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(asked[k].size()));
    for (Eigen::Index i = 0; i < answered.size(); ++i)
      for (Eigen::Index j = 0; j < 7; ++j)
        answered(i) +=
            relative
                ? robot.A_inverse(static_cast<Eigen::Index>(k), j) *
                      expected["a_" + robot.relative_names[static_cast<std::size_t>(j)]][static_cast<std::size_t>(i)]
                : (j == static_cast<Eigen::Index>(k) ? expected[name][static_cast<std::size_t>(i)] : 0.0);
    const auto mapped = [](const std::vector<float>& values)
    {
      return Eigen::VectorXd(
          Eigen::Map<const Eigen::VectorXf>(values.data(), static_cast<Eigen::Index>(values.size())).cast<double>());
    };
    CHECK(mismatch(mapped(floats(moved["runs"][0]["frames"][name])), answered, 1e-6) == "");
    const std::vector<float> on_page = floats(moved["asked"]["frames"][name]);
    CHECK(mismatch(mapped(on_page),
                   Eigen::Map<const Eigen::VectorXd>(asked[k].data(), static_cast<Eigen::Index>(asked[k].size())),
                   1e-6) == "");
    if (k < 6) // the trunk may be left alone
      CHECK(mismatch(mapped(on_page), answered, 0.01) != "");
  }
  // legs are beside each other, and shaded where the foot is on the ground
  const Json& section = shown["sections"][2];
  CHECK(section["title"] == "Accelerations, answered and asked for");
  CHECK(section["curves"][3] == Json{{"name", "a_q4"},
                                     {"title", "right shin (q4)"},
                                     {"unit", "rad/s²"},
                                     {"side", "right"},
                                     {"group", "a_shin"},
                                     {"bounds", Json::array()}});
  CHECK(section["curves"][2]["name"] == "a_q1");
  CHECK(section["curves"][6]["title"] == "trunk (q6)");
  CHECK(section["curves"][8]["title"] == "base point upward (zH)");
  CHECK(section["curves"][8]["unit"] == "m/s²");
  CHECK(difference(floats(moved["runs"][0]["frames"]["a_zH"]), expected["a_zH"]) == "");
  // a base that follows from contact is not asked for
  CHECK(difference(floats(moved["asked"]["frames"]["a_zH"]),
                   relative ? std::vector<double>(asked[0].size(), NAN) : expected["ddzH"]) == "");

  // what is answered as it was asked for has no such curves
  REQUIRE(run({"report", gait, "--config", config, "-o", page}).code == 0);
  const Json still = document(page)["motions"][0];
  CHECK_FALSE(still.contains("asked"));
  CHECK_FALSE(still["runs"][0]["frames"].contains("a_q0"));
}

TEST_CASE("the figures of a page are those of compare", "[report]")
{
  const TemporaryFolder folder;
  const std::string page = folder.file("walk.html"), json = folder.file("compare.json");
  REQUIRE(run({"compare", kWalk, "--robot", "human-subject01", "--json", json}).code == 0);
  REQUIRE(run({"report", kWalk, "--robot", "human-subject01", "--method", "human-transition", "--method", "constrained",
               "-o", page})
              .code == 0);
  const Json compared = Json::parse(read_file(json));
  const Json runs = document(page)["motions"][0]["runs"];
  REQUIRE(runs.size() == 2);
  for (const Json& shown : runs)
  {
    CAPTURE(shown["name"]);
    const auto& methods = compared["methods"];
    const auto method =
        std::find_if(methods.begin(), methods.end(), [&](const Json& m) { return m["method"] == shown["name"]; });
    REQUIRE(method != methods.end());
    const Json& figures = shown["figures"];
    for (const char* name : {"answered", "peak", "effort", "jumps", "double_support", "held"})
      CHECK(figures[name] == (*method)[name]);
    REQUIRE(figures["measured"].size() == (*method)["measured"].size());
    std::set<std::string> titles;
    for (std::size_t i = 0; i < figures["measured"].size(); ++i)
    {
      const Json& measured = figures["measured"][i];
      CHECK(measured["rms"] == (*method)["measured"][i]["whole"]["rms"]);
      titles.insert(measured["title"].get<std::string>() + ", " + measured["unit"].get<std::string>());
    }
    // both feet under one title
    CHECK(titles ==
          std::set<std::string>{"forward force, N", "upward force, N", "ankle, N m", "knee, N m", "hip, N m"});
    // 2.2 s at 1.13 m/s, the belt's speed
    CHECK(mismatch(figures["distance"].get<double>(), 2.23 * 1.1314, 0.1) == "");
  }
}

TEST_CASE("a log is shown as it was answered, beside what was measured in the motion that was sent", "[report]")
{
  const TemporaryFolder folder;
  const std::string log = folder.file("walk.lcm"), page = folder.file("walk.html"),
                    answers = folder.file("answers.csv");
  REQUIRE(run({"eval", kWalk, "--robot", "human-subject01", "--method", "linear-transition", "-o", log}).code == 0);
  REQUIRE(run({"export", log, "-o", answers}).code == 0);
  // the robot is the one that the log says; the motion begins somewhere in the CSV
  const Run report = run({"report", log, "--measured", kWalk, "--from", "0.5", "--to", "1.5", "-o", page});
  CAPTURE(report.err);
  REQUIRE(report.code == 0);
  CHECK(report.err == "");
  const Json motion = document(page)["motions"][0];
  CHECK(motion["samples"] == 201);
  CHECK(motion["runs"][0]["name"] == "as recorded, linear-transition");

  const auto part = [](const std::vector<double>& values)
  {
    return std::vector<double>(values.begin() + 100, values.begin() + 301);
  };
  CHECK(difference(floats(motion["runs"][0]["frames"]["tau_left_hip"]), part(columns(answers)["tau_left_hip"])) == "");
  const auto measured = columns(kWalk);
  const Json& plates = motion["plates"]["frames"];
  CHECK(difference(floats(plates["fzL"]), part(measured.at("FzL"))) == "");
  CHECK(difference(floats(plates["fxR"]), part(measured.at("FxR"))) == "");
  CHECK(difference(floats(motion["published"]["frames"]["tau_left_knee"]),
                   [&]
                   {
                     std::vector<double> values = part(measured.at("pub_kneeL"));
                     for (double& value : values)
                       value = -value;
                     return values;
                   }()) == "");
  // The file has the pressure's place on the ground; along the level sole it is as far from the ankle. While the foot
  // is pitched less than 0.1 rad its line leaves the ground by less than a centimetre under the sole.
  const std::vector<float> cop = floats(plates["copR"]), poses = floats(motion["poses"]);
  const Robot robot = load_robot("human-subject01");
  const auto foot = static_cast<std::size_t>(robot.foot(Side::right).link);
  const std::vector<double> on_ground = part(measured.at("copR"));
  int compared = 0;
  for (std::size_t i = 0; i < cop.size(); ++i)
  {
    const float* pose = &poses[3 * (robot.links.size() * i + foot)];
    if (std::abs(pose[2]) > 0.1 || std::isnan(cop[i]) || std::isnan(on_ground[i]))
      continue;
    CHECK(mismatch(pose[0] + cop[i], on_ground[i], 0.02) == "");
    ++compared;
  }
  CHECK(compared > 50);
}

TEST_CASE("what was not answered is a gap in the curves, and is counted", "[report]")
{
  const TemporaryFolder folder;
  std::string text = read_file(kWalk);
  const std::string log = folder.file("walk.lcm"), cut = folder.file("cut.lcm"), page = folder.file("walk.html");
  REQUIRE(run({"eval", kWalk, "--robot", "human-subject01", "-o", log}).code == 0);
  const std::string bytes = read_file(log);
  LogReader reader(bytes);
  LogWriter writer(cut);
  std::vector<std::byte> buffer;
  int commands = 0;
  while (const auto record = reader.next())
  {
    const bool answer = record->channel == "TORQUED_COMMAND";
    const int number = answer ? commands++ : -1;
    torque_command_t command;
    if (answer)
      REQUIRE(decode(record->data, command));
    rejection_t rejection{};
    rejection.utime = command.utime;
    rejection.stream_id = command.stream_id;
    rejection.reason = 8;
    if (number == 20)
      writer.write("TORQUED_REJECTED", record->timestamp, encode(rejection, buffer));
    else if (number != 10)
      writer.write(std::string(record->channel), record->timestamp, record->data);
  }
  writer.close();
  const Run report = run({"report", cut, "-o", page});
  CAPTURE(report.err);
  REQUIRE(report.code == 0);
  const Json shown = document(page)["motions"][0]["runs"][0];
  const std::vector<float> torque = floats(shown["frames"]["tau_left_hip"]);
  for (std::size_t i = 0; i < torque.size(); ++i)
    CHECK(std::isnan(torque[i]) == (i == 10 || i == 20));
  CHECK(shown["figures"]["answered"] == 445);
  CHECK(shown["figures"]["unanswered"] == Json{{"NO_ANSWER", 1}, {"STALE", 1}});
}

TEST_CASE("a page of a long motion loses no peak and no flag", "[report]")
{
  const Robot robot = load_robot("ck");
  const Resolution resolution{.frames = 3600, .stretches = 2000};
  const std::size_t count = 3 * resolution.frames + 17;
  ReportMotion motion;
  motion.source = "long.lcm";
  DesiredState state{};
  state.support = {{Contact::sole, Contact::none}, Side::left, 0.0, 0.0};
  state.q = state.v = state.a = VectorQ::Zero(robot.mechanism.num_q());
  Answer quiet{};
  quiet.torque = VectorJ::Zero(6);
  ReportRun answered;
  answered.name = "made up";
  for (std::size_t i = 0; i < count; ++i)
  {
    state.utime = 1000 * static_cast<std::int64_t>(i);
    motion.states.push_back(state);
    answered.answers.emplace_back(quiet);
  }
  const std::size_t peak = 5001; // no frame: those are 0, 4, 8, …
  (*answered.answers[peak]).torque(2) = 77.0;
  (*answered.answers[peak + 1]).torque(2) = -55.0;
  (*answered.answers[peak]).flags = flag::tips;
  for (std::size_t i = 900; i < 990; ++i)
    answered.answers[i].reset();
  motion.runs.push_back(answered);

  const std::string text = report_document(robot, {motion}, resolution);
  CHECK(text.size() < 20'000'000 / 10); // a tenth of what a page has at most, whatever the number of samples
  const Json shown = Json::parse(text)["motions"][0];
  const std::vector<double> times = decoded<double>(shown["time"].get<std::string>());
  CHECK(times.size() <= resolution.frames);
  CHECK(times.size() > resolution.frames / 2);
  const Json& run = shown["runs"][0];
  const std::vector<float> curve = floats(run["curves"]["tau_left_hip"]);
  const std::vector<double> curve_times = decoded<double>(shown["curve_time"].get<std::string>());
  REQUIRE(curve.size() == curve_times.size());
  CHECK(curve.size() <= 2 * resolution.stretches);
  CHECK(std::is_sorted(curve_times.begin(), curve_times.end()));
  const auto highest =
      std::max_element(curve.begin(), curve.end(), [](float a, float b) { return !(a >= b) && !std::isnan(b); });
  REQUIRE(*highest == 77.0F);
  CHECK(*std::next(highest) == -55.0F); // in the order in which they come
  const double stretch = 0.001 * static_cast<double>(count) / static_cast<double>(resolution.stretches);
  CHECK(mismatch(curve_times[static_cast<std::size_t>(highest - curve.begin())], 0.001 * peak, 1.1 * stretch) == "");
  CHECK(std::count_if(curve.begin(), curve.end(), [](float v) { return std::isnan(v); }) > 0);
  const std::vector<float> flags = floats(run["frames"]["flags"]);
  CHECK(std::count(flags.begin(), flags.end(), 4.0F) == 1);
  CHECK(run["figures"]["peak"] == 77.0);
  CHECK(run["figures"]["flags"] == Json{{"TIPS", 1}});
  CHECK(run["figures"]["answered"] == count - 90);
}

TEST_CASE("several files are laid over one another", "[report]")
{
  const TemporaryFolder folder;
  const std::string ck = folder.file("slow.csv"), other = folder.file("fast.csv"), page = folder.file("both.html");
  REQUIRE(run({"gait", "--robot", "ck", "-o", ck, "--steps", "1", "--rate", "50"}).code == 0);
  REQUIRE(run({"gait", "--robot", "ck", "-o", other, "--steps", "1", "--rate", "50", "--step-time", "0.6"}).code == 0);
  REQUIRE(run({"report", ck, other, "--method", "constrained", "-o", page}).code == 0);
  const Json shown = document(page)["motions"];
  REQUIRE(shown.size() == 2);
  CHECK(shown[0]["runs"][0]["name"] == "slow: constrained");
  CHECK(shown[1]["runs"][0]["name"] == "fast: constrained");
}

TEST_CASE("a file's name cannot break the page", "[report]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("<!--<script>&{{library}}.csv"), page = folder.file("walk.html");
  REQUIRE(run({"gait", "--robot", "ck", "-o", walk, "--steps", "1", "--rate", "50"}).code == 0);
  REQUIRE(run({"report", walk, "-o", page}).code == 0);
  const std::string text = read_file(page);
  CHECK(text.find("<!--") == std::string::npos);
  CHECK(text.find("<h1>&lt;!--&lt;script&gt;&amp;{{library}}.csv – ck</h1>") != std::string::npos);
  CHECK(document(page)["motions"][0]["source"] == "<!--<script>&{{library}}.csv");
}

TEST_CASE("a page needs nothing from elsewhere", "[report]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("walk.csv"), page = folder.file("walk.html");
  REQUIRE(run({"gait", "--robot", "ck", "-o", walk, "--steps", "1", "--rate", "50"}).code == 0);
  REQUIRE(run({"report", walk, "-o", page}).code == 0);
  const std::string text = read_file(page);
  for (const char* reference : {"src=", "href=\"http", "@import", "url(", "sourceMappingURL"})
  {
    CAPTURE(reference);
    const std::string head = text.substr(0, text.find("id=\"report\""));
    CHECK(head.find(reference) == std::string::npos);
  }
  CHECK(text.find("sourceMappingURL") == std::string::npos);
}

TEST_CASE("report says what it cannot show", "[report]")
{
  const TemporaryFolder folder;
  const std::string page = folder.file("page.html"), walk = folder.file("walk.csv"), log = folder.file("walk.lcm");
  REQUIRE(run({"gait", "--robot", "ck", "-o", walk, "--steps", "1", "--rate", "50"}).code == 0);
  REQUIRE(run({"eval", walk, "-o", log}).code == 0);
  const auto fails = [&](const std::vector<std::string>& words, int code, const std::string& what)
  {
    const Run found = run(words);
    CAPTURE(what, found.err);
    CHECK(found.code == code);
    CHECK(found.err.find(what) != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(page));
  };
  fails({"report", folder.file("none.csv"), "-o", page}, 65, "none.csv");
  fails({"report", walk}, 64, "--output is required");
  fails({"report", walk, "-o", walk}, 64, "walk.csv");
  fails({"report", walk, "--method", "magic", "-o", page}, 64, "--method: found \"magic\"");
  fails({"report", walk, "--from", "1e", "-o", page}, 64, "--from: found \"1e\"; expected a time in s, 0 or more");
  fails({"report", walk, "--from", "7", "-o", page}, 64,
        "--from 7 --to inf: " + walk + " holds no sample there; expected times between 0 and 0.738 s");
  fails({"report", walk, "--robot", "nobody", "-o", page}, 78, "nobody");
  fails({"report", walk, "--robot", "bip-itlag", "-o", page}, 65, "walk.csv");
  const std::string human = folder.file("human.csv");
  REQUIRE(run({"gait", "--robot", "human-subject01", "-o", human, "--steps", "1", "--rate", "50"}).code == 0);
  fails({"report", human, "--measured", kWalk, "-o", page}, 65,
        "no row has the coordinates of a sample of the motion; expected the CSV that was sent");
  fails({"report", log, "--measured", walk, "-o", page}, 65, "found no column of what was measured");
  fails({"report", walk, "-o", "/nowhere/page.html"}, 1, "/nowhere/page.html");

  // a log that does not say its robot: recorded too late for the model, which comes every two seconds
  const std::string bytes = read_file(log);
  LogReader reader(bytes);
  LogWriter writer(folder.file("nameless.lcm"));
  while (const auto record = reader.next())
    if (record->channel != "TORQUED_MODEL")
      writer.write(std::string(record->channel), record->timestamp, record->data);
  writer.close();
  fails({"report", folder.file("nameless.lcm"), "-o", page}, 65,
        "nameless.lcm holds no model_info_t, which would name its robot: say --robot NAME|FILE");
}

} // namespace report_test
