/// The settings that change answers.
#pragma once

#include "methods/method_settings.h"
#include "nearest/nearest_settings.h"

#include <cstdint>

namespace torqued
{

/// What happens when a limit or a tolerance is passed.
enum class OnExcess
{
  flag,   ///< the answer says so
  refuse, ///< the desired state is refused
  clamp   ///< limits only: the torque is cut to the limit, and the answer says so
};

/// The settings that change answers.
struct AnswerSettings
{
  MethodSettings methods;
  NearestSettings nearest;                ///< if methods.infeasible says so
  OnExcess consistency = OnExcess::flag;  ///< flag or refuse
  double contact_speed_tolerance = 0.01;  ///< m/s, rad/s
  double contact_tolerance = 0.1;         ///< m/s², rad/s²; beyond it the flag is contact_acceleration
  double sole_tilt_tolerance = 0.02;      ///< rad
  double contact_height_tolerance = 0.03; ///< m above or below the ground z = 0; no torque depends on that height
  double residual_tolerance = 1e-3;       ///< share of the weight, or of weight × leg length; see solve_torques
  bool project = false;                   ///< answer the nearest motion that keeps its contacts, projection.h
  OnExcess limits = OnExcess::flag;       ///< torque limits
  OnExcess rate_limits = OnExcess::flag;  ///< torque-rate limits
};

/// All of them, one after another.
void list(AnswerSettings& settings, SettingList& with);

/// FNV-1a of the settings; never 0.
std::int64_t settings_id(AnswerSettings settings);

/// What is wrong with the settings for a robot: one line, or nothing. Weights need a row and a column for each motor;
/// with the nearest motion a margin leaves something of every sole, and f_min of both feet is less than the weight.
std::optional<std::string> complaint(AnswerSettings settings, const Robot& robot);

} // namespace torqued
