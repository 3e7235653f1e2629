#include "catch.h"

#include <torqued/desired_state_t.hpp>
#include <torqued/dynamics_request_t.hpp>
#include <torqued/dynamics_t.hpp>
#include <torqued/ground_reaction_t.hpp>
#include <torqued/model_info_t.hpp>
#include <torqued/rejection_t.hpp>
#include <torqued/status_t.hpp>
#include <torqued/torque_command_t.hpp>

namespace lcmtypes_test
{

using namespace torqued;

TEST_CASE("the fingerprints are those that clients, logs and other languages know", "[lcmtypes]")
{
  const auto fingerprint = [](std::int64_t hash)
  {
    return static_cast<std::uint64_t>(hash);
  };
  CHECK(fingerprint(desired_state_t::getHash()) == 0x848ee5a595a95ea6ULL);
  CHECK(fingerprint(torque_command_t::getHash()) == 0x3e42ae98b613c06bULL);
  CHECK(fingerprint(ground_reaction_t::getHash()) == 0xa564d025f3c20169ULL);
  CHECK(fingerprint(rejection_t::getHash()) == 0x5cf405f930c78269ULL);
  CHECK(fingerprint(status_t::getHash()) == 0x6bb8521dfc26ba14ULL);
  CHECK(fingerprint(dynamics_request_t::getHash()) == 0x31728d27123ab996ULL);
  CHECK(fingerprint(dynamics_t::getHash()) == 0x08ae4d0fafcac5d1ULL);
  CHECK(fingerprint(model_info_t::getHash()) == 0x4fbb0390edbabac1ULL);
}

TEST_CASE("the constants are those that clients, logs and other languages know", "[lcmtypes]")
{
  using D = desired_state_t;
  CHECK(std::vector<int>{D::ABSOLUTE, D::RELATIVE} == std::vector<int>{0, 1});
  CHECK(std::vector<int>{D::FROM_CONTACT, D::GIVEN} == std::vector<int>{0, 1});
  CHECK(std::vector<int>{D::NONE, D::HEEL, D::SOLE, D::TOE} == std::vector<int>{0, 1, 2, 3});
  CHECK(std::vector<int>{D::LEFT, D::RIGHT} == std::vector<int>{0, 1});
  CHECK(std::vector<int>{D::DEFAULT, D::PSEUDO_INVERSE, D::LINEAR_TRANSITION, D::INTERNAL_WRENCH, D::TORSO_WRENCH,
                         D::TRACKED_REACTION, D::TRACKED_INTERNAL, D::CONSTRAINED, D::ZMP_TRANSITION,
                         D::HUMAN_TRANSITION} == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  using Q = dynamics_request_t;
  CHECK(std::vector<int>{Q::ABSOLUTE, Q::RELATIVE} == std::vector<int>{0, 1});
  CHECK(std::vector<int>{Q::NONE, Q::HEEL, Q::SOLE, Q::TOE} == std::vector<int>{0, 1, 2, 3});
  using C = torque_command_t;
  CHECK(std::vector<int>{C::SLIPS, C::LIFTS, C::TIPS, C::OVER_TORQUE, C::CLAMPED, C::RELAXED, C::INCONSISTENT, C::LATE,
                         C::OVER_RATE, C::PROJECTED, C::ADJUSTED, C::CONTACT_ACCELERATION,
                         C::PRIOR} == std::vector<int>{1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096});
  using R = rejection_t;
  CHECK(std::vector<int>{R::UNDECODABLE, R::WRONG_MODEL, R::WRONG_SIZE, R::NOT_FINITE, R::OUT_OF_RANGE,
                         R::UNKNOWN_METHOD, R::OUT_OF_ORDER, R::STALE, R::OTHER_STREAM, R::INCONSISTENT,
                         R::UNDER_ACTUATED, R::INFEASIBLE, R::OVER_LIMIT, R::NOT_SUPPORTED,
                         R::NUMERICAL} == std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15});
  using S = status_t;
  CHECK(std::vector<int>{S::WAITING, S::RUNNING, S::STALE, S::STOPPING} == std::vector<int>{0, 1, 2, 3});
  using M = model_info_t;
  CHECK(std::vector<int>{M::FLOATING, M::REVOLUTE, M::ROLLING, M::PARALLEL, M::SLIDE, M::FIXED} ==
        std::vector<int>{0, 1, 2, 3, 4, 5});
  CHECK(std::vector<int>{M::LEFT, M::RIGHT} == std::vector<int>{0, 1});
}

} // namespace lcmtypes_test
