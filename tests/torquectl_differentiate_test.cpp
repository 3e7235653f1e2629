#include "catch.h"

#include "run_torquectl.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>
#include <vector>

namespace torquectl_differentiate_test
{

using namespace torqued;

namespace
{

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";

double number(const std::string& cell)
{
  double value = 0.0;
  std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return value;
}

// the torques of each row
std::vector<std::vector<double>> torques(const std::string& path)
{
  const auto table = rows(path);
  std::vector<std::vector<double>> found;
  for (std::size_t i = 1; i < table.size(); ++i)
  {
    found.emplace_back();
    for (std::size_t j = 0; j < table[0].size(); ++j)
      if (table[0][j].starts_with("tau_"))
        found.back().push_back(number(table[i][j]));
  }
  return found;
}

double peak(const std::vector<std::vector<double>>& all)
{
  double largest = 0.0;
  for (const auto& row : all)
    for (const double torque : row)
      largest = std::max(largest, std::abs(torque));
  return largest;
}

// of the differences, but for some rows at each end
double rms(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b, std::size_t ends)
{
  REQUIRE(a.size() == b.size());
  double sum = 0.0, count = 0.0;
  for (std::size_t i = ends; i + ends < a.size(); ++i)
    for (std::size_t j = 0; j < a[i].size(); ++j, ++count)
      sum += (a[i][j] - b[i][j]) * (a[i][j] - b[i][j]);
  return std::sqrt(sum / count);
}

// the walk's times, positions and contacts, every so many rows, written with `change`
template <typename Change> std::string walk_positions(std::size_t every, Change change)
{
  const auto table = rows(kWalk);
  const std::vector<std::string> names{"time", "q0", "q1", "q2", "q3",       "q4",
                                       "q5",   "q6", "xH", "zH", "contactL", "contactR"};
  std::string text = fmt::format("{}\n", fmt::join(names, ","));
  for (std::size_t i = 1; i < table.size(); i += every)
  {
    std::vector<std::string> cells;
    for (const std::string& name : names)
    {
      const auto column = std::find(table[0].begin(), table[0].end(), name) - table[0].begin();
      cells.push_back(change(name, (i - 1) / every, table[i][static_cast<std::size_t>(column)]));
    }
    text += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return text;
}

std::vector<std::vector<double>> evaluated(const TemporaryFolder& folder, const std::string& text,
                                           std::vector<std::string> more, std::string& notes)
{
  const std::string out = folder.file("out.csv");
  std::vector<std::string> words{
      "eval", folder.write("t.csv", text), "--robot", "human-subject01", "--differentiate", "-o", out};
  words.insert(words.end(), more.begin(), more.end());
  const Run eval = run(words);
  CAPTURE(eval.err);
  CHECK(eval.code == 0);
  notes = eval.err;
  return torques(out);
}

} // namespace

TEST_CASE("the walk that gait writes has the same torques from its positions alone", "[torquectl_differentiate][slow]")
{
  const TemporaryFolder folder;
  for (const std::string robot : {"ck", "rk"})
    for (const std::string rate : {"200", "300", "1000"})
    {
      CAPTURE(robot, rate);
      const std::string walk = folder.file("walk.csv");
      REQUIRE(run({"gait", "--robot", robot, "--rate", rate, "-o", walk}).code == 0);
      const auto eval = [&](const std::string& out, bool differentiate)
      {
        std::vector<std::string> words{"eval",           walk, "--robot",       robot, "--method",
                                       "zmp-transition", "-o", folder.file(out)};
        if (differentiate)
          words.emplace_back("--differentiate");
        const Run found = run(words);
        CAPTURE(found.err);
        CHECK((found.err.find("the instant of the row before once more") != std::string::npos) == differentiate);
        CHECK(found.err.find("accelerations leap") == std::string::npos);
        return torques(folder.file(out));
      };
      const auto analytic = eval("analytic.csv", false), spline = eval("spline.csv", true);
      // jerk changes where contacts do, so that a spline rounds the accelerations there
      CHECK(peak(spline) == Approx(peak(analytic)).margin(4.8));
      CHECK(rms(spline, analytic, 0) < 1.0);
    }
}

TEST_CASE("times to three decimals change no torque by a newton metre", "[torquectl_differentiate]")
{
  // the walk at 66.7 Hz
  const TemporaryFolder folder;
  std::string notes;
  const auto exact = evaluated(
      folder,
      walk_positions(3, [](const std::string& name, std::size_t row, const std::string& cell)
                     { return name == "time" ? fmt::format("{:.9f}", static_cast<double>(row) / 60.0) : cell; }),
      {}, notes);
  const auto rounded = evaluated(
      folder,
      walk_positions(3, [](const std::string& name, std::size_t row, const std::string& cell)
                     { return name == "time" ? fmt::format("{:.3f}", static_cast<double>(row) / 60.0) : cell; }),
      {}, notes);
  CHECK(rms(rounded, exact, 0) < 0.1);
  CHECK(notes.find("times are rounded to 0.001 s: put back on 60 Hz (largest move 0.0003") != std::string::npos);
}

TEST_CASE("a low-pass takes the noise of rounded angles out of the torques", "[torquectl_differentiate]")
{
  const TemporaryFolder folder;
  std::string notes;
  const auto as_given = [](const std::string&, std::size_t, const std::string& cell)
  {
    return cell;
  };
  const auto quantized = [](const std::string& name, std::size_t, const std::string& cell)
  {
    return name[0] == 'q' || name.ends_with("H") ? fmt::format("{:.4f}", number(cell)) : cell;
  };
  const auto exact = evaluated(folder, walk_positions(1, as_given), {}, notes);
  CHECK(notes.find("accelerations") == std::string::npos);
  constexpr std::size_t ends = 40; // 0.2 s, which depend on what the motion is taken to have been before
  const auto noisy = evaluated(folder, walk_positions(1, quantized), {}, notes);
  CHECK(rms(noisy, exact, ends) > 100.0);
  CHECK(notes.find("accelerations leap from sample to sample") != std::string::npos);
  const auto smooth = evaluated(folder, walk_positions(1, quantized), {"--lowpass", "10"}, notes);
  CHECK(rms(smooth, exact, ends) < 3.5);
  CHECK(notes.find("low-passed at 10 Hz") != std::string::npos);
}

TEST_CASE("--lowpass is refused where it cannot mean anything", "[torquectl_differentiate]")
{
  const TemporaryFolder folder;
  const std::string out = folder.file("out.csv");
  const Run alone = run({"eval", kWalk, "--robot", "human-subject01", "--lowpass", "6", "-o", out});
  CHECK(alone.code == 64);
  CHECK(alone.err.find("--differentiate") != std::string::npos);
  const Run negative =
      run({"eval", kWalk, "--robot", "human-subject01", "--differentiate", "--lowpass", "-6", "-o", out});
  CHECK(negative.code == 64);
  const Run fast = run({"eval", kWalk, "--robot", "human-subject01", "--differentiate", "--lowpass", "100", "-o", out});
  CHECK(fast.code == 65);
  CHECK(fast.err.find("found --lowpass 100 Hz for frames at 200 Hz; expected less than half of their rate") !=
        std::string::npos);
}

TEST_CASE("every subcommand that differentiates says what it did", "[torquectl_differentiate]")
{
  const TemporaryFolder folder;
  const std::string walk =
      folder.write("t.csv", walk_positions(1, [](const std::string& name, std::size_t row, const std::string& cell)
                                           { return name == "q3" && row == 100 ? std::string() : cell; }));
  for (const std::vector<std::string>& words : {std::vector<std::string>{"eval", walk, "-o", folder.file("o.csv")},
                                                std::vector<std::string>{"dynamics", walk, "-o", folder.file("o.json")},
                                                std::vector<std::string>{"wrenches", walk, "-o", folder.file("o.csv")},
                                                std::vector<std::string>{"project", walk, "-o", folder.file("o.csv")},
                                                std::vector<std::string>{"nearest", walk, "-o", folder.file("o.csv")},
                                                std::vector<std::string>{"report", walk, "-o", folder.file("o.html")}})
  {
    std::vector<std::string> all = words;
    all.insert(all.end(), {"--robot", "human-subject01", "--differentiate", "--lowpass", "20"});
    const Run found = run(all);
    CAPTURE(words[0], found.err);
    CHECK(found.code == (words[0] == "project" ? 65 : 0)); // a human foot rolls too far for a rigid one
    CHECK(found.err.find("t.csv: cells without a number bridged in 1 row, line 102 first (column q3)\n") !=
          std::string::npos);
    CHECK(found.err.find("t.csv: low-passed at 20 Hz") != std::string::npos);
  }
  // an empty cell is one only where derivatives are asked for
  const Run given = run({"eval", walk, "--robot", "human-subject01", "-o", folder.file("o.csv")});
  CHECK(given.code == 65);
}

} // namespace torquectl_differentiate_test
