#include "answer/command.h"
#include "catch.h"
#include "matchers.h"
#include "oracles.h"

#include "methods/method.h"
#include "robot/files/load.h"
#include "robot/files/toml_robot.h"
#include "wire/codec.h"

#include <functional>
#include <limits>

namespace codec_test
{

using namespace torqued;

namespace
{

desired_state_t good(const Robot& robot)
{
  oracle::Random random(41);
  desired_state_t message{};
  message.utime = 123456789;
  message.stream_id = 987654321;
  message.model_id = robot.model_id;
  message.base = desired_state_t::GIVEN;
  message.left_contact = desired_state_t::SOLE;
  message.right_contact = desired_state_t::HEEL;
  message.leading_foot = desired_state_t::RIGHT;
  message.load_transfer = 0.25;
  message.phase = 0.5;
  for (auto* base : {message.base_q, message.base_v, message.base_a})
    for (int i = 0; i < 2; ++i)
      base[i] = oracle::uniform(random, -1.0, 1.0);
  message.num_coordinates = robot.num_coordinates();
  for (auto* vector : {&message.q, &message.v, &message.a})
    for (int i = 0; i < message.num_coordinates; ++i)
      vector->push_back(oracle::uniform(random, -1.0, 1.0));
  return message;
}

std::vector<std::byte> bytes_of(const desired_state_t& message)
{
  std::vector<std::byte> buffer;
  const Bytes bytes = encode(message, buffer);
  return {bytes.begin(), bytes.end()};
}

// "" if it was decoded, else the reason's name
std::string outcome(Bytes bytes, const Robot& robot)
{
  const auto result = decode_desired_state(bytes, robot);
  const Refusal* refusal = std::get_if<Refusal>(&result);
  return refusal ? std::string(name_of(refusal->reason())) : "";
}

void write_int32(std::vector<std::byte>& bytes, std::size_t at, std::int32_t value)
{
  for (int i = 0; i < 4; ++i)
    bytes[at + static_cast<std::size_t>(i)] = static_cast<std::byte>(static_cast<std::uint32_t>(value) >> (24 - 8 * i));
}

constexpr std::size_t kCountAt = 8 + 24 + 6 + 64; // num_coordinates in an encoded desired_state_t

} // namespace

TEST_CASE("a desired state arrives as it was sent", "[codec]")
{
  const Robot robot = load_robot("ck");
  const desired_state_t sent = good(robot);
  const auto result = decode_desired_state(bytes_of(sent), robot);
  REQUIRE(std::holds_alternative<DesiredState>(result));
  const DesiredState& got = std::get<DesiredState>(result);
  CHECK(got.utime == sent.utime);
  CHECK(got.stream_id == sent.stream_id);
  CHECK(got.base_given);
  CHECK(got.method == Method::none);
  CHECK(got.support.contact == std::array<Contact, 2>{Contact::sole, Contact::heel});
  CHECK(got.support.leading == Side::right);
  CHECK(got.support.load_transfer == 0.25);
  CHECK(got.support.phase == 0.5);
  const auto expected = [](const std::vector<double>& angles, const double* base)
  {
    Eigen::VectorXd all(9);
    all << Eigen::Map<const Eigen::VectorXd>(angles.data(), 7), base[0], base[1];
    return all;
  };
  CHECK(mismatch(got.q, expected(sent.q, sent.base_q), 0.0) == "");
  CHECK(mismatch(got.v, expected(sent.v, sent.base_v), 0.0) == "");
  CHECK(mismatch(got.a, expected(sent.a, sent.base_a), 0.0) == "");
}

TEST_CASE("relative coordinates mean the same motion as the absolute ones they stand for", "[codec]")
{
  const std::string with_offset = [&]
  {
    std::string text(shipped_robot_toml("ck"));
    const std::string key = "torque_limit = 150.0";
    return text.replace(text.find(key), key.size(), key + "\noffset = 0.3");
  }();
  const Robot robot = read_toml_robot(with_offset, "r.toml");
  desired_state_t absolute = good(robot);
  desired_state_t relative = absolute;
  relative.coordinates = desired_state_t::RELATIVE;
  const Eigen::Map<const Eigen::VectorXd> q(absolute.q.data(), 7), v(absolute.v.data(), 7), a(absolute.a.data(), 7);
  Eigen::Map<Eigen::VectorXd>(relative.q.data(), 7) = robot.A * q + robot.b;
  Eigen::Map<Eigen::VectorXd>(relative.v.data(), 7) = robot.A * v;
  Eigen::Map<Eigen::VectorXd>(relative.a.data(), 7) = robot.A * a;
  CHECK(relative.q[0] == absolute.q[1] - absolute.q[0] + 0.3);
  const auto from_absolute = std::get<DesiredState>(decode_desired_state(bytes_of(absolute), robot));
  const auto from_relative = std::get<DesiredState>(decode_desired_state(bytes_of(relative), robot));
  CHECK(mismatch(from_relative.q, from_absolute.q, 1e-14) == "");
  CHECK(mismatch(from_relative.v, from_absolute.v, 1e-14) == "");
  CHECK(mismatch(from_relative.a, from_absolute.a, 1e-14) == "");
  CHECK(from_absolute.relative_a.size() == 0);
  // the accelerations are kept as they were sent, to the last bit
  relative.a = {1e-3, 0.1, 12.3, 4567.8, -0.09, 3.3, 1e5}; // whose sums are rounded
  const auto kept = std::get<DesiredState>(decode_desired_state(bytes_of(relative), robot)).relative_a;
  CHECK(std::equal(relative.a.begin(), relative.a.end(), kept.begin(), kept.end()));
}

TEST_CASE("a desired state cut at any byte, or extended, is undecodable", "[codec]")
{
  const Robot robot = load_robot("ck");
  const std::vector<std::byte> whole = bytes_of(good(robot));
  REQUIRE(outcome(whole, robot) == "");
  for (std::size_t length = 0; length < whole.size(); ++length)
  {
    CAPTURE(length);
    // a copy of exactly this length, so that a sanitizer sees every byte read past it
    const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    CHECK(outcome(cut, robot) == "UNDECODABLE");
    const Sender sender = read_sender(cut);
    CHECK(sender.utime == (length >= 16 ? 123456789 : 0));
    CHECK(sender.stream_id == (length >= 24 ? 987654321 : 0));
  }
  for (const std::size_t extra : {1u, 8u, 1000u})
  {
    std::vector<std::byte> extended = whole;
    extended.insert(extended.end(), extra, std::byte{0});
    CHECK(outcome(extended, robot) == "UNDECODABLE");
  }
  for (std::size_t byte = 0; byte < 8; ++byte)
  {
    std::vector<std::byte> other_type = whole;
    other_type[byte] ^= std::byte{1};
    CHECK(outcome(other_type, robot) == "UNDECODABLE");
    CHECK(read_sender(other_type).utime == 0);
  }
}

TEST_CASE("a wrong count is refused before anything is sized by it", "[codec]")
{
  const Robot robot = load_robot("ck");
  for (const std::int32_t count : {-1, 0, 6, 8, 100'000'000, 1 << 29, std::numeric_limits<std::int32_t>::max(),
                                   std::numeric_limits<std::int32_t>::min()})
  {
    CAPTURE(count);
    std::vector<std::byte> bytes = bytes_of(good(robot));
    write_int32(bytes, kCountAt, count);
    CHECK(outcome(bytes, robot) == "WRONG_SIZE");
    desired_state_t message;
    CHECK_FALSE(decode(Bytes(bytes), message));
  }
}

TEST_CASE("a field that is not finite is refused, whether it is used or not", "[codec]")
{
  const Robot robot = load_robot("ck");
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()})
    for (int field = 0; field < 2 + 6 + 21; ++field)
    {
      CAPTURE(bad, field);
      desired_state_t message = good(robot);
      message.base = desired_state_t::FROM_CONTACT;
      double* fields[] = {&message.load_transfer, &message.phase, message.base_q, message.base_v, message.base_a};
      if (field < 2)
        *fields[field] = bad;
      else if (field < 8)
        fields[2 + (field - 2) / 2][field % 2] = bad;
      else if (field < 15)
        message.q[static_cast<std::size_t>(field - 8)] = bad;
      else if (field < 22)
        message.v[static_cast<std::size_t>(field - 15)] = bad;
      else
        message.a[static_cast<std::size_t>(field - 22)] = bad;
      CHECK(outcome(bytes_of(message), robot) == "NOT_FINITE");
    }
}

