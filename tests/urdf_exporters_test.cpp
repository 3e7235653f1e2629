// URDFs as exporters and simulators write them are read unedited, and refused where that would be a guess.
#include "catch.h"
#include "matchers.h"
#include "same_numbers.h"
#include "temporary_folder.h"
#include "urdf_walker.h"

#include "robot/files/load.h"
#include "robot/files/robot_files.h"

namespace urdf_exporters_test
{

using namespace torqued;

TEST_CASE("a frame turned by a rounded angle gives the numbers of the exact one", "[urdf_exporters]")
{
  const double quarter = 1.5707963267948966;
  const double half = 3.141592653589793;
  struct Rounded
  {
    std::string angle;
    double exact;
  };
  const std::vector<Rounded> angles{{"1.5708", quarter},   {"1.57079633", quarter}, {"1.5707", quarter},
                                    {"-1.5708", -quarter}, {"3.14159", half},       {"3.1416", half},
                                    {"3.1415", half},      {"-3.14159265", -half}};
  for (const Rounded& rounded : angles)
  {
    const std::string& angle = rounded.angle;
    const double exact = rounded.exact;
    CAPTURE(angle);
    const bool is_quarter = std::abs(exact) < 2.0;
    const auto check = [&](const auto& walker_of)
    {
      const Robot found = walker_of(angle).robot();
      // what one rounding after the other leaves: the angle's own would show as 1e-9 and more
      check_same_numbers(found, walker_of(fmt::format("{}", exact)).robot(), 1e-12);
      const std::string note = all_notes(found);
      CHECK(note.starts_with("w.urdf: out of the x-z plane, as rounded angles are, and read as in it: "));
      CHECK(note.find(fmt::format(" by {:.3g} rad", std::abs(std::stod(angle) - exact))) != std::string::npos);
    };

    // a joint that turns
    check(
        [&](const std::string& rpy)
        {
          Walker walker;
          walker.left_origin = "<origin xyz=\"0.02 0.1 -0.05\" rpy=\"" + rpy + " 0 0\"/>";
          walker.left_axis = is_quarter ? "0 0 1" : "0 1 0";
          return walker;
        });
    // a joint that does not, before one that does
    check(
        [&](const std::string& rpy)
        {
          const std::string turn = is_quarter ? rpy + " 0 0" : "0 0 " + rpy;
          return with_tail(link_element("bracket", "0.5") +
                           joint_element("mount", "fixed", "trunk", "bracket", "",
                                         "<origin xyz=\"0.1 0.2 0.3\" rpy=\"" + turn + "\"/>") +
                           link_element("arm", "0.7") +
                           joint_element("shoulder", "revolute", "bracket", "arm", is_quarter ? "0 0 1" : "0 1 0",
                                         "<origin xyz=\"0.3 0.2 0.1\"/>"));
        });
    // the tensor of inertia
    check(
        [&](const std::string& rpy)
        {
          Walker walker;
          walker.left_inertia_rpy = rpy + " 0 0";
          return walker;
        });
    // the root on the world
    if (!is_quarter)
      check(
          [&](const std::string& rpy)
          {
            return with_head(
                link_element("world") +
                joint_element("base", "floating", "world", "trunk", "",
                              "<origin xyz=\"0 0 1\" rpy=\"0 0 " + rpy + "\"/>") +
                link_element("spare") +
                joint_element("spare_mount", "fixed", "trunk", "spare", "", "<origin rpy=\"" + rpy + " 0 0\"/>"));
          });
  }

  // the root's own joints, which are none of the robot's
  const std::string mounted =
      all_notes(with_head(link_element("world") +
                          joint_element("base", "floating", "world", "trunk", "", "<origin rpy=\"0 0 3.14159\"/>"))
                    .robot());
  CHECK(mounted.find("joint 'base' by 2.65e-06 rad") != std::string::npos);

  // a frame that stands askew is in the plane by its joint's axis
  const auto askew = [](const std::string& rpy)
  {
    Walker walker;
    walker.left_origin = "<origin xyz=\"0.02 0.1 -0.05\" rpy=\"" + rpy + " 0 0\"/>";
    walker.left_axis = "0 -1 1";
    return walker.robot();
  };
  const Robot exact = askew("0.7853981633974483");
  check_same_numbers(askew("0.7854"), exact, 1e-12);
  CHECK(all_notes(exact) == "");
  CHECK(all_notes(askew("0.7854")).find("joint 'left_hip' by 1.84e-06 rad") != std::string::npos);
}

TEST_CASE("an axis further from the pitch axis than a rounded angle is refused, with both angles", "[urdf_exporters]")
{
  struct Row
  {
    std::string angle, axis, message;
  };
  for (const auto& [angle, axis, message] :
       std::vector<Row>{{"1.57", "0 0 1", "0.000796 rad from -y; the rpy of joint 'left_hip' is (1.57, 0, 0)"},
                        {"1.571", "0 0 1", "0.000204 rad from -y; the rpy of joint 'left_hip' is (1.571, 0, 0)"},
                        {"3.141", "0 1 0", "0.000593 rad from -y; the rpy of joint 'left_hip' is (3.141, 0, 0)"},
                        {"0.00011", "0 1 0", "0.00011 rad from +y; the rpy of joint 'left_hip' is (0.00011, 0, 0)"}})
  {
    CAPTURE(angle);
    Walker walker;
    walker.left_origin = "<origin rpy=\"" + angle + " 0 0\"/>";
    walker.left_axis = axis;
    const std::string found = walker.complaint();
    CHECK(found.starts_with("w.urdf:6: joint 'left_hip': axis: found "));
    CHECK(found.find(message + "; expected one parallel to y within 0.0001 rad") != std::string::npos);
  }
}

TEST_CASE("whatever lets a root float, the robot is the same", "[urdf_exporters]")
{
  const std::int64_t id = Walker().robot().model_id;
  const auto chain =
      [](const std::string& top, const std::string& first, const std::string& second, const std::string& third)
  {
    return link_element("a") + link_element("b") + first + second + third + (top.empty() ? "" : link_element(top));
  };
  const std::string x = joint_element("px", "prismatic", "world", "a", "1 0 0");
  const std::string z = joint_element("pz", "prismatic", "a", "b", "0 0 1");
  const std::string pitch = joint_element("pitch", "continuous", "b", "trunk", "0 1 0");
  for (const std::string& head : std::vector<std::string>{
           chain("world", x, z, pitch),
           chain("world", joint_element("pz", "prismatic", "world", "a", "0 0 -1"),
                 joint_element("px", "prismatic", "a", "b", "-1 0 0"),
                 joint_element("pitch", "revolute", "b", "trunk", "0 -1 -0")),
           chain("world", joint_element("pitch", "revolute", "world", "a", "0 1 0"),
                 joint_element("px", "prismatic", "a", "b", "1 0 0"),
                 joint_element("pz", "prismatic", "b", "trunk", "0 0 1")),
           chain("", x, z, pitch), // the world need not be declared
           chain("base", joint_element("px", "prismatic", "base", "a", "1 0 0"), z, pitch),
           chain("odom",
                 joint_element("still", "fixed", "odom", "still") + link_element("still") +
                     joint_element("px", "prismatic", "still", "a", "1 0 0"),
                 z, pitch),
           link_element("base", "0") + link_element("a", "0") + link_element("b", "0") +
               joint_element("px", "prismatic", "base", "a", "1 0 0") + z + pitch,
           chain("world", x + link_element("camera") + joint_element("seen", "fixed", "a", "camera"), z, pitch),
           link_element("world") + link_element("ground", "30") + joint_element("stands", "fixed", "world", "ground") +
               joint_element("base", "floating", "world", "trunk"),
           link_element("world") + joint_element("base", "planar", "world", "trunk", "0 1 0"),
           joint_element("base", "planar", "world", "trunk", "0 -1 0"),
           link_element("base_footprint") + joint_element("base", "planar", "base_footprint", "trunk", "0 1 0"),
           joint_element("base", "floating", "world", "trunk"),
           link_element("odom") + joint_element("base", "floating", "odom", "trunk", "0 0 0"),
           link_element("world", "0") + joint_element("base", "floating", "world", "trunk"),
           "<link name=\"world\"><inertial><mass value=\"0\"/></inertial></link>" +
               joint_element("base", "floating", "world", "trunk"),
           link_element("world"),
       })
  {
    CAPTURE(head);
    const Robot robot = with_head(head).robot();
    CHECK(robot.model_id == id);
    CHECK(robot.notes.size() == (head.find("camera") != std::string::npos || head.find("ground") != std::string::npos));
  }

  const std::string limited =
      joint_element("pitch", "continuous", "b", "trunk", "0 1 0", "<limit lower=\"-1\" upper=\"1\"/>");
  CHECK(all_notes(with_head(chain("world", x, z, limited)).robot()) ==
        "w.urdf:2: joint 'pitch' lets the root, 'trunk', float; limits and dynamics there are not read\n");
  const Robot ground = with_head(link_element("world") + link_element("ground", "30") +
                                 joint_element("stands", "fixed", "world", "ground") +
                                 joint_element("base", "floating", "world", "trunk"))
                           .robot();
  CHECK(all_notes(ground) == "w.urdf: passed over, because it moves nothing: link 'ground'\n");
}

TEST_CASE("a root that does not float is refused by what holds it", "[urdf_exporters]")
{
  const std::string x = joint_element("px", "prismatic", "world", "a", "1 0 0");
  const std::string z = joint_element("pz", "prismatic", "a", "b", "0 0 1");
  const std::string pitch = joint_element("pitch", "continuous", "b", "trunk", "0 1 0");
  struct Row
  {
    std::string head, message;
  };
  for (const auto& [head, message] : std::vector<Row>{
           {link_element("a", "0.01") + link_element("b") + x + z + pitch,
            "link 'a': moves with joint 'px' between the world and the root, and has a mass of 0.01 kg"},
           {link_element("a") + link_element("b", "0.5") + x + z + pitch, "link 'b': moves with joint 'pz' between"},
           {link_element("a") + link_element("b", "0") + joint_element("pitch", "continuous", "world", "a", "0 1 0") +
                joint_element("px", "prismatic", "a", "b", "1 0 0") +
                joint_element("pz", "prismatic", "b", "trunk", "0 0 1"),
            "link 'b': moves with joint 'px' between the world and the root, and has an inertia"},
           {link_element("a") + x + joint_element("pitch", "continuous", "a", "trunk", "0 1 0"),
            "joint 'px': its parent is the world"},
           {link_element("a") + link_element("b") + x + joint_element("pz", "prismatic", "a", "b", "-1 0 0") + pitch,
            "joint 'px': its parent is the world"},
           {link_element("a") + link_element("b") + joint_element("py", "prismatic", "world", "a", "0 1 0") + z + pitch,
            "joint 'py': its parent is the world"},
           {link_element("a") + link_element("b") + x + z + joint_element("roll", "continuous", "b", "trunk", "1 0 0"),
            "joint 'px': its parent is the world"},
           {joint_element("base", "planar", "world", "trunk", "0 0 1"),
            "joint 'base': axis: found (0, 0, 1), the normal of its plane; expected y"},
           {joint_element("base", "planar", "world", "trunk"), "joint 'base': axis: is missing"},
           {link_element("base", "1") + joint_element("base_joint", "floating", "base", "trunk"),
            "joint 'base_joint': is floating"},
           {link_element("arm", "1") + joint_element("shoulder", "planar", "trunk", "arm", "0 1 0"),
            "joint 'shoulder': is planar"},
       })
  {
    const std::string found = with_head(head).complaint();
    CAPTURE(head, found);
    CHECK(found.find(message) != std::string::npos);
  }
}

TEST_CASE("numbers as people and programs write them", "[urdf_exporters]")
{
  const std::int64_t id = Walker().robot().model_id;
  Walker walker;
  for (const std::string com : {"+0.01 +.03 -0.12", " 1e-2\t3.0E-2\n -.12 ", "+1.0e-02 0.03 -0.12000"})
  {
    walker.left_com = com;
    CHECK(walker.robot().model_id == id);
  }
  for (const std::string bad : {"+-0.01 0 0", "++0.01 0 0", "+ 0.01 0 0", "0.01 0 +", "+inf 0 0"})
  {
    walker.left_com = bad;
    CHECK(walker.complaint().find("xyz: found") != std::string::npos);
  }
}

TEST_CASE("a name may have 64 characters, and a refusal shows all of a longer one", "[urdf_exporters]")
{
  const std::string longest(64, 'n');
  const Robot robot = with_head(link_element(longest) + joint_element(longest, "fixed", "trunk", longest)).robot();
  CHECK(robot.links[0].name == longest);
  const TemporaryFolder folder;
  CHECK(load_robot(folder.write("r.toml", to_toml(robot))).model_id == robot.model_id);
  const std::string found = with_head(link_element(longest + "m")).complaint();
  CHECK(found.find("name: found \"" + longest + "m\" of 65 characters; expected 1 to 64 letters") != std::string::npos);
}

} // namespace urdf_exporters_test
