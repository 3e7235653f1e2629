// What may come over the bus. The first four bytes choose robot, settings, kind of message, and whether fingerprint,
// size and count are put right: without that, few inputs would get beyond these checks.

#include "../decode_dynamics.h"
#include "require.h"

#include "answer/answer.h"
#include "answer/answer_dynamics.h"
#include "answer/command.h"
#include "robot/files/load.h"
#include "robot/files/robot_files.h"
#include "wire/finite.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

using namespace torqued;

namespace
{

struct Daemon
{
  Robot robot;
  std::vector<BaseParameter> parameters;
  dynamics_t reply;
};

std::vector<Daemon> daemons()
{
  flush_denormals();
  std::vector<Daemon> all;
  for (const char* name : {"ck", "rk", "six-link", "compass", "human-subject01"})
  {
    const Robot robot = load_robot(name);
    all.push_back({robot, base_parameters(robot), {}});
    reserve(all.back().reply, robot, all.back().parameters);
  }
  return all;
}

AnswerSettings settings(std::uint8_t choice)
{
  AnswerSettings settings;
  settings.limits = static_cast<OnExcess>(choice % 3);
  settings.rate_limits = static_cast<OnExcess>(choice / 3 % 3);
  settings.project = (choice & 16) != 0;
  settings.consistency = (choice & 32) != 0 ? OnExcess::refuse : OnExcess::flag;
  constexpr std::array infeasible{OnInfeasible::relax, OnInfeasible::refuse, OnInfeasible::nearest,
                                  OnInfeasible::nearest};
  settings.methods.infeasible = infeasible[choice >> 6];
  if (choice >> 6 == 3)
    settings.nearest = {.metric = NearestMetric::angles, .contact_damping = 40.0, .margin = 0.005};
  return settings;
}

void put(std::vector<std::byte>& message, std::size_t at, std::uint64_t number, std::size_t width)
{
  for (std::size_t i = 0; i < width && at + i < message.size(); ++i)
    message[at + i] = static_cast<std::byte>(number >> (8 * (width - 1 - i)));
}

template <typename Message>
void put_right(std::vector<std::byte>& message, const Robot& robot, std::size_t size, std::size_t count_at)
{
  message.resize(size);
  put(message, 0, static_cast<std::uint64_t>(Message::getHash()), 8);
  put(message, count_at, static_cast<std::uint64_t>(robot.num_coordinates()), 4);
}

bool all_finite(const torque_command_t& command)
{
  bool finite = is_finite(command.zmp) && is_finite(command.dynamics_residual) && is_finite(command.contact_speed) &&
                is_finite(command.contact_residual);
  for (const ground_reaction_t* foot : {&command.left, &command.right})
    finite = finite && is_finite(foot->fx) && is_finite(foot->fz) && is_finite(foot->moment) && is_finite(foot->cop) &&
             is_finite(foot->friction_ratio);
  return finite && std::all_of(command.torque.begin(), command.torque.end(), is_finite);
}

void hear_desired(const Robot& robot, const AnswerSettings& settings, Bytes message)
{
  const Result<DesiredState> decoded = decode_desired_state(message, robot);
  if (!std::holds_alternative<DesiredState>(decoded))
    return;
  const DesiredState& desired = std::get<DesiredState>(decoded);
  std::array<torque_command_t, 2> commands{};
  std::array<bool, 2> answered{};
  for (std::size_t twice = 0; twice < 2; ++twice)
  {
    StreamMemory memory;
    const Result<Answer> result = answer(robot, settings, desired, memory);
    answered[twice] = std::holds_alternative<Answer>(result);
    if (answered[twice])
      fill(commands[twice], std::get<Answer>(result), robot.model_id, 1);
  }
  require(answered[0] == answered[1], "the same sample is answered twice, or refused twice");
  if (!answered[0])
    return;
  const torque_command_t& command = commands[0];
  require(all_finite(command), "every number of a command is finite");
  require(command.utime == desired.utime && command.stream_id == desired.stream_id, "a command is that of its sample");
  const bool within = settings.limits == OnExcess::clamp || settings.methods.infeasible == OnInfeasible::nearest;
  for (std::size_t j = 0; within && j < command.torque.size(); ++j)
    require(std::abs(command.torque[j]) <=
                robot.actuators[j].torque_limit * (settings.limits == OnExcess::clamp ? 1.0 : 1.0 + 1e-8),
            "torques that are clamped, or the nearest motion's, keep their limits");
  std::array<std::vector<std::byte>, 2> bytes;
  for (std::size_t i = 0; i < 2; ++i)
    encode(commands[i], bytes[i]);
  require(bytes[0] == bytes[1], "the same sample gives the same bits");
}

void hear_request(Daemon& daemon, Bytes message)
{
  answer_dynamics(daemon.robot, daemon.parameters, message, daemon.reply);
  std::vector<std::byte> bytes;
  dynamics_t heard;
  require(decode(encode(daemon.reply, bytes), heard), "a reply can be decoded");
  for (const auto* matrix : {&heard.M, &heard.C, &heard.J, &heard.Y, &heard.F, &heard.Fdot, &heard.F_bar})
    for (const std::vector<double>& row : *matrix)
      require(std::all_of(row.begin(), row.end(), is_finite), "every number of a reply is finite");
}

// what a client does with bytes that need not come from the daemon
template <typename Message> void hear_as_client(Bytes message)
{
  Message heard;
  if (!decode(message, heard))
    return;
  std::vector<std::byte> again;
  const Bytes encoded = encode(heard, again);
  require(std::equal(encoded.begin(), encoded.end(), message.begin(), message.end()),
          "a decoded message is encoded to the same bytes");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  static std::vector<Daemon> all = daemons();
  if (size < 4)
    return 0;
  Daemon& daemon = all[data[0] % all.size()];
  const int kind = data[2] % 8;
  const bool right = data[3] % 2 == 0;
  std::vector<std::byte> message(size - 4);
  std::transform(data + 4, data + size, message.begin(), [](std::uint8_t byte) { return std::byte{byte}; });

  if (kind <= 1)
  {
    constexpr std::size_t count_at = 8 + 3 * 8 + 6 + 8 * 8;
    const auto angles = static_cast<std::size_t>(daemon.robot.num_coordinates());
    if (right)
    {
      put_right<desired_state_t>(message, daemon.robot, count_at + 4 + 3 * 8 * angles, count_at);
      put(message, 24, 0, 8); // model_id: not checked
    }
    hear_desired(daemon.robot, settings(data[1]), message);
  }
  else if (kind == 2)
  {
    const std::size_t request_size = dynamics_request_size(daemon.robot);
    constexpr std::size_t count_at = 8 + 8 + 5 + 4 * 8;
    if (right)
      put_right<dynamics_request_t>(message, daemon.robot, request_size, count_at);
    hear_request(daemon, message);
  }
  else
  {
    const std::array<std::int64_t, 5> fingerprints{torque_command_t::getHash(), rejection_t::getHash(),
                                                   status_t::getHash(), model_info_t::getHash(), dynamics_t::getHash()};
    if (right)
      put(message, 0, static_cast<std::uint64_t>(fingerprints[static_cast<std::size_t>(kind - 3)]), 8);
    hear_as_client<desired_state_t>(message);
    hear_as_client<torque_command_t>(message);
    hear_as_client<rejection_t>(message);
    hear_as_client<status_t>(message);
    hear_as_client<model_info_t>(message);
    hear_as_client<dynamics_t>(message);
    read_status_instance(message);
  }
  return 0;
}
