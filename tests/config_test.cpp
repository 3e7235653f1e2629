#include "catch.h"

#include "daemon/config.h"
#include "robot/strict_toml.h"
#include "temporary_folder.h"

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
  CHECK(config.robot == "ck");
  CHECK(config.lcm_url.empty());
  CHECK(config.prefix.empty());
  CHECK_FALSE(config.every_sample);
  CHECK(config.max_age == 0.020);
  CHECK(config.deadline == 0.001);
  CHECK(config.answers.methods.method == Method::linear_transition);
  CHECK(config.answers.consistency == OnExcess::flag);
  CHECK(config.answers.contact_speed_tolerance == 0.01);
  CHECK(config.answers.contact_tolerance == 0.1);
  CHECK(config.answers.sole_tilt_tolerance == 0.02);
  CHECK(config.answers.residual_tolerance == 1e-3);
  CHECK(config.answers.limits == OnExcess::flag);
  CHECK(config.answers.rate_limits == OnExcess::flag);
  CHECK_FALSE(config.answers.methods.linear_transition.leading_cop);
}

TEST_CASE("the printed configuration, read again, is the same configuration", "[config]")
{
  const std::string changed = R"(
robot = "a \"quoted\" 'name'"
lcm_url = "udpm://239.255.76.67:7667?ttl=0"
prefix = "left/robot_"
log_level = "off"
every_sample = true
max_age = 0.1
deadline = 3e-4
method = "linear-transition"
consistency = "refuse"
contact_speed_tolerance = 0.011
contact_tolerance = 0.12
sole_tilt_tolerance = 0
residual_tolerance = 2e-3
limits = "clamp"
rate_limits = "refuse"
[linear_transition]
cop = 0.3
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
  CHECK(config.answers.methods.linear_transition.leading_cop == 0.3);
  CHECK(to_toml(config) != to_toml(Config()));
}

TEST_CASE("a bad configuration is refused with line, key and what would be right", "[config]")
{
  CHECK(complaint("\nrobots = \"ck\"").starts_with(":2: robots: is not known here; known are: consistency,"));
  CHECK(complaint("robot = 3") == ":1: robot: found 3; expected a text in quotes");
  CHECK(complaint("every_sample = 1") == ":1: every_sample: found 1; expected true or false");
  CHECK(complaint("max_age = 0") == ":1: max_age: found 0; expected a positive number of seconds, up to 3600");
  CHECK(complaint("max_age = nan") == ":1: max_age: found nan; expected a finite number");
  CHECK(complaint("deadline = -1") == ":1: deadline: found -1; expected a positive number of seconds, up to 3600");
  CHECK(complaint("contact_tolerance = -0.1") ==
        ":1: contact_tolerance: found -0.1; expected a number that is not negative");
  CHECK(complaint("consistency = \"clamp\"") == ":1: consistency: found \"clamp\"; expected one of: flag, refuse");
  CHECK(complaint("limits = \"never\"") == ":1: limits: found \"never\"; expected one of: flag, refuse, clamp");
  CHECK(complaint("method = \"constrained\"") ==
        ":1: method: found \"constrained\"; expected one of: linear-transition");
  CHECK(complaint("prefix = \"a.*\"") == ":1: prefix: found \"a.*\"; expected at most 32 letters, digits, _, - or /");
  CHECK(complaint("log_level = \"loud\"").starts_with(":1: log_level: found \"loud\"; expected one of: trace, debug,"));
  CHECK(complaint("[linear_transition]\ncop = 1.5") == ":2: linear_transition: cop: found 1.5; expected \"zmp\", or 0 "
                                                       "(heel) to 1 (toe)");
  CHECK(complaint("[linear_transition]\ncop = \"middle\"") ==
        ":2: linear_transition: cop: expected \"zmp\", or 0 (heel) to 1 (toe)");
  CHECK(complaint("[linear_transition]\ncops = 1").starts_with(":2: linear_transition: cops: is not known here"));
  CHECK(complaint("infeasible = \"relax\"").starts_with(":1: infeasible: is not known here"));
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
                                 "every_sample = true", "log_level = \"off\"", "lcm_url = \"memq://\""})
    CHECK(id(same) == plain);
  for (const std::string other : {"consistency = \"refuse\"", "contact_speed_tolerance = 1", "contact_tolerance = 1",
                                  "sole_tilt_tolerance = 1", "residual_tolerance = 1", "limits = \"refuse\"",
                                  "limits = \"clamp\"", "rate_limits = \"refuse\"", "[linear_transition]\ncop = 0.5"})
  {
    CAPTURE(other);
    CHECK(id(other) != plain);
  }
}
