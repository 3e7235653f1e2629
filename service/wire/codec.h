/// Between messages and what they mean to a robot: desired states, checked before they are believed, and answers.
#pragma once

#include "stance/checks.h"
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

/// What is published for a desired state that was answered.
struct Answer
{
  Answer() {} // or a variant would set all of its bytes to zero first, and `torque` needs no zeros

  std::int64_t utime = 0, stream_id = 0;
  Method method = Method::none;
  std::int32_t flags = 0;
  std::array<GroundReaction, 2> ground;             ///< indexed by Side
  double zmp = 0.0;                                 ///< m
  double dynamics_residual = 0.0;                   ///< N, N m
  double contact_speed = 0.0;                       ///< m/s, rad/s
  double contact_residual = 0.0;                    ///< m/s², rad/s²
  Eigen::Vector2d base_a = Eigen::Vector2d::Zero(); ///< of the base point, m/s²; 0 for a fixed root
  double adjustment = 0.0;                          ///< largest |a − a desired| among the coordinates, rad/s²
  VectorQ a;      ///< without the base point, in the coordinates that were sent, rad/s²
  VectorJ torque; ///< N m
};

/// Fills a command; all but sequence and compute_ns, which belong to the loop. Allocates only if command.a or
/// command.torque grows.
void fill(torque_command_t& command, const Answer& answer, std::int64_t model_id, std::int64_t settings_id);

/// Fills a rejection. Allocates only if rejection.detail grows.
void fill(rejection_t& rejection, const Sender& sender, const Refusal& refusal);

/// Describes a robot; instance_id and settings are the daemon's.
model_info_t model_info(const Robot& robot, std::int64_t instance_id, std::int64_t settings_id,
                        const std::string& settings);

} // namespace torqued
