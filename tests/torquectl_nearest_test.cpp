#include "catch.h"
#include "matchers.h"
#include "run_torquectl.h"

#include "motion/lcm_log.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"
#include "robot/files/robot_files.h"
#include "stance/flags.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

namespace torquectl_nearest_test
{

using namespace torqued;

namespace
{

const std::string kMeasured = TRAJECTORIES "/subject01-walk/walk.csv";
// windows choose torques among those that feet and motors can have, and may give way
const std::string kNoWindows = "[constrained]\nwindows = false\n";
const std::string kNearest = "infeasible = \"nearest\"\n";

// a CSV's cells by column
using Table = std::map<std::string, std::vector<std::string>>;
Table table(const std::string& path)
{
  Table result;
  const auto lines = rows(path);
  for (std::size_t i = 1; i < lines.size(); ++i)
    for (std::size_t k = 0; k < lines[0].size(); ++k)
      result[lines[0][k]].push_back(lines[i][k]);
  return result;
}

std::vector<double> numbers(const std::vector<std::string>& cells)
{
  std::vector<double> result;
  for (const std::string& cell : cells)
    result.push_back(std::stod(cell));
  return result;
}

double largest_difference(const std::vector<double>& one, const std::vector<double>& other)
{
  REQUIRE(one.size() == other.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i)
    largest = std::max(largest, std::abs(one[i] - other[i]));
  return largest;
}

// how many rows have any of these flags
std::ptrdiff_t flagged(const Table& answers, std::int32_t bits)
{
  return std::ranges::count_if(answers.at("flags"),
                               [bits](const std::string& flags) { return (std::stoi(flags) & bits) != 0; });
}

// A walk whose accelerations are disturbed in the middle third, beyond what feet and motors can do. rates: by how much
// its rates are, too, so that contacts do not rest, rad/s.
std::vector<desired_state_t> disturbed_walk(const Robot& robot, const TemporaryFolder& folder, double rates = 0.0)
{
  const std::string walk = folder.file("gait.csv");
  REQUIRE(run({"gait", "--robot", robot.name, "--rate", "40", "-o", walk}).code == 0);
  std::vector<desired_state_t> states =
      parse_trajectory(read_file(walk), walk, coordinate_names(robot), false, Channels()).states;
  for (std::size_t i = states.size() / 3; i < 2 * states.size() / 3; ++i)
    for (std::size_t k = 0; k < states[i].a.size(); ++k)
    {
      const double wave = std::sin(0.9 * static_cast<double>(i) + 2.0 * static_cast<double>(k));
      states[i].v[k] += rates * wave;
      states[i].a[k] += 30.0 * wave;
    }
  return states;
}

enum class Coordinates
{
  absolute_with_base,
  absolute,
  relative
};

// The states as a CSV by hand.
std::string text(const Robot& robot, const std::vector<desired_state_t>& states, Coordinates coordinates)
{
  const bool relative = coordinates == Coordinates::relative, base = coordinates == Coordinates::absolute_with_base;
  std::vector<std::string> names = relative ? robot.relative_names : robot.absolute_names;
  if (base)
    names.insert(names.end(), robot.base_names.begin(), robot.base_names.end());
  std::ostringstream csv;
  csv.precision(17);
  csv << "time";
  for (const char* derivative : {"", "d", "dd"})
    for (const std::string& name : names)
      csv << ',' << derivative << name;
  csv << ",contactL,contactR,leading,load_transfer,phase\n";
  for (const desired_state_t& state : states)
  {
    csv << 1e-6 * static_cast<double>(state.utime);
    const auto write = [&](const std::vector<double>& angles, const double* of_base, bool position)
    {
      VectorQ in_columns = Eigen::Map<const Eigen::VectorXd>(angles.data(), robot.num_coordinates());
      if (relative)
        in_columns = (robot.A * in_columns + (position ? robot.b : VectorQ(0.0 * robot.b))).eval();
      for (const double number : in_columns)
        csv << ',' << number;
      if (base)
        csv << ',' << of_base[0] << ',' << of_base[1];
    };
    write(state.q, state.base_q, true);
    write(state.v, state.base_v, false);
    write(state.a, state.base_a, false);
    csv << ',' << int{state.left_contact} << ',' << int{state.right_contact} << ','
        << (state.leading_foot == desired_state_t::LEFT ? 'L' : 'R') << ',' << state.load_transfer << ',' << state.phase
        << '\n';
  }
  return csv.str();
}

// A number of the report, by the words before it.
double reported(const std::string& report, const std::string& what)
{
  const std::size_t line = report.find("\n  " + what + "  ");
  CAPTURE(report, what);
  REQUIRE(line != std::string::npos);
  return std::stod(report.substr(line + what.size() + 3));
}

} // namespace

TEST_CASE("what nearest writes can be had: it is answered as it is, by the same torques", "[torquectl_nearest]")
{
  const TemporaryFolder folder;
  const std::string name = GENERATE("ck", "rk");
  const auto coordinates = GENERATE(Coordinates::absolute_with_base, Coordinates::absolute, Coordinates::relative);
  const std::string settings = GENERATE("", "[nearest]\nmetric = \"angles\"\nmargin = 0.005\n");
  const Robot robot = load_robot(name);
  CAPTURE(name, static_cast<int>(coordinates), settings);
  const std::string asked = folder.write("asked.csv", text(robot, disturbed_walk(robot, folder), coordinates)),
                    feasible = folder.file("feasible.csv"), answers = folder.file("answers.csv"),
                    again = folder.file("again.csv"), config = folder.write("c.toml", kNearest + kNoWindows + settings);
  const Run done = run({"nearest", asked, "--robot", name, "--config", config, "-o", feasible});
  CAPTURE(done.out);
  REQUIRE(done.err == "");
  REQUIRE(done.code == 0);
  REQUIRE(run({"eval", asked, "--robot", name, "--config", config, "-o", answers}).code == 0);
  REQUIRE(run({"eval", feasible, "--config", config, "-o", again}).code == 0);
  const Table before = table(asked), after = table(feasible), was = table(answers), now = table(again);

  // all but the accelerations is as it was, and they are those that eval has
  const bool relative = coordinates == Coordinates::relative;
  std::vector<std::string> moved = relative ? robot.relative_names : robot.absolute_names;
  if (coordinates == Coordinates::absolute_with_base)
    moved.insert(moved.end(), robot.base_names.begin(), robot.base_names.end());
  for (const auto& [column, cells] : before)
  {
    CAPTURE(column);
    if (column == "leading")
      CHECK(after.at(column) == cells);
    else if (!column.starts_with("dd"))
      CHECK(numbers(after.at(column)) == numbers(cells));
  }
  for (const std::string& coordinate : moved)
    CHECK(after.at("dd" + coordinate) == was.at("a_" + coordinate));
  CHECK(after.size() == before.size() + 2); // utime and method
  CHECK(std::ranges::count(after.at("method"), "default") == static_cast<std::ptrdiff_t>(after.at("method").size()));

  // it had to be moved, and need not be moved again
  CHECK(flagged(was, flag::adjusted) > 5);
  CHECK(flagged(was, flag::adjusted) < static_cast<std::ptrdiff_t>(was.at("flags").size()));
  CHECK(flagged(was, flag::relaxed) == 0);
  CHECK(flagged(now, flag::slips | flag::lifts | flag::tips | flag::relaxed | flag::over_torque) == 0);
  if (settings.empty()) // constrained by itself keeps no margin
    CHECK(flagged(now, flag::adjusted) == 0);
  const std::vector<double> adjustments = numbers(now.at("adjustment"));
  CHECK(*std::ranges::max_element(adjustments) < 1e-9);
  for (const auto& [column, cells] : was)
    if (column.starts_with("tau_"))
    {
      CAPTURE(column);
      CHECK(largest_difference(numbers(now.at(column)), numbers(cells)) < 1e-6); // largest: 150
    }
}

TEST_CASE("nearest says how many samples it moved, and how far", "[torquectl_nearest]")
{
  const TemporaryFolder folder;
  const Robot robot = load_robot("ck");
  const auto coordinates = GENERATE(Coordinates::absolute_with_base, Coordinates::relative);
  const std::string asked = folder.write("asked.csv", text(robot, disturbed_walk(robot, folder), coordinates)),
                    feasible = folder.file("feasible.csv");
  const Run done = run({"nearest", asked, "--robot", "ck", "-o", feasible});
  REQUIRE(done.code == 0);
  const Table before = table(asked), after = table(feasible);
  double largest = 0.0, squares = 0.0;
  std::string where;
  std::vector<bool> moved(before.at("time").size(), false);
  for (const std::string& name : coordinates == Coordinates::relative ? robot.relative_names : robot.absolute_names)
    for (std::size_t i = 0; i < moved.size(); ++i)
    {
      const double change = std::stod(after.at("dd" + name)[i]) - std::stod(before.at("dd" + name)[i]);
      moved[i] = moved[i] || std::abs(change) > 1e-9;
      squares += change * change;
      if (std::abs(change) > largest)
        where = fmt::format("({}, {} s, {}:{})", name, std::stod(before.at("time")[i]), asked, i + 2);
      largest = std::max(largest, std::abs(change));
    }
  const auto count = std::ranges::count(moved, true);
  CAPTURE(done.out);
  CHECK(
      done.out.starts_with(fmt::format("ck: {0} of {0} samples answered, 0 rejected\nflags: ADJUSTED ", moved.size())));
  CHECK(done.out.find(fmt::format("\naccelerations were moved in {} of {} samples, by up to\n", count, moved.size())) !=
        std::string::npos);
  CHECK(mismatch(reported(done.out, "coordinates"), largest, 1e-3) == "");
  CHECK(done.out.find(where) != std::string::npos);
  CHECK(done.out.find(fmt::format(", rms {:.4g}\n", std::sqrt(squares / (7.0 * static_cast<double>(moved.size()))))) !=
        std::string::npos);
  if (coordinates == Coordinates::relative)
    CHECK(done.out.find("base point") == std::string::npos);
  else
    CHECK(reported(done.out, "base point") > 0.0);

  // a walk that can be had stays as it is
  const std::string walk = folder.file("gait.csv");
  const Run idle = run({"nearest", walk, "-o", feasible});
  CHECK(idle.out.ends_with("samples answered, 0 rejected\nno acceleration was moved\n"));
  CHECK(table(feasible).at("ddq3") == table(walk).at("ddq3"));
}

TEST_CASE("of a measured walk nearest moves those samples whose pressure leaves the sole", "[torquectl_nearest]")
{
  const TemporaryFolder folder;
  const std::string feasible = folder.file("feasible.csv"), again = folder.file("again.csv"),
                    config = folder.write("c.toml", kNearest + kNoWindows + "[nearest]\ncontacts = \"as-desired\"\n");
  const Run done = run({"nearest", kMeasured, "--config", config, "-o", feasible});
  CAPTURE(done.out);
  REQUIRE(done.code == 0);
  REQUIRE(run({"eval", feasible, "--config", config, "-o", again}).code == 0);
  // those in single support; in double support other reactions are enough
  CHECK(done.out.find("\naccelerations were moved in 17 of 447 samples, by up to\n") != std::string::npos);
  const Table before = table(kMeasured), after = table(feasible), now = table(again);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < 447; ++i)
    if (std::abs(std::stod(after.at("ddq6")[i]) - std::stod(before.at("ddq6")[i])) > 1e-9)
    {
      ++moved;
      CHECK((before.at("contactL")[i] == "0" || before.at("contactR")[i] == "0"));
    }
  CHECK(moved == 17);
  CHECK(flagged(now, flag::adjusted | flag::slips | flag::lifts | flag::tips | flag::relaxed) == 0);
}

