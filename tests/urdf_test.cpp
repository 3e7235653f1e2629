#include "catch.h"
#include "matchers.h"
#include "oracles.h"
#include "same_numbers.h"
#include "temporary_folder.h"

#include "robot/files/load.h"
#include "robot/files/robot_files.h"
#include "robot/files/strict_toml.h"
#include "robot/files/toml_robot.h"
#include "robot/files/urdf_robot.h"

namespace urdf_test
{

using namespace torqued;

namespace
{

void check_same_drawing(const Robot& found, const Robot& expected)
{
  REQUIRE(found.links.size() == expected.links.size());
  for (std::size_t i = 0; i < found.links.size(); ++i)
  {
    CAPTURE(expected.links[i].name);
    CHECK(found.links[i].name == expected.links[i].name);
    REQUIRE(found.links[i].drawing.size() == expected.links[i].drawing.size());
    for (std::size_t k = 0; k < found.links[i].drawing.size(); ++k)
    {
      CHECK(found.links[i].drawing[k].from == expected.links[i].drawing[k].from);
      CHECK(found.links[i].drawing[k].to == expected.links[i].drawing[k].to);
      CHECK(found.links[i].drawing[k].width == expected.links[i].drawing[k].width);
    }
  }
}

Robot by_way_of_urdf(const Robot& robot)
{
  const TemporaryFolder folder;
  folder.write("robot.urdf", to_urdf(robot));
  return load_robot(folder.write("robot.toml", to_companion_toml(robot, "robot.urdf")));
}

// Two links that ride, turn, roll and slide on a trunk, every frame turned in space in its own way. What a rotation by
// rpy = (r, p, y) is to the plane is worked out by hand in kPlain, which says the same.
const std::string kTurned = R"(<?xml version="1.0"?>
<robot name="turned" version="1.0" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="trunk">
    <inertial>
      <origin xyz="0.02 0.3 0.19" rpy="1.5707963267948966 0 0"/>
      <mass value="29.2"/>
      <inertia ixx="0.9" ixy="0" ixz="0" iyy="0.7" iyz="0" izz="0.81"/>
    </inertial>
    <visual><geometry><box size="1 1 1"/></geometry></visual>
  </link>

  <!-- turned by +0.3 about y, clockwise in the plane; its axis is -y -->
  <joint name="hip" type="revolute">
    <origin xyz="0.1 0.2 -0.05" rpy="0 0.3 0"/>
    <parent link="trunk"/>
    <child link="thigh"/>
    <axis xyz="0 -2 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="10"/>
    <dynamics damping="0.1" friction="0.2"/>
  </joint>
  <link name="thigh">
    <inertial>
      <origin xyz="0.01 0 -0.17"/>
      <mass value="5"/>
      <inertia ixx="0.06" ixy="0" ixz="0" iyy="0.066" iyz="0" izz="0.01"/>
    </inertial>
    <collision/>
  </link>

  <!-- rolled by 90 degrees about x, so that its z axis is -y of the thigh -->
  <joint name="knee" type="continuous">
    <origin xyz="0 0 -0.4" rpy="1.5707963267948966 0 0"/>
    <parent link="thigh"/>
    <child link="shin"/>
    <axis xyz="0 0 1"/>
  </joint>
  <link name="shin">
    <inertial>
      <origin xyz="0.02 -0.16 0.7" rpy="0 0 0.4"/>
      <mass value="2.2"/>
      <inertia ixx="0.03" ixy="0.001" ixz="0.002" iyy="0.02" iyz="0.003" izz="0.028"/>
    </inertial>
  </link>

  <!-- rides on the shin at a constant angle; turned back by 90 degrees about x, and by -0.5 about y -->
  <joint name="mount" type="fixed">
    <origin xyz="0.05 -0.39 0" rpy="-1.5707963267948966 0 0.5"/>
    <parent link="shin"/>
    <child link="foot"/>
  </joint>
  <link name="foot">
    <inertial>
      <origin xyz="0.03 0 -0.04"/>
      <mass value="0.7"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.0025" iyz="0" izz="0.003"/>
    </inertial>
  </link>

  <!-- slides along the y axis of the trunk, which is its own -x -->
  <joint name="weight_slide" type="prismatic">
    <origin xyz="0.3 0 0.4" rpy="0 0 -1.5707963267948966"/>
    <parent link="trunk"/>
    <child link="weight"/>
    <axis xyz="-1 0 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="10"/>
  </joint>
  <link name="weight">
    <inertial>
      <origin xyz="0 0.05 0.06"/>
      <mass value="3"/>
      <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.3" iyz="0" izz="0.4"/>
    </inertial>
  </link>
</robot>
)";

std::string plain_toml()
{
  const double c = std::cos(0.3);
  const double s = std::sin(0.3);
  // a turn about y by p takes (x, z) to (x cos p + z sin p, z cos p - x sin p)
  const auto thigh_frame = [&](double x, double z)
  {
    return fmt::format("[{}, {}]", c * x + s * z, c * z - s * x);
  };
  // in the shin, x is along the thigh's x and y along its z; the foot is turned by -0.5 about y against the shin: +0.5
  // about the shin's z, which is -y
  const double cf = std::cos(0.3 - 0.5);
  const double sf = std::sin(0.3 - 0.5);
  const double x = 0.03;
  const double z = -0.04;
  return fmt::format(R"(
name = "plain"
[[link]]
name = "trunk"
joint = "floating"
mass = 29.2
com = [0.02, 0.19]
inertia = 0.81
[[link]]
name = "thigh"
joint = "revolute"
parent = "trunk"
at = [0.1, -0.05]
mass = 5
com = {}
inertia = 0.066
[[link]]
name = "shin"
joint = "revolute"
parent = "thigh"
at = {}
mass = 2.2
com = {}
inertia = 0.028
[[link]]
name = "foot"
joint = "fixed"
parent = "shin"
at = {}
mass = 0.7
com = [{}, {}]
inertia = 0.0025
[[link]]
name = "weight"
joint = "slide"
parent = "trunk"
at = [0.3, 0.4]
mass = 3
com = [0.05, 0.06]
inertia = 0.2
[[actuator]]
name = "hip"
on = "thigh"
against = "trunk"
[[actuator]]
name = "knee"
on = "shin"
against = "thigh"
[[actuator]]
name = "weight_slide"
on = "weight"
against = "trunk"
)",
                     thigh_frame(0.01, -0.17), thigh_frame(0.0, -0.4), thigh_frame(0.02, -0.16),
                     thigh_frame(0.05, -0.39), cf * x + sf * z, cf * z - sf * x);
}

