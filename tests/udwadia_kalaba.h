/// Accelerations under constraints without a matrix F and without multipliers.
#pragma once

#include "questions/equation_of_motion.h"

namespace torqued
{

/// a + M^(-1/2) (J M^(-1/2))⁺ (b − J a), with a = M⁻¹(B τ − C v − g) and b = −J̇ v [Udwadia and Kalaba].
VectorQ udwadia_kalaba(const EquationOfMotion& equation, const VectorJ& torque);

} // namespace torqued
