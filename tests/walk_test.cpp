#include "catch.h"

#include "answer/answer.h"
#include "motion/csv_lines.h"
#include "motion/files.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace walk_test
{

using namespace torqued;

namespace
{

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";

// A column of numbers of a CSV.
std::vector<double> column(const std::string& text, const std::string& name)
{
  CsvReader reader(text, "walk.csv");
  CsvLine line;
  REQUIRE(reader.next(line));
  const auto at = std::find(line.cells.begin(), line.cells.end(), name) - line.cells.begin();
  REQUIRE(at < static_cast<std::ptrdiff_t>(line.cells.size()));
  std::vector<double> numbers;
  while (reader.next(line))
  {
    const std::string& cell = line.cells[static_cast<std::size_t>(at)];
    double number = NAN;
    std::from_chars(cell.data(), cell.data() + cell.size(), number);
    numbers.push_back(number);
  }
  return numbers;
}

} // namespace

TEST_CASE("the measured walk's total ground reaction is what the plates measured", "[walk]")
{
  const Robot robot = load_robot("human-subject01");
  const std::string text = read_file(kWalk);
  const Trajectory walk = parse_trajectory(text, "walk.csv", coordinate_names(robot), false, Channels());
  REQUIRE(walk.states.size() == 447);
  const std::vector<double> FxL = column(text, "FxL");
  const std::vector<double> FxR = column(text, "FxR");
  const std::vector<double> FzL = column(text, "FzL");
  const std::vector<double> FzR = column(text, "FzR");

  double squares_x = 0.0;
  double squares_z = 0.0;
  StreamMemory memory;
  std::vector<std::byte> buffer;
  for (std::size_t i = 0; i < walk.states.size(); ++i)
  {
    CAPTURE(i);
    const auto desired = decode_desired_state(encode(walk.states[i], buffer), robot);
    REQUIRE(std::holds_alternative<DesiredState>(desired));
    const auto result = answer(robot, {}, std::get<DesiredState>(desired), memory);
    REQUIRE(std::holds_alternative<Answer>(result));
    const Answer& found = std::get<Answer>(result);
    squares_x += std::pow(found.ground[0].wrench.fx + found.ground[1].wrench.fx - FxL[i] - FxR[i], 2);
    squares_z += std::pow(found.ground[0].wrench.fz + found.ground[1].wrench.fz - FzL[i] - FzR[i], 2);
    // rounding of forces of some 10³ N
    CHECK(found.dynamics_residual < 1e-9);
  }
  const double rms_x = std::sqrt(squares_x / 447.0);
  const double rms_z = std::sqrt(squares_z / 447.0);
  CAPTURE(rms_x, rms_z);
  // what the data support: 21.6 and 29.5 N, by the walk's own README; a sign or a mass that is wrong gives hundreds
  CHECK(rms_x < 22.0);
  CHECK(rms_z < 30.0);
}

} // namespace walk_test
