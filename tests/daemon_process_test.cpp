#include "catch.h"
#include "daemon_bench.h"
#include "temporary_folder.h"

#include "motion/files.h"
#include "robot/files/load.h"
#include "robot/files/robot_files.h"

#include <fmt/format.h>

namespace daemon_process_test
{

using namespace torqued;

namespace
{

// What torqued prints and how it ends when it is started with these arguments.
std::pair<std::optional<int>, std::string> run(std::vector<std::string> arguments)
{
  const TemporaryFolder folder;
  arguments.insert(arguments.begin(), TORQUED);
  Process torqued(arguments, folder.file("output"));
  const auto code = torqued.wait();
  return {code, read_file(folder.file("output"))};
}

} // namespace

TEST_CASE("each kind of bad sample gives one rejection with its reason, and the next good one is answered",
          "[daemon_process]")
{
  for (const char* mode : {"--every-sample", "--log-level=info"})
  {
    Bench bench({mode});
    struct Row
    {
      std::function<void(desired_state_t&, std::vector<std::byte>&)> damage;
      int reason;
    };
    const auto encoded = [](const desired_state_t& desired, std::vector<std::byte>& bytes)
    {
      bytes.resize(static_cast<std::size_t>(desired.getEncodedSize()));
      encode(desired, bytes);
    };
    const std::vector<Row> rows{
        {[&](auto& d, auto& b) { encoded(d, b), b.resize(b.size() - 9); }, rejection_t::UNDECODABLE},
        {[&](auto& d, auto& b) { encoded(d, b), b.push_back(std::byte{0}); }, rejection_t::UNDECODABLE},
        {[&](auto& d, auto& b) { encoded(d, b), b[0] ^= std::byte{1}; }, rejection_t::UNDECODABLE},
        {[&](auto&, auto& b) { b = {}; }, rejection_t::UNDECODABLE},
        {[&](auto& d, auto& b)
         {
           d.num_coordinates = 8;
           for (auto* vector : {&d.q, &d.v, &d.a})
             vector->push_back(0.0);
           encoded(d, b);
         },
         rejection_t::WRONG_SIZE},
        {[&](auto& d, auto& b) { d.a[6] = NAN, encoded(d, b); }, rejection_t::NOT_FINITE},
        {[&](auto& d, auto& b) { d.left_contact = 4, encoded(d, b); }, rejection_t::OUT_OF_RANGE},
        {[&](auto& d, auto& b) { d.method = 10, encoded(d, b); }, rejection_t::UNKNOWN_METHOD},
        {[&](auto& d, auto& b) { d.model_id ^= 1, encoded(d, b); }, rejection_t::WRONG_MODEL},
        {[&](auto& d, auto& b)
         {
           d.left_contact = d.right_contact = desired_state_t::NONE;
           encoded(d, b);
         },
         rejection_t::NOT_SUPPORTED},
        {[&](auto& d, auto& b)
         {
           d.right_contact = desired_state_t::NONE;
           d.left_contact = desired_state_t::TOE;
           encoded(d, b);
         },
         rejection_t::UNDER_ACTUATED},
    };
    for (const Row& row : rows)
    {
      CAPTURE(mode, row.reason);
      const std::size_t rejections = bench.rejections.size();
      const std::size_t commands = bench.commands.size();
      desired_state_t bad = bench.standing();
      std::vector<std::byte> bytes;
      row.damage(bad, bytes);
      bench.send(Bytes(bytes));
      REQUIRE(bench.wait([&] { return bench.rejections.size() > rejections; }));
      CHECK(bench.rejections.back().reason == row.reason);
      CHECK_FALSE(bench.rejections.back().detail.empty());

      const desired_state_t good = bench.standing();
      bench.send(good);
      REQUIRE(bench.wait([&] { return bench.commands.size() > commands; }));
      CHECK(bench.commands.back().utime == good.utime);
      CHECK(bench.rejections.size() == rejections + 1);
      CHECK(bench.commands.size() == commands + 1);
    }

    // the status accounts for every one of them
    const auto all = static_cast<std::int64_t>(2 * rows.size());
    REQUIRE(bench.wait([&] { return !bench.statuses.empty() && bench.statuses.back().received == all; }));
    CHECK(bench.statuses.back().answered == all / 2);
    CHECK(bench.statuses.back().rejected == all / 2);
    CHECK(bench.undecoded == 0);
  }
}

TEST_CASE("SIGTERM, SIGINT and SIGHUP end torqued cleanly, with STOPPING as its last status", "[daemon_process]")
{
  for (const int signal : {SIGTERM, SIGINT, SIGHUP})
  {
    CAPTURE(signal);
    Bench bench({}, {"env", "--default-signal=HUP"});
    bench.torqued().signal(signal);
    CHECK(bench.wait([&] { return !bench.statuses.empty() && bench.statuses.back().state == status_t::STOPPING; }));
    CHECK(bench.torqued().wait() == 0);
  }
  // but a terminal that is closed ends nothing that nohup has started
  Bench bench({}, {"env", "--ignore-signal=HUP"});
  bench.torqued().signal(SIGHUP);
  bench.hear_for(std::chrono::milliseconds(150));
  bench.send_one(bench.standing());
  CHECK(bench.commands.size() == 1);
  bench.check_account();
}

TEST_CASE("model and status are published unasked, and say which robot and which settings", "[daemon_process]")
{
  Bench bench({"--robot", "human-subject01", "--prefix", ""});
  CHECK(bench.model->name == "human-subject01");
  CHECK(bench.model->settings.find("robot = 'human-subject01'") != std::string::npos);
  bench.model.reset();
  REQUIRE(bench.wait([&] { return bench.model.has_value(); }));
  CHECK(bench.statuses.size() >= 10);
  CHECK(bench.statuses.back().model_id == bench.model->model_id);
  CHECK(bench.statuses.back().settings_id == bench.model->settings_id);
  CHECK(bench.statuses.back().state == status_t::WAITING);
}

TEST_CASE("a robot without feet is computed with in the air, and the log says so, and what of its file is not read",
          "[daemon_process]")
{
  const TemporaryFolder folder;
  std::string urdf = to_urdf(load_robot("rabbit"));
  urdf.insert(urdf.find("</joint>"), "<dynamics damping=\"2\"/>");
  Bench bench({"--robot", folder.write("flier.urdf", urdf)});
  CHECK(bench.wait([&] { return bench.output().find("no contact with the ground is possible") != std::string::npos; }));
  CHECK(bench.output().find("<dynamics damping=2> is not read: set viscous in the TOML") != std::string::npos);
  CHECK(bench.model->joint_names == std::vector<std::string>{"left_knee", "left_hip", "right_hip", "right_knee"});
  bench.send(bench.standing());
  REQUIRE(bench.wait([&] { return !bench.rejections.empty(); }));
  CHECK(bench.commands.empty());
}

TEST_CASE("a start that cannot succeed ends with one clear line and its exit code", "[daemon_process]")
{
  const TemporaryFolder folder;
  struct Row
  {
    std::vector<std::string> arguments;
    int code;
    std::string says;
  };
  const std::vector<Row> rows{
      {{"--nonsense"}, 64, "--nonsense"},
      {{"--method", "fastest"},
       64,
       "torqued: --method: found \"fastest\"; expected one of: pseudo-inverse, linear-transition, "},
      {{},
       78,
       "torqued: no robot is said: say --robot NAME|FILE, or robot = \"NAME\" in the file of --config (robots that "
       "ship: ck, rk, six-link, compass, bip-itlag, human-subject01, rabbit)\n"},
      {{"--config", folder.write("none.toml", "every_sample = true")}, 78, "torqued: no robot is said: "},
      {{"--config", folder.write("w.toml", "robot = \"ck\"\n[constrained]\nweights = [1, 2]")},
       78,
       "torqued: the configuration does not fit ck: constrained: weights: found 2 of them; this robot has 6 motors\n"},
      {{"--prefix", "a b"}, 64, "torqued: --prefix: found \"a b\"; expected at most 32 letters, digits, _, - or /\n"},
      {{"--log-level", "loud"}, 64, "torqued: --log-level: found \"loud\""},
      {{"--robot", "nobody"}, 78, "torqued: \"nobody\" is neither a robot that ships"},
      {{"--robot", folder.write("r.toml", "name = 3")}, 78, "r.toml:1: name: found 3; expected a text in quotes\n"},
      {{"--config", folder.write("c.toml", "\nmax_age = -1")},
       78,
       "c.toml:2: max_age: found -1; expected a positive number of seconds, up to 1\n"},
      {{"--config", folder.file("no.toml")}, 78, "no.toml: cannot be read: No such file or directory\n"},
      {{"--robot", "ck", "--lcm-url", "nothing://"},
       69,
       "torqued: the LCM bus cannot be opened: --lcm-url is \"nothing://\": LCM knows no \"nothing\"; expected udpm"},
  };
  for (const Row& row : rows)
  {
    const auto [code, output] = run(row.arguments);
    CAPTURE(row.says, output);
    CHECK(code == row.code);
    CHECK(output.find(row.says) != std::string::npos);
  }
}

TEST_CASE("a bus whose URL leads nowhere is refused at once, with who set it and what would be right",
          "[daemon_process]")
{
  const TemporaryFolder folder;
  struct Row
  {
    std::string url, says;
  };
  const std::vector<Row> rows{
      {"memq://", "such a bus stays within this process, where nobody else hears it; expected udpm://"},
      {"file://" + folder.write("walk.lcm", ""), "such a bus replays a log, or writes one"},
      {"udpm://239.255.76.67", "the port is missing; expected udpm://239.255.76.67:7667 or the like\n"},
      {"udpm://239.255.76.67:0", "the port is \"0\"; expected a whole number from 1 to 65535\n"},
      {"udpm://10.0.0.1:7667", "the address \"10.0.0.1\" is no group of IPv4 multicast; expected one from 224.0.0.0"},
      {"udpm://239.255.76.67:7667?ttl=300", "ttl is \"300\"; expected a whole number from 0 to 255\n"},
      {"udpm://239.255.76.67:7667?recv_buf_size=2M", "recv_buf_size is \"2M\"; expected a whole number"},
      {"udpm://239.255.76.67:7667?tll=0", "LCM knows no option \"tll\"; expected ttl or recv_buf_size\n"},
      {"tcpq://127.0.0.1:1", "No server of LCM's answers at 127.0.0.1 port 1: start one there"},
  };
  const auto began = std::chrono::steady_clock::now();
  for (const Row& row : rows)
  {
    const std::string file = folder.write("c.toml", fmt::format("robot = \"ck\"\nlcm_url = \"{}\"\n", row.url));
    const std::vector<std::pair<std::string, std::vector<std::string>>> ways{
        {"LCM_DEFAULT_URL", {"env", "LCM_DEFAULT_URL=" + row.url, TORQUED, "--robot", "ck"}},
        {"--lcm-url", {TORQUED, "--robot", "ck", "--lcm-url", row.url}},
        {"lcm_url in " + file, {TORQUED, "--config", file}}};
    for (const auto& [set_by, command] : ways)
    {
      Process torqued(command, folder.file("output"));
      const std::optional<int> code = torqued.wait();
      const std::string output = read_file(folder.file("output"));
      CAPTURE(command, output);
      CHECK(code == 69);
      CHECK(output.find(fmt::format("{} is \"{}\"", set_by, row.url)) != std::string::npos);
      CHECK(output.find(row.says) != std::string::npos);
    }
  }
  // LCM would search for ten seconds, twice, where it finds no port
  CHECK(std::chrono::steady_clock::now() - began < std::chrono::seconds(10 * rows.size()));
}

TEST_CASE("help, version and the printed configuration come without a bus", "[daemon_process]")
{
  const auto [help_code, help] = run({"--help"});
  CHECK(help_code == 0);
  for (const char* option : {"--robot", "--config", "--method", "--lcm-url", "--prefix", "--every-sample",
                             "--log-level", "--version", "--print-config", "default: constrained", "human-transition"})
    CHECK(help.find(option) != std::string::npos);
  const auto [version_code, version] = run({"--version"});
  CHECK(version_code == 0);
  CHECK(version.starts_with("torqued 0."));

  const TemporaryFolder folder;
  const auto [code, printed] =
      run({"--print-config", "--robot", "human-subject01", "--every-sample", "--prefix", "p_"});
  CHECK(code == 0);
  const auto [again_code, again] = run({"--print-config", "--config", folder.write("c.toml", printed)});
  CHECK(again_code == 0);
  CHECK(again == printed);
  // a robot is not needed to print what is set
  const auto [robotless_code, robotless] = run({"--print-config"});
  CHECK(robotless_code == 0);
  CHECK(robotless.find("\nrobot = ''") != std::string::npos);
  CHECK(printed.find("prefix = 'p_'") != std::string::npos);
}

TEST_CASE("torqued runs with every robot that ships: it answers a desired state and a request for the dynamics",
          "[daemon_process]")
{
  for (const std::string_view name : shipped_robot_names())
  {
    CAPTURE(name);
    Bench bench({"--every-sample", "--robot", std::string(name)});
    CHECK(bench.model->name == name);
    const auto& limits = bench.model->torque_limits;
    const bool unlimited = std::all_of(limits.begin(), limits.end(), [](double limit) { return std::isinf(limit); });
    CHECK(unlimited == (name != "ck" && name != "rk" && name != "six-link"));
    const std::string warning = fmt::format("{} has no torque limit for any motor", name);
    CHECK(bench.wait([&] { return (bench.output().find(warning) != std::string::npos) == unlimited; }));
    desired_state_t desired = bench.standing();
    if (bench.model->num_feet == 1)
      desired.right_contact = desired_state_t::NONE;
    if (name == "rabbit")
      desired.left_contact = desired.right_contact = desired_state_t::TOE;
    if (name == "rabbit")
      for (std::size_t i : {0U, 1U}) // one leg before the other: points at one place hold nothing
        desired.q[i] = 0.2;
    bench.send(desired);
    bench.ask(42);
    CHECK(
        bench.wait([&] { return bench.commands.size() + bench.rejections.size() == 1 && bench.dynamics.size() == 1; }));
    CHECK(bench.rejections.empty());
    REQUIRE(bench.commands.size() == 1);
    CHECK(bench.commands[0].num_joints == bench.model->num_joints);
    REQUIRE(bench.dynamics.size() == 1);
    const dynamics_t& reply = bench.dynamics[0];
    CHECK(reply.error == "");
    CHECK(reply.request_id == 42);
    CHECK(reply.model_id == bench.model->model_id);
    CHECK(reply.n == bench.model->num_coordinates + (bench.model->base_names[0].empty() ? 0 : 2));
    CHECK(reply.num_parameters > 0);
    CHECK(bench.undecoded == 0);
    bench.torqued().signal(SIGTERM);
    CHECK(bench.torqued().wait() == 0);
  }
}

} // namespace daemon_process_test