// A thigh on a trunk, and a shin whose circle rolls on the thigh's: the bar between the centres stands at an angle.
struct RollingUrdf
{
  std::string first_axis = "0 -1 0", second_axis = "0 -1 0";
  std::string first_extra = "", second_extra = "", bar = "", more = "";

  std::string text() const
  {
    const auto joint = [](std::string_view name, std::string_view parent, std::string_view child, std::string_view at,
                          std::string_view axis, std::string_view extra)
    {
      return fmt::format("<joint name=\"{}\" type=\"revolute\"><origin xyz=\"{}\"/><parent link=\"{}\"/>\n"
                         "<child link=\"{}\"/><axis xyz=\"{}\"/>\n{}</joint>\n",
                         name, at, parent, child, axis, extra);
    };
    const std::string inertial = "<inertial><origin xyz=\"0.01 0 -0.1\"/><mass value=\"2\"/><inertia ixx=\"0\" "
                                 "ixy=\"0\" ixz=\"0\" iyy=\"0.03\" iyz=\"0\" izz=\"0\"/></inertial>";
    return "<robot name=\"roll\">\n<link name=\"thigh\">" + inertial + "</link>\n<link name=\"bar\">" + bar +
           "</link>\n<link name=\"shin\">" + inertial + "</link>\n" +
           joint("first", "thigh", "bar", "0.02 0 -0.36", first_axis, first_extra) +
           joint("second", "bar", "shin", "0.03 0 -0.08", second_axis, second_extra) + more + "</robot>\n";
  }
};

std::string rolling_toml(double parent_radius, double child_radius, std::string_view actuator)
{
  const std::string body = "mass = 2\ncom = [0.01, -0.1]\ninertia = 0.03\n";
  return fmt::format("name = \"roll\"\n[[link]]\nname = \"thigh\"\njoint = \"floating\"\n{}[[link]]\nname = \"shin\"\n"
                     "joint = \"rolling\"\nparent = \"thigh\"\nat = [0.02, -0.36]\nangle = {}\nparent_radius = {}\n"
                     "child_radius = {}\n{}[[actuator]]\nname = \"{}\"\non = \"shin\"\nagainst = \"thigh\"\n",
                     body, std::atan2(0.03, 0.08), parent_radius, child_radius, body, actuator);
}

std::string mimic(std::string_view joint, double multiplier)
{
  return fmt::format("<mimic joint=\"{}\" multiplier=\"{}\"/>\n", joint, multiplier);
}

std::string complaint(const std::string& text)
{
  try
  {
    read_urdf_robot(text, "r.urdf");
    return "";
  }
  catch (const FileError& error)
  {
    return error.what();
  }
}

