/// What the robot should do at one instant, and on which feet it stands.
#pragma once

#include "robot/robot.h"

#include <array>
#include <cstdint>
#include <string_view>

namespace torqued
{

/// Which part of a foot carries; numbered as in desired_state_t, in the order in which a foot rolls.
enum class Contact : std::int8_t
{
  none = 0,
  heel = 1,
  sole = 2,
  toe = 3
};

/// "none", "heel", "sole", "toe".
std::string_view name_of(Contact contact);

/// Components of a contact's wrench: (fx, fz) at a heel or toe, (fx, fz, moment about the ankle) at a sole.
inline int wrench_components(Contact contact)
{
  return contact == Contact::none ? 0 : contact == Contact::sole ? 3 : 2;
}

/// A rule that chooses the ground reactions of double support; numbered as in desired_state_t.
enum class Method : std::int8_t
{
  none = 0, ///< in an answer: nothing had to be chosen; in a desired state: the daemon's setting
  pseudo_inverse = 1,
  linear_transition = 2,
  internal_wrench = 3,
  torso_wrench = 4,
  tracked_reaction = 5,
  tracked_internal = 6,
  constrained = 7,
  zmp_transition = 8,
  human_transition = 9
};

/// The two contacts, and how far the load has moved from the trailing to the leading foot.
struct Support
{
  PerSide<Contact> contact;
  Side leading;
  double load_transfer; ///< 0..1 over the whole double support: 0 = on the trailing foot, 1 = on the leading one
  double phase;         ///< 0..1 within the present pair of a sole and a point

  Contact of(Side side) const { return contact[side]; }
  Side trailing() const { return other(leading); }
  /// How far the present handing over of the load has come, 0..1: load_transfer on two soles, else phase.
  double progress() const { return contact[0] == Contact::sole && contact[1] == Contact::sole ? load_transfer : phase; }
  /// Where a foot's components begin.
  int row(Side side) const { return side == Side::left ? 0 : torqued::wrench_components(contact[0]); }
  int wrench_components() const
  {
    return torqued::wrench_components(contact[0]) + torqued::wrench_components(contact[1]);
  }
  /// Components of the ground reactions that the motion leaves free, for contact points that do not coincide:
  /// all but the three that the whole robot's Newton and Euler equations determine.
  int redundancy() const { return wrench_components() > 3 ? wrench_components() - 3 : 0; }
};

/// A desired state, checked and in ABSOLUTE coordinates.
struct DesiredState
{
  std::int64_t utime;     ///< µs, the sender's clock
  std::int64_t stream_id; ///< the sender
  bool base_given;        ///< else the last two of q, v, a are not set: the resting foot places the base
  Method method;          ///< none: the daemon's setting
  Support support;
  VectorQ q, v, a; ///< angles, then the base point's x and z
  /// a as it was sent in RELATIVE coordinates, without the base point; empty if it was sent in ABSOLUTE ones.
  VectorQ relative_a = {};
};

} // namespace torqued
