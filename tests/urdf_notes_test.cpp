// What a URDF says and no robot takes from it: named in a note, or refused.
#include "catch.h"
#include "temporary_folder.h"
#include "urdf_walker.h"

#include "planar/kinematics.h"
#include "robot/files/load.h"
#include "robot/files/robot_files.h"
#include "robot/files/urdf_robot.h"

#include <Eigen/Geometry>

namespace urdf_notes_test
{

using namespace torqued;

TEST_CASE("what a URDF says of motors and no robot reads is named, joint by joint", "[urdf_notes]")
{
  const std::string dynamics = "<dynamics damping=\"2\" friction=\"1\"/>";
  const std::string limit = "<limit lower=\"-1\" upper=\"1\" effort=\"50\" velocity=\"5\"/>";
  const std::string both = "w.urdf:6: joint 'left_hip': <dynamics damping=2 friction=1> and <limit effort=50> are not "
                           "read: set viscous, coulomb, torque_limit in the TOML\n";
  CHECK(all_notes(with_hip(dynamics + limit).robot()) == both);
  CHECK(all_notes(with_hip(limit + dynamics).robot()) == both);
  CHECK(all_notes(with_hip(limit).robot()) ==
        "w.urdf:6: joint 'left_hip': <limit effort=50> is not read: set torque_limit in the TOML\n");
  Walker walker = with_hip("<dynamics damping=\"2\"/>");
  walker.right_hip = limit;
  CHECK(walker.robot().notes.size() == 2);

  // what is nothing, or none, or bounds the motion alone
  for (const std::string nothing :
       {"", "<dynamics/>", "<dynamics damping=\"0.0\" friction=\"0\"/>",
        "<limit lower=\"-1\" upper=\"1\" velocity=\"5\"/>", "<limit effort=\"0\" velocity=\"0\"/>",
        "<limit effort=\"-1\"/>", "<limit effort=\"1e10\"/>", "<limit effort=\"inf\"/>",
        "<calibration rising=\"0.1\"/>", "<joint_properties friction=\"0.0\"/>"})
  {
    CAPTURE(nothing);
    CHECK(all_notes(with_hip(nothing).robot()) == "");
  }

  // gears, rotors and springs, wherever they stand
  const auto transmission = [](const std::string& inside)
  {
    return all_notes(with_tail("<transmission name=\"t\"><type>transmission_interface/SimpleTransmission</type><joint "
                               "name=\"left_hip\"><hardwareInterface>EffortJointInterface</hardwareInterface></joint>" +
                               inside + "</transmission>")
                         .robot());
  };
  CHECK(transmission("<actuator name=\"m\"><mechanicalReduction> 50 </mechanicalReduction></actuator>") ==
        "w.urdf:6: joint 'left_hip': <transmission mechanicalReduction=50> is not read: set rotor_inertia (gear ratio "
        "squared times the motor's inertia) in the TOML\n");
  CHECK(transmission("<actuator name=\"m\"><mechanicalReduction>1</mechanicalReduction></actuator>") == "");
  CHECK(transmission("<mechanicalReduction>63.16</mechanicalReduction>").find("mechanicalReduction=63.16") !=
        std::string::npos);
  CHECK(transmission("<actuator name=\"m\"><drake:rotor_inertia value=\"0.0003\"/><drake:gear_ratio value=\"50\"/>"
                     "</actuator>")
            .find("<transmission rotor_inertia=0.0003 gear_ratio=50> is not read: set rotor_inertia = 0.75 (gear") !=
        std::string::npos);
  CHECK(transmission("<actuator name=\"m\"><mechanicalReduction>50</mechanicalReduction><motorInertia>1e-4"
                     "</motorInertia></actuator>")
            .find("<transmission mechanicalReduction=50 motorInertia=1e-4> is not read: set rotor_inertia = 0.25 (") !=
        std::string::npos);
  CHECK(transmission("<motorInertia>0</motorInertia>") == "");
  CHECK(all_notes(with_tail("<transmission name=\"t\"><actuator name=\"m\"><motorInertia>1e-4</motorInertia></actuator>"
                            "</transmission>")
                      .robot()) ==
        "w.urdf:8: <transmission motorInertia=1e-4> is not read, and names no joint of the robot\n");
  const std::string rotor = "<drake:rotor_inertia value=\"0.1\"/>";
  CHECK(all_notes(with_hip(rotor + "<drake:gear_ratio value=\"50\"/>").robot()) ==
        "w.urdf:6: joint 'left_hip': <drake:rotor_inertia value=0.1> and <drake:gear_ratio value=50> are not read: set "
        "rotor_inertia = 250 (gear ratio squared times the motor's inertia) in the TOML\n");
  CHECK(
      all_notes(with_hip(rotor + "<drake:gear_ratio value=\"1\"/>").robot()) ==
      "w.urdf:6: joint 'left_hip': <drake:rotor_inertia value=0.1> is not read: set rotor_inertia (gear ratio squared "
      "times the motor's inertia) in the TOML\n");
  CHECK(all_notes(with_hip("<drake:rotor_inertia value=\"0\"/>").robot()) == "");
  CHECK(all_notes(with_hip("<dynamics armature=\"0.1\" spring_stiffness=\"7\"/>").robot()) ==
        "w.urdf:6: joint 'left_hip': <dynamics armature=0.1 spring_stiffness=7> is not read: set rotor_inertia in the "
        "TOML; no key there says the others\n");
  CHECK(all_notes(with_hip("<safety_controller k_velocity=\"10\"/>").robot()) ==
        "w.urdf:6: joint 'left_hip': <safety_controller k_velocity=10> is not read, and no key in the TOML says it\n");
  CHECK(all_notes(with_tail("<gazebo reference=\"trunk\"><turnGravityOff>true</turnGravityOff></gazebo>").robot())
            .find("w.urdf:8: <gazebo> turnGravityOff=true is not read") != std::string::npos);
}

TEST_CASE("a TOML that says a motor's number takes the note of it away", "[urdf_notes]")
{
  const TemporaryFolder folder;
  const std::string urdf =
      folder.write("w.urdf", with_hip("<dynamics damping=\"2\" friction=\"1\"/><limit effort=\"50\"/>").text());
  const auto notes = [&](const std::string& left)
  {
    return all_notes(load_robot(folder.write("w.toml", "urdf = \"w.urdf\"\n[[actuator]]\nname = \"l\"\n" + left +
                                                           "[[actuator]]\nname = \"r\"\non = \"right_thigh\"\n"
                                                           "against = \"trunk\"\nviscous = 1\n")));
  };
  const std::string between = "on = \"left_thigh\"\nagainst = \"trunk\"\n";
  CHECK(notes(between + "viscous = 2\ncoulomb = 1\ntorque_limit = 50\n") == "");
  CHECK(notes("on = \"trunk\"\nagainst = \"left_thigh\"\nviscous = 0\ncoulomb = 0\ntorque_limit = 60\n") == "");
  CHECK(notes(between + "coulomb = 1\n") ==
        urdf + ":6: joint 'left_hip': <dynamics damping=2> and <limit effort=50> are not read: set viscous, "
               "torque_limit in the TOML\n");
  // an actuator between other links says nothing of this joint
  CHECK(notes("on = \"left_thigh\"\nagainst = \"right_thigh\"\nviscous = 2\ncoulomb = 1\ntorque_limit = 50\n") ==
        urdf + ":6: joint 'left_hip': <dynamics damping=2 friction=1> and <limit effort=50> are not read: set viscous, "
               "coulomb, torque_limit in the TOML\n");
}

TEST_CASE("what is written as a URDF is read without a note", "[urdf_notes]")
{
  for (const std::string name : {"ck", "rk", "six-link", "compass", "human-subject01", "rabbit"})
  {
    const TemporaryFolder folder;
    const Robot robot = load_robot(name);
    folder.write("r.urdf", to_urdf(robot));
    CHECK(all_notes(load_robot(folder.write("r.toml", to_companion_toml(robot, "r.urdf")))) == "");
    CHECK(all_notes(robot) == "");
  }
}

TEST_CASE("what moves nothing is passed over, in one note", "[urdf_notes]")
{
  const std::int64_t id = Walker().robot().model_id;
  struct Row
  {
    Walker walker;
    std::string names;
  };
  for (const auto& [walker, names] : std::vector<Row>{
           {with_tail("<mujoco><compiler meshdir=\"m\"/></mujoco>"), "<mujoco>"},
           {with_tail("<collision_filter_group name=\"g\"><member link=\"trunk\"/></collision_filter_group>"),
            "<collision_filter_group>"},
           {with_tail("<gazebo><plugin name=\"p\" filename=\"q\"><joint>left_hip</joint></plugin></gazebo><sensor "
                      "name=\"imu\"/><ros2_control name=\"c\"/><drake:frame name=\"f\"/>"),
            "<drake:frame>, <gazebo>, <ros2_control>, <sensor>"},
           {with_head("<link name=\"part\" type=\"tube\" drake:hidden=\"1\"><visual concave=\"yes\"><any/></visual>"
                      "<collision group=\"g\"><verbose value=\"V\"/></collision><contact><any/></contact>"
                      "</link>" +
                      joint_element("glue", "fixed", "trunk", "part")),
            "<contact>, drake:hidden=\"...\", type=\"...\""}})
  {
    const Robot robot = walker.robot();
    CAPTURE(names);
    CHECK(all_notes(robot) == "w.urdf: passed over, because it moves nothing: " + names + "\n");
    if (robot.links.size() == 3)
      CHECK(robot.model_id == id);
  }
  std::string drake = Walker().text();
  drake.replace(0, 6, "<robot xmlns=\"http://drake.mit.edu\" xmlns:xsi=\"x\" xsi:schemaLocation=\"a b\" version=\"1\"");
  CHECK(read_urdf_robot(drake, "w.urdf").model_id == id);
  CHECK(read_urdf_robot(drake, "w.urdf").notes.empty());

  std::string many;
  for (int i = 10; i < 40; ++i)
    many += fmt::format("<vendor{}/>", i);
  CHECK(all_notes(with_tail(many).robot()).find("<vendor21> and 18 more\n") != std::string::npos);
}

TEST_CASE("what a simulator or a vendor says of mechanics is named as not read", "[urdf_notes]")
{
  const std::int64_t id = Walker().robot().model_id;
  struct Row
  {
    Walker walker;
    std::string note;
  };
  const std::string mu = "<mu1>0.9</mu1><mu2>0.9</mu2></gazebo>";
  for (const auto& [walker, note] : std::vector<Row>{
           {with_tail("<gazebo reference=\"left_hip\"><springStiffness>400</springStiffness><implicitSpringDamper>1"
                      "</implicitSpringDamper><material>Gazebo/Blue</material></gazebo>"),
            "w.urdf:8: <gazebo reference=\"left_hip\"> is not read: what its <springStiffness>, "
            "<implicitSpringDamper> say has no effect here\n"},
           {with_tail("<gazebo reference=\"trunk\"><inertial><mass>60</mass></inertial></gazebo>"),
            "w.urdf:8: <gazebo reference=\"trunk\"> is not read: what its <inertial> says has no effect here\n"},
           {with_tail("<gazebo reference=\"trunk\"><mu1>0</mu1></gazebo>"), // which is ice
            "w.urdf:8: <gazebo reference=\"trunk\"> is not read: what its <mu1> says has no effect here\n"},
           {with_tail("<gazebo><mass>60</mass></gazebo><gazebo><sensor name=\"imu\"><a/></sensor></gazebo>"),
            "w.urdf:8: <gazebo> is not read: what its <mass> says has no effect here\n"},
           {with_tail("<mujoco><compiler meshdir=\"m\" settotalmass=\"60\"/></mujoco>"),
            "w.urdf:8: <mujoco> is not read: what its <compiler settotalmass=60> says has no effect here\n"},
           {with_tail("<mujoco><option gravity=\"0 0 -1.62\" integrator=\"RK4\"/><joint armature=\"1\"/></mujoco>"),
            "w.urdf:8: <mujoco> is not read: what its <option gravity=0 0 -1.62>, <joint armature=1> say has no effect "
            "here\n"},
           {with_tail("<gazebo reference=\"left_thigh\">" + mu + "\n<gazebo reference=\"right_thigh\">" + mu),
            "w.urdf:8: <gazebo reference=\"left_thigh\"> and 1 more like it are not read: what their <mu1>, <mu2> say "
            "has no effect here\n"},
           {with_head("<link name=\"part\"><contact><rolling_friction value=\"1\"/></contact></link>" +
                      joint_element("glue", "fixed", "trunk", "part")),
            "w.urdf:2: link 'part': <contact> is not read: what its <rolling_friction> says has no effect here\n"},
           {with_tail("<gazebo reference=\"left_hip\"><springStiffness>0</springStiffness><selfCollide>1</selfCollide>"
                      "<implicitSpringDamper>false</implicitSpringDamper></gazebo><mujoco><compiler angle=\"radian\"/>"
                      "<option timestep=\"0.001\"/></mujoco>"),
            "w.urdf: passed over, because it moves nothing: <gazebo>, <mujoco>\n"}})
  {
    const Robot robot = walker.robot();
    CHECK(all_notes(robot) == note);
    if (robot.links.size() == 3)
      CHECK(robot.model_id == id);
  }
}

TEST_CASE("a body that a joint moves and that has no mass has a note", "[urdf_notes]")
{
  const std::string shin = joint_element("knee", "revolute", "left_thigh", "shin", "0 -1 0");
  const std::string foot = joint_element("ankle", "fixed", "shin", "foot");
  const std::string massless = "w.urdf:2: link 'shin' is massless as read, and joint 'knee' moves it: neither it nor "
                               "what is fixed to it has a mass\n";
  CHECK(all_notes(with_head(link_element("shin") + shin).robot()) == massless);
  CHECK(all_notes(with_head(link_element("shin", "0") + shin).robot()) == massless);
  CHECK(all_notes(with_head(link_element("shin") + link_element("foot") + shin + foot).robot()) == massless);
  // the body that moves is both
  CHECK(all_notes(with_head(link_element("shin") + link_element("foot", "1") + shin + foot).robot()) == "");
  // what moves against it is another
  CHECK(all_notes(with_head(link_element("shin") + link_element("foot", "1") + shin +
                            joint_element("ankle", "revolute", "shin", "foot", "0 -1 0"))
                      .robot()) == massless);
  // frames and points of feet, and what lets a root float, have none
  CHECK(all_notes(with_head(link_element("tip") + joint_element("glue", "fixed", "trunk", "tip")).robot()) == "");
  CHECK(all_notes(with_head(link_element("a") + link_element("b") +
                            joint_element("px", "prismatic", "world", "a", "1 0 0") +
                            joint_element("pz", "prismatic", "a", "b", "0 0 1") +
                            joint_element("pitch", "continuous", "b", "trunk", "0 1 0"))
                      .robot()) == "");
}

TEST_CASE("a tensor of inertia that no body has, has a note", "[urdf_notes]")
{
  const auto notes = [](const std::string& tensor, const std::string& rpy = "0 0 0")
  {
    return all_notes(with_head("<link name=\"part\"><inertial><origin rpy=\"" + rpy +
                               "\"/><mass value=\"1\"/><inertia " + tensor + "/></inertial></link>" +
                               joint_element("glue", "fixed", "trunk", "part"))
                         .robot());
  };
  const auto tensor = [](double ixx, double ixy, double ixz, double iyy, double iyz, double izz)
  {
    return fmt::format("ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"", ixx, ixy, ixz, iyy, iyz,
                       izz);
  };
  const std::string more = "w.urdf:2: link 'part': inertia: no body has the principal moments 0.05, 0.47 and 4.7 kg "
                           "m^2, of which the largest is more than the sum of the others; only that about y is read, ";
  CHECK(notes(tensor(0.47, 0, 0, 0.05, 0, 4.7)) == more + "0.05\n");
  CHECK(notes(tensor(0.47, 0, 0, 0.05, 0, 4.7), "1.5707963267948966 0 0") == more + "4.7\n");
  // turned by 45 degrees about y, and about x
  CHECK(notes(tensor(2.585, 0, 2.115, 0.05, 0, 2.585)) == more + "0.05\n");
  CHECK(notes(tensor(0.47, 0, 0, 2.375, 2.325, 2.375)) == more + "2.375\n");
  CHECK(notes(tensor(1, 1.5, 0, 1, 0, 1)) ==
        "w.urdf:2: link 'part': inertia: no body has the principal moments -0.5, 1 and 2.5 kg m^2, of which one is "
        "negative; only that about y is read, 1\n");
  // plates, rods, points, and digits that are rounded
  for (const std::string& good :
       {tensor(0.1, 0, 0, 0.2, 0, 0.1), tensor(0.2, 0, 0, 0.2, 0, 0), tensor(0, 0, 0, 0, 0, 0),
        tensor(0.1, 0, 0, 0.20015, 0, 0.1), tensor(1e-300, 0, 0, 1e-300, 0, 1e-300), tensor(0.1, 0.1, 0, 0.1, 0, 0.2),
        tensor(1, -0.5, -0.5, 1, -0.5, 1)})
  {
    CAPTURE(good);
    CHECK(notes(good) == "");
  }
  CHECK(notes(tensor(0.1, 0, 0, 0.2003, 0, 0.1)) != "");
}

TEST_CASE("an axis along +y counts angles against ours, and a note says of which joints", "[urdf_notes]")
{
  Walker walker;
  walker.left_axis = "0 1 0";
  const auto turned = [](const std::string& names)
  {
    return "w.urdf: angle and torque of " + names +
           " count against the URDF's: its axis is +y, ours counter-clockwise in the x-z plane";
  };
  CHECK(all_notes(walker.robot()) == turned("'left_hip'") + "\n");
  CHECK(all_notes(with_head(link_element("shin", "1") + link_element("weight", "1") +
                            joint_element("knee", "revolute", "left_thigh", "shin", "0 1 0") +
                            joint_element("slide", "prismatic", "trunk", "weight", "0 -1 0"))
                      .robot()) ==
        turned("'knee'") + "; displacement and force of 'slide' count against the URDF's: its axis is -y, ours +y\n");
  std::string all = walker.text();
  all.replace(all.find("\"0 -1 0\""), 8, "\"0 1 0\"");
  CHECK(all_notes(read_urdf_robot(all, "w.urdf")) == turned("all joints") + "\n");
  // an axis is where its frame turns it
  Walker rolled;
  rolled.left_origin = "<origin rpy=\"1.5707963267948966 0 0\"/>";
  rolled.left_axis = "0 0 1";
  CHECK(all_notes(rolled.robot()) == "");
  rolled.left_axis = "0 0 -1";
  CHECK(all_notes(rolled.robot()) == turned("'left_hip'") + "\n");

  // by the right hand about +y what hangs goes back, to -x; by our angle it goes to +x
  CHECK((Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()) * -Eigen::Vector3d::UnitZ()).x() < 0.0);
  const Robot robot = walker.robot();
  REQUIRE(robot.relative_names.front() == "left_hip");
  const auto foot_at = [&robot](double left_hip)
  {
    VectorQ q = VectorQ::Zero(robot.mechanism.num_q());
    q.head(robot.num_coordinates()) = robot.A_inverse.col(0) * left_hip;
    const Body thigh = body_of(robot.links[1]);
    Point foot = thigh.origin;
    foot.push_back({thigh.direction, {0.0, -1.0}});
    return position(kinematics(robot.mechanism, q, VectorQ::Zero(robot.mechanism.num_q())), foot);
  };
  CHECK(foot_at(0.3).x() > foot_at(0.0).x() + 0.29);