TEST_CASE("torque-rate limits hold from one sample to the next", "[torquectl_nearest]")
{
  const TemporaryFolder folder;
  std::string toml(shipped_robot_toml("ck"));
  for (std::size_t at = 0; (at = toml.find("torque_limit", at)) != std::string::npos; at += 20)
    toml.insert(at, "rate_limit = 400.0\n");
  const std::string slow = folder.write("slow.toml", toml),
                    config = folder.write("c.toml", kNearest + "rate_limits = \"clamp\"\n" + kNoWindows),
                    feasible = folder.file("feasible.csv"), answers = folder.file("answers.csv");
  const std::string asked = folder.write(
      "asked.csv", text(load_robot("ck"), disturbed_walk(load_robot("ck"), folder), Coordinates::absolute));
  REQUIRE(run({"nearest", asked, "--robot", slow, "--config", config, "-o", feasible}).code == 0);
  REQUIRE(run({"eval", asked, "--robot", slow, "--config", config, "-o", answers}).code == 0);
  CHECK(table(feasible).at("ddq1") == table(answers).at("a_q1"));
  const auto answered = table(answers);
  CHECK(flagged(answered, flag::over_rate | flag::over_torque | flag::clamped) == 0);
  for (const std::string& residual : answered.at("dynamics_residual"))
    CHECK(std::stod(residual) < 1e-9);
  REQUIRE(run({"nearest", asked, "--robot", slow, "-o", answers}).code == 0);
  CHECK(table(feasible).at("ddq1") != table(answers).at("ddq1"));
}

