#include "catch.h"
#include "matchers.h"
#include "nearest_oracle.h"
#include "oracles.h"

#include "motion/gait.h"
#include "robot/files/load.h"

namespace nearest_walk_test
{

using namespace torqued;

namespace
{

#ifdef NDEBUG
constexpr int kSamples = 1000;
#else
constexpr int kSamples = 30;
#endif

} // namespace

TEST_CASE("a walk whose accelerations are disturbed keeps every condition of its contacts and every torque limit",
          "[nearest_walk]")
{
  oracle::Random random(841);
  for (const auto& [name, disturbance] : {std::pair("ck", 5.0), {"rk", 5.0}, {"ck", 40.0}, {"rk", 40.0}})
  {
    CAPTURE(name, disturbance);
    const Robot robot = load_robot(name);
    GaitOptions options = default_gait(robot);
    options.steps = 4;
    const Gait gait(robot, options);
    AnswerSettings settings;
    settings.methods.infeasible = OnInfeasible::nearest;
    const double end = gait.phases().back().end;
    double lacking = 0.0, range = 0.0, residual = 0.0;
    int samples = 0, adjusted = 0, would_fail = 0;
    for (const GaitPhase& phase : gait.phases())
    {
      const int here = static_cast<int>(kSamples * (phase.end - phase.begin) / end) + 1;
      for (int i = 0; i < here; ++i)
      {
        DesiredState desired = gait.at(phase.begin + (phase.end - phase.begin) * (i + 0.5) / here, phase);
        CAPTURE(desired.utime);
        for (int k = 0; k < robot.num_coordinates(); ++k)
          desired.a(k) += oracle::uniform(random, -disturbance, disturbance);
        StreamMemory memory, other;
        const Result<Answer> result = answer(robot, settings, desired, memory);
        REQUIRE(std::holds_alternative<Answer>(result));
        const Answer& found = std::get<Answer>(result);
        constexpr std::int32_t wrong = flag::slips | flag::lifts | flag::tips | flag::over_torque | flag::clamped;
        CHECK((found.flags & wrong) == 0);
        const oracle::NearestProblem problem(robot, settings, desired, {});
        const oracle::Answered at = oracle::answered(robot, desired, found);
        lacking = std::max(lacking, problem.lacking(at).maxCoeff());
        range = std::max(range, problem.out_of_range(at));
        residual = std::max(residual, problem.residual(at));
        ++samples;
        adjusted += (found.flags & flag::adjusted) != 0 ? 1 : 0;
        const Result<Answer> usual = answer(robot, {}, desired, other);
        would_fail += std::holds_alternative<Answer>(usual) && (std::get<Answer>(usual).flags & wrong) != 0 ? 1 : 0;
      }
    }
    CHECK(samples >= kSamples);
    CHECK(lacking <= 1e-9); // of the weight, of weight × sole length
    CHECK(range == 0.0);
    CHECK(residual <= 1e-9);
    CHECK(adjusted > samples / 2);
    CHECK(would_fail >= samples / (disturbance > 5.0 ? 10 : 1000)); // else there was nothing to keep
  }
}

} // namespace nearest_walk_test