  // a TOML's own actuator counts as it says
  const TemporaryFolder folder;
  const std::string urdf = folder.write("w.urdf", walker.text());
  const auto notes = [&folder](const std::string& left)
  {
    return all_notes(load_robot(folder.write("w.toml", "urdf = \"w.urdf\"\n[[actuator]]\nname = \"l\"\n" + left +
                                                           "[[actuator]]\nname = \"r\"\non = \"right_thigh\"\n"
                                                           "against = \"trunk\"\n")));
  };
  CHECK(notes("on = \"left_thigh\"\nagainst = \"trunk\"\n") == urdf + turned("'left_hip'").substr(6) + "\n");
  CHECK(notes("on = \"trunk\"\nagainst = \"left_thigh\"\n") == "");
}

TEST_CASE("a volume has no mechanics", "[urdf_notes]")
{
  std::string text = Walker().text();
  text.replace(text.find("<mass"), 0, "<volume value=\"0.01\"/>");
  const Robot robot = read_urdf_robot(text, "w.urdf");
  CHECK(robot.model_id == Walker().robot().model_id);
  CHECK(all_notes(robot) == "");
}

TEST_CASE("what might be mechanics is never passed over", "[urdf_notes]")
{
  struct Row
  {
    Walker walker;
    std::string message;
  };
  for (const auto& [walker, message] : std::vector<Row>{
           {with_tail("<loop_joint name=\"l\"><link1 link=\"left_thigh\"/><link2 link=\"right_thigh\"/></loop_joint>"),
            "w.urdf:8: <loop_joint> is not known here: its name speaks of mechanics"},
           {with_tail("<force_element name=\"f\"/>"), "w.urdf:8: <force_element> is not known here"},
           {with_tail("<drake:joint name=\"u\" type=\"universal\"/>"), "w.urdf:8: <drake:joint> is not known here"},
           {with_tail("<drake:linear_bushing_rpy/>"), "<drake:linear_bushing_rpy> is not known here"},
           {with_tail("<drake:ball_constraint/>"), "<drake:ball_constraint> is not known here"},
           {with_tail(
                "<gazebo><joint name=\"l\"><parent>left_thigh</parent><child>right_thigh</child></joint></gazebo>"),
            "w.urdf:8: <gazebo> holds <joint>, which changes how the robot moves"},
           {with_tail("<mujoco><equality/></mujoco>"), "w.urdf:8: <mujoco> holds <equality>"},
           {with_head("<link name=\"part\"><inertail/></link>"),
            "w.urdf:2: link 'part': <inertail> is not known here: did you mean <inertial>?"},
           {with_head("<link name=\"part\"><Inertial/></link>"), "did you mean <inertial>?"},
           {with_head("<link name=\"part\" mass=\"3\"/>"), "mass: is not known here; known are: name"},
           {with_hip("<mimc joint=\"right_hip\"/>"),
            "joint 'left_hip': <mimc> is not known here: did you mean <mimic>?"},
           {with_tail("<jiont name=\"j\"/>"), "<jiont> is not known here: did you mean <joint>?"}})
  {
    const std::string found = walker.complaint();
    CAPTURE(found);
    CHECK(found.find(message) != std::string::npos);
  }
}

} // namespace urdf_notes_test