TEST_CASE("a link without mass or inertia has a nearest motion by angles, and none by mass", "[torquectl_nearest]")
{
  const TemporaryFolder folder;
  std::string toml(shipped_robot_toml("ck"));
  const std::size_t foot = toml.find("name = \"right_foot\"");
  for (const std::string key : {"\nmass = ", "\ninertia = "})
  {
    const std::size_t number = toml.find(key, foot) + key.size();
    toml.replace(number, toml.find('\n', number) - number, "0.0");
  }
  const std::string light = folder.write("light.toml", toml), out = folder.file("out.csv");
  const std::string asked = folder.write(
      "asked.csv", text(load_robot("ck"), disturbed_walk(load_robot("ck"), folder), Coordinates::absolute));
  const Run by_mass = run({"nearest", asked, "--robot", light, "-o", out});
  CAPTURE(by_mass.out);
  CHECK(by_mass.out.find("a link of ck can move without mass or inertia, so that M does not tell accelerations apart; "
                         "expected mass or inertia, or [nearest] metric = \"angles\"") != std::string::npos);
  const Run by_angles = run({"nearest", asked, "--robot", light, "--metric", "angles", "-o", out});
  CHECK(by_angles.code == 0);
  CHECK(by_angles.out.find(" 0 rejected\n") != std::string::npos);
}

