/// Requests for the equation of motion, and their answers, checked like all other messages (codec.h).
#pragma once

#include "questions/equation_of_motion.h"
#include "wire/codec.h"

#include <torqued/dynamics_request_t.hpp>

namespace torqued
{

/// A request, checked.
struct DynamicsRequest
{
  std::int64_t request_id;
  Coordinates coordinates;
  bool want_regressor, want_reduced;
  DesiredState state; ///< in ABSOLUTE coordinates, base given unless the root is fixed
};

/// The request's id, as far as it can be read: 0 where it cannot.
std::int64_t read_request_id(Bytes message);

/// The size in bytes of every request for this robot.
std::size_t dynamics_request_size(const Robot& robot);

/// Checks and decodes a request for this robot, in the order of decode_desired_state(). Does not throw, whatever the
/// bytes. Refuses: undecodable, wrong_size, not_finite, out_of_range.
Result<DynamicsRequest> decode_dynamics_request(Bytes message, const Robot& robot);

} // namespace torqued
