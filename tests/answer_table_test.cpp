#include "catch.h"
#include "wire/messages.h"

#include "motion/csv_lines.h"
#include "study/answer_table.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>

namespace answer_table_test
{

using namespace torqued;

namespace
{

const std::vector<std::string> kJoints{"left_ankle", "right_ankle"}, kAccelerations{"q0", "xH", "zH"};

} // namespace

TEST_CASE("the columns are those that scripts and the manual know", "[answer_table]")
{
  CHECK(csv_line({"utime"}, answer_columns(kJoints, kAccelerations)) ==
        "utime,tau_left_ankle,tau_right_ankle,fxL,fzL,momentL,sole_copL,fxR,fzR,momentR,sole_copR,zmp,flags,"
        "flag_names,dynamics_residual,contact_speed,contact_residual,a_q0,a_xH,a_zH,adjustment,method,rejected\n");
}

TEST_CASE("each number of a command stands under its column", "[answer_table]")
{
  torque_command_t command{};
  command.torque = {1.5, -2.0};
  command.left = {3.0, 4.0, 5.0, 6.0, 99.0};
  command.right = {7.0, 8.0, 9.0, 10.0, 99.0};
  command.zmp = 11.0;
  command.flags = 12;
  command.dynamics_residual = 13.0;
  command.contact_speed = 14.0;
  command.contact_residual = 15.0;
  command.adjustment = 19.0;
  command.method = desired_state_t::LINEAR_TRANSITION;
  const std::vector<std::string> cells = answer_cells(command, {16.0, 17.0, 18.0});
  CHECK(csv_line(cells) == "1.5,-2,3,4,5,6,7,8,9,10,11,12,TIPS|OVER_TORQUE,13,14,15,16,17,18,19,linear-transition,\n");
  CHECK(cells.size() == answer_columns(kJoints, kAccelerations).size());
  command.flags = 0;
  command.adjustment = std::nan("");
  CHECK(csv_line(answer_cells(command, {std::nan(""), 17.0, 18.0})) ==
        "1.5,-2,3,4,5,6,7,8,9,10,11,0,,13,14,15,,17,18,,linear-transition,\n");
}

TEST_CASE("a row that was not answered holds nothing but the reason", "[answer_table]")
{
  CHECK(csv_line(rejected_cells(4, "STALE")) == ",,,STALE\n");
}

TEST_CASE("numbers read back as the same bits", "[answer_table]")
{
  std::mt19937_64 random(GENERATE(1, 2, 3));
  std::vector<double> numbers{0.0,  -0.0, 1.0, 0.1, 5e-324, -2.2e-308, std::numeric_limits<double>::max(),
                              M_PI, 1e22, 1e23};
  for (int i = 0; i < 10'000; ++i)
    if (const auto number = std::bit_cast<double>(random()); std::isfinite(number))
      numbers.push_back(number);
  for (const double number : numbers)
  {
    const std::string cell = number_cell(number);
    double read = std::nan("");
    std::from_chars(cell.data(), cell.data() + cell.size(), read);
    CAPTURE(cell);
    REQUIRE(std::bit_cast<std::uint64_t>(read) == std::bit_cast<std::uint64_t>(number));
  }
  CHECK(number_cell(0.1) == "0.1");
  CHECK(seconds_cell(4000) == "0.004");
  CHECK(seconds_cell(1'700'000'000'123'456) == "1700000000.123456");
}

TEST_CASE("methods are named, and unknown ones keep their number", "[answer_table]")
{
  CHECK(method_name(0) == "none");
  CHECK(method_name(desired_state_t::LINEAR_TRANSITION) == "linear-transition");
  CHECK(method_name(100) == "100");
  CHECK(method_name(-1) == "-1");
}

TEST_CASE("each flag has the name of its message's constant", "[answer_table]")
{
  using c = torque_command_t;
  const std::vector<std::pair<std::int32_t, std::string>> known{
      {c::SLIPS, "SLIPS"},         {c::LIFTS, "LIFTS"},         {c::TIPS, "TIPS"},
      {c::CLAMPED, "CLAMPED"},     {c::RELAXED, "RELAXED"},     {c::OVER_TORQUE, "OVER_TORQUE"},
      {c::LATE, "LATE"},           {c::OVER_RATE, "OVER_RATE"}, {c::INCONSISTENT, "INCONSISTENT"},
      {c::PROJECTED, "PROJECTED"}, {c::ADJUSTED, "ADJUSTED"},   {c::CONTACT_ACCELERATION, "CONTACT_ACCELERATION"},
      {c::PRIOR, "PRIOR"}};
  for (const auto& [bit, name] : known)
    CHECK(flag_names(bit) == std::vector{name});
  CHECK(flag_names(0).empty());
  CHECK(flag_names(8191).size() == known.size());
  CHECK(flag_names(5) == std::vector<std::string>{"SLIPS", "TIPS"});
}

TEST_CASE("any text in a cell reads back as it was", "[answer_table]")
{
  const std::vector<std::string> cells{"plain", "with,comma", "with \"quotes\"", "", "  spaces ", "#5", "\"", "µs"};
  const std::string text = csv_line(cells);
  CsvReader reader(text, "t.csv");
  CsvLine line;
  REQUIRE(reader.next(line));
  CHECK(line.cells == cells);
  CHECK_FALSE(reader.next(line));
}

} // namespace answer_table_test
