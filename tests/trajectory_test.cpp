#include "catch.h"

#include "motion/failure.h"
#include "motion/files.h"
#include "motion/lcm_log.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"
#include "study/measured.h"
#include "temporary_folder.h"

#include <algorithm>
#include <array>
#include <clocale>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <locale>
#include <map>
#include <numbers>
#include <set>
#include <span>
#include <sstream>
#include <unistd.h>

namespace trajectory_test
{

using namespace torqued;

namespace
{

// a robot of two angles: enough to see which column goes where
const CoordinateNames kNames{{"p0", "p1"}, {"knee", "p1"}, {"xB", "zB"}};

Trajectory read(const std::string& text, bool differentiate = false, const CoordinateNames& names = kNames)
{
  return parse_trajectory(text, "t.csv", names, differentiate, Channels());
}

std::string complaint(const std::string& text, bool differentiate = false)
{
  try
  {
    read(text, differentiate);
    return "";
  }
  catch (const Failure& failure)
  {
    CHECK(failure.code() == ExitCode::bad_data);
    return failure.what();
  }
}

// one row at 0.5 s; cells override those of the columns named
std::string table(const std::map<std::string, std::string>& cells, const std::set<std::string>& without = {})
{
  std::map<std::string, std::string> row{{"time", "0.5"}, {"p0", "1"},       {"p1", "2"},
                                         {"dp0", "3"},    {"dp1", "4"},      {"ddp0", "5"},
                                         {"ddp1", "6"},   {"contactL", "2"}, {"contactR", "0"}};
  for (const auto& [name, cell] : cells)
    row[name] = cell;
  std::vector<std::string> names, values;
  for (const auto& [name, cell] : row)
    if (!without.contains(name))
    {
      names.push_back(name);
      values.push_back(cell);
    }
  return fmt::format("{}\n{}\n", fmt::join(names, ","), fmt::join(values, ","));
}

desired_state_t only_state(const std::string& text)
{
  const Trajectory trajectory = read(text);
  REQUIRE(trajectory.states.size() == 1);
  return trajectory.states[0];
}

// rows of one motion with these contacts, "20" for the left sole alone, a second apart unless times are given
std::vector<desired_state_t> walk(const std::vector<std::string>& contacts, std::vector<double> times = {})
{
  std::string text = "time,p0,p1,dp0,dp1,ddp0,ddp1,contactL,contactR\n";
  for (std::size_t i = 0; i < contacts.size(); ++i)
    text += fmt::format("{},0,0,0,0,0,0,{},{}\n", times.empty() ? static_cast<double>(i) : times[i], contacts[i][0],
                        contacts[i][1]);
  return read(text).states;
}

// rows at these times with p0 = f(t) and p1 = −2 f(t), to be differentiated
template <typename F> std::vector<desired_state_t> differentiated(const std::vector<double>& times, F f)
{
  std::string text = "time,p0,p1,contactL,contactR\n";
  for (const double t : times)
    text += fmt::format("{},{},{},2,0\n", t, f(t), -2.0 * f(t));
  return read(text, true).states;
}

std::string contents(const std::string& path)
{
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

bool same(const desired_state_t& a, const desired_state_t& b)
{
  std::vector<std::byte> first, second;
  const Bytes x = encode(a, first), y = encode(b, second);
  return std::equal(x.begin(), x.end(), y.begin(), y.end());
}

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";

} // namespace

TEST_CASE("each column of a trajectory reaches its field, in any order and among others", "[trajectory]")
{
  const desired_state_t state =
      only_state("# a comment before the names\n"
                 "contactR,ddp1,note,p1,dp0,time,p0,ddp0,contactL,dp1,leading,load_transfer,phase,"
                 "method,xB,zB,dxB,dzB,ddxB,ddzB\n"
                 "\n"
                 "  # and one between\n"
                 "1,-6e-1,nan,2,+3,-0.25,1,.5,2,4,R,0.75,0.5,linear-transition,7,8,9,10,11,12\n");
  CHECK(state.utime == -250'000);
  CHECK(state.stream_id == 1);
  CHECK(state.model_id == 0);
  CHECK(state.coordinates == desired_state_t::ABSOLUTE);
  CHECK(state.base == desired_state_t::GIVEN);
  CHECK(state.left_contact == desired_state_t::SOLE);
  CHECK(state.right_contact == desired_state_t::HEEL);
  CHECK(state.leading_foot == desired_state_t::RIGHT);
  CHECK(state.method == desired_state_t::LINEAR_TRANSITION);
  CHECK(state.load_transfer == 0.75);
  CHECK(state.phase == 0.5);
  CHECK(state.num_coordinates == 2);
  CHECK(state.q == std::vector{1.0, 2.0});
  CHECK(state.v == std::vector{3.0, 4.0});
  CHECK(state.a == std::vector{0.5, -0.6});
  CHECK((state.base_q[0] == 7.0 && state.base_q[1] == 8.0));
  CHECK((state.base_v[0] == 9.0 && state.base_v[1] == 10.0));
  CHECK((state.base_a[0] == 11.0 && state.base_a[1] == 12.0));
}

TEST_CASE("quotes, spaces, line ends of other systems and a byte order mark change nothing", "[trajectory]")
{
  const desired_state_t plain = only_state(table({}));
  std::string text = table({});
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
    text.insert(at, 1, '\r');
  CHECK(same(only_state(text), plain));
  CHECK(same(only_state("\xef\xbb\xbf" + table({})), plain));
  CHECK(same(only_state(table({{"p0", "  1\t"}, {"p1", "\"2\""}, {"dp0", " \"3\" "}})), plain));
  std::string no_last_line_end = table({});
  no_last_line_end.pop_back();
  CHECK(same(only_state(no_last_line_end), plain));
}

TEST_CASE("a motion is the same however its table is written", "[trajectory]")
{
  const CoordinateNames names = coordinate_names(load_robot("human-subject01"));
  const std::string text = contents(kWalk);
  const std::vector<desired_state_t> plain = read(text, false, names).states;
  const auto check = [&](const std::string& bytes, const std::vector<std::string>& said)
  {
    const Trajectory trajectory = read(bytes, false, names);
    REQUIRE(trajectory.states.size() == plain.size());
    for (std::size_t i = 0; i < plain.size(); ++i)
      REQUIRE(same(trajectory.states[i], plain[i]));
    CHECK(notes(trajectory) == said);
  };
  std::string german = text, utf16 = "\xff\xfe";
  std::replace(german.begin(), german.end(), ',', ';');
  std::replace(german.begin(), german.end(), '.', ',');
  for (const char c : german) // the file is ASCII
    utf16 += {c, '\0'};
  check(text, {});
  check(german, {"t.csv: cells are separated by semicolons, decimals by commas"});
  check(utf16,
        {"t.csv: is UTF-16 text (little-endian)", "t.csv: cells are separated by semicolons, decimals by commas"});
}

TEST_CASE("what was measured is the same however its table is written", "[trajectory]")
{
  const Robot robot = load_robot("human-subject01");
  const std::string text = contents(kWalk);
  std::string german = text;
  std::replace(german.begin(), german.end(), ',', ';');
  std::replace(german.begin(), german.end(), '.', ',');
  const Measured plain = read_measured(text, "t.csv", robot, {}), other = read_measured(german, "t.csv", robot, {});
  const auto same_numbers = [](const std::vector<double>& a, const std::vector<double>& b)
  {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
  };
  for (std::size_t k = 0; k < plain.plates.size(); ++k)
  {
    CHECK(plain.plates[k].size() == 447);
    CHECK(same_numbers(plain.plates[k], other.plates[k]));
  }
  const std::string kilo = "time,FxL (kN),FzL,ML,FxR,FzR,MR [N m]\n0,1,2,3,4,5,6\n";
  CHECK(read_measured(kilo, "t.csv", robot, {}).plates[0] == std::vector{1000.0});
  CHECK_THROWS_WITH(read_measured("time,FxL (lbf)\n0,1\n", "t.csv", robot, {}),
                    "t.csv:1: column FxL: found unit lbf; expected N or kN");
}

TEST_CASE("units are converted, and lengths stay lengths where angles are in degrees", "[trajectory]")
{

  const std::string header = "time,p0,p1,dp0,dp1,ddp0,ddp1,xB,dxB,ddxB,zB,dzB,ddzB,contactL,contactR";
  const std::string text = header + "\n0,180,90,360,18,90,0,1,2,3,4,5,6,2,0\n";
  const double pi = std::numbers::pi;
  const auto check = [&](const Trajectory& trajectory)
  {
    REQUIRE(trajectory.states.size() == 1);
    const desired_state_t& state = trajectory.states[0];
    const double tolerance = 4e-16; // of one product
    for (const auto& [found, expected] : std::vector<std::pair<double, double>>{
             {state.q[0], pi}, {state.q[1], pi / 2}, {state.v[0], 2 * pi}, {state.v[1], pi / 10}, {state.a[0], pi / 2}})
      CHECK_THAT(found, Catch::Matchers::WithinRel(expected, tolerance));
    CHECK((state.base_q[0] == 1.0 && state.base_v[0] == 2.0 && state.base_a[0] == 3.0));
    CHECK((state.base_q[1] == 4.0 && state.base_v[1] == 5.0 && state.base_a[1] == 6.0));
  };
  const Trajectory opensim = read("x\nnRows=2\ninDegrees=yes\nendheader\n" + text);
  check(opensim);
  CHECK(notes(opensim) ==
        std::vector<std::string>{
            "t.csv: its OpenSim header says inDegrees=yes; converted to rad: p0, p1, dp0, dp1, ddp0, ddp1",
            "t.csv: its OpenSim header says nRows=2, but it has 1 rows"});
  check(read("time,p0 (deg),p1 (deg),dp0 (deg/s),dp1 (deg/s),ddp0 (deg/s^2),ddp1 (deg/s^2),xB (m)" +
             text.substr(text.find(",dxB"))));

  // what slides is a length, too
  CoordinateNames sliding = kNames;
  sliding.displacements = {"p1"};
  CHECK(read("x\ninDegrees=yes\nendheader\n" + text, false, sliding).states[0].q[1] == 90.0);
  CHECK(coordinate_names(load_robot("bip-itlag")).displacements == std::set<std::string>{"r"}); // by both names
  CHECK(coordinate_names(load_robot("ck")).displacements.empty());
  model_info_t model = model_info(load_robot("bip-itlag"), 1, 2, "");
  const auto name = std::find(model.relative_names.begin(), model.relative_names.end(), "r");
  REQUIRE(name != model.relative_names.end());
  *name = "s";
  CHECK(coordinate_names(model).displacements == std::set<std::string>{"r", "s"});
}

TEST_CASE("cells and names without anything may be left out at the end of a line", "[trajectory]")
{
  const desired_state_t plain = only_state(table({}));
  const std::string text = table({});
  const std::size_t end = text.find('\n');
  const std::string header = text.substr(0, end), row = text.substr(end + 1, text.size() - end - 2);
  for (const std::string& written : {header + ",\n" + row + ",\n", header + "\n" + row + ",,\n",
                                     header + ",,\n" + row + "\n", header + "\n" + row + "\n,,,,\n"})
    CHECK(same(only_state(written), plain));
}

TEST_CASE("numbers have a decimal point whatever the locale", "[trajectory]")
{
  // the locale of C++ streams with a decimal comma, and that of C where the machine has one
  struct DecimalComma : std::numpunct<char>
  {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "de_DE"})
    std::setlocale(LC_NUMERIC, name);
  const desired_state_t state = only_state(table({{"p0", "0.125"}}));
  std::setlocale(LC_NUMERIC, "C");
  std::locale::global(before);
  CHECK(state.q[0] == 0.125);
}

TEST_CASE("time is in s and rounded to µs, utime is in µs", "[trajectory]")
{
  CHECK(only_state(table({{"time", "0.0000014"}})).utime == 1);
  CHECK(only_state(table({{"time", "0.0000016"}})).utime == 2);
  CHECK(only_state(table({{"time", "1e6"}})).utime == 1'000'000'000'000);
  CHECK(only_state(table({{"utime", "1700000000123456"}}, {"time"})).utime == 1'700'000'000'123'456);
}

TEST_CASE("time and utime may both be there if they are the same but for a constant and rounding", "[trajectory]")
{
  const auto both = [](const std::vector<std::string>& times)
  {
    std::string text = "utime,time,p0,p1,dp0,dp1,ddp0,ddp1,contactL,contactR\n";
    for (const std::string& pair : times)
      text += pair + ",0,0,0,0,0,0,2,0\n";
    return text;
  };
  // one of them counts from the epoch, or from the first row
  for (const std::vector<std::string>& times :
       {std::vector<std::string>{"0,0", "33333,0.0333333333", "66667,0.0666666667"},
        {"1700000000000000,0", "1700000000033333,0.0333333333", "1700000000066667,0.0666666667"},
        {"5,1700000000.0000001", "33338,1700000000.033333", "66671,1700000000.066667"}})
  {
    const Trajectory read_both = read(both(times));
    CHECK(read_both.states[2].utime == std::stoll(times[2]));
    CHECK(read_both.seconds[2] == std::stod(times[2].substr(times[2].find(',') + 1)));
  }
  CHECK(complaint(both({"0,0", "33333,0.033"})) ==
        "t.csv:3: column time: found \"0.033\", 0.033000 s after the first row; expected 0.033333 s after it, as utime "
        "says, or only one of the two columns");
  CHECK(complaint(both({"0,0", "33333,0.0333351"})) != "");
  CHECK(complaint(both({"0,0", "33333,33.333"})) != "");
  // a spline goes through unrounded times
  CHECK(read(table({{"utime", "7"}})).seconds == std::vector<double>{0.5});
  CHECK(read(table({{"utime", "7"}}, {"time"})).seconds.empty());
}

TEST_CASE("contacts, leading foot and methods are accepted in each of their forms", "[trajectory]")
{
  const std::vector<std::string> names{"none", "heel", "sole", "toe"};
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const std::string& form : {names[i], std::to_string(i),
                                    std::string(1, static_cast<char>(std::toupper(names[i][0]))) + names[i].substr(1)})
    {
      CAPTURE(form);
      CHECK(static_cast<std::size_t>(only_state(table({{"contactL", form}})).left_contact) == i);
      CHECK(static_cast<std::size_t>(only_state(table({{"contactR", form}})).right_contact) == i);
    }
  CHECK(only_state(table({{"leading", "L"}})).leading_foot == desired_state_t::LEFT);
  CHECK(only_state(table({{"leading", "R"}})).leading_foot == desired_state_t::RIGHT);
  CHECK(only_state(table({{"leading", "Left"}})).leading_foot == desired_state_t::LEFT);
  CHECK(only_state(table({{"leading", "right"}})).leading_foot == desired_state_t::RIGHT);
  for (const std::string form : {"default", "none", "", "0"})
    CHECK(only_state(table({{"method", form}})).method == desired_state_t::DEFAULT);
  for (const std::string form : {"linear-transition", "2"})
    CHECK(only_state(table({{"method", form}})).method == desired_state_t::LINEAR_TRANSITION);
  CHECK(only_state(table({{"method", "-7"}})).method == -7);
}

TEST_CASE("coordinates are absolute if all absolute names are there, else relative", "[trajectory]")
{
  const std::string relative = "time,knee,p1,dknee,dp1,ddknee,ddp1,contactL,contactR\n0,1,2,3,4,5,6,2,0\n";
  CHECK(only_state(relative).coordinates == desired_state_t::RELATIVE);
  CHECK(only_state(relative).q == std::vector{1.0, 2.0});
  const desired_state_t both = only_state(table({{"knee", "9"}, {"dknee", "9"}, {"ddknee", "9"}}));
  CHECK(both.coordinates == desired_state_t::ABSOLUTE);
  CHECK(both.q == std::vector{1.0, 2.0});
}

TEST_CASE("without base columns the resting foot places the base", "[trajectory]")
{
  CHECK(only_state(table({})).base == desired_state_t::FROM_CONTACT);
}

TEST_CASE("a bad trajectory is refused with file, line, column, what was found and what would be right", "[trajectory]")
{
  struct Row
  {
    std::string text, message;
  };
  const std::string names = "time,p0,p1,dp0,dp1,ddp0,ddp1,contactL,contactR";
  const std::string good = "\n0,1,2,3,4,5,6,2,0";
  const std::string methods = "pseudo-inverse, linear-transition, internal-wrench, torso-wrench, tracked-reaction, "
                              "tracked-internal, constrained, zmp-transition, human-transition";
  const std::vector<Row> rows{
      {"", "t.csv: found no line that names columns; expected one such as time,q0,..."},
      {"# nothing but a comment\n\n", "t.csv: found no line that names columns; expected one such as time,q0,..."},
      {names + "\n", "t.csv: found no row below the names of the columns; expected one per desired state"},

      // names
      {"\n# x\np0,p1,p0", "t.csv:3: column p0: found it twice; expected it once"},
      {table({}, {"time"}), "t.csv:1: column time: found no column time or utime among contactL, contactR, ddp0, ddp1, "
                            "dp0, ...; expected time (s) or utime (µs)"},
      {table({}, {"contactR"}),
       "t.csv:1: column contactR: found no column contactR; expected what carries at each foot: 0 "
       "to 3, or none, heel, sole, toe"},
      {table({}, {"p0"}),
       "t.csv:1: column p0: found no column p0; expected all of p0, p1 (absolute), or all of knee, p1 "
       "(relative)"},
      {table({{"knee", "1"}}, {"p0", "p1"}),
       "t.csv:1: column p1: found no column p1; expected all of p0, p1 (absolute), or "
       "all of knee, p1 (relative)"},
      {table({}, {"dp1", "ddp0"}), "t.csv:1: column dp1: found no column dp1, ddp0; expected all derivatives, or "
                                   "--differentiate to find them by a spline through the samples"},
      {table({{"zB", "1"}, {"dxB", "1"}, {"dzB", "1"}}),
       "t.csv:1: column xB: found no column xB, ddxB, ddzB; expected all of xB, zB, dxB, dzB, ddxB, ddzB, or no base "
       "columns "
       "and the resting foot places the base; --differentiate finds derivatives"},
      {"time;p0;p1\n0;1;2\n", "t.csv:1: column contactL: found no column contactL, contactR; expected what carries at "
                              "each foot: 0 to 3, or none, heel, sole, toe"},
      {"time;p0,p1;dp0\n0;1;2\n", "t.csv:1: found cells between semicolons and, in \"p0,p1\", commas; expected one "
                                  "separator throughout"},
      {"A walk, at noon\n" + names + good, "t.csv:1: column time: found no column time or utime among A walk, at noon; "
                                           "expected time (s) or utime (µs)"},
      {good.substr(1), "t.csv:1: no header: the first line holds only numbers; expected the names of the columns, such "
                       "as time,q0,..."},
      {"time,tau_hip,flags\n0,1,0\n",
       "t.csv:1: found answers, as torquectl eval and export write them: torques, but "
       "not every position and acceleration; expected a desired motion, or --differentiate if all positions are there"},
      {"ik\ninDegrees=yes\nendheader\ntime\tpelvis_tilt\tknee_angle_r\n0\t1\t2\n",
       "t.csv:4: found an OpenSim file with columns time, pelvis_tilt, knee_angle_r, which are none of this robot's; "
       "expected time, contactL, contactR and p0, p1"},

      // cells
      {names + good + "\n1,1,nan,3,4,5,6,2,0", "t.csv:3: column p1: found \"nan\"; expected a finite number"},
      {names + "\n1,1,2,3,-inf,5,6,2,0", "t.csv:2: column dp1: found \"-inf\"; expected a finite number"},
      {names + "\n1,1,2,3,4,,6,2,0", "t.csv:2: column ddp0: found nothing; expected a number, such as -0.25 or 1e-3"},
      {names + "\n1,1kg,2,3,4,5,6,2,0", "t.csv:2: column p0: found \"1kg\"; expected a number, such as -0.25 or 1e-3"},
      {names + "\n1,+-1,2,3,4,5,6,2,0", "t.csv:2: column p0: found \"+-1\"; expected a number, such as -0.25 or 1e-3"},
      {names + "\n1,0x10,2,3,4,5,6,2,0",
       "t.csv:2: column p0: found \"0x10\"; expected a number, such as -0.25 or 1e-3"},
      {names + "\n1,1e999,2,3,4,5,6,2,0",
       "t.csv:2: column p0: found \"1e999\"; expected a number, such as -0.25 or 1e-3"},
      {names + "\n1,\x1b[31m,2,3,4,5,6,2,0",
       "t.csv:2: column p0: found \"?[31m\"; expected a number, such as -0.25 or 1e-3"},
      {names + "\n1,1,2,3,4,5,6,4,0",
       "t.csv:2: column contactL: found \"4\"; expected 0, 1, 2, 3, or none, heel, sole, toe"},
      {names + "\n1,1,2,3,4,5,6,2,flat",
       "t.csv:2: column contactR: found \"flat\"; expected 0, 1, 2, 3, or none, heel, sole, toe"},
      {table({{"leading", "links"}}), "t.csv:2: column leading: found \"links\"; expected L or R"},
      {table({{"load_transfer", ""}}),
       "t.csv:2: column load_transfer: found nothing; expected a number, such as -0.25 or 1e-3"},
      {table({{"phase", "nan"}}), "t.csv:2: column phase: found \"nan\"; expected a finite number"},
      {table({{"method", "pseudo"}}),
       "t.csv:2: column method: found \"pseudo\"; expected default, " + methods + ", or a method's number"},
      {table({{"method", "128"}}),
       "t.csv:2: column method: found \"128\"; expected default, " + methods + ", or a method's number"},
      {table({{"utime", "1.5"}}, {"time"}), "t.csv:2: column utime: found \"1.5\"; expected a whole number of µs"},
      {table({{"utime", "9000000000000000000"}}, {"time"}),
       "t.csv:2: column utime: found \"9000000000000000000\"; expected a whole number of µs"},
      {table({{"time", "1e13"}}), "t.csv:2: column time: found \"1e13\"; expected a time in s"},

      // rows
      {names + good + "\n\n# x\n1,1,2,3",
       "t.csv:5: column dp1: found nothing, the row ends after 4 cells; expected 9 cells"},
      {names + good + "\n1;1;2;3;4;5;6;2;0",
       "t.csv:3: found semicolons in a row; expected commas between cells, as in the names of the columns"},
      {names + "\n0,0,5,1,5,2,5,3,5,2,0",
       "t.csv:2: found 11 cells without a decimal point below 9 names; expected as many cells as names: decimal commas "
       "cannot be told from the commas between cells, which must be semicolons or tabs then"},
      {names + good + ",17", "t.csv:2: column 10: found \"17\"; expected 9 cells"},
      {names + good + good,
       "t.csv:3: column time: found \"0\" after \"0\"; expected a later time in each row, by 1 µs or more"},
      {names + good + "\n-1,1,2,3,4,5,6,2,0",
       "t.csv:3: column time: found \"-1\" after \"0\"; expected a later time in each row, by 1 µs or more"},
      {names + good + "\n4e-7,1,2,3,4,5,6,2,0",
       "t.csv:3: column time: found \"4e-7\" after \"0\"; expected a later time in each row, by 1 µs or more"},
      {names + "\n1,\"2,3",
       "t.csv:2: column 2: found a quote out of place; expected a cell without quotes, or one in quotes "
       "with \"\" for a quote inside"},
  };
  for (const Row& row : rows)
  {
    CAPTURE(row.text);
    CHECK(complaint(row.text) == row.message);
  }
}

TEST_CASE("phase is the share of its contact pair's time, up to the next pair's first sample", "[trajectory]")
{
  const auto states = walk({"20", "20", "20", "21", "22", "22", "22"}, {0.0, 1.0, 1.5, 2.0, 4.0, 5.0, 9.0});
  const std::vector<double> expected{0.0, 0.5, 0.75, 0.0, 0.0, 0.2, 1.0};
  for (std::size_t i = 0; i < states.size(); ++i)
    CHECK(states[i].phase == expected[i]);
  CHECK(walk({"20", "02"})[1].phase == 0.0);
}

TEST_CASE("load_transfer is the share of the whole double support's time, whatever its contact pairs", "[trajectory]")
{
  const auto states = walk({"20", "20", "21", "32", "32", "02", "01", "22"}, {-1.0, 0.0, 1.0, 2.0, 4.0, 5.0, 5.5, 6.0});
  const std::vector<double> expected{0.0, 0.0, 0.0, 0.25, 0.75, 0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < states.size(); ++i)
    CHECK(states[i].load_transfer == expected[i]);
  CHECK(walk({"20", "22", "22"})[2].load_transfer == 1.0);
}

TEST_CASE("where both feet keep their contacts throughout, half of the load is handed over, and a note says so",
          "[trajectory]")
{
  for (const std::vector<std::string>& contacts :
       {std::vector<std::string>{"22"}, {"22", "22", "22"}, {"21", "21"}, {"32", "32", "32"}, {"13", "13"}})
  {
    CAPTURE(contacts);
    for (const desired_state_t& state : walk(contacts))
    {
      CHECK(state.load_transfer == 0.5);
      CHECK(state.phase == 0.5);
    }
  }
  CHECK(walk({"20", "20", "20"})[1].load_transfer == 0.0);
  CHECK(walk({"22", "22", "20"})[0].load_transfer == 0.0); // a double support that ends: from 0 on

  // which columns do not say, of those that mean something
  const auto said = [](const std::string& contact, const std::set<std::string>& columns)
  {
    std::map<std::string, std::string> cells{{"contactR", contact}};
    for (const std::string& column : columns)
      cells[column] = "0.25";
    const Trajectory trajectory = read(table(cells));
    CHECK((trajectory.states[0].load_transfer == 0.25) == columns.contains("load_transfer"));
    CHECK((trajectory.states[0].phase == 0.25) == columns.contains("phase"));
    const auto lines = notes(trajectory);
    CHECK(lines.size() <= 1);
    return lines.empty() ? "" : lines.front();
  };
  const auto note = [](const std::string& columns)
  {
    return "t.csv: both feet keep their contacts throughout, and no column says " + columns +
           ": 0.5, half of the load handed over; a posture that is not symmetric still loads its feet unequally under "
           "the method constrained";
  };
  CHECK(said("2", {}) == note("load_transfer"));
  CHECK(said("2", {"phase"}) == note("load_transfer"));
  CHECK(said("2", {"load_transfer"}) == "");
  CHECK(said("1", {}) == note("load_transfer and phase"));
  CHECK(said("1", {"phase"}) == note("load_transfer"));
  CHECK(said("1", {"load_transfer"}) == note("phase"));
  CHECK(said("1", {"load_transfer", "phase"}) == "");
  CHECK(notes(read(table({}))).empty()); // on one foot neither means anything
}

TEST_CASE("an optional column whose name has a slip of the pen is named in a note", "[trajectory]")
{
  const auto said = [](const std::string& column)
  {
    return notes(read(table({{column, "0.25"}})));
  };
  CHECK(said("load_tranfer") ==
        std::vector<std::string>{"t.csv: column load_tranfer is left out, and there is no column load_transfer"});
  CHECK(said("Phasee") == std::vector<std::string>{"t.csv: column Phasee is left out, and there is no column phase"});
  CHECK(said("load_transfer").empty());
  CHECK(said("remark").empty());
}

TEST_CASE("the foot that landed last leads", "[trajectory]")
{
  struct Row
  {
    std::vector<std::string> contacts;
    std::string leading; // L or R at each sample
  };
  const std::vector<Row> rows{
      {{"20", "21", "32", "02", "12", "22", "20"}, "LRRRLLL"}, // a walk: heel strikes, toes leave
      {{"22", "22", "02"}, "RRR"}, // begins with both: the left foot lifts first, it trailed
      {{"22", "32", "20"}, "LLL"},
      {{"22", "22"}, "LL"},                             // neither ever lifts
      {{"22", "00"}, "LL"},                             // both lift at once
      {{"00", "22", "02", "00", "22", "20"}, "LRRRLL"}, // both land at once: as at the beginning
      {{"02", "00", "02", "22"}, "RRRL"},               // in flight as before
      {{"20", "22", "20", "22", "02"}, "LRLRR"},        // the same foot steps twice
  };
  for (const Row& row : rows)
  {
    std::string found;
    for (const desired_state_t& state : walk(row.contacts))
      found += state.leading_foot == desired_state_t::LEFT ? 'L' : 'R';
    CAPTURE(row.contacts);
    CHECK(found == row.leading);
  }
}

TEST_CASE("a motion that begins or ends on both feet without load_transfer is noted", "[trajectory]")
{
  const auto notes_of = [](const std::vector<std::pair<int, int>>& contacts, bool given)
  {
    std::string text = given ? "time,p0,p1,dp0,dp1,ddp0,ddp1,contactL,contactR,load_transfer\n"
                             : "time,p0,p1,dp0,dp1,ddp0,ddp1,contactL,contactR\n";
    for (std::size_t i = 0; i < contacts.size(); ++i)
      text += fmt::format("{},1,2,3,4,5,6,{},{}{}\n", 0.1 * static_cast<double>(i), contacts[i].first,
                          contacts[i].second, given ? ",0.5" : "");
    return fmt::format("{}", fmt::join(read(text).assumptions, "\n"));
  };
  const std::string sentence = "on both feet, and no column load_transfer says";
  CHECK(notes_of({{2, 2}, {2, 2}, {2, 0}}, false).find("the motion begins " + sentence) != std::string::npos);
  CHECK(notes_of({{2, 0}, {2, 2}, {2, 2}}, false).find("the motion ends " + sentence) != std::string::npos);
  CHECK(notes_of({{2, 2}, {2, 0}, {2, 2}}, false).find("the motion begins and ends " + sentence) != std::string::npos);
  CHECK(notes_of({{2, 2}, {2, 0}, {2, 2}}, true) == "");
  CHECK(notes_of({{2, 0}, {2, 2}, {0, 2}}, false) == "");
}

TEST_CASE("a row whose base cells are all empty is placed by its resting foot", "[trajectory]")
{
  const std::string header = "time,p0,p1,dp0,dp1,ddp0,ddp1,xB,zB,dxB,dzB,ddxB,ddzB,contactL,contactR\n";
  const Trajectory found = read(header + "0,1,2,3,4,5,6,7,8,9,10,11,12,2,0\n0.1,1,2,3,4,5,6,,,,,,,2,0\n");
  REQUIRE(found.states.size() == 2);
  CHECK(found.states[0].base == desired_state_t::GIVEN);
  CHECK(found.states[0].base_a[1] == 12.0);
  CHECK(found.states[1].base == desired_state_t::FROM_CONTACT);
  CHECK(found.states[1].base_q[0] == 0.0);
  // some of them are a slip
  CHECK(complaint(header + "0,1,2,3,4,5,6,7,8,9,10,11,,2,0\n") ==
        "t.csv:2: column ddzB: found nothing; expected a number, such as -0.25 or 1e-3");
}

TEST_CASE("columns that are given are not overwritten by what the contacts say", "[trajectory]")
{
  const desired_state_t state =
      only_state(table({{"contactR", "2"}, {"leading", "R"}, {"load_transfer", "0.4"}, {"phase", "0.3"}}));
  CHECK(state.leading_foot == desired_state_t::RIGHT);
  CHECK(state.load_transfer == 0.4);
  CHECK(state.phase == 0.3);
}

TEST_CASE("the spline reproduces a polynomial of degree 5 and its derivatives at uneven times", "[trajectory]")
{
  const auto f = [](double t)
  {
    return 1.0 + t * (2.0 + t * (-3.0 + t * (0.5 + t * (1.0 - 0.25 * t))));
  };
  const auto df = [](double t)
  {
    return 2.0 + t * (-6.0 + t * (1.5 + t * (4.0 - 1.25 * t)));
  };
  const auto ddf = [](double t)
  {
    return -6.0 + t * (3.0 + t * (12.0 - 5.0 * t));
  };
  const std::vector<double> times{0.0, 0.1, 0.35, 0.4, 0.8, 1.0, 1.1, 1.6, 1.75, 2.0};
  for (const std::size_t count : {std::size_t{6}, std::size_t{7}, times.size()})
    for (const desired_state_t& state : differentiated({times.begin(), times.begin() + static_cast<long>(count)}, f))
    {
      const double t = 1e-6 * static_cast<double>(state.utime);
      CAPTURE(count, t);
      // rounding errors only, grown by the square of the smallest step
      CHECK_THAT(state.v[0], Catch::Matchers::WithinAbs(df(t), 1e-11));
      CHECK_THAT(state.a[0], Catch::Matchers::WithinAbs(ddf(t), 1e-9));
      CHECK_THAT(state.a[1], Catch::Matchers::WithinAbs(-2.0 * ddf(t), 2e-9));
    }
}

TEST_CASE("the spline's derivatives of a sine come closer as its theory says when the step is halved", "[trajectory]")
{
  const auto worst = [](int count)
  {
    std::vector<double> times;
    for (int i = 0; i < count; ++i)
      times.push_back(2.0 * i / (count - 1));
    std::array<double, 2> error{};
    for (const desired_state_t& state : differentiated(times, [](double t) { return std::sin(3.0 * t); }))
    {
      const double t = 1e-6 * static_cast<double>(state.utime);
      error[0] = std::max(error[0], std::abs(state.v[0] - 3.0 * std::cos(3.0 * t)));
      error[1] = std::max(error[1], std::abs(state.a[0] + 9.0 * std::sin(3.0 * t)));
    }
    return error;
  };
  // degree 5: with step h first derivatives are off by O(h^5), second ones by O(h^4), here about 3 (3h)^5 and 9 (3h)^4
  // times a constant that is well below one
  const auto coarse = worst(26), fine = worst(51);
  CHECK(coarse[0] < 3.0 * std::pow(0.24, 5) / 10.0);
  CHECK(coarse[1] < 9.0 * std::pow(0.24, 4) / 3.0);
  CHECK(fine[0] < coarse[0] / 20.0);
  CHECK(fine[1] < coarse[1] / 12.0);
}

TEST_CASE("the spline is differentiated in unrounded time", "[trajectory]")
{
  // 600 samples a second are not whole µs: rounded, the accelerations of this parabola would be off by more than 0.1
  std::string text = "time,p0,p1,contactL,contactR\n";
  for (int i = 0; i < 40; ++i)
    text += fmt::format("{},{},0,2,0\n", i / 600.0, 0.5 * (i / 600.0) * (i / 600.0) + i / 600.0);
  for (const desired_state_t& state : read(text, true).states)
    CHECK_THAT(state.a[0], Catch::Matchers::WithinAbs(1.0, 1e-8));
}

TEST_CASE("a spline needs six rows, and is asked for base points, too", "[trajectory]")
{
  std::string text = "time,p0,p1,xB,zB,contactL,contactR\n";
  for (int i = 0; i < 5; ++i)
    text += fmt::format("{},0,0,{},0,2,0\n", i, 3 * i);
  CHECK(complaint(text, true) == "t.csv: found 5 rows; expected at least 6 for --differentiate");
  const Trajectory trajectory = read(text + "5,0,0,15,0,2,0\n", true);
  CHECK(trajectory.states[0].base == desired_state_t::GIVEN);
  for (const desired_state_t& state : trajectory.states)
  {
    CHECK_THAT(state.base_v[0], Catch::Matchers::WithinAbs(3.0, 1e-12));
    CHECK_THAT(state.base_a[0], Catch::Matchers::WithinAbs(0.0, 1e-12));
  }
  CHECK(complaint("time,p0,p1,zB,contactL,contactR\n", true) ==
        "t.csv:1: column xB: found no column xB; expected all of xB, zB, or no base columns and the resting foot "
        "places the "
        "base");
}

TEST_CASE("with differentiate, derivative columns are not looked at", "[trajectory]")
{
  std::string text = "time,p0,p1,dp0,contactL,contactR\n";
  for (int i = 0; i < 6; ++i)
    text += fmt::format("{},{},0,nan,2,0\n", i, 2 * i);
  CHECK_THAT(read(text, true).states[3].v[0], Catch::Matchers::WithinAbs(2.0, 1e-12));
}

TEST_CASE("the measured walk: the spline finds its derivatives, and its steps are found", "[trajectory]")
{
  const CoordinateNames names = coordinate_names(load_robot("human-subject01"));
  const std::string text = contents(kWalk);
  const std::vector<desired_state_t> given = read(text, false, names).states;
  const std::vector<desired_state_t> found = read(text, true, names).states;
  REQUIRE(given.size() == 447);
  REQUIRE(found.size() == 447);

  // the file's derivatives are those of a quintic spline through the samples before they were rounded to 1e-9 rad, m,
  // and its derivatives to 7 digits; near the ends that spline knew samples that the file does not hold
  constexpr std::size_t ends = 8;
  double speed = 0.0, acceleration = 0.0;
  for (std::size_t i = ends; i + ends < given.size(); ++i)
    for (std::size_t j = 0; j < 7; ++j)
    {
      speed = std::max(speed, std::abs(given[i].v[j] - found[i].v[j]));
      acceleration = std::max(acceleration, std::abs(given[i].a[j] - found[i].a[j]));
    }
  CHECK(speed < 1e-5);
  CHECK(acceleration < 3e-3);

  // double support as measured: left to right, right to left, left to right
  std::string supports;
  for (const desired_state_t& state : given)
  {
    const std::string now = state.left_contact && state.right_contact ? (state.leading_foot ? "R" : "L") : "-";
    if (supports.empty() || supports.substr(supports.size() - 1) != now)
      supports += now;
  }
  CHECK(supports == "-R-L-R-");
}

TEST_CASE("a log gives the desired states that were recorded, whatever its name", "[trajectory]")
{
  const TemporaryFolder folder;
  const std::string path = folder.file("log.csv");
  const Robot robot = load_robot("ck");
  std::vector<desired_state_t> states = walk({"20", "21", "22"});
  states[1].stream_id = -5;
  states[1].q = {1.0, 2.0, 3.0};
  states[1].v = states[1].a = states[1].q;
  states[1].num_coordinates = 3;
  std::vector<std::byte> buffer;
  {
    LogWriter log(path);
    const model_info_t model = model_info(robot, 1, 2, "");
    log.write("TORQUED_MODEL", 0, encode(model, buffer));
    for (const desired_state_t& state : states)
    {
      log.write("TORQUED_DESIRED", 1, encode(state, buffer));
      log.write("OTHER", 1, encode(state, buffer));
    }
    const Bytes bytes = encode(states[0], buffer);
    log.write("TORQUED_DESIRED", 2, bytes.first(bytes.size() - 1));
    log.write("left/TORQUED_DESIRED", 2, bytes);
    log.close();
  }
  const std::string bytes = contents(path);
  const Trajectory trajectory = parse_trajectory(bytes, path, kNames, false, Channels());
  REQUIRE(trajectory.states.size() == 3);
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(same(trajectory.states[i], states[i]));
  CHECK(trajectory.undecodable == 1);
  CHECK(trajectory.damaged_bytes == 0);
  CHECK(trajectory.place(1) == path + ": record 3");

  CHECK(parse_trajectory(bytes, path, kNames, false, Channels("left/")).states.size() == 1);
  CHECK_THROWS_WITH(
      parse_trajectory(bytes, path, kNames, false, Channels("right/")),
      path + ": found no desired state on channel right/TORQUED_DESIRED of this LCM log (0 undecodable there); "
             "it holds OTHER, TORQUED_DESIRED, TORQUED_MODEL, left/TORQUED_DESIRED; --prefix names another "
             "channel");

  CHECK(notes(trajectory) ==
        std::vector{path + ": 1 messages cannot be decoded as desired states; they were passed over"});
}

TEST_CASE("a damaged log gives every record that is whole", "[trajectory]")
{
  const TemporaryFolder folder;
  const std::vector<desired_state_t> states = walk({"20", "21", "22", "02"});
  std::vector<std::byte> buffer;
  LogWriter log(folder.file("log"));
  for (const desired_state_t& state : states)
    log.write("TORQUED_DESIRED", 1, encode(state, buffer));
  log.close();
  const std::string whole = contents(folder.file("log"));
  const std::size_t record = whole.size() / 4;
  const auto read_log = [](const std::string& bytes)
  {
    return parse_trajectory(bytes, "log", kNames, false, Channels());
  };

  SECTION("cut at any byte of its last record, as by a killed logger")
  {
    for (std::size_t size = 3 * record; size < whole.size(); ++size)
    {
      const Trajectory trajectory = read_log(whole.substr(0, size));
      REQUIRE(trajectory.states.size() == 3);
      REQUIRE(trajectory.damaged_bytes == size - 3 * record);
    }
  }
  SECTION("cut at any byte of its first record, as by a ring buffer")
  {
    for (std::size_t size = 1; size < record; ++size)
    {
      const std::string bytes = whole.substr(size);
      REQUIRE(LogReader::is_log(bytes));
      const Trajectory trajectory = read_log(bytes);
      REQUIRE(trajectory.states.size() == 3);
      REQUIRE(same(trajectory.states[0], states[1]));
      REQUIRE(trajectory.damaged_bytes == 0);
      REQUIRE(notes(trajectory) ==
              std::vector<std::string>{fmt::format(
                  "log: begins in the middle of a record; its first {} bytes were passed over", record - size)});
    }
    CHECK_FALSE(LogReader::is_log(whole.substr(3 * record + 1))); // no whole record
  }
  SECTION("with a destroyed sync word, or lengths that point far away or nowhere")
  {
    for (const std::size_t byte : {0, 20, 24})
      for (const char value : {'\x7f', '\xff'})
      {
        std::string bytes = whole;
        bytes[record + byte] = value;
        const Trajectory trajectory = read_log(bytes);
        CAPTURE(byte, static_cast<int>(value));
        REQUIRE(trajectory.states.size() == 3);
        CHECK(trajectory.damaged_bytes == record);
        CHECK(same(trajectory.states[1], states[2]));
        CHECK(notes(trajectory).front() ==
              fmt::format("log: {} bytes belong to no whole record of the log; they were passed over", record));
      }
  }
}

TEST_CASE("what is answered are the bytes that were recorded, or those of a table's rows", "[trajectory]")
{
  const TemporaryFolder folder;
  const std::vector<desired_state_t> states = walk({"20", "21", "22"});
  std::vector<std::byte> buffer;
  LogWriter log(folder.file("log"));
  for (const desired_state_t& state : states)
    log.write("TORQUED_DESIRED", 1, encode(state, buffer));
  log.write("TORQUED_DESIRED", 1, encode(states[0], buffer).first(50));
  log.close();

  const auto check = [&](const DesiredMessages& desired, const Trajectory& trajectory)
  {
    REQUIRE(desired.messages.size() == trajectory.states.size());
    for (std::size_t i = 0; i < desired.messages.size(); ++i)
    {
      const Bytes expected = encode(trajectory.states[i], buffer);
      CHECK(std::equal(desired.messages[i].begin(), desired.messages[i].end(), expected.begin(), expected.end()));
      CHECK(desired.place(i) == trajectory.place(i));
    }
    CHECK(desired.undecodable == trajectory.undecodable);
  };
  for (const std::string& file : {folder.file("log"), folder.write("rows", table({}))})
  {
    const Trajectory trajectory = parse_trajectory(contents(file), file, kNames, false, Channels());
    check(read_messages(std::make_shared<const InputFile>(file), file, kNames, false, Channels()), trajectory);
    check(encode_all(trajectory), trajectory);
  }
  const auto log_file = std::make_shared<const InputFile>(folder.file("log"));
  CHECK_THROWS_AS(read_messages(log_file, "log", kNames, false, Channels("right/")), Failure);
}

TEST_CASE("a file is read to its end, with or without a size", "[trajectory]")
{
  const TemporaryFolder folder;
  const std::string text(3'000'000, 'x');
  CHECK((read_file(folder.write("large", text)) == text));
  CHECK(read_file(folder.write("empty", "")).empty());
  CHECK(read_file("/proc/self/comm").ends_with("\n"));
  std::array<int, 2> ends{};
  REQUIRE(pipe(ends.data()) == 0);
  REQUIRE(write(ends[1], "a,b\n", 4) == 4);
  close(ends[1]);
  CHECK(read_file(fmt::format("/dev/fd/{}", ends[0])) == "a,b\n");
  close(ends[0]);
  CHECK_THROWS_WITH(read_file(folder.file("none")),
                    folder.file("none") + ": cannot be read: No such file or directory");
  CHECK_THROWS_WITH(read_file("/proc"), "/proc: cannot be read: Is a directory");
}

TEST_CASE("a log is liblcm's, byte by byte, and either reads the other's", "[trajectory]")
{
  const TemporaryFolder folder;
  const std::string ours = folder.file("ours"), liblcms = folder.file("liblcms");
  const auto channel = [](int i)
  {
    return "CHANNEL" + std::string(static_cast<std::size_t>(i % 60), 'x');
  };
  const auto data = [](int i)
  {
    return std::string(static_cast<std::size_t>(i % 7 == 0 ? 0 : 300 * (i % 11)), static_cast<char>(i));
  };
  const auto timestamp = [](int i)
  {
    return i % 2 == 0 ? std::int64_t{i} : std::numeric_limits<std::int64_t>::min() + i;
  };
  constexpr int records = 1000; // over 1 MB, which is more than any buffer
  {
    LogWriter writer(ours);
    lcm::LogFile other(liblcms, "w");
    for (int i = 0; i < records; ++i)
    {
      std::string bytes = data(i);
      writer.write(channel(i), timestamp(i), std::as_bytes(std::span(bytes)));
      lcm::LogEvent event{0, timestamp(i), channel(i), static_cast<std::int32_t>(bytes.size()), bytes.data()};
      REQUIRE(other.writeEvent(&event) == 0);
    }
    writer.close();
  }
  const std::string bytes = contents(ours);
  REQUIRE(bytes.size() > 1'000'000);
  CHECK((bytes == contents(liblcms)));

  lcm::LogFile other(ours, "r");
  LogReader reader(bytes);
  for (int i = 0; i < records; ++i)
  {
    const lcm::LogEvent* const event = other.readNextEvent();
    const auto record = reader.next();
    REQUIRE((event && record));
    CHECK((event->eventnum == i && record->number == i));
    CHECK((event->timestamp == timestamp(i) && record->timestamp == timestamp(i)));
    CHECK((event->channel == channel(i) && record->channel == channel(i)));
    const std::string heard(static_cast<const char*>(event->data), static_cast<std::size_t>(event->datalen));
    CHECK(heard == data(i));
    CHECK(std::equal(record->data.begin(), record->data.end(), std::as_bytes(std::span(heard)).begin(),
                     std::as_bytes(std::span(heard)).end()));
  }
  CHECK_FALSE(other.readNextEvent());
  CHECK_FALSE(reader.next());
}

TEST_CASE("a log on a full disk is said not to be written, whether by its last bytes or before", "[trajectory]")
{
  const std::string why = "/dev/full: cannot be written: No space left on device";
  const std::string data(1000, 'x');
  LogWriter few("/dev/full");
  few.write("CHANNEL", 0, std::as_bytes(std::span(data)));
  CHECK_THROWS_WITH(few.close(), why);

  LogWriter many("/dev/full");
  const auto write = [&]
  {
    for (int i = 0; i < 1000; ++i)
      many.write("CHANNEL", 0, std::as_bytes(std::span(data)));
  };
  CHECK_THROWS_WITH(write(), why);
  CHECK_THROWS_WITH(LogWriter("/nowhere/log"), "/nowhere/log: cannot be written: No such file or directory");
}

} // namespace trajectory_test
