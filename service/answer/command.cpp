#include "answer/command.h"

#include <algorithm>

namespace torqued
{

namespace
{

// A field of an answer as that of a message, or back.
struct Copy
{
  void operator()(const char*, double from, double& to) const { to = from; }
  void operator()(const char*, std::int32_t from, std::int32_t& to) const { to = from; }
  void operator()(const char*, Method from, std::int8_t& to) const { to = static_cast<std::int8_t>(from); }
  void operator()(const char*, std::int8_t from, Method& to) const { to = static_cast<Method>(from); }
  void operator()(const char*, const Eigen::Vector2d& from, double (&to)[2]) const { std::ranges::copy(from, to); }
  void operator()(const char*, const double (&from)[2], Eigen::Vector2d& to) const { to = {from[0], from[1]}; }
  template <int Most> void operator()(const char*, const BoundedVector<Most>& from, std::vector<double>& to) const
  {
    to.assign(from.begin(), from.end());
  }
  template <int Most> void operator()(const char*, const std::vector<double>& from, BoundedVector<Most>& to) const
  {
    to = Eigen::Map<const Eigen::VectorXd>(from.data(), static_cast<Eigen::Index>(from.size()));
  }
  void operator()(const char*, const GroundReaction& from, ground_reaction_t& to) const
  {
    to.fx = from.wrench.fx;
    to.fz = from.wrench.fz;
    to.moment = from.wrench.moment;
    to.cop = from.cop;
    to.friction_ratio = from.friction_ratio;
  }
  void operator()(const char*, const ground_reaction_t& from, GroundReaction& to) const
  {
    to = {{from.fx, from.fz, from.moment}, from.cop, from.friction_ratio};
  }
};

} // namespace

void fill(torque_command_t& command, const Answer& answer, std::int64_t model_id, std::int64_t settings_id)
{
  command.utime = answer.utime;
  command.stream_id = answer.stream_id;
  command.model_id = model_id;
  command.settings_id = settings_id;
  command.num_coordinates = static_cast<std::int32_t>(answer.a.size());
  command.num_joints = static_cast<std::int32_t>(answer.torque.size());
  for_each_field(Copy(), answer, command);
}

Answer to_answer(const torque_command_t& command)
{
  Answer answer;
  answer.utime = command.utime;
  answer.stream_id = command.stream_id;
  for_each_field(Copy(), command, answer);
  return answer;
}

} // namespace torqued
