#include "catch.h"
#include "matchers.h"
#include "methods/constrained.h"
#include "methods/human_transition.h"
#include "methods/least_torque.h"
#include "methods/linear_transition.h"
#include "methods/pseudo_inverse.h"
#include "methods/torque_solution.h"

#include "answer/config.h"
#include "robot/files/load.h"
#include "robot/files/strict_toml.h"
#include "temporary_folder.h"

namespace config_test
{

using namespace torqued;

namespace
{

struct Written
{
  explicit Written(const std::string& text) : path(folder.write("c.toml", text)) {}
  TemporaryFolder folder;
  std::string path;
};

std::string complaint(const std::string& text)
{
  const Written file(text);
  try
  {
    read_config(file.path);
    return "";
  }
  catch (const FileError& error)
  {
    const std::string message = error.what();
    REQUIRE(message.starts_with(file.path));
    return message.substr(file.path.size());
  }
}

} // namespace

TEST_CASE("an empty configuration gives the documented defaults", "[config]")
{
  const Config config = read_config(Written("").path);
  CHECK(config.robot == "");
  CHECK(config.lcm_url.empty());
  CHECK(config.prefix.empty());
  CHECK_FALSE(config.every_sample);
  CHECK_FALSE(config.lock_memory);
  CHECK(config.scheduling.policy == Scheduling::Policy::other);
  CHECK_FALSE(config.scheduling.priority);
  CHECK(config.scheduling.cpus.empty());
  CHECK(config.max_age == 0.020);
  CHECK(config.deadline == 0.001);
  CHECK(config.answers.methods.method == Method::constrained);
  CHECK(config.answers.consistency == OnExcess::flag);
  CHECK(config.answers.contact_speed_tolerance == 0.01);
  CHECK(config.answers.contact_tolerance == 0.1);
  CHECK(config.answers.sole_tilt_tolerance == 0.02);
  CHECK(config.answers.contact_height_tolerance == 0.03);
  CHECK(config.answers.residual_tolerance == 1e-3);
  CHECK(config.answers.limits == OnExcess::flag);
  CHECK(config.answers.rate_limits == OnExcess::flag);
  CHECK_FALSE(config.answers.project);
  CHECK(config.answers.nearest.metric == NearestMetric::mass);
  CHECK(config.answers.nearest.contacts == NearestContacts::rest);
  CHECK(config.answers.nearest.contact_damping == 0.0);
  CHECK(config.answers.nearest.margin == 0.0);
  const MethodSettings& methods = config.answers.methods;
  CHECK(methods.infeasible == OnInfeasible::relax);
  CHECK(methods.of<PseudoInverse>().weights.size() == 0);
  CHECK(methods.of<PseudoInverse>().reaction_weights == Eigen::Vector3d(1.0, 1.0, 1.0));
  CHECK_FALSE(methods.of<LinearTransition>().leading_cop);
  CHECK(methods.of<InternalWrench>().weights.size() == 0);
  CHECK(methods.of<TorsoWrench>().weights.size() == 0);
  CHECK(methods.of<Constrained>().weights.size() == 0);
  CHECK(methods.of<Constrained>().windows);
  CHECK(methods.of<Constrained>().reference_weight == 0.0);
  CHECK_FALSE(methods.of<Constrained>().f_min);
}

TEST_CASE("the printed configuration, read again, is the same configuration", "[config]")
{
  const std::string changed = R"(
robot = "a \"quoted\" 'name'"
lcm_url = "udpm://239.255.76.67:7667?ttl=0"
prefix = "left/robot_"
log_level = "off"
every_sample = true
lock_memory = true
max_age = 0.1
deadline = 3e-4
method = "linear-transition"
consistency = "refuse"
contact_speed_tolerance = 0.011
contact_tolerance = 0.12
sole_tilt_tolerance = 0
contact_height_tolerance = 0.05
residual_tolerance = 2e-3
limits = "clamp"
rate_limits = "refuse"
project = true
infeasible = "refuse"
[pseudo_inverse]
weights = [1, 2, 3, 4, 5, 6]
reaction_weights = [0.5, 0.25, 8]
[linear_transition]
cop = 0.3
[internal_wrench]
weights = [[2, 1], [1, 3]]
[torso_wrench]
weights = [0.1]
[constrained]
weights = [1e-3, 1e3]
windows = false
reference_weight = 0.01
f_min = 20
[human_transition]
trailing_cop = 0.75
leading_cop = 0.25
time_weight = 1
fade = 0.5
[nearest]
metric = "angles"
contacts = "as-desired"
contact_damping = 40
margin = 0.005
[scheduling]
policy = "rr"
priority = 99
cpus = "0-2,7"
)";
  for (const std::string& text : {std::string(), changed})
  {
    const Config config = read_config(Written(text).path);
    const std::string printed = to_toml(config);
    CHECK(to_toml(read_config(Written(printed).path)) == printed);
  }
  const Config config = read_config(Written(changed).path);
  CHECK(config.robot == "a \"quoted\" 'name'");
  CHECK(config.answers.limits == OnExcess::clamp);
  CHECK(config.answers.project);
  CHECK(config.answers.nearest.metric == NearestMetric::angles);
  CHECK(config.answers.nearest.contacts == NearestContacts::as_desired);
  CHECK(config.answers.nearest.contact_damping == 40.0);
  CHECK(config.answers.nearest.margin == 0.005);
  const MethodSettings& methods = config.answers.methods;
  CHECK(methods.infeasible == OnInfeasible::refuse);
  CHECK(mismatch(methods.of<PseudoInverse>().weights.diagonal(), (Eigen::VectorXd(6) << 1, 2, 3, 4, 5, 6).finished(),
                 0.0) == "");
  CHECK(methods.of<PseudoInverse>().weights.isDiagonal(0.0));
  CHECK(methods.of<PseudoInverse>().reaction_weights == Eigen::Vector3d(0.5, 0.25, 8.0));
  CHECK(methods.of<LinearTransition>().leading_cop == 0.3);
  CHECK(mismatch(methods.of<InternalWrench>().weights, (Eigen::Matrix2d() << 2, 1, 1, 3).finished(), 0.0) == "");
  CHECK(methods.of<TorsoWrench>().weights(0, 0) == 0.1);
  CHECK(methods.of<Constrained>().weights(1, 1) == 1e3);
  CHECK_FALSE(methods.of<Constrained>().windows);
  CHECK(methods.of<Constrained>().reference_weight == 0.01);
  CHECK(methods.of<Constrained>().f_min == 20.0);
  CHECK(methods.of<HumanTransition>().trailing_cop == 0.75);
  CHECK(methods.of<HumanTransition>().leading_cop == 0.25);
  CHECK(methods.of<HumanTransition>().time_weight == 1.0);
  CHECK(methods.of<HumanTransition>().fade == 0.5);
  CHECK(config.lock_memory);
  CHECK(config.scheduling.policy == Scheduling::Policy::rr);
  CHECK(config.scheduling.priority == 99.0);
  CHECK(processors(config.scheduling.cpus) == std::vector{0, 1, 2, 7});
  CHECK(to_toml(config) != to_toml(Config()));
}