int line_of(const std::string& text, const std::string& piece)
{
  const std::size_t at = text.find(piece);
  REQUIRE(at != std::string::npos);
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

std::string replaced(std::string text, const std::string& from, const std::string& to)
{
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

} // namespace

TEST_CASE("a robot as URDF, completed by its TOML, gives the same numbers", "[urdf]")
{
  for (const std::string name : {"ck", "rk", "six-link", "compass", "human-subject01", "rabbit"})
  {
    CAPTURE(name);
    const Robot robot = load_robot(name);
    const Robot again = by_way_of_urdf(robot);
    CHECK(again.name == robot.name);
    CHECK(again.source == robot.source);
    // the same constants, rotated nowhere; the radii of rolling joints are divided and multiplied
    check_same_numbers(again, robot, 1e-12);
    check_same_drawing(again, robot);
    if (name != "rk")
      CHECK(again.model_id == robot.model_id);
    for (int i = 0; i < robot.num_joints(); ++i)
    {
      const Actuator& found = again.actuators[static_cast<std::size_t>(i)];
      const Actuator& expected = robot.actuators[static_cast<std::size_t>(i)];
      CHECK(found.name == expected.name);
      CHECK(found.placement == expected.placement);
      CHECK(found.torque_limit == expected.torque_limit);
      CHECK(found.rotor_inertia == expected.rotor_inertia);
    }
  }
}

TEST_CASE("links that ride at an angle, or roll on such links, survive the way over a URDF", "[urdf]")
{
  const std::string text = R"(
name = "angles"
[[link]]
name = "trunk"
joint = "floating"
mass = 10
inertia = 1
[[link]]
name = "bracket"
joint = "fixed"
parent = "trunk"
at = [0.1, -0.2]
angle = 0.7
mass = 2
com = [0.1, 0.05]
inertia = 0.1
draw = [{ from = [0, 0], to = [0.1, 0] }]
[[link]]
name = "shin"
joint = "rolling"
parent = "bracket"
at = [0.05, -0.3]
angle = -0.2
parent_radius = 0.03
child_radius = 0.07
mass = 3
com = [0.0, -0.2]
inertia = 0.2
[[link]]
name = "pegleg"
joint = "fixed"
parent = "shin"
at = [0.02, -0.3]
angle = 0.4
mass = 1
com = [0.0, -0.1]
inertia = 0.1
[[link]]
name = "other_leg"
joint = "revolute"
parent = "bracket"
at = [0.0, -0.1]
mass = 3
inertia = 0.2
[[link]]
name = "weight"
joint = "slide"
parent = "bracket"
at = [0.1, 0.1]
mass = 1
com = [0.1, 0.0]
inertia = 0.1
[[actuator]]
name = "knee"
on = "bracket"
against = "shin"
between = "bar-child"
offset = 0.25
[[actuator]]
name = "hip"
on = "pegleg"
against = "other_leg"
coulomb = 1
viscous = 2
stribeck = 3
stribeck_velocity = 4
friction_offset = 5
stick_velocity = 0.25
rate_limit = 6
[[actuator]]
name = "push"
on = "weight"
against = "bracket"
offset = 0.1
[[foot]]
side = "left"
link = "pegleg"
ankle = [0.0, -0.2]
friction = 0.5
[[foot]]
side = "right"
link = "other_leg"
ankle = [0.0, -0.6]
heel = [-0.1, -0.7]
toe = [0.1, -0.7]
friction = 0.4
f_min = 12.5
)";
  const Robot robot = read_toml_robot(text, "r.toml");
  check_same_numbers(by_way_of_urdf(robot), robot, 1e-12);
  CHECK(read_toml_robot(to_toml(robot), "again.toml").model_id == robot.model_id);

  // the feet change legs
  const std::string peg_to_other = replaced(text, "link = \"pegleg\"\nankle", "link = \"other_leg\"\nankle");
  const std::size_t right = peg_to_other.find("side = \"right\"\nlink = \"other_leg\"");
  REQUIRE(right != std::string::npos);
  const Robot sole = read_toml_robot(
      peg_to_other.substr(0, right) + replaced(peg_to_other.substr(right), "link = \"other_leg\"", "link = \"pegleg\""),
      "r.toml");
  CHECK_THROWS_WITH(by_way_of_urdf(sole), Catch::Matchers::StartsWith("link 'pegleg' rides on 'shin' at an angle"));
}

TEST_CASE("a URDF that is written turns about -y, so that its joint angles are ours", "[urdf]")
{
  const std::string urdf = to_urdf(load_robot("rk"));
  CHECK(urdf.find("<axis xyz=\"0 -1 0\"/>") != std::string::npos);
  CHECK(urdf.find("<axis xyz=\"0 1 0\"/>") == std::string::npos);
}

TEST_CASE("what a URDF cannot say is refused by name", "[urdf]")
{
  CHECK_THROWS_WITH(to_urdf(load_robot("bip-itlag")),
                    Catch::Matchers::StartsWith("link 'pelvis' is parallel to the world"));
  CHECK_THROWS_WITH(to_urdf(read_toml_robot(rolling_toml(0.0, 0.1, "knee"), "r.toml")),
                    Catch::Matchers::StartsWith("link 'shin' rolls with a radius of 0"));
}

TEST_CASE("a robot as TOML reads back as the same robot", "[urdf]")
{
  for (const std::string_view name : shipped_robot_names())
  {
    CAPTURE(name);
    const Robot robot = load_robot(std::string(name));
    const Robot again = read_toml_robot(to_toml(robot), "again.toml");
    CHECK(again.model_id == robot.model_id);
    CHECK(again.name == robot.name);
    CHECK(again.source == robot.source);
    CHECK(again.leg_length == robot.leg_length);
    check_same_drawing(again, robot);
    CHECK(to_toml(again) == to_toml(robot));
  }
}

TEST_CASE("a source keeps every character on the way through TOML", "[urdf]")
{
  Robot robot = load_robot("ck");
  for (const std::string& source :
       {std::string("\"quoted\" \\ \t\x01\x7f"), std::string("\n\n\"\"\"\"lines\"\"\"\n\\\""),
        std::string("\r\nμ κ \xf0\x9f\xa6\xbf\n  "), std::string("\"\n\"")})
  {
    robot.source = source;
    CHECK(read_toml_robot(to_toml(robot), "again.toml").source == source);
  }
}

TEST_CASE("a URDF with frames turned in space equals its projection worked out by hand", "[urdf]")
{
  const Robot turned = read_urdf_robot(kTurned, "turned.urdf");
  const Robot plain = read_toml_robot(plain_toml(), "plain.toml");
  check_same_numbers(turned, plain, 1e-12);
  CHECK(turned.mechanism.gravity() == 9.81);
  CHECK(turned.relative_names == std::vector<std::string>{"hip", "knee", "weight_slide", "trunk"});
  CHECK(std::isinf(turned.actuators[0].torque_limit));
}

