#include "catch.h"
#include "matchers.h"
#include "run_torquectl.h"

#include "robot/files/load.h"
#include "robot/robot.h"
#include "study/answer_table.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

namespace torquectl_dynamics_test
{

using namespace torqued;

namespace
{

using Json = nlohmann::json;

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";

std::vector<Json> objects(const std::string& path)
{
  std::istringstream lines(read_file(path));
  std::vector<Json> result;
  for (std::string line; std::getline(lines, line);)
    result.push_back(Json::parse(line));
  return result;
}

Eigen::MatrixXd matrix(const Json& rows)
{
  Eigen::MatrixXd result(rows.size(), rows.empty() ? 0 : rows[0].size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < rows[i].size(); ++j)
      result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j].get<double>();
  return result;
}

Eigen::VectorXd vector(const Json& numbers)
{
  const auto values = numbers.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

// a CSV's columns by name, as numbers; empty cells are 0
std::map<std::string, std::vector<double>> columns(const std::string& path)
{
  const auto table = rows(path);
  std::map<std::string, std::vector<double>> result;
  for (std::size_t i = 1; i < table.size(); ++i)
    for (std::size_t j = 0; j < table[0].size(); ++j)
    {
      const std::string& cell = table[i][j];
      char* end = nullptr;
      const double number = std::strtod(cell.c_str(), &end);
      if (*end == '\0')
        result[table[0][j]].push_back(number);
    }
  return result;
}

double largest(const std::vector<double>& numbers)
{
  return *std::max_element(numbers.begin(), numbers.end());
}

} // namespace

TEST_CASE("dynamics and eval agree: the generalized force is what torques and ground reactions give",
          "[torquectl_dynamics]")
{
  const TemporaryFolder folder;
  const std::string answers = folder.file("a.csv");
  REQUIRE(run({"eval", kWalk, "--robot", "human-subject01", "-o", answers}).code == 0);
  const auto answer = columns(answers);
  const auto walk = columns(kWalk);
  const Robot robot = load_robot("human-subject01");
  for (const std::string coordinates : {"absolute", "relative"})
  {
    const std::string out = folder.file(coordinates + ".json");
    const Run done =
        run({"dynamics", kWalk, "--robot", "human-subject01", "-o", out, "--coordinates", coordinates, "--regressor"});
    CHECK(done.code == 0);
    CHECK(done.err == "");
    CHECK(done.out == "human-subject01: 447 of 447 samples, in " + coordinates + " coordinates\n");
    const std::vector<Json> equations = objects(out);
    REQUIRE(equations.size() == 447);
    for (std::size_t i = 0; i < equations.size(); ++i)
    {
      CAPTURE(coordinates, i);
      const Json& equation = equations[i];
      CHECK(equation["utime"] == answer.at("utime")[i]);
      const Eigen::VectorXd force = vector(equation["generalized_force"]);
      Eigen::VectorXd torque(6), w(equation["J"].size());
      for (int j = 0; j < 6; ++j)
        torque(j) = answer.at("tau_" + robot.actuators[static_cast<std::size_t>(j)].name)[i];
      Eigen::Index row = 0;
      for (const std::string side : {"L", "R"})
        if (walk.at("contact" + side)[i] != 0.0)
        {
          w.segment<3>(row) << answer.at("fx" + side)[i], answer.at("fz" + side)[i], answer.at("moment" + side)[i];
          row += 3;
        }
      REQUIRE(row == w.size()); // on this walk every contact is a sole
      CHECK(mismatch(matrix(equation["B"]) * torque + matrix(equation["J"]).transpose() * w, force, 1e-10) == "");
      CHECK(mismatch(matrix(equation["Y"]) * vector(equation["alpha"]), force, 1e-10) == "");
    }
  }
}

TEST_CASE("wrenches gives the torques of eval by the second way, and leaves no residual", "[torquectl_dynamics]")
{
  const TemporaryFolder folder;
  const std::string answers = folder.file("a.csv"), wrenches = folder.file("w.csv");
  // rabbit has motors with inertia
  const std::string rabbit =
      folder.write("rabbit.csv", "time,q1,q2,q3,q4,q6,dq1,dq2,dq3,dq4,dq6,ddq1,ddq2,ddq3,ddq4,ddq6,contactL,contactR\n"
                                 "0,0.1,0.3,-0.3,-0.4,0,1,2,3,4,5,6,7,8,9,10,heel,heel\n");
  using Row = std::pair<std::string, std::string>;
  for (const auto& [robot, file] :
       {Row{"human-subject01", kWalk}, Row{"rabbit", rabbit}, Row{"compass", TRAJECTORIES "/compass/case-b.csv"}})
  {
    REQUIRE(run({"eval", file, "--robot", robot, "-o", answers}).code == 0);
    const Run done = run({"wrenches", file, "--robot", robot, "-o", wrenches});
    CHECK(done.code == 0);
    CHECK(done.out.find("samples answered, 0 rejected") != std::string::npos);
    const auto answer = columns(answers);
    const auto found = columns(wrenches);
    for (const auto& [name, values] : answer)
      if (name.starts_with("tau_"))
        for (std::size_t i = 0; i < values.size(); ++i)
          CHECK(mismatch(found.at(name)[i], values[i], 1e-9) == "");
    for (const char* residual : {"residual_fx", "residual_fz", "residual_m"})
      for (const double value : found.at(residual))
        CHECK(std::abs(value) < 1e-9);
  }
}

TEST_CASE("wrenches says where and what the joints carry: a compass at rest", "[torquectl_dynamics]")
{
  // statics: the swing leg hangs its 5 kg on the hip; with it the hip's 10 kg and the stance leg's 5 kg stand on the
  // foot
  const TemporaryFolder folder;
  const std::string out = folder.file("w.csv");
  REQUIRE(run({"wrenches", TRAJECTORIES "/compass/case-a.csv", "--robot", "compass", "-o", out}).code == 0);
  const auto found = columns(out);
  const double c = std::sqrt(0.5), g = 9.81;
  CHECK(mismatch(found.at("x_swing_leg")[0], c, 1e-12) == "");
  CHECK(mismatch(found.at("z_swing_leg")[0], c, 1e-12) == "");
  CHECK(mismatch(found.at("fz_swing_leg")[0], 5.0 * g, 1e-12) == "");
  CHECK(mismatch(found.at("fz_hip")[0], 15.0 * g, 1e-12) == "");
  CHECK(mismatch(found.at("fz_stance_leg")[0], 20.0 * g, 1e-12) == "");
  CHECK(mismatch(found.at("fx_stance_leg")[0], 0.0, 1e-12) == "");
  // the swing leg is level: its weight half a metre from the hip
  CHECK(mismatch(found.at("tau_q2")[0], 5.0 * g * 0.5, 1e-12) == "");
  CHECK(mismatch(found.at("m_stance_leg")[0], found.at("tau_q1")[0], 1e-12) == "");
}

TEST_CASE("the compass biped's published motions need the published torques", "[torquectl_dynamics]")
{
  // [De-León-Gómez 2017, section 4]; the paper cuts its decimals off. τ1 is that of relative, τ̄1 that of absolute
  // coordinates, of which b has none printed
  struct Row
  {
    std::string motion;
    double tau, tau_bar, printed_tau, printed_tau_bar;
  };
  const std::vector<Row> table{{"case-a", 145.917557, 121.392557, 145.9175, 121.3925},
                               {"case-b", 144.465824, 123.083687, 144.46, 123.083687},
                               {"case-c", 152.730239, 135.388445, 152.73, 135.38}};
  const TemporaryFolder folder;
  for (const Row& row : table)
  {
    CAPTURE(row.motion);
    const std::string file = std::string(TRAJECTORIES) + "/compass/" + row.motion + ".csv";
    REQUIRE(run({"eval", file, "--robot", "compass", "-o", folder.file("a.csv")}).code == 0);
    REQUIRE(run({"dynamics", file, "--robot", "compass", "-o", folder.file("d.json")}).code == 0);
    const double tau = largest(columns(folder.file("a.csv")).at("tau_q1"));
    std::vector<double> absolute;
    for (const Json& equation : objects(folder.file("d.json")))
      absolute.push_back(equation["generalized_force"][0]);
    // sampled every 10 ms, a smooth maximum is missed by at most some 2e-4 N m
    CHECK(std::abs(tau - row.tau) < 3e-4);
    CHECK(std::abs(largest(absolute) - row.tau_bar) < 3e-4);
    CHECK(tau - row.printed_tau < 0.01);
    CHECK(largest(absolute) - row.printed_tau_bar < 0.01);
  }
}

TEST_CASE("along a motion the energy changes at the rate of the power", "[torquectl_dynamics]")
{
  const TemporaryFolder folder;
  const std::string out = folder.file("d.json");
  REQUIRE(run({"dynamics", TRAJECTORIES "/compass/case-b.csv", "--robot", "compass", "-o", out}).code == 0);
  const std::vector<Json> equations = objects(out);
  const auto energy = [&](std::size_t i)
  {
    return equations[i]["kinetic_energy"].get<double>() + equations[i]["potential_energy"].get<double>();
  };
  for (std::size_t i = 2; i + 2 < equations.size(); ++i)
  {
    // differences of fourth order, 10 ms apart, of a motion with a period of 6 s
    const double rate = (energy(i - 2) - 8.0 * energy(i - 1) + 8.0 * energy(i + 1) - energy(i + 2)) / (12.0 * 0.01);
    CHECK(std::abs(rate - equations[i]["power"].get<double>()) < 1e-6);
  }
  // at rest both legs of case a: 5 kg half way up the stance leg, 10 and 5 kg at the hip's height; the swing leg is
  // level
  REQUIRE(run({"dynamics", TRAJECTORIES "/compass/case-a.csv", "--robot", "compass", "-o", out}).code == 0);
  const Json resting = objects(out).front();
  CHECK(resting["kinetic_energy"] == 0.0);
  CHECK(resting["power"] == 0.0);
  CHECK(mismatch(resting["potential_energy"].get<double>(), 9.81 * std::sqrt(0.5) * (2.5 + 15.0), 1e-12) == "");
}

TEST_CASE("a sample that has no answer has a line that says why", "[torquectl_dynamics]")
{
  const TemporaryFolder folder;
  const std::string file = folder.write("m.csv", "time,q1,q2,dq1,dq2,ddq1,ddq2,contactL,contactR\n"
                                                 "0,1,1,0,0,0,0,sole,none\n1,1,1,0,0,0,0,heel,none\n"
                                                 "2,1,1,1e120,0,0,0,sole,none\n");
  const Run done = run({"dynamics", file, "--robot", "compass", "-o", folder.file("d.json")});
  CHECK(done.code == 0);
  CHECK(done.out == "compass: 1 of 3 samples, in absolute coordinates\n");
  CHECK(done.err.find(file + ":3: left_contact is 1, but the left foot is fixed to the world") != std::string::npos);
  const std::vector<Json> equations = objects(folder.file("d.json"));
  CHECK(equations[0].contains("M"));
  CHECK(equations[1]["utime"] == 1'000'000);
  CHECK(equations[1]["error"].get<std::string>().find("stands as SOLE (2)") != std::string::npos);
  CHECK(equations[2]["error"].get<std::string>().find("not finite") != std::string::npos);

  REQUIRE(run({"wrenches", file, "--robot", "compass", "-o", folder.file("w.csv")}).code == 0);
  const auto table = rows(folder.file("w.csv"));
  CHECK(table[1].back() == "");
  CHECK(table[2].back() == "NOT_SUPPORTED");
  CHECK(table[2].front() == "1000000");
}

TEST_CASE("dynamics and wrenches write to the terminal, and nothing else there", "[torquectl_dynamics]")
{
  const std::string file = TRAJECTORIES "/compass/case-a.csv";
  const Run dynamics = run({"dynamics", file, "--robot", "compass", "-o", "-"});
  CHECK(std::count(dynamics.out.begin(), dynamics.out.end(), '\n') == 61);
  CHECK(dynamics.out.starts_with("{\"utime\":0,\"M\":[["));
  const Run wrenches = run({"wrenches", file, "--robot", "compass", "-o", "-"});
  CHECK(std::count(wrenches.out.begin(), wrenches.out.end(), '\n') == 64); // a header, two comments, 61 rows
  CHECK(wrenches.out.starts_with("utime,x_stance_leg,z_stance_leg,fx_stance_leg,fz_stance_leg,m_stance_leg,x_hip,"));
}

TEST_CASE("the multipliers are the ground reactions, whatever the elimination, and null without an answer",
          "[torquectl_dynamics]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("walk.csv"), answers = folder.file("a.csv");
  REQUIRE(run({"gait", "--robot", "rk", "--rate", "20", "-o", walk}).code == 0);
  REQUIRE(run({"eval", walk, "--robot", "rk", "--method", "human-transition", "-o", answers}).code == 0);
  const auto table = rows(walk), answered = rows(answers);
  const auto at = [](const std::vector<std::vector<std::string>>& cells, std::size_t row, const std::string& name)
  {
    return cells[row + 1]
                [static_cast<std::size_t>(std::find(cells[0].begin(), cells[0].end(), name) - cells[0].begin())];
  };
  for (const std::string name : {"partitioning", "qr", "svd", "zero-eigenvalue", "schur", "putd"})
    for (const std::string coordinates : {"absolute", "relative"})
    {
      CAPTURE(name, coordinates);
      const std::string out = folder.file("d.json");
      const Run done = run({"dynamics", walk, "--robot", "rk", "-o", out, "--reduced", "--elimination", name,
                            "--method", "human-transition", "--coordinates", coordinates});
      CAPTURE(done.err);
      REQUIRE(done.code == 0);
      const std::vector<Json> equations = objects(out);
      REQUIRE(equations.size() + 1 == table.size());
      for (std::size_t i = 0; i < equations.size(); ++i)
      {
        CAPTURE(i);
        const Json& equation = equations[i];
        std::vector<double> w;
        for (const std::string side : {"L", "R"})
          if (const std::string contact = at(table, i, "contact" + side); contact != "none")
          {
            w.push_back(std::stod(at(answered, i, "fx" + side)));
            w.push_back(std::stod(at(answered, i, "fz" + side)));
            if (contact == "sole")
              w.push_back(std::stod(at(answered, i, "moment" + side)));
          }
        CHECK(mismatch(vector(equation["multipliers"]),
                       Eigen::Map<const Eigen::VectorXd>(w.data(), static_cast<Eigen::Index>(w.size())), 1e-9) == "");
        CHECK(equation["independent"].size() == (name == "partitioning" ? 9 - w.size() : 0));
        // the walk keeps its contacts: its rates and accelerations are F's, and the reduced equation holds
        const Eigen::MatrixXd F = matrix(equation["F"]);
        CHECK(mismatch(matrix(equation["J"]) * F, Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(w.size()), F.cols()),
                       1e-12) == "");
        CHECK(matrix(equation["reduced_mass"]).llt().info() == Eigen::Success);
      }
    }