TEST_CASE("a bad configuration is refused with line, key and what would be right", "[config]")
{
  CHECK(complaint("\nrobots = \"ck\"").starts_with(":2: robots: is not known here; known are: consistency,"));
  CHECK(complaint("robot = 3") == ":1: robot: found 3; expected a text in quotes");
  CHECK(complaint("every_sample = 1") == ":1: every_sample: found 1; expected true or false");
  CHECK(complaint("max_age = 0") == ":1: max_age: found 0; expected a positive number of seconds, up to 1");
  CHECK(complaint("max_age = nan") == ":1: max_age: found nan; expected a finite number");
  CHECK(complaint("deadline = -1") == ":1: deadline: found -1; expected a positive number of seconds, up to 3600");
  CHECK(complaint("contact_tolerance = -0.1") ==
        ":1: contact_tolerance: found -0.1; expected a number that is not negative");
  CHECK(complaint("consistency = \"clamp\"") == ":1: consistency: found \"clamp\"; expected one of: flag, refuse");
  CHECK(complaint("limits = \"never\"") == ":1: limits: found \"never\"; expected one of: flag, refuse, clamp");
  CHECK(complaint("method = \"human-shuffle\"") ==
        ":1: method: found \"human-shuffle\"; expected one of: " + method_names());
  CHECK(method_names().starts_with("pseudo-inverse, linear-transition, "));
  CHECK(complaint("prefix = \"a.*\"") == ":1: prefix: found \"a.*\"; expected at most 32 letters, digits, _, - or /");
  CHECK(complaint("log_level = \"loud\"").starts_with(":1: log_level: found \"loud\"; expected one of: trace, debug,"));
  CHECK(complaint("[linear_transition]\ncop = 1.5") == ":2: linear_transition: cop: found 1.5; expected \"zmp\", or 0 "
                                                       "(heel) to 1 (toe)");
  CHECK(complaint("[linear_transition]\ncop = \"middle\"") ==
        ":2: linear_transition: cop: found \"middle\"; expected \"zmp\", or 0 (heel) to 1 (toe)");
  CHECK(complaint("[linear_transition]\ncops = 1").starts_with(":2: linear_transition: cops: is not known here"));
  CHECK(complaint("infeasible = \"flag\"") == ":1: infeasible: found \"flag\"; expected one of: relax, refuse, "
                                              "nearest");
  CHECK(complaint("projection = true").starts_with(":1: projection: is not known here"));
  CHECK(complaint("[tracked_internal]\ncop = 0.5").starts_with(":1: tracked_internal: is not known here"));
  const std::string weights = "expected up to 16 finite numbers, or as many rows of as many numbers";
  CHECK(complaint("[constrained]\nweights = 3") == ":2: constrained: weights: found 3; " + weights);
  CHECK(complaint("[constrained]\nweights = [1, nan]").ends_with(weights));
  CHECK(complaint("[constrained]\nweights = [1, \"2\"]").ends_with(weights));
  CHECK(complaint("[constrained]\nweights = [1, [2]]").ends_with(weights));
  CHECK(complaint("[constrained]\nweights = [[1, 2], [2]]").ends_with(weights));
  CHECK(complaint("[constrained]\nweights = [[1, 2], 2]").ends_with(weights));
  CHECK(complaint("[constrained]\nweights = [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]").ends_with(weights));
  CHECK(complaint("[torso_wrench]\nweights = [[1, 2], [3, 9]]") ==
        ":2: torso_wrench: weights: found 3 in row 2, column 1 and 2 in row 1, column 2; expected a symmetric matrix");
  const std::string definite = "found a matrix that is not positive definite; expected one that is, such as positive "
                               "numbers for its diagonal";
  CHECK(complaint("[internal_wrench]\nweights = [[1, 2], [2, 1]]") == ":2: internal_wrench: weights: " + definite);
  CHECK(complaint("[pseudo_inverse]\nweights = [1, 0]") == ":2: pseudo_inverse: weights: " + definite);
  for (const std::string_view wrong : {"[1, 1]", "[1, 1, 0]", "[1, 1, -1]", "[[1, 1, 0], [1, 2, 0], [0, 0, 1]]"})
    CHECK(complaint(fmt::format("[pseudo_inverse]\nreaction_weights = {}", wrong)) ==
          ":2: pseudo_inverse: reaction_weights: expected three positive numbers: of f_x, of f_z and of the moment");
  CHECK(complaint("[constrained]\nf_min = -1") ==
        ":2: constrained: f_min: found -1; expected \"robot\", or a force of 0 N or more");
  CHECK(complaint("[constrained]\nf_min = \"some\"") ==
        ":2: constrained: f_min: found \"some\"; expected \"robot\", or a force of 0 N or more");
  CHECK(complaint("[constrained]\nreference_weight = -1") ==
        ":2: constrained: reference_weight: found -1; expected a number that is not negative");
  CHECK(complaint("[human_transition]\ntrailing_cop = 1.5") ==
        ":2: human_transition: trailing_cop: found 1.5; expected 0 to 1");
  CHECK(complaint("[human_transition]\nleading_cop = -0.1") ==
        ":2: human_transition: leading_cop: found -0.1; expected 0 to 1");
  CHECK(complaint("[human_transition]\ntime_weight = 2") ==
        ":2: human_transition: time_weight: found 2; expected 0 to 1");
  CHECK(complaint("[human_transition]\nfade = 0.6") == ":2: human_transition: fade: found 0.6; expected 0 to 0.5");
  CHECK(complaint("[human_transition]\nshape = 1").starts_with(":2: human_transition: shape: is not known here"));
  CHECK(complaint("lock_memory = 1") == ":1: lock_memory: found 1; expected true or false");
  CHECK(complaint("[scheduling]\npolicy = \"deadline\"") ==
        ":2: scheduling: policy: found \"deadline\"; expected one of: other, fifo, rr");
  for (const std::string wrong : {"0", "100", "-1", "1.5"})
    CHECK(complaint("[scheduling]\npolicy = \"fifo\"\npriority = " + wrong) ==
          ":3: scheduling: priority: found " + wrong + "; expected \"none\", or a whole number from 1 to 99");
  CHECK(
      complaint("[scheduling]\npriority = 50") ==
      ":2: scheduling: priority: found 50 with policy \"other\", which has none; expected policy = \"fifo\" or \"rr\" "
      "beside it, or no priority");
  CHECK(complaint("[scheduling]\npolicy = \"fifo\"") ==
        ":1: scheduling: priority: found none with policy \"fifo\"; expected a whole number from 1 to 99, such as 50");
  for (const std::string wrong : {"x", "2-", "-2", "3-2", "1024", "1,", ",1", "1,,2", "1 2", "0-99999999999", "0x1"})
    CHECK(
        complaint("[scheduling]\ncpus = \"" + wrong + "\"") ==
        ":2: scheduling: cpus: found \"" + wrong +
            "\"; expected processors as taskset lists them, such as \"2\", \"2,3\" or \"2-5\", with numbers from 0 to "
            "1023");
  CHECK(complaint("[scheduling]\ncpus = 2") == ":2: scheduling: cpus: found 2; expected a text in quotes");
  CHECK(complaint("[scheduling]\ncpu = \"2\"").starts_with(":2: scheduling: cpu: is not known here"));
  CHECK(complaint("robot = ").starts_with(":1: not TOML: "));
  CHECK(complaint("max_age = 1e300").starts_with(":1: max_age: found 1e+300; expected a positive number of seconds"));
  CHECK(complaint("robot = \"a\\nb\"") == ":1: robot: found \"a?b\"; expected a text without control characters");
  CHECK(complaint("lcm_url = \"\\u001b[2J\"").starts_with(":1: lcm_url: found \"?[2J\"; expected a text"));
  CHECK(complaint("\"a\\nb\" = 1").starts_with(":1: a?b: is not known here"));
  CHECK_THROWS_AS(read_config("/no/such/file.toml"), FileError);
  CHECK_THROWS_AS(read_config("/dev/zero"), FileError);
}