TEST_CASE("frames are aligned with the world, if there is one", "[urdf]")
{
  const std::string world = "<link name=\"world\"/><joint name=\"base\" type=\"floating\"><origin xyz=\"1 2 3\" "
                            "rpy=\"0 0.2 0\"/><parent link=\"world\"/><child link=\"trunk\"/></joint></robot>";
  const Robot leaning = read_urdf_robot(replaced(kTurned, "</robot>", world), "r.urdf");
  const double c = std::cos(0.2);
  const double s = std::sin(0.2);
  const Link& trunk = leaning.link(leaning.root());
  CHECK(trunk.name == "trunk");
  CHECK(mismatch(trunk.com, Eigen::Vector2d(c * 0.02 + s * 0.19, c * 0.19 - s * 0.02), 1e-15) == "");
  CHECK(mismatch(leaning.links[1].at, Eigen::Vector2d(c * 0.1 - s * 0.05, -c * 0.05 - s * 0.1), 1e-15) == "");
}

TEST_CASE("two joints around a massless bar roll, whichever mimics the other and wherever their axes point", "[urdf]")
{
  const double length = std::hypot(0.03, 0.08);
  const double r_p = 0.4 * length;
  const double r_c = 0.6 * length;
  for (const bool second_mimics : {true, false})
    for (const std::string first_axis : {"0 -1 0", "0 1 0"})
      for (const std::string second_axis : {"0 -1 0", "0 1 0"})
      {
        CAPTURE(second_mimics, first_axis, second_axis);
        const double ratio = (second_mimics ? r_p / r_c : r_c / r_p) * (first_axis == second_axis ? 1.0 : -1.0);
        RollingUrdf urdf{first_axis, second_axis};
        (second_mimics ? urdf.second_extra : urdf.first_extra) = mimic(second_mimics ? "first" : "second", ratio);
        const Robot robot = read_urdf_robot(urdf.text(), "r.urdf");
        const Robot expected = read_toml_robot(rolling_toml(r_p, r_c, second_mimics ? "first" : "second"), "r.toml");
        check_same_numbers(robot, expected, 1e-12);
        REQUIRE(robot.links.size() == 2);
        CHECK(robot.links[1].joint == JointKind::rolling);
      }
}

TEST_CASE("a TOML file completes a URDF", "[urdf]")
{
  const TemporaryFolder folder;
  folder.write("turned.urdf", kTurned);
  const std::string feet = "[[foot]]\nside = \"left\"\nlink = \"foot\"\nfriction = 0.5\n"
                           "[[foot]]\nside = \"right\"\nlink = \"shin\"\nankle = [0, -0.4]\nfriction = 0.5\n";
  const Robot robot = load_robot(folder.write("named.toml", "urdf = \"turned.urdf\"\nname = \"named\"\n"
                                                            "gravity = 1.62\nsource = \"here\"\n"
                                                            "[[link]]\nname = \"trunk\"\nbase = [\"xH\", \"zH\"]\n"
                                                            "[[link]]\nname = \"shin\"\ncoordinate = \"q1\"\n"
                                                            "draw = [{ from = [0, 0], to = [0, -0.4] }]\n" +
                                                                feet));
  CHECK(robot.name == "named");
  CHECK(robot.source == "here");
  CHECK(robot.mechanism.gravity() == 1.62);
  CHECK(robot.base_names == std::array<std::string, 2>{"xH", "zH"});
  CHECK(robot.absolute_names == std::vector<std::string>{"trunk", "thigh", "q1", "weight"});
  CHECK(robot.relative_names == std::vector<std::string>{"hip", "knee", "weight_slide", "trunk"});
  CHECK(robot.links[2].drawing.size() == 1);
  CHECK(robot.foot(Side::left).exists());
  CHECK(load_robot(folder.write("short.toml", "urdf = \"turned.urdf\"\n" + feet)).name == "turned");
  CHECK_FALSE(load_robot(folder.file("turned.urdf")).foot(Side::left).exists());

  struct Row
  {
    std::string text, message;
  };
  const std::string urdf = "urdf = \"turned.urdf\"\n";
  const auto trunk = [&](const std::string& line)
  {
    return Row{urdf + "[[link]]\nname = \"trunk\"\n" + line,
               ":4: link 'trunk': " + line.substr(0, line.find(' ')) + ": comes from the URDF, " +
                   folder.file("turned.urdf") + ":" + std::to_string(line_of(kTurned, "<link name=\"trunk\"")) +
                   "; change it there"};
  };
  for (const Row& row : std::vector<Row>{
           trunk("mass = 1"),
           trunk("inertia = 1"),
           trunk("com = [0, 0]"),
           trunk("at = [0, 0]"),
           trunk("angle = 0"),
           trunk("joint = \"floating\""),
           trunk("parent = \"world\""),
           trunk("parent_radius = 1"),
           trunk("child_radius = 1"),
           {urdf + "[[link]]\nname = \"trunc\"",
            ":3: link 'trunc': name: found \"trunc\"; the URDF has no link of that"},
           {urdf + "[[link]]\nname = \"trunk\"\n[[link]]\nname = \"trunk\"",
            ":5: link 'trunk': name: is that of a second"},
           {urdf + "[[link]]\nname = \"thigh\"\nbase = [\"x\", \"z\"]", ":4: link 'thigh': base: is not known here"},
           {urdf + "[[link]]\nname = \"foot\"\ncoordinate = \"q0\"", ":4: link 'foot': coordinate: is not known here"},
           {urdf + "gear = 1",
            ":2: gear: is not known here; known are: actuator, foot, gravity, link, name, source, urdf"},
           {"urdf = 3", ":1: urdf: found 3; expected a text in quotes"},
           {"\nurdf = \"other.urdf\"", ":2: urdf: " + folder.file("other.urdf") + " cannot be read; expected a URDF"},
           {"urdf = \"\\u001b[31m.urdf\"", ":1: urdf: " + folder.file("?[31m.urdf") + " cannot be read"},
           {"urdf = \".\"", ":1: urdf: " + folder.file(".") + " cannot be read"},
           {urdf + "[[foot]]\nside = \"left\"\nlink = \"bar\"\nfriction = 1",
            ":2: left foot: link \"bar\" is not the name"},
           {urdf + "[[actuator]]\nname = \"hip\"\non = \"thigh\"\nagainst = \"trunk\"", ":2: there are 1 actuators"},
           {urdf + "[[foot]]\nside = \"left\"\nlink = \"foot\"\nfriction = 1", ":1: there is no [[foot]] with side"},
       })
  {
    const std::string file = folder.write("bad.toml", row.text);
    CAPTURE(row.text);
    CHECK_THROWS_WITH(load_robot(file), Catch::Matchers::StartsWith(file + row.message));
  }

  // what is wrong with the URDF is said with its own line
  const std::string bad = replaced(kTurned, "<mass value=\"5\"/>", "<mass value=\"5 kg\"/>");
  const std::string bad_path = folder.write("bad.urdf", bad);
  const std::string naming_bad = folder.write("naming.toml", "urdf = \"bad.urdf\"\n" + feet);
  CHECK_THROWS_WITH(load_robot(naming_bad),
                    Catch::Matchers::StartsWith(fmt::format(
                        "{}:{}: link 'thigh': inertial: mass: value: found \"5 kg\"", bad_path, line_of(bad, "5 kg"))));
  std::string many = "<robot name=\"many\">\n<link name=\"l0\"/>\n";
  for (int i = 1; i < 30; ++i)
    many += fmt::format("<joint name=\"j{0}\" type=\"fixed\"><parent link=\"l{1}\"/><child link=\"l{0}\"/></joint>\n"
                        "<link name=\"l{0}\"/>\n",
                        i, i - 1);
  const std::string many_path = folder.write("many.urdf", many + "</robot>");
  CHECK_THROWS_WITH(load_robot(folder.write("naming.toml", "urdf = \"many.urdf\"")),
                    Catch::Matchers::StartsWith(many_path + ":50: there are 30 links; at most 24"));
}

