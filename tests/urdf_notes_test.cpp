// What a URDF says and no robot takes from it: named in a note, or refused.
#include "catch.h"
#include "temporary_folder.h"
#include "urdf_walker.h"

#include "robot/robot_files.h"

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
        "w.urdf:6: joint 'left_hip': <transmission mechanicalReduction=50> is not read: set rotor_inertia in the "
        "TOML\n");
  CHECK(transmission("<actuator name=\"m\"><mechanicalReduction>1</mechanicalReduction></actuator>") == "");
  CHECK(transmission("<mechanicalReduction>63.16</mechanicalReduction>").find("mechanicalReduction=63.16") !=
        std::string::npos);
  CHECK(transmission("<actuator name=\"m\"><drake:rotor_inertia value=\"0.0003\"/><drake:gear_ratio value=\"50\"/>"
                     "</actuator>")
            .find("<transmission rotor_inertia=0.0003 gear_ratio=50>") != std::string::npos);
  CHECK(all_notes(with_hip("<dynamics armature=\"0.1\" spring_stiffness=\"7\"/>").robot()) ==
        "w.urdf:6: joint 'left_hip': <dynamics armature=0.1 spring_stiffness=7> is not read: set rotor_inertia in the "
        "TOML; no key there says the others\n");
  CHECK(all_notes(with_hip("<safety_controller k_velocity=\"10\"/>").robot()) ==
        "w.urdf:6: joint 'left_hip': <safety_controller k_velocity=10> is not read, and no key in the TOML says it\n");
  CHECK(all_notes(with_tail("<gazebo reference=\"left_hip\"><springStiffness>3</springStiffness></gazebo>").robot())
            .find("w.urdf:6: joint 'left_hip': <gazebo springStiffness=3> is not read") != std::string::npos);
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
                      "<collision group=\"g\"><verbose value=\"V\"/></collision><contact><rolling_friction "
                      "value=\"1\"/></contact></link>" +
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
