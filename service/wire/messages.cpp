#include "wire/messages.h"

#include "wire/cursor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <utility>

namespace torqued
{

namespace
{

constexpr std::size_t kCount = 4, kEmptyText = 5; // bytes

// bytes of a message without entries in its arrays and texts, after the fingerprint
template <typename Message> std::size_t empty_size()
{
  static const int size = Message{}.getEncodedSize() - 8;
  return static_cast<std::size_t>(size);
}

Cursor walk_desired_state(Bytes bytes)
{
  Cursor cursor = after_fingerprint<desired_state_t>(bytes);
  cursor.skip(empty_size<desired_state_t>() - kCount);
  cursor.skip(3 * 8 * cursor.count());
  return cursor;
}

// what is wrong with the names of coordinates or joints
std::string flaw_of(const std::string& what, const std::vector<std::string>& names)
{
  const std::set<std::string> distinct(names.begin(), names.end());
  if (distinct.count("") > 0)
    return "one of " + what + " is empty";
  return distinct.size() < names.size() ? "two of " + what + " are the same" : "";
}

template <typename Numbers, typename IsGood>
std::string flaw_of(const std::string& what, const Numbers& numbers, const IsGood& is_good)
{
  const auto found = std::ranges::find_if_not(numbers, is_good);
  return found == numbers.end() ? "" : what + " is " + std::to_string(*found);
}

} // namespace

std::string flaw_of(const model_info_t& model)
{
  const auto is_finite = [](double number)
  {
    return std::isfinite(number);
  };
  const auto is_limit = [](double limit)
  {
    return limit >= 0.0; // or infinite
  };
  if (model.name.empty())
    return "it has no name";
  if (model.num_joints < 1 || model.num_joints > model.num_coordinates)
    return "it has " + std::to_string(model.num_joints) + " joints and " + std::to_string(model.num_coordinates) +
           " coordinates";
  std::string flaw;
  const auto look = [&flaw](std::string found)
  {
    if (flaw.empty())
      flaw = std::move(found);
  };
  look(flaw_of("absolute_names", model.absolute_names));
  look(flaw_of("relative_names", model.relative_names));
  look(flaw_of("joint_names", model.joint_names));
  look(flaw_of("gravity", std::array{model.gravity}, is_finite));
  look(flaw_of("total_mass", std::array{model.total_mass},
               [](double mass) { return mass > 0.0 && std::isfinite(mass); }));
  for (const std::vector<double>& row : model.A)
    look(flaw_of("a number of A", row, is_finite));
  look(flaw_of("a number of b", model.b, is_finite));
  look(flaw_of("a torque limit", model.torque_limits, is_limit));
  look(flaw_of("a rate limit", model.rate_limits, is_limit));
  return flaw;
}

std::int64_t random_id()
{
  std::random_device device;
  return std::uniform_int_distribution<std::int64_t>(1)(device);
}

bool is_desired_state(Bytes bytes)
{
  return walk_desired_state(bytes).at_end();
}

bool decode(Bytes bytes, desired_state_t& message)
{
  return decode_checked(bytes, walk_desired_state(bytes), message);
}

bool decode(Bytes bytes, torque_command_t& message)
{
  Cursor cursor = after_fingerprint<torque_command_t>(bytes);
  cursor.skip(empty_size<torque_command_t>() - 2 * kCount);
  const std::size_t coordinates = cursor.count();
  cursor.skip(8 * (coordinates + cursor.count()));
  return decode_checked(bytes, cursor, message);
}

bool decode(Bytes bytes, rejection_t& message)
{
  Cursor cursor = after_fingerprint<rejection_t>(bytes);
  cursor.skip(empty_size<rejection_t>() - kEmptyText);
  cursor.skip_text();
  return decode_checked(bytes, cursor, message);
}

bool decode(Bytes bytes, status_t& message)
{
  Cursor cursor = after_fingerprint<status_t>(bytes);
  cursor.skip(empty_size<status_t>() - kEmptyText);
  cursor.skip_text();
  return decode_checked(bytes, cursor, message);
}

bool decode(Bytes bytes, model_info_t& message)
{
  Cursor cursor = after_fingerprint<model_info_t>(bytes);
  cursor.skip(3 * 8);
  cursor.skip_text();
  cursor.skip(2 * 8);
  const std::size_t coordinates = cursor.count();
  cursor.skip_texts(2 * coordinates + 2);
  cursor.skip(8 * coordinates * (coordinates + 1));
  const std::size_t joints = cursor.count();
  cursor.skip_texts(joints);
  cursor.skip(2 * 8 * joints);
  const std::size_t links = cursor.count();
  cursor.skip_texts(links);
  cursor.skip((4 + 1 + 5 * 8 + 4) * links);
  cursor.skip((4 + 5 * 8) * cursor.count());
  cursor.skip((1 + 4 + 7 * 8) * cursor.count());
  cursor.skip_text();
  return decode_checked(bytes, cursor, message);
}

} // namespace torqued