TEST_CASE("a URDF with a fixed root needs a TOML file that says which foot it is", "[urdf]")
{
  const std::string text = to_urdf(load_robot("six-link"));
  CHECK(complaint(text) ==
        fmt::format("r.urdf:{}: link 'left_foot' is fixed to the world and stands for a foot; a TOML "
                    "file with urdf = \"r.urdf\" must say which, in a [[foot]]",
                    line_of(text, "<link name=\"left_foot\"")));
  const TemporaryFolder folder;
  const std::string urdf = folder.write("r.urdf", text);
  const std::string toml = folder.write("r.toml", "urdf = \"r.urdf\"");
  CHECK_THROWS_WITH(load_robot(toml), Catch::Matchers::StartsWith(fmt::format("{}:{}: link 'left_foot' is fixed to the "
                                                                              "world, but is no [[foot]]",
                                                                              urdf, line_of(text, "\"left_foot\""))));
}

TEST_CASE("a bad URDF is refused with file, line, key and what would be right", "[urdf]")
{
  struct Row
  {
    std::string from, to, at, message; // at: the piece of text on whose line the complaint is
  };
  const std::string shin_mass = "<mass value=\"2.2\"/>";
  const std::string knee_axis = "<axis xyz=\"0 0 1\"/>";
  const std::string before_end = "</robot>";
  const auto joint = [](std::string_view type, std::string_view parent, std::string_view child, std::string_view extra)
  {
    return fmt::format(
        "\n<joint name=\"extra\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/>{}</joint></robot>", type, parent,
        child, extra);
  };
  const std::string part = "<link name=\"part\"/>";
  const std::vector<Row> rows{
      {shin_mass, "<mass value=\"1kg\"/>", "1kg",
       "link 'shin': inertial: mass: value: found \"1kg\"; expected a number"},
      {shin_mass, "<mass value=\"1,5\"/>", "1,5", "value: found \"1,5\"; expected a number"},
      {shin_mass, "<mass value=\"nan\"/>", "nan", "value: found \"nan\"; expected a number"},
      {shin_mass, "<mass value=\"inf\"/>", "\"inf\"", "value: found \"inf\"; expected a number"},
      {shin_mass, "<mass value=\"1e999\"/>", "1e999", "value: found \"1e999\"; expected a number"},
      {shin_mass, "<mass value=\"0x10\"/>", "0x10", "value: found \"0x10\"; expected a number"},
      {shin_mass, "<mass value=\"\"/>", "value=\"\"", "value: found \"\"; expected a number"},
      {shin_mass, "<mass value=\"1 2\"/>", "\"1 2\"", "value: found \"1 2\"; expected a number"},
      {shin_mass, "<mass value=\"-2.2\"/>", "-2.2", "value: found -2.2; expected a number that is not negative"},
      {shin_mass, "<mass value=\"1&#0;kg\"/>", "&#0;", "a character as a number, &#...; expected the character itself"},
      {shin_mass, "<mass value=\"1&amp;\"/>", "&amp;", "value: found \"1&\"; expected a number"},
      {shin_mass, "<mass/>", "<mass/>", "link 'shin': inertial: mass: value: is missing"},
      {shin_mass, "<mass value=\"1\" unit=\"kg\"/>", "unit=", "mass: unit: is not known here; known are: value"},
      {shin_mass, "<mass value=\"1\">2</mass>", "<mass value=\"1\">", "mass: found the text \"2\"; expected elements"},
      {shin_mass, shin_mass + "\n<mass value=\"3\"/>", "<mass value=\"3\"/>", "mass: is there twice; expected one"},
      {shin_mass, "", "<inertial>\n      <origin xyz=\"0.02 -0.16", "link 'shin': inertial: <mass> is missing"},
      {"izz=\"0.028\"", "izz=\"-0.028\"", "-0.028",
       "link 'shin': inertial: inertia: izz: found -0.028; expected a number that is not negative"},
      {"ixz=\"0.002\" ", "", "iyy=\"0.02\"", "link 'shin': inertial: inertia: ixz: is missing"},
      {"izz=\"0.028\"", "izz=\"0.028\" ixx2=\"1\"", "ixx2", "inertia: ixx2: is not known here"},
      {"xyz=\"0 0 -0.4\"", "xyz=\"0 0\"", "xyz=\"0 0\"",
       "joint 'knee': origin: xyz: found \"0 0\"; expected 3 numbers, separated by spaces"},
      {"xyz=\"0 0 -0.4\"", "xyz=\"0 0 -0.4 1\"", "-0.4 1", "origin: xyz: found"},
      {"xyz=\"0 0 -0.4\"", "xyz=\"0, 0, -0.4\"", "0, 0, -0.4", "origin: xyz: found"},
      {"xyz=\"0 0 -0.4\"", "xyz=\"0 0-0.4\"", "0 0-0.4", "origin: xyz: found"},
      {"xyz=\"0 0 -0.4\"", "quat_xyzw=\"0 0 0 1\"", "quat_xyzw", "quat_xyzw: is not known here; known are: xyz, rpy"},
      {"rpy=\"1.5707963267948966 0 0\"/>\n    <parent", "rpy=\"1.57 0 0\"/>\n    <parent", "name=\"knee\"",
       "joint 'knee': axis: found (0, 0, 1), which is"},
      {knee_axis, "<axis xyz=\"1 0 0\"/>", "name=\"knee\"",
       "1.57 rad from +y; the rpy of joint 'knee' is (1.5707963267948966, 0, 0); expected one parallel to y within "},
      {knee_axis, "<axis xyz=\"0 0 0\"/>", "name=\"knee\"",
       "joint 'knee': axis: found (0, 0, 0); expected a direction"},
      {knee_axis, "", "name=\"knee\"", "joint 'knee': axis: is missing; URDF then takes x"},
      {knee_axis, "<axis/>", "name=\"knee\"", "joint 'knee': axis: found (1, 0, 0)"},
      {"<axis xyz=\"-1 0 0\"/>", "<axis xyz=\"0 0 1\"/>", "name=\"weight_slide\"",
       "is not a sum of constant rotated vectors"},
      {"type=\"continuous\"", "type=\"ball\"", "ball",
       "joint 'knee': type: found \"ball\"; expected revolute, continuous, prismatic, fixed, floating or planar"},
      {"type=\"continuous\"", "type=\"planar\"", "planar", "joint 'knee': is planar; only a root floats"},
      {"type=\"continuous\"", "type=\"floating\"", "floating", "joint 'knee': is floating; only a root floats"},
      {"type=\"continuous\"", "", "name=\"knee\"", "joint 'knee': type: is missing"},
      {"<child link=\"shin\"/>", "", "name=\"knee\"", "joint 'knee': <child> is missing"},
      {"<child link=\"shin\"/>", "<child link=\"shin2\"/>", "shin2", "child: link: found \"shin2\"; there is no link"},
      {"<parent link=\"thigh\"/>", "<parent link=\"shin\"/>", "<link name=\"shin\"", "its parents form a circle"},
      {"<parent link=\"shin\"/>", "<parent link=\"foot\"/>", "<link name=\"foot\"", "its parents form a circle"},
      {before_end, joint("fixed", "shin", "weight", ""), "\"extra\"",
       "its child \"weight\" is the child of joint 'weight_slide', too; a link has one parent"},
      {before_end, joint("fixed", "shin", "trunk", ""), "<link name=\"trunk\"", "there is no root"},
      {before_end, part + before_end, "\"part\"", "is no joint's child, and neither is 'trunk'; one root carries all"},
      {"name=\"thigh\"", "name=\"trunk\"", "<link name=\"trunk\">\n    <inertial>\n      <origin xyz=\"0.01",
       "second link"},
      {"name=\"knee\"", "name=\"hip\"", "<joint name=\"hip\" type=\"cont", "there is a second joint of this name"},
      {"link name=\"foot\"", "link name=\"the foot\"", "the foot",
       "name: found \"the foot\"; expected 1 to 64 letters"},
      {"link name=\"foot\"", "link", "<link>", "link 4: name: is missing"},
      {"name=\"turned\"", "name=\"turned\" scale=\"2\"", "scale", "scale: is not known here; known are: name"},
      {"name=\"turned\"", "", "<robot ", "name: is missing"},
      {"<collision/>", "text", "text", "link 'thigh': found the text"},
      {"<collision/>", "<![CDATA[x]]>", "CDATA", "link 'thigh': found the text \"x\""},
      {"<collision/>", "<inertial/>", "<inertial/>", "link 'thigh': inertial: is there twice"},
      {before_end, "\n<xacro:leg side=\"left\"/></robot>", "xacro:leg", "run the file through xacro first"},
      {before_end, "</robot>\n<robot name=\"two\"/>", "\"two\"", "expected one element <robot>, and nothing else"},
      {before_end, "</robot>\ntrailing", "trailing", "not XML: found text where an element <robot> is expected"},
      {before_end, "</robot a=\"1\">", "</robot", "a closing tag with an attribute"},
      {"<robot ", "<!DOCTYPE robot [<!ENTITY a \"1\">]>\n<robot ", "DOCTYPE", "found <!; a file with a DOCTYPE"},
      {"name=\"trunk\"", "name=\"trunk\" name=\"trunk\"", "<link name=\"trunk\" name",
       "not XML: an attribute is not well"},
      {"</link>", "</robot>", "<link name=\"trunk\"", "not XML: an element is not closed, or another one is"},
      {"name=\"knee\" type", "name=\"left.knee\" type", "left.knee", "name: found \"left.knee\"; expected 1 to 64"},
  };
  for (const Row& row : rows)
  {
    const std::string text = replaced(kTurned, row.from, row.to);
    const std::string found = complaint(text);
    CAPTURE(row.from, row.to, found);
    CHECK(found.find(row.message) != std::string::npos);
    CHECK(found.starts_with(fmt::format("r.urdf:{}:", line_of(text, row.at))));
  }
}

