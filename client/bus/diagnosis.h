/// What is wrong with this machine's LCM set-up, and what mends it: from facts to findings.
#pragma once

#include "bus/daemons.h"
#include "wire/bus_url.h"

#include <optional>
#include <string>
#include <vector>

namespace torqued
{

/// A network interface.
struct Interface
{
  std::string name;
  bool up, multicast, loopback; ///< its flags
};

/// A chain of the firewall, at a hook through which our messages pass, that drops some packets.
struct DroppingChain
{
  std::string family, table, chain; ///< as nft names them
};

/// What was found out about a bus on this machine.
struct BusFacts
{
  ChosenBus bus;
  bool has_ip = false; ///< whether the program ip is here, which knows interfaces and route
  std::vector<Interface> interfaces;
  std::string route;          ///< name of the interface to which the bus's address leads; empty: none does
  std::string socket_trouble; ///< why no socket could be opened, bound or joined to the address, or the bus's server
                              ///< did not answer; empty: it could
  std::string send_trouble;   ///< why no message could be sent; empty: it could
  bool came_back = false;     ///< whether that message came back, or the server answered
  bool is_root = false;
  std::optional<std::vector<DroppingChain>> firewall; ///< nothing: nft is not here, or shows this user nothing
  bool keeps_others_out = false; ///< of the firewall: whether it drops what other machines send to the bus's port
  int buffer_size = 0;           ///< bytes that the system grants a socket of LCM's, as SO_RCVBUF counts them
  int buffer_messages = 0;       ///< how many desired states or commands that holds; 0: they did not reach it
  std::string lcm_trouble;       ///< why LCM could not be listened to although that message came back; empty: it could
  std::vector<Daemon> daemons;
  std::string lcm_version;
};

/// One sentence about the bus, and how good or bad that is.
struct Finding
{
  enum class Grade
  {
    good,
    remark, ///< it works, but perhaps not as meant, or not for long
    bad
  };
  Grade grade;
  std::string text; ///< a sentence
  std::string mend; ///< a command that mends it; empty if there is nothing to mend
};

/// What the facts mean, in the order in which a message passes: bus, interface, message, firewall, buffer, daemons.
std::vector<Finding> diagnose(const BusFacts& facts);

} // namespace torqued
