/// What a whole motion's contacts say about each of its samples.
#pragma once

#include "stance/desired_state.h"

#include <array>
#include <cstdint>
#include <vector>

namespace torqued
{

/// The contacts of one sample; indexed by Side.
using Contacts = std::array<Contact, 2>;

/// Whether both feet have contact, and keep it unchanged, throughout a motion.
bool stands_throughout(const std::vector<Contacts>& contacts);

/// Leading foot, load transfer and phase, as they follow from the contacts of a whole motion.
///
/// The motion falls into runs of one contact pair, and into double supports: the longest stretches in which both feet
/// have contact, whatever the pairs. A stretch begins at its first sample and ends at the first sample after it, or at
/// the motion's last sample if there is none.
///
/// - phase: the share of the present run's time that has passed.
/// - load_transfer: the share of the present double support's time that has passed; 0 outside double support.
///   Both are 0.5 in a motion that stands_throughout(): nothing is handed over, so each foot has its half.
/// - leading: in double support the foot that landed last. Where the contacts do not say which (the motion begins with
///   both feet on the ground, or both landed at once): the foot that stays when the other one lifts, because the
///   trailing foot lifts first; the left one if neither lifts, or both at once. Outside double support, where it means
///   nothing: the loaded foot; in flight that of the sample before, left at the beginning.
///
/// utime: µs, strictly increasing, as many as contacts.
std::vector<Support> follow_contacts(const std::vector<std::int64_t>& utime, const std::vector<Contacts>& contacts);

} // namespace torqued