TEST_CASE("only the moment of inertia about the pitch axis enters", "[urdf]")
{
  // the shin's z is the pitch axis
  const Robot robot = read_urdf_robot(kTurned, "r.urdf");
  for (const std::string other : {"iyy=\"0.02\"", "ixx=\"0.03\"", "iyz=\"0.003\""})
    CHECK(read_urdf_robot(replaced(kTurned, other, other.substr(0, 5) + "0.5\""), "r.urdf").links[2].inertia ==
          Catch::Detail::Approx(robot.links[2].inertia).epsilon(1e-13));
}

TEST_CASE("a mimic that is no rolling joint is refused with the joint's name and why", "[urdf]")
{
  const std::string mass = "<inertial><mass value=\"0.1\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" "
                           "izz=\"0\"/></inertial>";
  const std::string third_link = "<link name=\"extra\"/>\n<joint name=\"third\" type=\"revolute\"><parent link=\"{}\"/>"
                                 "<child link=\"extra\"/><axis xyz=\"0 1 0\"/>\n{}</joint>";
  const auto third = [&](std::string_view parent, std::string_view extra)
  {
    return fmt::format(fmt::runtime(third_link), parent, extra);
  };
  struct Row
  {
    RollingUrdf urdf;
    std::string joint, message;
  };
  const std::string follow = mimic("first", 0.7);
  const std::string straight = "0 -1 0";
  const std::vector<Row> rows{
      {{straight, straight, "", mimic("first", -0.7)},
       "second",
       "multiplier: found -0.7; expected one by which both turn"},
      {{straight, straight, "", mimic("first", 0.0)}, "second", "multiplier: found 0; expected one by which both turn"},
      {{straight, "0 1 0", "", follow}, "second", "multiplier: found 0.7 between opposite axes; expected"},
      {{straight, straight, "", "<mimic joint=\"first\" offset=\"0.1\"/>"}, "second", "offset: found 0.1; expected 0"},
      {{straight, straight, "", mimic("none", 1.0)}, "second", "found \"none\"; there is no joint of that name"},
      {{straight, straight, "", mimic("second", 1.0)}, "second", "does not follow joint 'second'"},
      {{straight, straight, mimic("second", 1.0), follow}, "first", "joint 'second' mimics a joint itself"},
      {{straight, straight, "", follow, mass}, "second", "link 'bar' between the joints has a mass"},
      {{straight, straight, "", follow, "", third("bar", "")},
       "second",
       "link 'bar' between the joints has 2 children"},
      {{straight, straight, "", "", "", third("thigh", mimic("second", 1.0))},
       "third",
       "does not follow joint 'second'"},
      {{straight, straight, "", follow, "", third("shin", mimic("second", 1.0))},
       "third",
       "joint 'second' mimics a joint itself"},
      {{straight, straight, mimic("second", 0.5), "", "", third("shin", mimic("second", -1.0))},
       "third",
       "one of the two joints rolls with another one, too"},
  };
  for (const Row& row : rows)
  {
    const std::string text = row.urdf.text();
    const std::string found = complaint(text);
    CAPTURE(found);
    CHECK(found.find(fmt::format("joint '{}': mimic: {}", row.joint, row.message)) != std::string::npos);
    // the complaint is on the line of the mimic that it is about
    const std::size_t of_joint = text.find(fmt::format("<joint name=\"{}\"", row.joint));
    const auto line =
        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find("<mimic", of_joint)), '\n');
    CHECK(found.starts_with(fmt::format("r.urdf:{}:", line)));
  }
  const RollingUrdf good{straight, straight, "", follow};
  CHECK(complaint(good.text()) == "");
  CHECK(complaint(replaced(good.text(), "xyz=\"0.03 0 -0.08\"", "xyz=\"0 1 0\""))
            .find("both joints are at the same place; the bar between them, 'bar'") != std::string::npos);
  CHECK(complaint(replaced(good.text(), "name=\"first\" type=\"revolute\"", "name=\"first\" type=\"fixed\""))
            .find("joint 'second': mimic: only two revolute joints can roll") != std::string::npos);
}