TEST_CASE("a field out of its range is refused by name", "[codec]")
{
  const Robot robot = load_robot("ck");
  using Change = std::function<void(desired_state_t&)>;
  struct Row
  {
    Change change;
    Reason reason;
    std::string detail;
  };
  const std::vector<Row> rows{
      {[](auto& m) { m.coordinates = 2; }, Reason::out_of_range,
       "coordinates is 2; expected ABSOLUTE (0) or RELATIVE (1)"},
      {[](auto& m) { m.coordinates = -1; }, Reason::out_of_range,
       "coordinates is -1; expected ABSOLUTE (0) or RELATIVE (1)"},
      {[](auto& m) { m.base = 2; }, Reason::out_of_range, "base is 2; expected FROM_CONTACT (0) or GIVEN (1)"},
      {[](auto& m) { m.left_contact = 4; }, Reason::out_of_range,
       "left_contact is 4; expected NONE (0), HEEL (1), SOLE (2) or TOE (3)"},
      {[](auto& m) { m.right_contact = -128; }, Reason::out_of_range,
       "right_contact is -128; expected NONE (0), HEEL (1), SOLE (2) or TOE (3)"},
      {[](auto& m) { m.leading_foot = 2; }, Reason::out_of_range, "leading_foot is 2; expected LEFT (0) or RIGHT (1)"},
      {[](auto& m) { m.load_transfer = 1.0000000000000002; }, Reason::out_of_range,
       "load_transfer is 1.0000000000000002; expected 0 to 1"},
      {[](auto& m) { m.load_transfer = -1e-300; }, Reason::out_of_range, "load_transfer is -1e-300; expected 0 to 1"},
      {[](auto& m) { m.phase = 2.0; }, Reason::out_of_range, "phase is 2; expected 0 to 1"},
      {[](auto& m) { m.method = 99; }, Reason::unknown_method,
       "method is 99; expected DEFAULT (0), PSEUDO_INVERSE (1), LINEAR_TRANSITION (2), "},
      {[](auto& m) { m.method = static_cast<std::int8_t>(methods().size() + 1); }, Reason::unknown_method,
       fmt::format("method is {}; expected DEFAULT (0), ", methods().size() + 1)},
      {[](auto& m) { m.method = -1; }, Reason::unknown_method, "method is -1; expected DEFAULT (0), "},
      {[](auto& m) { m.model_id = 5; }, Reason::wrong_model, "model_id is 5; expected"},
  };
  for (const Row& row : rows)
  {
    desired_state_t message = good(robot);
    row.change(message);
    const auto result = decode_desired_state(bytes_of(message), robot);
    CAPTURE(row.detail);
    REQUIRE(std::holds_alternative<Refusal>(result));
    CHECK(std::get<Refusal>(result).reason() == row.reason);
    CHECK(std::string(std::get<Refusal>(result).detail()).starts_with(row.detail));
  }
  desired_state_t unchecked = good(robot);
  unchecked.model_id = 0;
  unchecked.method = desired_state_t::LINEAR_TRANSITION;
  CHECK(outcome(bytes_of(unchecked), robot) == "");
}

