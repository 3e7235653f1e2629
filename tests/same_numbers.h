/// Two robots that should be one.
#pragma once

#include "catch.h"
#include "matchers.h"
#include "oracles.h"

#include "planar/dynamics.h"
#include "planar/kinematics.h"
#include "robot/robot.h"

#include <string>

namespace torqued
{

/// Checks that two robots compute the same in any state, coordinates' names included.
inline void check_same_numbers(const Robot& found, const Robot& expected, double tolerance)
{
  CHECK(found.absolute_names == expected.absolute_names);
  CHECK(found.relative_names == expected.relative_names);
  CHECK(found.base_names == expected.base_names);
  CHECK(mismatch(found.A, expected.A, tolerance) == "");
  CHECK(mismatch(found.b, expected.b, tolerance) == "");
  CHECK(mismatch(input_matrix(found), input_matrix(expected), tolerance) == "");
  REQUIRE(found.mechanism.num_q() == expected.mechanism.num_q());
  const Eigen::Index size = expected.mechanism.num_q();
  oracle::Random random(7);
  const auto random_vector = [&](double most)
  {
    VectorQ x(size);
    for (double& number : x)
      number = oracle::uniform(random, -most, most);
    return x;
  };
  constexpr int states = 1000;
  std::string first;
  for (int i = 0; i < states && first.empty(); ++i)
  {
    const VectorQ q = random_vector(3.0);
    const VectorQ v = random_vector(5.0);
    const VectorQ a = random_vector(20.0);
    const Kinematics of_found = kinematics(found.mechanism, q, v);
    const Kinematics of_expected = kinematics(expected.mechanism, q, v);
    first += mismatch(inverse_dynamics(found.mechanism, of_found, a),
                      inverse_dynamics(expected.mechanism, of_expected, a), tolerance);
    for (const Side side : kSides)
    {
      REQUIRE(found.foot(side).exists() == expected.foot(side).exists());
      for (const auto point : {&Foot::ankle, &Foot::heel, &Foot::toe})
        first += mismatch(from_base(of_found, found.foot(side).*point),
                          from_base(of_expected, expected.foot(side).*point), tolerance);
    }
  }
  CHECK(first == "");
}

} // namespace torqued
