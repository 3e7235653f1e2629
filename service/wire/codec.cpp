#include "wire/codec.h"

#include "methods/method_settings.h"
#include "wire/fields.h"

#include <array>
#include <optional>

namespace torqued
{

namespace
{

// desired_state_t up to and including num_coordinates: fingerprint, 3 int64, 6 int8, 2 + 6 double, 1 int32
constexpr std::size_t kFixedStateSize = 8 + 3 * 8 + 6 + 8 * 8 + 4;

std::optional<Refusal> check_share(std::string_view field, double value)
{
  if (value < 0.0 || value > 1.0)
    return Refusal(Reason::out_of_range, "{} is {:.17g}; expected 0 to 1", field, value);
  return {};
}

std::optional<Refusal> check_ranges(int coordinates, int base, int left_contact, int right_contact, int leading_foot,
                                    const Support& support)
{
  if (auto refusal = check_choice("coordinates", coordinates, 1, kCoordinatesChoices))
    return refusal;
  if (auto refusal = check_choice("base", base, 1, "FROM_CONTACT (0) or GIVEN (1)"))
    return refusal;
  if (auto refusal = check_contact_fields(left_contact, right_contact))
    return refusal;
  if (auto refusal = check_choice("leading_foot", leading_foot, 1, "LEFT (0) or RIGHT (1)"))
    return refusal;
  if (auto refusal = check_share("load_transfer", support.load_transfer))
    return refusal;
  if (auto refusal = check_share("phase", support.phase))
    return refusal;
  return {};
}

} // namespace

Sender read_sender(Bytes message)
{
  Cursor cursor(message);
  if (cursor.int64() != desired_state_t::getHash())
    return {};
  const std::int64_t utime = cursor.int64();
  const bool utime_read = cursor.ok();
  const std::int64_t stream_id = cursor.int64();
  return {utime_read ? utime : 0, cursor.ok() ? stream_id : 0};
}

std::int64_t read_status_instance(Bytes message)
{
  Cursor cursor = after_fingerprint<status_t>(message);
  cursor.skip(8); // utime
  const std::int64_t instance_id = cursor.int64();
  return cursor.ok() ? instance_id : 0;
}

Result<DesiredState> decode_desired_state(Bytes message, const Robot& robot)
{
  const int angles = robot.num_coordinates();
  const std::size_t expected_size = kFixedStateSize + 3 * 8 * static_cast<std::size_t>(angles);

  // fingerprint, count, size
  Cursor cursor(message);
  if (const std::int64_t fingerprint = cursor.int64(); !cursor.ok() || fingerprint != desired_state_t::getHash())
    return Refusal(Reason::undecodable, "fingerprint is {:#018x}; expected {:#018x}, that of torqued.desired_state_t",
                   static_cast<std::uint64_t>(fingerprint), static_cast<std::uint64_t>(desired_state_t::getHash()));
  if (message.size() < kFixedStateSize)
    return Refusal(Reason::undecodable, "size is {} bytes; expected {} for {} coordinates", message.size(),
                   expected_size, angles);

  DesiredState desired;
  desired.utime = cursor.int64();
  desired.stream_id = cursor.int64();
  const std::int64_t model_id = cursor.int64();
  const int coordinates = cursor.int8();
  const int base = cursor.int8();
  const int left_contact = cursor.int8();
  const int right_contact = cursor.int8();
  const int leading_foot = cursor.int8();
  const int method = cursor.int8();
  desired.support.load_transfer = cursor.real();
  desired.support.phase = cursor.real();
  std::array<double, 6> base_motion;
  for (double& number : base_motion)
    number = cursor.real();
  const std::int32_t num_coordinates = cursor.int32();
  if (num_coordinates != angles)
    return Refusal(Reason::wrong_size, "num_coordinates is {}; expected {} for {}", num_coordinates, angles,
                   robot.name);
  if (message.size() != expected_size)
    return Refusal(Reason::undecodable, "size is {} bytes; expected {} for {} coordinates", message.size(),
                   expected_size, angles);
  if (model_id != 0 && model_id != robot.model_id)
    return Refusal(Reason::wrong_model, "model_id is {}; expected {}, that of {}, or 0", model_id, robot.model_id,
                   robot.name);

  // every number finite, whether it is used or not
  for (const auto& [field, number] :
       {std::pair("load_transfer", desired.support.load_transfer), std::pair("phase", desired.support.phase)})
    if (auto refusal = check_finite(field, -1, number))
      return *refusal;
  constexpr std::string_view base_fields[] = {"base_q", "base_v", "base_a"};
  for (int i = 0; i < 6; ++i)
    if (auto refusal = check_finite(base_fields[i / 2], i % 2, base_motion[static_cast<std::size_t>(i)]))
      return *refusal;
  if (auto refusal = read_motion(cursor, robot, desired))
    return *refusal;

  if (auto refusal = check_ranges(coordinates, base, left_contact, right_contact, leading_foot, desired.support))
    return *refusal;
  desired.method = static_cast<Method>(method);
  if (method != 0 && name_of(desired.method) == name_of(Method::none))
    return Refusal(Reason::unknown_method, "method is {}; expected {}", method, kMethodNumbers);

  desired.base_given = base == desired_state_t::GIVEN;
  desired.support.contact = {static_cast<Contact>(left_contact), static_cast<Contact>(right_contact)};
  desired.support.leading = static_cast<Side>(leading_foot);
  if (coordinates == desired_state_t::RELATIVE)
  {
    desired.relative_a = desired.a.head(angles);
    make_absolute(robot, desired);
  }
  desired.q.tail<2>() << base_motion[0], base_motion[1];
  desired.v.tail<2>() << base_motion[2], base_motion[3];
  desired.a.tail<2>() << base_motion[4], base_motion[5];
  return desired;
}

void fill(rejection_t& rejection, const Sender& sender, const Refusal& refusal)
{
  rejection.utime = sender.utime;
  rejection.stream_id = sender.stream_id;
  rejection.reason = static_cast<std::int32_t>(refusal.reason());
  rejection.detail = refusal.detail();
}

model_info_t model_info(const Robot& robot, std::int64_t instance_id, std::int64_t settings_id,
                        const std::string& settings)
{
  const auto pair = [](const Eigen::Vector2d& r)
  {
    return std::vector<double>{r.x(), r.y()};
  };
  model_info_t info{};
  info.instance_id = instance_id;
  info.model_id = robot.model_id;
  info.settings_id = settings_id;
  info.name = robot.name;
  info.gravity = robot.mechanism.gravity();
  info.total_mass = robot.mechanism.mass();

  info.num_coordinates = robot.num_coordinates();
  info.absolute_names = robot.absolute_names;
  info.relative_names = robot.relative_names;
  info.base_names[0] = robot.base_names[0];
  info.base_names[1] = robot.base_names[1];
  for (int i = 0; i < info.num_coordinates; ++i)
  {
    const auto row = robot.A.row(i).head(info.num_coordinates);
    info.A.emplace_back(row.begin(), row.end());
    info.b.push_back(robot.b(i));
  }

  info.num_joints = robot.num_joints();
  for (const Actuator& actuator : robot.actuators)
  {
    info.joint_names.push_back(actuator.name);
    info.torque_limits.push_back(actuator.torque_limit);
    info.rate_limits.push_back(actuator.rate_limit);
  }

  info.num_links = static_cast<std::int32_t>(robot.links.size());
  for (const Link& link : robot.links)
  {
    info.link_names.push_back(link.name);
    info.parents.push_back(link.parent);
    info.joint_kinds.push_back(static_cast<std::int8_t>(link.joint));
    info.joint_positions.push_back(pair(link.at));
    info.joint_angles.push_back(link.angle);
    info.parent_radii.push_back(link.parent_radius);
    info.child_radii.push_back(link.child_radius);
    info.link_coordinates.push_back(link.coordinate < robot.num_coordinates() ? link.coordinate : -1);
    for (const Segment& segment : link.drawing)
    {
      info.segment_links.push_back(static_cast<std::int32_t>(&link - robot.links.data()));
      info.segment_from.push_back(pair(segment.from));
      info.segment_to.push_back(pair(segment.to));
      info.segment_widths.push_back(segment.width);
    }
  }
  info.num_segments = static_cast<std::int32_t>(info.segment_links.size());

  for (const Foot& foot : robot.feet)
  {
    if (!foot.exists())
      continue;
    ++info.num_feet;
    info.foot_sides.push_back(static_cast<std::int8_t>(foot.side));
    info.foot_links.push_back(foot.link);
    info.foot_ankles.push_back(pair(foot.ankle_at));
    info.foot_heels.push_back(pair(foot.heel_at));
    info.foot_toes.push_back(pair(foot.toe_at));
    info.foot_friction.push_back(foot.friction);
  }
  info.settings = settings;
  return info;
}

} // namespace torqued