TEST_CASE("settings of the nearest motion are those of the configuration, or of options", "[torquectl_nearest]")
{
  const TemporaryFolder folder;
  const Robot robot = load_robot("ck");
  const std::string asked =
      folder.write("asked.csv", text(robot, disturbed_walk(robot, folder), Coordinates::absolute));
  const auto written = [&](const std::vector<std::string>& more)
  {
    std::vector<std::string> words{"nearest", asked, "--robot", "ck", "-o", folder.file("o.csv")};
    words.insert(words.end(), more.begin(), more.end());
    const Run done = run(words);
    CAPTURE(done.err);
    REQUIRE(done.code == 0);
    return read_file(folder.file("o.csv"));
  };
  const std::string plain = written({});
  for (const auto& [option, value, line] :
       std::vector<std::array<std::string, 3>>{{"--metric", "angles", "metric = \"angles\""},
                                               {"--contacts", "as-desired", "contacts = \"as-desired\""},
                                               {"--contact-damping", "20", "contact_damping = 20"},
                                               {"--margin", "0.01", "margin = 0.01"}})
  {
    CAPTURE(option);
    const std::string by_option = written({option, value});
    CHECK(by_option == written({"--config", folder.write("c.toml", "[nearest]\n" + line)}));
    CHECK(by_option != plain);
  }
  CHECK(written({"--metric", "mass", "--config", folder.write("c.toml", "[nearest]\nmetric = \"angles\"")}) == plain);
  // whatever the configuration says of motions that cannot be had
  CHECK(written({"--config", folder.write("c.toml", "infeasible = \"refuse\"")}) == plain);
}

