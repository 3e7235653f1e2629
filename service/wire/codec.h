/// Between messages and what they mean to a robot: desired states, checked before they are believed, and answers.
#pragma once

#include "stance/desired_state.h"
#include "stance/refusal.h"
#include "wire/messages.h"

namespace torqued
{

/// Who sent a desired state and when, as far as it can be read: 0 where it cannot.
struct Sender
{
  std::int64_t utime = 0, stream_id = 0;
};
Sender read_sender(Bytes message);

/// Whose status this is: its instance_id; 0 if it is no status. Does not allocate.
std::int64_t read_status_instance(Bytes message);

/// Checks and decodes a desired state for this robot.
///
/// Checked in this order: fingerprint, count, exact size, model, every number finite, every field in its range, method.
/// RELATIVE coordinates become ABSOLUTE. Does not allocate and does not throw, whatever the bytes.
/// Refuses: undecodable, wrong_size, wrong_model, not_finite, out_of_range, unknown_method.
Result<DesiredState> decode_desired_state(Bytes message, const Robot& robot);

/// Fills a rejection. Allocates only if rejection.detail grows.
void fill(rejection_t& rejection, const Sender& sender, const Refusal& refusal);

/// Describes a robot; instance_id and settings are the daemon's.
model_info_t model_info(const Robot& robot, std::int64_t instance_id, std::int64_t settings_id,
                        const std::string& settings);

} // namespace torqued
