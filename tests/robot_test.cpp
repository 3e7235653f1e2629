#include "catch.h"
#include "matchers.h"

#include "planar/kinematics.h"
#include "robot/files/load.h"
#include "robot/files/strict_toml.h"
#include "robot/files/toml_robot.h"
#include "robot/robot.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

namespace robot_test
{

using namespace torqued;

namespace
{

const std::string& ck_text()
{
  static const std::string text(shipped_robot_toml("ck"));
  return text;
}

// a robot that ships with one piece of its text replaced
std::string changed(const std::string& from, const std::string& to, std::string_view robot = "ck")
{
  std::string text(shipped_robot_toml(robot));
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

int line_of(const std::string& text, const std::string& piece)
{
  const std::size_t at = text.find(piece);
  REQUIRE(at != std::string::npos);
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

std::string complaint(const std::string& text)
{
  try
  {
    read_toml_robot(text, "r.toml");
    return "";
  }
  catch (const FileError& error)
  {
    return error.what();
  }
}

} // namespace

TEST_CASE("every robot that ships loads, under its own name and with a source for its numbers", "[robot]")
{
  using Names = std::vector<std::string>;
  struct Row
  {
    std::string name;
    Names absolute, relative, joints;
    bool fixed_root;
  };
  const Names seven{"q0", "q1", "q2", "q3", "q4", "q5", "q6"};
  const Names six_joints{"left_ankle", "left_knee", "left_hip", "right_hip", "right_knee", "right_ankle"};
  const Names four_joints{"left_knee", "left_hip", "right_hip", "right_knee"};
  const auto with_root = [](Names names)
  {
    names.push_back("q6");
    return names;
  };
  const std::vector<Row> rows{
      {"ck", seven, with_root(six_joints), six_joints, false},
      {"rk", seven, with_root(six_joints), six_joints, false},
      {"six-link", {"q1", "q2", "q6", "q3", "q4", "q5"}, six_joints, six_joints, true},
      {"compass", {"theta_s", "theta_ns"}, {"q1", "q2"}, {"q1", "q2"}, true},
      {"bip-itlag",
       {"theta1", "theta2", "theta3", "theta4", "r"},
       {"q1", "q2", "q4", "q5", "r"},
       {"q1", "q2", "q4", "q5", "r"},
       true},
      {"human-subject01", seven, with_root(six_joints), six_joints, false},
      {"rabbit", {"q1", "q2", "q3", "q4", "q6"}, with_root(four_joints), four_joints, false},
  };
  REQUIRE(shipped_robot_names().size() == rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
  {
    const Row& row = rows[i];
    CAPTURE(row.name);
    CHECK(shipped_robot_names()[i] == row.name);
    const Robot robot = load_robot(row.name);
    CHECK(robot.name == row.name);
    CHECK_FALSE(robot.source.empty());
    CHECK(robot.model_id != 0);
    CHECK(robot.absolute_names == row.absolute);
    CHECK(robot.relative_names == row.relative);
    CHECK(robot.fixed_root() == row.fixed_root);
    CHECK(robot.base_names == (row.fixed_root ? std::array<std::string, 2>{} : std::array<std::string, 2>{"xH", "zH"}));
    Names joints;
    for (const Actuator& actuator : robot.actuators)
      joints.push_back(actuator.name);
    CHECK(joints == row.joints);
  }
  CHECK(mismatch(load_robot("ck").mechanism.mass(), 45.0, 1e-14) == "");
  CHECK(mismatch(load_robot("ck").leg_length, 0.79, 1e-14) == "");
  CHECK(mismatch(load_robot("rk").mechanism.mass(), 45.0, 1e-14) == "");
  CHECK(mismatch(load_robot("rk").leg_length, 0.79, 1e-14) == "");
}

TEST_CASE("relative coordinates are the actuators' angles, then the root's", "[robot]")
{
  const Robot robot = load_robot("ck");
  MatrixQ A(7, 7);
  A << -1, 1, 0, 0, 0, 0, 0, //
      0, -1, 1, 0, 0, 0, 0,  //
      0, 0, -1, 0, 0, 0, 1,  //
      0, 0, 0, -1, 0, 0, 1,  //
      0, 0, 0, 1, -1, 0, 0,  //
      0, 0, 0, 0, 1, -1, 0,  //
      0, 0, 0, 0, 0, 0, 1;
  CHECK(mismatch(robot.A, A, 0.0) == "");
  CHECK(mismatch(robot.b, Eigen::VectorXd::Zero(7), 0.0) == "");
  CHECK(mismatch(robot.A * robot.A_inverse, Eigen::MatrixXd::Identity(7, 7), 1e-15) == "");
  CHECK(robot.relative_names == std::vector<std::string>{"left_ankle", "left_knee", "left_hip", "right_hip",
                                                         "right_knee", "right_ankle", "q6"});
}

TEST_CASE("the trunk is half way between the feet, and each leg is what hangs between it and a foot", "[robot]")
{
  const auto legs = [](const Robot& robot)
  {
    std::string text = robot.trunk < 0 ? "" : robot.link(robot.trunk).name + ":";
    for (std::size_t i = 0; i < robot.links.size(); ++i)
      if (robot.leg[i])
        text += " " + robot.links[i].name + (*robot.leg[i] == Side::left ? " left" : " right");
    return text;
  };
  const std::string seven =
      "trunk: left_foot left, left_shin left, left_thigh left, right_thigh right, right_shin right, "
      "right_foot right";
  const auto sorted = [](std::string text)
  {
    std::replace(text.begin(), text.end(), ',', ' ');
    std::istringstream words(text);
    std::vector<std::string> all{std::istream_iterator<std::string>(words), {}};
    std::sort(all.begin(), all.end());
    return all;
  };
  CHECK(sorted(legs(load_robot("ck"))) == sorted(seven));
  CHECK(sorted(legs(load_robot("rk"))) == sorted(seven));
  // the tree begins at the left foot; the legs are the same
  CHECK(sorted(legs(load_robot("six-link"))) == sorted(seven));
  CHECK(sorted(legs(load_robot("rabbit"))) ==
        sorted("trunk: left_shin left, left_thigh left, right_thigh right, right_shin right"));
  // one foot only
  CHECK(load_robot("compass").trunk == -1);
  CHECK(legs(load_robot("compass")).empty());
  // what hangs on the trunk is carried with it, what hangs on a leg is the leg's
  const std::string more =
      "[[link]]\nname = \"arm\"\njoint = \"fixed\"\nparent = \"trunk\"\nat = [0, 0]\nmass = 1\ncom = [0, 0]\n"
      "inertia = 0\n[[link]]\nname = \"bag\"\njoint = \"fixed\"\nparent = \"left_thigh\"\nat = [0, 0]\nmass = 1\n"
      "com = [0, 0]\ninertia = 0\n";
  CHECK(sorted(legs(read_toml_robot(ck_text() + more, "more.toml"))) == sorted(seven + " bag left"));
}

TEST_CASE("human-subject01 has the numbers published with the measured walk", "[robot]")
{
  std::ifstream file(TRAJECTORIES "/subject01-walk/params.json");
  REQUIRE(file);
  const nlohmann::json params = nlohmann::json::parse(file);
  const auto number = [&](const char* part, const char* key)
  {
    return params.at(part).at(key).get<double>();
  };
  const Robot robot = load_robot("human-subject01");
  CHECK(robot.mechanism.gravity() == params.at("gravity").get<double>());
  CHECK(mismatch(robot.mechanism.mass(), params.at("mass_total").get<double>(), 1e-6) == "");
  CHECK(mismatch(robot.leg_length, number("shin", "l1") + number("thigh", "l2"), 1e-15) == "");
  for (const Link& link : robot.links)
  {
    CAPTURE(link.name);
    const bool foot = link.name.ends_with("foot");
    const bool trunk = link.name == "trunk";
    const char* part = foot ? "foot" : trunk ? "trunk" : link.name.ends_with("shin") ? "shin" : "thigh";
    CHECK(link.mass == number(part, "m"));
    CHECK(link.inertia == number(part, "I_com"));
    const Eigen::Vector2d com = foot    ? Eigen::Vector2d(number(part, "s_x"), -number(part, "s_z"))
                                : trunk ? Eigen::Vector2d(0.0, number(part, "s3_from_hip"))
                                : link.name.ends_with("shin") ? Eigen::Vector2d(0.0, -number(part, "s1_from_knee"))
                                                              : Eigen::Vector2d(0.0, -number(part, "s2_from_hip"));
    CHECK(mismatch(link.com, com, 0.0) == "");
  }
  for (const Foot& foot : robot.feet)
  {
    CHECK(foot.ankle_height() == number("foot", "h_p"));
    CHECK(foot.heel_x() == -number("foot", "l_p"));
    CHECK(mismatch(foot.toe_x() - foot.heel_x(), number("foot", "L_p"), 1e-15) == "");
  }
}

TEST_CASE("the model id changes with what is computed, and not with what is drawn or said", "[robot]")
{
  const std::int64_t id = load_robot("ck").model_id;
  const auto id_of = [](const std::string& text)
  {
    return read_toml_robot(text, "r.toml").model_id;
  };
  CHECK(id_of(ck_text()) == id);
  CHECK(id_of("# a comment\n" + ck_text()) == id);
  CHECK(id_of(changed("name = \"ck\"", "name = \"other\"")) == id);
  CHECK(id_of(changed("width = 0.12", "width = 0.2")) == id);
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"gravity = 9.81", "gravity = 9.82"},
           {"mass = 29.2", "mass = 29.200000000000003"},
           {"com = [0.0, 0.19]", "com = [1e-9, 0.19]"},
           {"inertia = 0.81", "inertia = 0.82"},
           {"at = [0.0, -0.39]", "at = [0.0, -0.391]"},
           {"torque_limit = 150.0", "torque_limit = 151.0"},
           {"torque_limit = 150.0", "torque_limit = 150.0\nrate_limit = 1e5"},
           {"torque_limit = 150.0", "torque_limit = 150.0\noffset = 0.1"},
           {"torque_limit = 150.0", "torque_limit = 150.0\nstick_velocity = 0.01"},
           {"friction = 0.6", "friction = 0.61"},
           {"friction = 0.6", "friction = 0.6\nf_min = 1"},
           {"toe = [0.15, -0.065]", "toe = [0.16, -0.065]"},
           {"coordinate = \"q0\"", "coordinate = \"left_foot\""},
           {"base = [\"xH\", \"zH\"]", "base = [\"x\", \"z\"]"}})
  {
    CAPTURE(from, to);
    CHECK(id_of(changed(from, to)) != id);
  }
}

TEST_CASE("a bad robot file is refused with file, line, key and what would be right", "[robot]")
{
  struct Row
  {
    std::string from, to, at, message; // at: the piece of text on whose line the complaint is
  };
  const std::vector<Row> rows{
      {"mass = 29.2", "mass = -29.2", "mass = -29.2",
       "link 'trunk': mass: found -29.2; expected a number that is not negative"},
      {"mass = 29.2", "mass = nan", "mass = nan", "link 'trunk': mass: found nan; expected a finite number"},
      {"mass = 29.2", "mass = inf", "mass = inf", "link 'trunk': mass: found inf; expected a finite number"},
      {"mass = 29.2", "mass = \"29.2 kg\"", "29.2 kg", "link 'trunk': mass: found '29.2 kg'; expected a finite number"},
      {"mass = 29.2", "mass = 1,5", "mass = 1,5", "not TOML"},
      {"mass = 29.2", "mass = 1kg", "mass = 1kg", "not TOML"},
      {"mass = 29.2\n", "", "[[link]]\nname = \"trunk\"", "link 'trunk': mass: is missing; expected a finite number"},
      {"mass = 29.2\n", "mas = 29.2\n", "[[link]]\nname = \"trunk\"",
       "link 'trunk': mass: is missing; expected a finite number; mas in line 82 is not known here"},
      {"mass = 29.2", "mass = 29.2\nmasss = 1.0", "masss",
       "link 'trunk': masss: is not known here; known are: base, com,"},
      {"inertia = 0.81", "inertia = -0.81", "-0.81", "link 'trunk': inertia: found -0.81"},
      {"com = [0.0, 0.19]", "com = [0.0, 0.19, 0.0]", "0.19, 0.0]", "link 'trunk': com: found"},
      {"com = [0.0, 0.19]", "com = 0.19", "com = 0.19", "expected two finite numbers, [x, z]"},
      {"joint = \"floating\"", "joint = \"prismatic\"", "prismatic",
       "found \"prismatic\"; expected one of: floating, revolute, rolling, parallel, slide, fixed"},
      {"joint = \"floating\"", "joint = \"fixed\"\nparent = \"left_thigh\"\nat = [0.0, 0.0]", "base = [",
       "base: is not known here"},
      {"name = \"trunk\"", "name = \"left_foot\"", "[[link]]\nname = \"left_foot\"\njoint = \"floating\"",
       "two links are called \"left_foot\""},
      {"parent = \"trunk\"", "parent = \"trunc\"", "[[link]]\nname = \"left_thigh\"",
       "parent \"trunc\" is not the name of a link"},
      {"parent = \"trunk\"", "parent = \"left_foot\"", "[[link]]\nname = \"left_foot\"",
       "link 'left_foot' does not hang on the root"},
      {"name = \"ck\"", "name = \"a robot\"", "a robot", "name: found \"a robot\"; expected 1 to 64 letters"},
      {"name = \"ck\"\n", "", "# A planar", "name: is missing; expected a text in quotes"},
      {"gravity = 9.81", "gravity = 0", "gravity = 0", "gravity: found 0; expected a positive number"},
      {"gravity = 9.81", "gravity = true", "gravity = true", "gravity: found true; expected a finite number"},
      {"on = \"left_shin\"", "on = \"left_toe\"", "[[actuator]]\nname = \"left_ankle\"",
       "actuator 'left_ankle': on \"left_toe\" is not the name"},
      {"against = \"left_foot\"", "against = \"left_shin\"", "[[actuator]]\nname = \"left_ankle\"",
       "do not turn against each other"},
      {"torque_limit = 150.0", "torque_limit = -1", "torque_limit = -1", "torque_limit: found -1"},
      {"torque_limit = 150.0", "gear = 50", "gear", "actuator 'left_ankle': gear: is not known"},
      {"name = \"left_knee\"\non = \"left_thigh\"\nagainst = \"left_shin\"",
       "name = \"left_knee\"\non = \"left_shin\"\nagainst = \"left_foot\"", "[[actuator]]\nname = \"right_ankle\"",
       "the actuators do not reach every link"},
      {"[[actuator]]\nname = \"left_ankle\"\non = \"left_shin\"\nagainst = \"left_foot\"\ntorque_limit = 150.0\n", "",
       "[[actuator]]\nname = \"right_ankle\"",
       "there are 5 actuators; a robot needs one for each link that moves against the others, 6"},
      {"name = \"left_knee\"", "name = \"left_ankle\"", "[[actuator]]\nname = \"left_ankle\"\non = \"left_thigh\"",
       "two actuators are called \"left_ankle\""},
      {"coordinate = \"q1\"", "coordinate = \"q0\"", "[[link]]\nname = \"left_shin\"",
       "two absolute coordinates are called \"q0\""},
      {"coordinate = \"q1\"", "coordinate = \"xH\"", "[[link]]\nname = \"left_shin\"",
       "two absolute coordinates are called \"xH\""},
      {"base = [\"xH\", \"zH\"]", "base = [\"xH\"]", "base = [", "base: found"},
      {"base = [\"xH\", \"zH\"]", "base = [\"x,H\", \"zH\"]", "base = [",
       "base: found \"x,H\"; expected two names of 1 to 64 letters, digits, _ or -"},
      {"base = [\"xH\", \"zH\"]", "base = [\"\", \"\"]", "base = [", "base: found \"\"; expected two names"},
      {"side = \"right\"", "side = \"left\"", "[[foot]]\nside = \"left\"\nlink = \"right_foot\"",
       "there is a second left foot"},
      {"link = \"right_foot\"", "link = \"left_foot\"", "[[foot]]\nside = \"right\"",
       "both feet are on link 'left_foot'; each needs a link of its own"},
      {"side = \"left\"", "side = \"middle\"", "middle", "expected one of: left, right"},
      {"link = \"left_foot\"", "link = \"left_hand\"", "[[foot]]\nside = \"left\"",
       "left foot: link \"left_hand\" is not the name of a link"},
      {"toe = [0.15, -0.065]\n", "", "[[foot]]\nside = \"left\"", "left foot: toe: is missing"},
      {"toe = [0.15, -0.065]", "toe = [0.15, -0.06]", "[[foot]]\nside = \"left\"",
       "the toe must lie before the heel and as high as it"},
      {"toe = [0.15, -0.065]", "toe = [-0.15, -0.065]", "[[foot]]\nside = \"left\"",
       "the toe must lie before the heel"},
      {"friction = 0.6", "friction = -0.6", "friction = -0.6", "friction: found -0.6"},
      {"friction = 0.6\n", "", "[[foot]]\nside = \"left\"", "left foot: friction: is missing"},
      {"width = 0.12", "width = 0.12, height = 1", "height", "link 'trunk': draw 1: height: is not known here"},
  };
  for (const Row& row : rows)
  {
    const std::string text = changed(row.from, row.to);
    const std::string found = complaint(text);
    CAPTURE(row.from, row.to, found);
    CHECK(found.find(row.message) != std::string::npos);
    CHECK(found.starts_with(fmt::format("r.toml:{}:", line_of(text, row.at))));
  }
}

TEST_CASE("joints that roll, slide or stand on the world are checked too", "[robot]")
{
  struct Row
  {
    std::string robot, from, to, at, message; // at: the piece of text on whose line the complaint is
  };
  const std::string left_shin = "[[link]]\nname = \"left_shin\"";
  const std::string left_knee = "[[actuator]]\nname = \"left_knee\"";
  const std::vector<Row> rows{
      {"rk", "parent_radius = 0.035\n", "", left_shin,
       "link 'left_shin': parent_radius: is missing; expected a finite number"},
      {"rk", "child_radius = 0.05\n", "", left_shin,
       "link 'left_shin': child_radius: is missing; expected a finite number"},
      {"rk", "parent_radius = 0.035", "parent_radius = -0.035", "-0.035",
       "parent_radius: found -0.035; expected a number that is not negative"},
      {"rk", "parent_radius = 0.035\nchild_radius = 0.05", "parent_radius = 0\nchild_radius = 0", left_shin,
       "parent_radius and child_radius are both 0; that is a revolute joint"},
      {"rk", "child_radius = 0.05", "child_radius = 0", left_knee,
       "actuator 'left_knee': between = \"bar-parent\", but these two do not turn against each other, because a "
       "radius"},
      {"rk", "between = \"bar-parent\"", "between = \"bar\"", "\"bar\"",
       "actuator 'left_knee': between: found \"bar\"; expected one of: links, bar-parent, bar-child"},
      {"ck", "name = \"left_knee\"", "name = \"left_knee\"\nbetween = \"bar-child\"", left_knee,
       "between = \"bar-child\", but there is no rolling joint between its links"},
      {"ck", "parent = \"trunk\"", "parent = \"trunk\"\nparent_radius = 0.1", "parent_radius",
       "link 'left_thigh': parent_radius: is not known here"},
      {"ck", "parent = \"trunk\"", "parent = \"trunk\"\nangle = 0.1", "angle",
       "link 'left_thigh': angle: is not known"},
      {"ck", "joint = \"revolute\"\nparent = \"trunk\"\nat = [0.0, 0.0]", "joint = \"revolute\"\nparent = \"world\"",
       "[[link]]\nname = \"left_thigh\"", "link 'left_thigh' is revolute on the world; a root that does not float"},
      {"ck", "joint = \"revolute\"\nparent = \"left_shin\"", "joint = \"floating\"", "at = [", "at: is not known here"},
      {"ck", "joint = \"revolute\"\nparent = \"left_shin\"\nat = [0.0, -0.39]\ncoordinate = \"q0\"",
       "joint = \"parallel\"\nparent = \"left_shin\"\nat = [0.0, -0.39]", "[[link]]\nname = \"left_foot\"",
       "link 'left_foot' is parallel to the world, but the root floats"},
      {"ck", "against = \"left_foot\"", "against = \"world\"", "[[actuator]]\nname = \"left_ankle\"",
       "actuator 'left_ankle': against the world, but the root floats"},
      {"ck", "on = \"left_shin\"", "on = \"world\"", "[[actuator]]\nname = \"left_ankle\"",
       "actuator 'left_ankle': on \"world\" is not the name of a link"},
      {"ck", "torque_limit = 150.0", "stribeck_velocity = 0", "stribeck_velocity",
       "actuator 'left_ankle': stribeck_velocity: found 0; expected a positive number"},
      {"ck", "torque_limit = 150.0", "stick_velocity = -0.1", "stick_velocity",
       "actuator 'left_ankle': stick_velocity: found -0.1; expected a number that is not negative"},
      {"ck", "torque_limit = 150.0", "rotor_inertia = -1", "rotor_inertia", "rotor_inertia: found -1; expected"},
      {"ck", "torque_limit = 150.0", "coulomb = -1", "coulomb", "coulomb: found -1; expected a number that is not"},
      {"ck", "torque_limit = 150.0", "viscous = inf", "viscous", "viscous: found inf; expected a finite number"},
      {"ck", "torque_limit = 150.0", "rate_limit = -1", "rate_limit", "rate_limit: found -1; expected"},
      {"ck", "torque_limit = 150.0", "offset = \"0\"", "offset", "offset: found '0'; expected a finite number"},
      {"ck", "name = \"trunk\"", "name = \"world\"", "name = \"world\"",
       "name: found \"world\"; that is what a fixed root"},
      {"ck", "gravity = 9.81", "urdf = \"no.urdf\"", "urdf",
       "urdf: no.urdf cannot be read; expected a URDF of at most 1 MB"},
      {"six-link", "side = \"left\"\nlink = \"left_foot\"", "side = \"left\"\nlink = \"left_shin\"",
       "[[link]]\nname = \"left_foot\"", "link 'left_foot' is fixed to the world, but is no [[foot]]"},
      {"six-link", "parent = \"world\"", "parent = \"world\"\ncoordinate = \"q0\"", "coordinate = \"q0\"",
       "link 'left_foot': coordinate: is not known here"},
      {"six-link", "parent = \"world\"", "parent = \"world\"\nbase = [\"x\", \"z\"]", "base",
       "base: is not known here"},
      {"six-link", "parent = \"left_foot\"", "parent = \"left_shin\"", left_shin, "does not hang on the root"},
      {"bip-itlag", "joint = \"slide\"", "joint = \"parallel\"", "coordinate = \"r\"", "coordinate: is not known here"},
      {"bip-itlag", "on = \"counterweight\"\nagainst = \"pelvis\"", "on = \"counterweight\"\nagainst = \"stance_foot\"",
       "[[actuator]]\nname = \"r\"", "actuator 'r': 'counterweight' and 'stance_foot' do not turn against each other"},
      {"rabbit", "side = \"right\"", "side = \"left\"", "[[foot]]\nside = \"left\"\nlink = \"right_shin\"",
       "there is a second left foot"},
  };
  for (const Row& row : rows)
  {
    const std::string text = changed(row.from, row.to, row.robot);
    const std::string found = complaint(text);
    CAPTURE(row.robot, row.from, row.to, found);
    CHECK(found.find(row.message) != std::string::npos);
    CHECK(found.starts_with(fmt::format("r.toml:{}:", line_of(text, row.at))));
  }
}

TEST_CASE("a file that is no robot at all is refused", "[robot]")
{
  CHECK(complaint("") == "r.toml:1: name: is missing; expected a text in quotes");
  CHECK(complaint("name = \"x\"\n").find("there is no [[link]]") != std::string::npos);
  CHECK(complaint(std::string("name = \"\0\"", 10)).find("not TOML") != std::string::npos);
  CHECK(complaint("link = 3\nname = \"x\"").find("link: found 3; expected tables, [[link]]") != std::string::npos);

  std::string many = "name = \"many\"\n[[link]]\nname = \"l0\"\njoint = \"floating\"\nmass = 1\ninertia = 1\n";
  for (int i = 1; i < 20; ++i)
    many += fmt::format(
        "[[link]]\nname = \"l{}\"\nparent = \"l{}\"\njoint = \"revolute\"\nat = [0, 0]\nmass = 1\ninertia = 1\n", i,
        i - 1);
  CHECK(complaint(many).find("link 'l14' is one too many that moves; at most 14 are possible") != std::string::npos);

  try
  {
    load_robot("no-such-robot");
    FAIL("loaded");
  }
  catch (const FileError& error)
  {
    CHECK(std::string(error.what()) ==
          "\"no-such-robot\" is neither a robot that ships (ck, rk, six-link, compass, bip-itlag, human-subject01, "
          "rabbit) nor a .toml or .urdf file");
  }
  CHECK_THROWS_AS(load_robot("/no/such/file.toml"), FileError);
  CHECK_THROWS_AS(load_robot("/tmp/.toml"), FileError);
}

TEST_CASE("without actuators in the file each link that turns is driven against its parent", "[robot]")
{
  std::string text = ck_text();
  const std::size_t first = text.find("[[actuator]]");
  const std::size_t feet = text.find("[[foot]]");
  text.erase(first, feet - first);
  const Robot robot = read_toml_robot(text, "r.toml");
  REQUIRE(robot.num_joints() == 6);
  CHECK(robot.actuators[0].name == "left_foot");
  CHECK(robot.A(0, 0) == 1.0);
  CHECK(robot.A(0, 1) == -1.0);
  CHECK(std::isinf(robot.actuators[0].torque_limit));
}

TEST_CASE("a file nested deeper than the parser can go is refused", "[robot]")
{
  std::string dotted;
  for (int i = 0; i < 300'000; ++i)
    dotted += "a.";
  dotted += "a";
  std::string brackets(300'000, '[');
  for (const std::string& text :
       {dotted + " = 1", "\n[" + dotted + "]", "\n[[" + dotted + "]]", "x = {" + dotted + " = 1}", "x = " + brackets})
  {
    const std::string found = complaint(text);
    CAPTURE(found);
    CHECK(found.starts_with("r.toml:"));
    CHECK(found.size() < 300);
  }
}

TEST_CASE("numbers that are useless together are refused", "[robot]")
{
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"mass = 29.2", "mass = 1e308"},
                                                        {"gravity = 9.81", "gravity = 1e300"},
                                                        {"gravity = 9.81", "gravity = 1e-300"},
                                                        {"at = [0.0, -0.39]", "at = [0.0, 1e200]"},
                                                        {"inertia = 0.81", "inertia = 1e30"}})
  {
    const std::string found = complaint(changed(from, to));
    CAPTURE(from, to, found);
    CHECK(found.starts_with("r.toml:1: the robot weighs "));
  }
  std::string strokes = "draw = [";
  for (int i = 0; i < 17; ++i)
    strokes += "{ from = [0, 0], to = [0, 1] }, ";
  const std::string draw = "draw = [{ from = [0.0, 0.0], to = [0.0, 0.5], width = 0.12 }]";
  CHECK(complaint(changed(draw, strokes + "]")).find("link 'trunk': draw: found 17 strokes; expected at most 16") !=
        std::string::npos);
}

} // namespace robot_test
