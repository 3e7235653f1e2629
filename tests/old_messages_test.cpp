#include "catch.h"

#include "bus/daemons.h"
#include "motion/lcm_log.h"
#include "motion/old_messages.h"
#include "motion/trajectory.h"
#include "run_torquectl.h"
#include "study/answer_table.h"

#include <bit>
#include <cmath>

namespace old_messages_test
{

using namespace torqued;

namespace
{

const std::string kWalk = TRAJECTORIES "/subject01-walk/walk.csv";

// A message's bytes, field by field: network byte order.
class Encoder
{
public:
  template <typename Integer> Encoder& integer(Integer value)
  {
    for (std::size_t byte = sizeof(Integer); byte-- > 0;)
      bytes.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * byte) & 0xff));
    return *this;
  }
  Encoder& real(double value) { return integer(std::bit_cast<std::uint64_t>(value)); }
  Encoder& text(const std::string& value)
  {
    integer(static_cast<std::int32_t>(value.size() + 1));
    for (const char letter : value)
      integer(letter);
    return integer('\0');
  }

  std::vector<std::byte> bytes;
};

std::vector<std::byte> old_command(const torque_command_t& command)
{
  Encoder encoder;
  encoder.integer(0x9ef6fb0910ac29c2ULL);
  for (const std::int64_t number :
       {command.utime, command.stream_id, command.sequence, command.model_id, command.settings_id})
    encoder.integer(number);
  encoder.integer(command.method).integer(command.flags);
  for (const ground_reaction_t& foot : {command.left, command.right})
    encoder.real(foot.fx).real(foot.fz).real(foot.moment).real(foot.cop).real(foot.friction_ratio);
  encoder.real(command.zmp).real(command.dynamics_residual).real(command.contact_speed).real(command.contact_residual);
  encoder.integer(command.compute_ns).integer(command.num_joints);
  for (const double torque : command.torque)
    encoder.real(torque);
  return encoder.bytes;
}

std::vector<std::byte> old_status(const status_t& status)
{
  Encoder encoder;
  encoder.integer(0x4bdd1b87b2ae75dcULL);
  for (const std::int64_t number :
       {status.utime, status.instance_id, status.uptime_us, status.model_id, status.settings_id})
    encoder.integer(number);
  encoder.integer(status.state);
  for (const std::int64_t number : {status.received, status.answered, status.rejected, status.superseded, status.late,
                                    status.conflicts, status.dropped_logs})
    encoder.integer(number);
  encoder.integer(status.last_reason).integer(status.input_age_us);
  for (const double number : {status.latency_us_p50, status.latency_us_p90, status.latency_us_p99,
                              status.latency_us_p999, status.latency_us_max})
    encoder.real(number);
  return encoder.text(status.version).bytes;
}

template <typename Message> bool same(const Message& a, const Message& b)
{
  std::vector<std::byte> first, second;
  const Bytes x = encode(a, first), y = encode(b, second);
  return std::equal(x.begin(), x.end(), y.begin(), y.end());
}

torque_command_t some_command()
{
  torque_command_t command{};
  command.utime = 1;
  command.stream_id = 2;
  command.sequence = 3;
  command.model_id = 4;
  command.settings_id = 5;
  command.method = 6;
  command.flags = 7;
  command.left = {8.0, 9.0, 10.0, 11.0, 12.0};
  command.right = {13.0, 14.0, 15.0, 16.0, 17.0};
  command.zmp = 18.0;
  command.dynamics_residual = 19.0;
  command.contact_speed = 20.0;
  command.contact_residual = 21.0;
  command.compute_ns = 22;
  command.num_joints = 3;
  command.torque = {23.0, 24.0, 25.0};
  return command;
}

status_t some_status()
{
  return {1, 2, 3, 4, 5, status_t::RUNNING, 7, 8, 9, 10, 11, 12, 13, -1, 15, 16, 17.0, 18.0, 19.0, 20.0, 21.0, "0.9"};
}

} // namespace