TEST_CASE("the settings id changes with every setting that changes answers, and with no other", "[config]")
{
  const auto id = [](const std::string& text)
  {
    return settings_id(read_config(Written(text).path).answers);
  };
  const std::int64_t plain = id("");
  CHECK(plain != 0);
  for (const std::string same : {"robot = \"human-subject01\"", "max_age = 1", "deadline = 1", "prefix = \"x\"",
                                 "every_sample = true", "log_level = \"off\"", "lcm_url = \"memq://\"",
                                 "lock_memory = true", "[scheduling]\npolicy = \"rr\"\npriority = 1\ncpus = \"0\""})
    CHECK(id(same) == plain);
  for (const std::string other : {"consistency = \"refuse\"",
                                  "contact_speed_tolerance = 1",
                                  "contact_tolerance = 1",
                                  "sole_tilt_tolerance = 1",
                                  "contact_height_tolerance = 1",
                                  "residual_tolerance = 1",
                                  "limits = \"refuse\"",
                                  "limits = \"clamp\"",
                                  "rate_limits = \"refuse\"",
                                  "project = true",
                                  "[linear_transition]\ncop = 0.5",
                                  "method = \"zmp-transition\"",
                                  "infeasible = \"refuse\"",
                                  "[pseudo_inverse]\nweights = [2]",
                                  "[pseudo_inverse]\nreaction_weights = [1, 1, 2]",
                                  "[internal_wrench]\nweights = [2]",
                                  "[torso_wrench]\nweights = [2]",
                                  "[constrained]\nweights = [2]",
                                  "[constrained]\nwindows = false",
                                  "[constrained]\nreference_weight = 1",
                                  "[constrained]\nf_min = 0",
                                  "[human_transition]\ntrailing_cop = 1",
                                  "[human_transition]\nleading_cop = 0",
                                  "[human_transition]\ntime_weight = 0",
                                  "[human_transition]\nfade = 0"})
  {
    CAPTURE(other);
    CHECK(id(other) != plain);
  }
}

