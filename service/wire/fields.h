/// What checks of the fields of messages have in common.
#pragma once

#include "stance/desired_state.h"
#include "stance/refusal.h"
#include "wire/cursor.h"
#include "wire/finite.h"

#include <optional>

namespace torqued
{

/// A field that numbers its choices from 0
inline std::optional<Refusal> check_choice(std::string_view field, int value, int last, std::string_view choices)
{
  if (value < 0 || value > last)
    return Refusal(Reason::out_of_range, "{} is {}; expected {}", field, value, choices);
  return {};
}

inline constexpr std::string_view kCoordinatesChoices = "ABSOLUTE (0) or RELATIVE (1)";

inline std::optional<Refusal> check_contact_fields(int left_contact, int right_contact)
{
  constexpr std::string_view contacts = "NONE (0), HEEL (1), SOLE (2) or TOE (3)";
  if (auto refusal = check_choice("left_contact", left_contact, 3, contacts))
    return refusal;
  return check_choice("right_contact", right_contact, 3, contacts);
}

/// index: of a member of the field; −1 if it is one number.
inline std::optional<Refusal> check_finite(std::string_view field, int index, double value)
{
  if (is_finite(value))
    return {};
  if (index < 0)
    return Refusal(Reason::not_finite, "{} is {}; expected a finite number", field, value);
  return Refusal(Reason::not_finite, "{}[{}] is {}; expected a finite number", field, index, value);
}

/// Reads q, v and a, as long as the robot's coordinates, into the head of those of `desired`; the rest of them is 0.
/// Refuses: not_finite.
inline std::optional<Refusal> read_motion(Cursor& cursor, const Robot& robot, DesiredState& desired)
{
  constexpr std::string_view fields[] = {"q", "v", "a"};
  VectorQ* const motion[] = {&desired.q, &desired.v, &desired.a};
  for (int k = 0; k < 3; ++k)
  {
    motion[k]->setZero(robot.mechanism.num_q());
    for (int i = 0; i < robot.num_coordinates(); ++i)
    {
      (*motion[k])(i) = cursor.real();
      if (auto refusal = check_finite(fields[k], i, (*motion[k])(i)))
        return refusal;
    }
  }
  return {};
}

/// q_absolute = A⁻¹ (q_relative − b), and its derivatives.
inline void make_absolute(const Robot& robot, DesiredState& desired)
{
  const int n = robot.num_coordinates();
  desired.q.head(n) -= robot.b.head(n);
  for (VectorQ* vector : {&desired.q, &desired.v, &desired.a})
    vector->head(n) = (robot.A_inverse.topLeftCorner(n, n) * vector->head(n)).eval();
}

} // namespace torqued