TEST_CASE("random bytes and random damage never get past the checks by more than they say", "[codec]")
{
  const Robot robot = load_robot("ck");
  oracle::Random random(42);
  const std::vector<std::byte> whole = bytes_of(good(robot));
  int passed = 0;
  for (int i = 0; i < 20'000; ++i)
  {
    std::vector<std::byte> bytes = whole;
    const int damages = 1 + static_cast<int>(random() % 4);
    for (int k = 0; k < damages; ++k)
      bytes[8 + random() % (bytes.size() - 8)] = static_cast<std::byte>(random());
    if (random() % 4 == 0)
      bytes.resize(random() % 600);
    desired_state_t message;
    REQUIRE(is_desired_state(bytes) == decode(Bytes(bytes), message));
    const auto result = decode_desired_state(bytes, robot);
    if (const auto* desired = std::get_if<DesiredState>(&result))
    {
      const bool sound = desired->q.allFinite() && desired->v.allFinite() && desired->a.allFinite() &&
                         desired->support.load_transfer >= 0.0 && desired->support.load_transfer <= 1.0 &&
                         desired->support.phase >= 0.0 && desired->support.phase <= 1.0 && bytes.size() == whole.size();
      CHECK(sound);
      ++passed;
    }
  }
  CAPTURE(passed);
  CHECK(passed > 2'000);
}

TEST_CASE("what the daemon says arrives as it was said, and damaged not at all", "[codec]")
{
  const Robot robot = load_robot("ck");
  std::vector<std::byte> buffer;
  const auto check = [&](const auto& sent, auto received)
  {
    const Bytes view = encode(sent, buffer);
    const std::vector<std::byte> bytes(view.begin(), view.end());
    REQUIRE(decode(Bytes(bytes), received));
    std::vector<std::byte> again;
    const Bytes second = encode(received, again);
    CHECK(std::equal(second.begin(), second.end(), bytes.begin(), bytes.end()));
    for (std::size_t length = 0; length < bytes.size(); ++length)
    {
      const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
      REQUIRE_FALSE(decode(Bytes(cut), received));
    }
    std::vector<std::byte> extended = bytes;
    extended.push_back(std::byte{0});
    REQUIRE_FALSE(decode(Bytes(extended), received));
    // any four bytes turned into a huge, a negative or a slightly wrong count: no crash, no allocation by it
    for (std::size_t at = 8; at + 4 <= bytes.size(); ++at)
      for (const std::int32_t value : {-1, 1 << 29, std::numeric_limits<std::int32_t>::max(), 3})
      {
        std::vector<std::byte> damaged = bytes;
        write_int32(damaged, at, value);
        decode(Bytes(damaged), received);
      }
  };

  torque_command_t command{};
  fill(command, Answer{}, 7, 8);
  command.num_coordinates = 7;
  command.a.resize(7);
  command.num_joints = 6;
  command.torque.resize(6);
  check(command, torque_command_t());

  rejection_t rejection{};
  fill(rejection, {1, 2}, Refusal(Reason::stale, "too old by {} us", 30));
  CHECK(rejection.detail == "too old by 30 us");
  CHECK(rejection.reason == 8);
  check(rejection, rejection_t());

  status_t status{};
  status.version = "1.2.3";
  status.instance_id = 77;
  check(status, status_t());

  const Bytes bytes = encode(status, buffer);
  CHECK(read_status_instance(bytes) == 77);
  CHECK(read_status_instance(bytes.first(24)) == 77);
  CHECK(read_status_instance(bytes.first(23)) == 0);
  CHECK(read_status_instance(encode(rejection, buffer)) == 0);

  const model_info_t info = model_info(robot, 1, 2, "# settings");
  CHECK(info.num_links == 7);
  CHECK(info.num_feet == 2);
  CHECK(info.total_mass == robot.mechanism.mass());
  check(info, model_info_t());
}

TEST_CASE("each part of an answer stands in its field of the command", "[codec]")
{
  Answer answer;
  answer.utime = 1;
  answer.stream_id = 2;
  answer.method = Method::linear_transition;
  answer.flags = 5;
  answer.ground[0] = {{6.0, 7.0, 8.0}, 9.0, 10.0};
  answer.ground[1] = {{11.0, 12.0, 13.0}, 14.0, 15.0};
  answer.zmp = 16.0;
  answer.dynamics_residual = 17.0;
  answer.contact_speed = 18.0;
  answer.contact_residual = 19.0;
  answer.torque = VectorJ::LinSpaced(3, 20.0, 22.0);
  answer.base_a << 23.0, 24.0;
  answer.adjustment = 25.0;
  answer.a = VectorQ::LinSpaced(2, 26.0, 27.0);
  torque_command_t command{};
  fill(command, answer, 3, 4);
  CHECK(command.utime == 1);
  CHECK(command.stream_id == 2);
  CHECK(command.model_id == 3);
  CHECK(command.settings_id == 4);
  CHECK(command.method == 2);
  CHECK(command.flags == 5);
  CHECK(command.left.fx == 6.0);
  CHECK(command.left.fz == 7.0);
  CHECK(command.left.moment == 8.0);
  CHECK(command.left.cop == 9.0);
  CHECK(command.left.friction_ratio == 10.0);
  CHECK(command.right.fx == 11.0);
  CHECK(command.right.fz == 12.0);
  CHECK(command.right.moment == 13.0);
  CHECK(command.right.cop == 14.0);
  CHECK(command.right.friction_ratio == 15.0);
  CHECK(command.zmp == 16.0);
  CHECK(command.dynamics_residual == 17.0);
  CHECK(command.contact_speed == 18.0);
  CHECK(command.contact_residual == 19.0);
  CHECK(command.num_joints == 3);
  CHECK(command.torque == std::vector<double>{20.0, 21.0, 22.0});
  CHECK(std::vector<double>{command.base_a[0], command.base_a[1], command.adjustment} ==
        std::vector<double>{23.0, 24.0, 25.0});
  CHECK(command.num_coordinates == 2);
  CHECK(command.a == std::vector<double>{26.0, 27.0});
}

TEST_CASE("each part of a robot stands in its field of the model", "[codec]")
{
  std::string text(shipped_robot_toml("ck"));
  const std::string limit = "torque_limit = 150.0";
  text.replace(text.find(limit), limit.size(), "torque_limit = 140.0\nrate_limit = 9.0\noffset = 0.5");
  const model_info_t info = model_info(read_toml_robot(text, "r.toml"), 1, 2, "settings");
  CHECK(info.instance_id == 1);
  CHECK(info.settings_id == 2);
  CHECK(info.settings == "settings");
  CHECK(info.name == "ck");
  CHECK(info.gravity == 9.81);
  CHECK(info.absolute_names[6] == "q6");
  CHECK(info.relative_names[0] == "left_ankle");
  CHECK(info.base_names[0] == "xH");
  CHECK(info.base_names[1] == "zH");
  CHECK(info.A[0] == std::vector<double>{-1, 1, 0, 0, 0, 0, 0});
  CHECK(info.b[0] == 0.5);
  CHECK(info.joint_names[1] == "left_knee");
  CHECK(info.torque_limits[0] == 140.0);
  CHECK(info.rate_limits[0] == 9.0);
  CHECK(info.link_names[1] == "left_shin");
  CHECK(info.parents == std::vector<std::int32_t>{1, 2, 6, 6, 3, 4, -1});
  CHECK(info.joint_kinds[0] == model_info_t::REVOLUTE);
  CHECK(info.joint_kinds[6] == model_info_t::FLOATING);
  CHECK(info.joint_positions[1] == std::vector<double>{0.0, -0.4});
  CHECK(info.link_coordinates == std::vector<std::int32_t>{0, 1, 2, 3, 4, 5, 6});
  CHECK(info.num_segments == 11);
  CHECK(info.segment_links[3] == 1);
  CHECK(info.segment_from[3] == std::vector<double>{0.0, 0.0});
  CHECK(info.segment_to[3] == std::vector<double>{0.0, -0.39});
  CHECK(info.segment_widths[3] == 0.05);
  CHECK(info.foot_sides[1] == model_info_t::RIGHT);
  CHECK(info.foot_links == std::vector<std::int32_t>{0, 5});
  CHECK(info.foot_ankles[0] == std::vector<double>{0.0, 0.0});
  CHECK(info.foot_heels[0] == std::vector<double>{-0.07, -0.065});
  CHECK(info.foot_toes[0] == std::vector<double>{0.15, -0.065});
  CHECK(info.foot_friction[0] == 0.6);
}

TEST_CASE("messages on the fast path stay within one Ethernet frame for the largest robot", "[codec]")
{
  desired_state_t desired{};
  desired.num_coordinates = kMaxCoordinates;
  desired.q.resize(kMaxCoordinates);
  desired.v = desired.a = desired.q;
  CHECK(desired.getEncodedSize() < 1400);
  torque_command_t command{};
  command.num_coordinates = kMaxCoordinates;
  command.a.resize(kMaxCoordinates);
  command.num_joints = kMaxJoints;
  command.torque.resize(kMaxJoints);
  CHECK(command.getEncodedSize() < 1400);
  rejection_t rejection{};
  rejection.detail.resize(Refusal(Reason::stale, "{}", std::string(1000, 'x')).detail().size());
  CHECK(rejection.getEncodedSize() < 1400);
}

TEST_CASE("a text ends with its only zero, whatever else its bytes are", "[codec]")
{
  rejection_t rejection{};
  rejection.detail = "ab";
  std::vector<std::byte> bytes;
  encode(rejection, bytes);
  const std::size_t last = bytes.size() - 1;
  rejection_t heard;
  CHECK(decode(bytes, heard));
  bytes[last - 1] = std::byte{0xff};
  CHECK(decode(bytes, heard));
  bytes[last - 1] = std::byte{0};
  CHECK_FALSE(decode(bytes, heard));
  bytes[last - 1] = bytes[last] = std::byte{'c'};
  CHECK_FALSE(decode(bytes, heard));
}

} // namespace codec_test