TEST_CASE("a world that carries no root is refused", "[urdf]")
{
  const std::string link = "<link name=\"world\"/>";
  const auto carries = [](std::string_view joint, std::string_view type, std::string_view child)
  {
    return fmt::format("<joint name=\"{}\" type=\"{}\"><parent link=\"world\"/><child link=\"{}\"/>"
                       "<axis xyz=\"0 1 0\"/></joint>",
                       joint, type, child);
  };
  struct Row
  {
    std::string extra, message;
  };
  for (const Row& row : std::vector<Row>{
           {"<link name=\"world\"><inertial><mass value=\"1\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" "
            "iyz=\"0\" "
            "izz=\"0\"/></inertial></link>" +
                carries("base", "fixed", "trunk"),
            "link 'world': has <inertial> with a mass; the world has no mass"},
           {link + carries("base", "revolute", "trunk"),
            "joint 'base': its parent is the world; a root there is floating"},
           {link +
                "<link name=\"rock\"/><link name=\"pebble\"/><joint name=\"rolls\" type=\"continuous\"><parent "
                "link=\"rock\"/><child link=\"pebble\"/></joint>" +
                carries("base", "fixed", "trunk") + carries("ground", "fixed", "rock"),
            "link 'world': has 2 children that carry something; the world has one, the robot's root"},
           {"<link name=\"world\"/><joint name=\"j\" type=\"fixed\"><parent link=\"trunk\"/><child "
            "link=\"world\"/></joint>",
            "link 'world': is the child of a joint; \"world\" is what a root stands on"}})
  {
    const std::string found = complaint(replaced(kTurned, "</robot>", row.extra + "</robot>"));
    CAPTURE(found);
    CHECK(found.find(row.message) != std::string::npos);
  }
  CHECK(complaint("<robot name=\"r\"><link name=\"world\"/></robot>").find("has 0 children") != std::string::npos);
}

