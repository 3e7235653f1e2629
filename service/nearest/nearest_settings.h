/// What can be set about the nearest motion; nearest_motion.h has what is done with it.
#pragma once

namespace torqued
{

/// How far two accelerations are from each other: ½ (a − a_d)ᵀ W (a − a_d).
enum class NearestMetric
{
  mass,  ///< W = M, rotors in it: Gauss's principle of least constraint; the same in all coordinates
  angles ///< W = 1 over the absolute angles of the links; base point and slides ÷ leg length
};

/// What the nearest motion does with the points that carry.
enum class NearestContacts
{
  rest,      ///< J a + J̇ v = −c J v
  as_desired ///< J a = J a_d: soft feet that roll, as measured; only the conditions on forces move the acceleration
};

struct NearestSettings
{
  NearestMetric metric = NearestMetric::mass;
  NearestContacts contacts = NearestContacts::rest;
  double contact_damping = 0.0; ///< c, 1/s, not negative
  double margin = 0.0;          ///< m, not negative: taken off both ends of every sole
};

} // namespace torqued