TEST_CASE("weights that do not fit the robot are refused before it moves", "[config]")
{
  const Robot ck = load_robot("ck");
  for (const std::string table : {"pseudo_inverse", "internal_wrench", "torso_wrench", "constrained"})
  {
    CHECK_NOTHROW(check_fits(read_config(Written("[" + table + "]\nweights = [1, 1, 1, 1, 1, 2]").path), ck));
    try
    {
      check_fits(read_config(Written("[" + table + "]\nweights = [1, 1, 1, 1, 2]").path), ck);
      FAIL("five weights for six motors");
    }
    catch (const FileError& error)
    {
      CHECK(error.what() ==
            "the configuration does not fit ck: " + table + ": weights: found 5 of them; this robot has 6 motors");
    }
  }
}

TEST_CASE("feet that shall carry more than the weight are refused where the motion would be moved for it", "[config]")
{
  const auto with = [](const std::string& infeasible, double f_min)
  {
    return read_config(fmt::format("infeasible = \"{}\"\n[constrained]\nf_min = {}\n", infeasible, f_min), "t.toml");
  };
  CHECK_NOTHROW(check_fits(with("nearest", 220.0), load_robot("ck"))); // of 441.45 N
  CHECK_NOTHROW(check_fits(with("relax", 221.0), load_robot("ck")));
  CHECK_THROWS_WITH(
      check_fits(with("nearest", 221.0), load_robot("ck")),
      "the configuration does not fit ck: f_min: the feet of ck shall carry 442 N at least, expected less "
      "than its weight, 441.5 N: the nearest motion would have to accelerate upwards");
}

TEST_CASE("a margin that leaves nothing of a sole is refused; a robot without soles takes any", "[config]")
{
  const auto with = [](double margin)
  {
    return read_config(fmt::format("[nearest]\nmargin = {}\n", margin), "t.toml");
  };
  CHECK_NOTHROW(check_fits(with(0.109), load_robot("ck")));
  CHECK_NOTHROW(check_fits(with(0.2), load_robot("rabbit")));
  CHECK_THROWS_WITH(check_fits(with(0.11), load_robot("ck")),
                    "the configuration does not fit ck: nearest: margin: found 0.11 m; off both ends it leaves nothing "
                    "of the left sole of ck, expected less than 0.11 m");
}

} // namespace config_test
