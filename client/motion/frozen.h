/// Frames that a recording repeats while the motion goes on.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace torqued
{

/// Rows that repeat the row before them, or at the beginning the one after them, in every coordinate.
struct FrozenRows
{
  Eigen::Index first, last; ///< the repetitions; the row beside them is a sample
};

/// Repetitions after which, and before which, the motion moves on: it arrives where it would have arrived without them,
/// or it moves just before and just after them at a quarter of its usual speed or more. A posture that is held, where a
/// motion stops and starts again, is not frozen; nor is a motion of no more than three units of the last digit
/// per frame. At the ends of the motion, repetitions shorter than a hold, 0.1 s, beside which it moves as fast; of
/// those at the beginning the last one is the sample.
///
/// times: s, strictly increasing, in equal steps but for gaps. step: s. motion: one row per time, finite.
std::vector<FrozenRows> find_frozen_rows(const Eigen::VectorXd& times, double step, const Eigen::MatrixXd& motion);

} // namespace torqued
