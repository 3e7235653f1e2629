/// Answers to requests for the equation of motion, decoded as a client would: checked as messages.h checks the others.
#pragma once

#include "wire/cursor.h"

#include <torqued/dynamics_t.hpp>

namespace torqued
{

inline bool decode(Bytes bytes, dynamics_t& message)
{
  Cursor cursor = after_fingerprint<dynamics_t>(bytes);
  cursor.skip(2 * 8);
  cursor.skip_text();
  const std::size_t n = cursor.count();
  const std::size_t joints = cursor.count();
  const std::size_t rows = cursor.count();
  const std::size_t parameters = cursor.count();
  const std::size_t reduced = cursor.count();
  const std::size_t multipliers = cursor.count();
  cursor.skip(8 * (n * (2 * n + 3 + joints) + rows * (n + 1) + parameters * (n + 1)));
  cursor.skip(8 * (reduced * (2 * n + 2 * reduced + 1 + joints) + n * multipliers));
  return decode_checked(bytes, cursor, message);
}

} // namespace torqued