TEST_CASE("what is no URDF at all is refused", "[urdf]")
{
  const std::string bomb = "<?xml version=\"1.0\"?>\n<!DOCTYPE lolz [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b "
                           "\"&a;&a;&a;&a;&a;&a;&a;&a;\">]>\n<robot name=\"&b;\"/>";
  CHECK(complaint(bomb).starts_with("r.urdf:2: found <!; a file with a DOCTYPE or entities of its own is not read"));
  CHECK(complaint("") == "r.urdf:1: not XML: there is nothing in it");
  CHECK(complaint("<!-- nothing -->") == "r.urdf:1: there is no element <robot>");
  CHECK(complaint("<sdf version=\"1.6\"/>") == "r.urdf:1: found <sdf>; expected <robot>");
  CHECK(complaint("<robot name=\"r\"/>") == "r.urdf:1: there is no <link>; a robot needs at least its root");
  CHECK(complaint("<robot name=\"r\"><link name=\"l\"/></robot>") ==
        "r.urdf:1: all links are massless; the robot's mass must be positive");
  CHECK(complaint(std::string("<robot>\n\0</robot>", 18)) ==
        "r.urdf:2: found a NUL byte; expected XML, encoded as UTF-8");

  const auto many = [](int count, auto piece)
  {
    std::string text = "<robot name=\"r\">\n";
    for (int i = 0; i < count; ++i)
      text += piece(i);
    return text;
  };
  const std::string nested = many(100'000, [](int) { return "<link>"; });
  const std::string links = many(100'000, [](int i) { return fmt::format("<link name=\"l{}\"/>\n", i); });
  std::string attributes = "<robot name=\"r\"><link ";
  for (int i = 0; i < 100'000; ++i)
    attributes += fmt::format("a{}='' ", i);
  attributes += "/></robot>";
  CHECK(complaint(nested).find("more than 20000 tags; no robot needs that") != std::string::npos);
  CHECK(complaint(many(15'000, [](int) { return "<link>"; })).find("nested deeper than any robot needs") !=
        std::string::npos);
  CHECK(complaint(links).starts_with("r.urdf:20001: more than 20000 tags"));
  CHECK(complaint(attributes).find("a tag with more than 100 attributes") != std::string::npos);
  CHECK(complaint(links.substr(0, links.find("<link name=\"l9000\"")) + "</robot>")
            .starts_with("r.urdf:3: link 'l1': is no joint's child, and neither is 'l0'"));
  CHECK(complaint(replaced(kTurned, "\"0 -2 0\"", fmt::format("\"{}\"", std::string(900'000, '1')))).size() < 300);
  CHECK(complaint(replaced(kTurned, "\"0 -2 0\"", fmt::format("\"{}\"", std::string(900'000, ' ')))).size() < 300);

  oracle::Random random(11);
  for (const bool printable : {false, true})
  {
    std::string garbage(1'000'000, ' ');
    for (char& c : garbage)
      c = static_cast<char>(printable ? 32 + random() % 95 : random() % 256);
    CHECK(complaint(garbage).starts_with("r.urdf:"));
  }
}

TEST_CASE("a URDF that is cut anywhere is refused", "[urdf]")
{
  REQUIRE(complaint(kTurned) == "");
  for (std::size_t length = 0; length < kTurned.size() - 1; ++length)
    if (complaint(kTurned.substr(0, length)).empty())
      FAIL("cut after " << length << " bytes it was read");
}

} // namespace urdf_test
