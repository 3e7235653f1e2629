#include "catch.h"
#include "matchers.h"

#include "robot/files/load.h"
#include "study/outcome.h"

namespace outcome_test
{

using namespace torqued;

namespace
{

// Samples a tenth of a second apart, on the left foot; all angles turn alike but the left shin.
std::vector<DesiredState> moving(const Robot& robot, std::size_t count)
{
  std::vector<DesiredState> states(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    DesiredState& state = states[i];
    state.utime = 100'000 * static_cast<std::int64_t>(i);
    state.support = {{Contact::sole, Contact::none}, Side::left, 0.0, 0.0};
    state.q = state.a = VectorQ::Zero(robot.mechanism.num_q());
    state.v = VectorQ::Constant(robot.mechanism.num_q(), 0.3);
    state.v(1) = 1.3;
  }
  return states;
}

Answer with_torque(const Robot& robot, double torque)
{
  Answer answer{};
  answer.torque = VectorJ::Constant(robot.num_joints(), torque);
  return answer;
}

} // namespace

TEST_CASE("of constant torques the figures are known", "[outcome]")
{
  const Robot robot = load_robot("rk");
  const std::vector<DesiredState> states = moving(robot, 11);
  const Outcome outcome = outcome_of(robot, states, Answers(11, with_torque(robot, -20.0)), find_changes(states));
  CHECK(outcome.answered == 11);
  CHECK(outcome.peak == 20.0);
  CHECK(mismatch(outcome.seconds, 1.0, 1e-12) == "");
  CHECK(mismatch(outcome.effort, 6 * 20.0 * 20.0, 1e-12) == "");
  CHECK(mismatch(outcome.rms(), std::sqrt(6.0) * 20.0, 1e-12) == "");
  // the shin turns by 1 rad/s against the foot and the thigh; a motor between bar and thigh turns r_c / (r_p + r_c) of
  // it
  const double kappa = robot.link(robot.actuators[1].against).bar_shares().own;
  REQUIRE(robot.actuators[1].placement == Placement::bar_parent);
  CHECK(mismatch(outcome.work, 20.0 * (1.0 + kappa), 1e-12) == "");
}

TEST_CASE("what is not answered has no part in the figures, and no integral runs over it", "[outcome]")
{
  const Robot robot = load_robot("ck");
  const std::vector<DesiredState> states = moving(robot, 6);
  Answers answers(6, with_torque(robot, 1.0));
  answers[2].reset();
  answers[5]->flags = flag::tips | flag::late | flag::prior;
  answers[0]->flags = flag::tips;
  const Outcome outcome = outcome_of(robot, states, answers, find_changes(states));
  CHECK(outcome.answered == 5);
  CHECK(mismatch(outcome.seconds, 0.3, 1e-12) == "");
  CHECK(mismatch(outcome.effort, 6 * 0.3, 1e-12) == "");
  CHECK(outcome.flagged == std::map<std::int32_t, int>{{flag::tips, 2}, {flag::late, 1}, {flag::prior, 1}});
  CHECK(outcome_of(robot, states, Answers(6), find_changes(states)).rms() == 0.0);
}

TEST_CASE("a jump counts where contacts change, by the kind of change", "[outcome]")
{
  const Robot robot = load_robot("ck");
  std::vector<DesiredState> states = moving(robot, 5);
  for (const std::size_t i : {2U, 3U})
    states[i].support = {{Contact::sole, Contact::heel}, Side::right, 0.2, 0.2};
  const Changes changes = find_changes(states);
  CHECK(changes.kinds == std::vector<std::string>{"SSP→DSP1", "DSP1→SSP"});
  CHECK(changes.at == std::vector<int>{-1, -1, 0, -1, 1});
  CHECK(changes.longest == 100'000);
  Answers answers;
  for (const double torque : {0.0, 50.0, 47.0, 90.0, 88.0})
    answers.emplace_back(with_torque(robot, torque));
  answers[3]->flags = flag::tips;
  const Outcome outcome = outcome_of(robot, states, answers, changes);
  CHECK(outcome.jumps == std::vector<double>{3.0, 2.0});
  CHECK(outcome.double_support == 2);
  CHECK(outcome.held == 1);
  answers[1].reset();
  CHECK(outcome_of(robot, states, answers, changes).jumps == std::vector<double>{0.0, 2.0});
}

TEST_CASE("from one stream to the next no torque jumps, and no time passes", "[outcome]")
{
  const Robot robot = load_robot("ck");
  std::vector<DesiredState> states = moving(robot, 4);
  for (const std::size_t i : {2U, 3U})
  {
    states[i].support = {{Contact::sole, Contact::heel}, Side::right, 0.2, 0.2};
    states[i].stream_id = 2;
    states[i].utime += 60'000'000;
  }
  const Changes changes = find_changes(states);
  CHECK(changes.kinds.empty());
  Answers answers;
  for (const double torque : {0.0, 50.0, 47.0, 90.0})
    answers.emplace_back(with_torque(robot, torque));
  CHECK_THAT(outcome_of(robot, states, answers, changes).seconds, Catch::Matchers::WithinAbs(0.2, 1e-12));
}

} // namespace outcome_test