  // a motion that cannot be answered has an equation, and no multipliers
  const std::string falls = folder.write("toe.csv", "time,q0,q1,q2,q3,q4,q5,q6,dq0,dq1,dq2,dq3,dq4,dq5,dq6,ddq0,ddq1,"
                                                    "ddq2,ddq3,ddq4,ddq5,ddq6,contactL,contactR\n"
                                                    "0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,toe,none\n");
  const std::string out = folder.file("toe.json");
  REQUIRE(run({"dynamics", falls, "--robot", "ck", "--reduced", "-o", out}).code == 0);
  CHECK(objects(out)[0]["multipliers"].is_null());
  CHECK(objects(out)[0]["F"].size() == 9);
  // without --reduced nothing of it
  REQUIRE(run({"dynamics", falls, "--robot", "ck", "-o", out}).code == 0);
  CHECK_FALSE(objects(out)[0].contains("F"));
  CHECK_FALSE(objects(out)[0].contains("multipliers"));

  for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{
           {"--elimination", "qr"}, {"--method", "constrained"}, {"--reduced", "--elimination", "gauss"}})
  {
    std::vector<std::string> words{"dynamics", walk, "--robot", "rk", "-o", out};
    words.insert(words.end(), more.begin(), more.end());
    CHECK(run(words).code == 64);
  }
}

} // namespace torquectl_dynamics_test
