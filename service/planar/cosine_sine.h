/// Cosines and sines of many angles at once.
#pragma once

#include "planar/mechanism.h"

namespace torqued
{

/// (cos φ, sin φ) of every angle, rad, as columns; off by no more than 2⁻⁵² in each. Requires: whole blocks of angles.
///
/// φ = n π/2 + r with |r| ≤ π/4; polynomials in r, exact to rounding, change places and signs with n.
/// No step branches, so that a compiler does several angles at a time: less than half of what libm takes, which is
/// called only where angles add up to more than 10⁵ rad.
PlaneVectors cosines_and_sines(const VectorD& phi);

} // namespace torqued
