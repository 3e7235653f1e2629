/// The daemon's second line: from a question for the equation of motion to its answer.
#pragma once

#include "questions/elimination.h"
#include "questions/regressor.h"
#include "wire/dynamics_codec.h"

namespace torqued
{

/// Answers a request; whatever its bytes, there is an answer, if need be with a sentence in `error`.
///
/// parameters: base_parameters(robot). Does not allocate if `reply` is one that reserve() made.
void answer_dynamics(const Robot& robot, const std::vector<BaseParameter>& parameters, Bytes request,
                     dynamics_t& reply);

/// Gives a reply the size of the largest there can be for this robot, so that answering does not allocate.
void reserve(dynamics_t& reply, const Robot& robot, const std::vector<BaseParameter>& parameters);

/// Refuses a request; error: one line, what was wrong and what would be right.
void refuse_request(dynamics_t& reply, const Robot& robot, std::int64_t request_id, std::string_view error);

/// Describes a motion: all but request_id, error empty. parameters: empty if Y is not wanted. elimination: by it the
/// reduced form, if that is wanted.
void describe_motion(dynamics_t& reply, const Robot& robot, const std::vector<BaseParameter>& parameters,
                     const Motion& motion, const Support& support, Coordinates coordinates,
                     std::optional<EliminationMethod> elimination);

} // namespace torqued
