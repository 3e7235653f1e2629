#include "wire/dynamics_codec.h"

#include "wire/fields.h"

namespace torqued
{

namespace
{

// dynamics_request_t up to and including num_coordinates: fingerprint, int64, 5 int8, 2 + 2 double, int32
constexpr std::size_t kFixedRequestSize = 8 + 8 + 5 + 4 * 8 + 4;

} // namespace

std::int64_t read_request_id(Bytes message)
{
  Cursor cursor = after_fingerprint<dynamics_request_t>(message);
  const std::int64_t request_id = cursor.int64();
  return cursor.ok() ? request_id : 0;
}

std::size_t dynamics_request_size(const Robot& robot)
{
  return kFixedRequestSize + 3 * 8 * static_cast<std::size_t>(robot.num_coordinates());
}

Result<DynamicsRequest> decode_dynamics_request(Bytes message, const Robot& robot)
{
  const std::size_t expected_size = dynamics_request_size(robot);
  Cursor cursor = after_fingerprint<dynamics_request_t>(message);
  if (!cursor.ok())
    return Refusal(Reason::undecodable, "the fingerprint is not that of torqued.dynamics_request_t, {:#018x}",
                   static_cast<std::uint64_t>(dynamics_request_t::getHash()));
  if (message.size() < kFixedRequestSize)
    return Refusal(Reason::undecodable, "size is {} bytes; expected {} for {} coordinates", message.size(),
                   expected_size, robot.num_coordinates());

  DynamicsRequest request{};
  request.request_id = cursor.int64();
  const int coordinates = cursor.int8();
  const int left_contact = cursor.int8();
  const int right_contact = cursor.int8();
  const int want_regressor = cursor.int8();
  const int want_reduced = cursor.int8();
  std::array<double, 4> base;
  for (double& number : base)
    number = cursor.real();
  const std::int32_t num_coordinates = cursor.int32();
  if (num_coordinates != robot.num_coordinates())
    return Refusal(Reason::wrong_size, "num_coordinates is {}; expected {} for {}", num_coordinates,
                   robot.num_coordinates(), robot.name);
  if (message.size() != expected_size)
    return Refusal(Reason::undecodable, "size is {} bytes; expected {} for {} coordinates", message.size(),
                   expected_size, robot.num_coordinates());

  constexpr std::string_view base_fields[] = {"base_v", "base_a"};
  for (int i = 0; i < 4; ++i)
    if (auto refusal = check_finite(base_fields[i / 2], i % 2, base[static_cast<std::size_t>(i)]))
      return *refusal;
  DesiredState& state = request.state;
  if (auto refusal = read_motion(cursor, robot, state))
    return *refusal;

  if (auto refusal = check_choice("coordinates", coordinates, 1, kCoordinatesChoices))
    return *refusal;
  if (auto refusal = check_contact_fields(left_contact, right_contact))
    return *refusal;
  if (auto refusal = check_choice("want_regressor", want_regressor, 1, "0 or 1"))
    return *refusal;
  if (auto refusal = check_choice("want_reduced", want_reduced, 1, "0 or 1"))
    return *refusal;
  if (robot.fixed_root() && base != std::array{0.0, 0.0, 0.0, 0.0})
    return Refusal(Reason::out_of_range, "base_v is ({}, {}) and base_a ({}, {}); the root of {} is fixed: all are 0",
                   base[0], base[1], base[2], base[3], robot.name);

  request.coordinates = static_cast<Coordinates>(coordinates);
  request.want_regressor = want_regressor != 0;
  request.want_reduced = want_reduced != 0;
  state.base_given = !robot.fixed_root();
  state.support = {{static_cast<Contact>(left_contact), static_cast<Contact>(right_contact)}, Side::left, 0.0, 0.0};
  if (request.coordinates == Coordinates::relative)
    make_absolute(robot, state);
  state.v.tail<2>() << base[0], base[1];
  state.a.tail<2>() << base[2], base[3];
  return request;
}

} // namespace torqued