TEST_CASE("an old message is read as the present one, and damaged not at all", "[old_messages]")
{
  const auto check = [](const auto& expected, const std::vector<std::byte>& bytes, auto found)
  {
    REQUIRE(decode_old(bytes, found));
    CHECK(same(found, expected));
    CHECK_FALSE(decode(Bytes(bytes), found));
    std::vector<std::byte> present;
    CHECK_FALSE(decode_old(encode(expected, present), found));
    for (std::size_t length = 0; length < bytes.size(); ++length)
    {
      const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
      REQUIRE_FALSE(decode_old(cut, found));
    }
    std::vector<std::byte> extended = bytes;
    extended.push_back(std::byte{0});
    CHECK_FALSE(decode_old(extended, found));
    CHECK(same(found, expected));
  };
  check(some_command(), old_command(some_command()), torque_command_t());
  check(some_status(), old_status(some_status()), status_t());
}

TEST_CASE("what an old command does not say is what was asked for, or not known", "[old_messages]")
{
  desired_state_t desired{};
  desired.base = desired_state_t::GIVEN;
  desired.base_a[0] = 1.0;
  desired.base_a[1] = 2.0;
  desired.num_coordinates = 2;
  desired.q = desired.v = {0.0, 0.0};
  desired.a = {3.0, 4.0};
  const auto completed = [&desired](torque_command_t command)
  {
    complete(command, desired);
    return command;
  };
  torque_command_t command = completed(some_command());
  CHECK(command.base_a[0] == 1.0);
  CHECK(command.base_a[1] == 2.0);
  CHECK(command.adjustment == 0.0);
  CHECK(command.num_coordinates == 2);
  CHECK(command.a == desired.a);

  // a command that says it is left as it is
  desired.a = {5.0, 6.0};
  CHECK(same(completed(command), command));

  desired.base = desired_state_t::FROM_CONTACT;
  command = completed(some_command());
  CHECK(std::isnan(command.base_a[0]));
  CHECK(std::isnan(command.base_a[1]));
  CHECK(command.a == desired.a);

  desired.base = desired_state_t::GIVEN;
  command = some_command();
  command.flags = torque_command_t::PROJECTED;
  command = completed(command);
  CHECK(std::isnan(command.base_a[0]));
  CHECK(std::isnan(command.adjustment));
  CHECK(command.a.size() == 2);
  CHECK(std::isnan(command.a[1]));
}

TEST_CASE("a log with old commands is exported and shown as one with present ones", "[old_messages]")
{
  const TemporaryFolder folder;
  const std::string present = folder.file("present.lcm"), old = folder.file("old.lcm");
  REQUIRE(run({"eval", kWalk, "--robot", "human-subject01", "-o", present}).code == 0);
  const std::string bytes = read_file(present);
  LogReader reader(bytes);
  LogWriter writer(old);
  while (const auto record = reader.next())
    if (torque_command_t command; decode(record->data, command))
      writer.write(record->channel, record->timestamp, old_command(command));
    else
      writer.write(record->channel, record->timestamp, record->data);
  writer.close();

  const auto exported = [&folder](const std::string& log)
  {
    const std::string csv = folder.file("exported.csv");
    const Run done = run({"export", log, "-o", csv});
    CHECK(done.code == 0);
    CHECK(done.err == "");
    return done.out + read_file(csv);
  };
  CHECK(exported(old) == exported(present)); // every base of this walk is GIVEN
  const std::string evaluated = folder.file("evaluated.csv");
  REQUIRE(run({"eval", kWalk, "--robot", "human-subject01", "-o", evaluated}).code == 0);
  CHECK(rows(evaluated) == rows(folder.file("exported.csv")));

  const auto page = [&folder](const std::string& log)
  {
    const Run done = run({"report", log, "-o", folder.file("page.html")});
    CHECK(done.code == 0);
    return done.out.substr(done.out.find(':'));
  };
  CHECK(page(old) == page(present));
}

TEST_CASE("an older daemon is heard, too", "[old_messages]")
{
  DaemonsHeard heard;
  heard.hear_status("", old_status(some_status()), DaemonsHeard::Clock::time_point{});
  const std::vector<Daemon> daemons = heard.at(DaemonsHeard::Clock::time_point{});
  REQUIRE(daemons.size() == 1);
  CHECK(same(daemons[0].status, some_status()));
}

} // namespace old_messages_test