TEST_CASE("what nearest cannot answer keeps its accelerations, and is told", "[torquectl_nearest]")
{
  const TemporaryFolder folder;
  const Robot robot = load_robot("ck");
  std::vector<desired_state_t> states = disturbed_walk(robot, folder);
  states.resize(4);
  states[1].left_contact = states[1].right_contact = 0; // in the air, where only the file could say where
  const std::string asked = folder.write("asked.csv", text(robot, states, Coordinates::absolute)),
                    out = folder.file("o.csv");
  const Run some = run({"nearest", asked, "--robot", "ck", "-o", out});
  CHECK(some.code == 0);
  CAPTURE(some.out);
  CHECK(some.out.starts_with("ck: 3 of 4 samples answered, 1 rejected: NOT_SUPPORTED 1\n"));
  CHECK(some.out.find(fmt::format("  NOT_SUPPORTED, first: {}:3: ", asked)) != std::string::npos);
  CHECK(some.out.ends_with("rejected samples have the accelerations that were asked for\n"));
  CHECK(table(out).at("time").size() == 4);
  CHECK(std::stod(table(out).at("ddq2")[1]) == std::stod(table(asked).at("ddq2")[1]));

  states = {states[1]};
  std::filesystem::remove(out);
  const Run none =
      run({"nearest", folder.write("air.csv", text(robot, states, Coordinates::absolute)), "--robot", "ck", "-o", out});
  CHECK(none.code == 65);
  CHECK(none.err.find("air.csv: no sample was answered: 1 rejected: NOT_SUPPORTED 1; the first: ") !=
        std::string::npos);
  CHECK_FALSE(std::filesystem::exists(out));
}

TEST_CASE("nearest says what it cannot use", "[torquectl_nearest]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("walk.csv"), out = folder.file("out.csv");
  REQUIRE(run({"gait", "--robot", "ck", "--steps", "1", "--rate", "20", "-o", walk}).code == 0);
  const auto says = [](const std::vector<std::string>& words)
  {
    const Run done = run(words);
    return fmt::format("{} {}", done.code, done.err);
  };
  CHECK(
      says({"nearest", walk, "-o", folder.file("out.lcm")}) ==
      fmt::format("64 torquectl: -o: found \"{}\"; expected a name that ends in .csv, or -\n", folder.file("out.lcm")));
  CHECK(says({"nearest", walk, "-o", walk}).starts_with("64 torquectl: "));
  CHECK(says({"nearest", walk, "--metric", "feet", "-o", out}) ==
        "64 torquectl: --metric: found \"feet\"; expected one of: mass, angles\n");
  CHECK(says({"nearest", walk, "--margin", "-0.01", "-o", out}) ==
        "64 torquectl: --margin: found \"-0.01\"; expected a number that is not negative\n");
  CHECK(says({"nearest", walk, "--contact-damping", "much", "-o", out}) ==
        "64 torquectl: --contact-damping: found \"much\"; expected a number that is not negative\n");
  CHECK(says({"nearest", walk, "--margin", "0.2", "-o", out})
            .starts_with("64 torquectl: the options do not fit ck: nearest: margin: found 0.2 m; "));
  const std::string config = folder.write("c.toml", "project = true");
  CHECK(says({"nearest", walk, "--config", config, "-o", out}) ==
        fmt::format("78 torquectl: {}: project: found true; expected false, because positions and rates stay as they "
                    "are here: torquectl project moves them\n",
                    config));
  CHECK_FALSE(std::filesystem::exists(out));
  // a log whose base comes and goes would have empty cells
  const std::string mixed = folder.file("mixed.lcm");
  Trajectory states = parse_trajectory(read_file(walk), walk, coordinate_names(load_robot("ck")), false, Channels());
  LogWriter log(mixed);
  std::vector<std::byte> buffer;
  states.states[1].base = desired_state_t::FROM_CONTACT;
  for (const std::size_t i : {0U, 1U})
    log.write("TORQUED_DESIRED", states.states[i].utime, encode(states.states[i], buffer));
  log.close();
  CHECK(says({"nearest", mixed, "--robot", "ck", "-o", out})
            .starts_with(fmt::format("65 torquectl: {}: record 1: base is FROM_CONTACT; expected it GIVEN", mixed)));
  // on the standard output: the table and nothing else
  const Run terminal = run({"nearest", walk, "-o", "-"});
  CHECK(terminal.out.starts_with("utime,time,q0,"));
  CHECK(terminal.out.find("moved") == std::string::npos);
  CHECK(terminal.err.ends_with("no acceleration was moved\n"));
}

} // namespace torquectl_nearest_test
