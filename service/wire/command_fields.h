/// The fields of an answer, each once, in the order of tables: what copies, checks or writes answers goes through them.
#pragma once

#include <torqued/torque_command_t.hpp>

namespace torqued
{

/// The reaction under a foot: of a message, or of an Answer.
template <typename Command> auto& left_of(Command& command)
{
  if constexpr (requires { command.left; })
    return command.left;
  else
    return command.ground[0];
}
template <typename Command> auto& right_of(Command& command)
{
  if constexpr (requires { command.right; })
    return command.right;
  else
    return command.ground[1];
}

/// see(name, number) for each number of the reaction under a foot.
template <typename See> void for_each_number(See&& see, const ground_reaction_t& foot)
{
  see("fx", foot.fx);
  see("fz", foot.fz);
  see("moment", foot.moment);
  see("cop", foot.cop);
  see("friction_ratio", foot.friction_ratio);
}

/// see(name, field...) for each field, with those of all commands at once: torque_command_t, or what has fields of the
/// same names.
template <typename See, typename... Commands> void for_each_field(See&& see, Commands&... command)
{
  see("torque", command.torque...);
  see("left", left_of(command)...);
  see("right", right_of(command)...);
  see("zmp", command.zmp...);
  see("flags", command.flags...);
  see("dynamics_residual", command.dynamics_residual...);
  see("contact_speed", command.contact_speed...);
  see("contact_residual", command.contact_residual...);
  see("a", command.a...);
  see("base_a", command.base_a...);
  see("adjustment", command.adjustment...);
  see("method", command.method...);
}

} // namespace torqued
