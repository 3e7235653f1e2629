// The answers' torques on a robot that falls if they are not good: MuJoCo moves it, and a controller asks for the plan
// and feedback of what was measured, a thousand times a second.

#include "catch.h"
#include "mujoco_model.h"

#include "answer/answer.h"
#include "motion/gait.h"
#include "robot/files/load.h"

#include <Eigen/LU>
#include <cmath>
#include <random>

namespace closed_loop_test
{

using namespace torqued;

namespace
{

#ifdef NDEBUG
constexpr int kSteps = 20, kSeeds = 10;
#else
constexpr int kSteps = 3, kSeeds = 1;
#endif

struct Walked
{
  bool to_the_end = true;
  int refused = 0;
  double tracking = 0.0;                               // root mean square of the links' angles off the plan, rad
  Eigen::Vector2d reactions = Eigen::Vector2d::Zero(); // of a foot's simulated force less the answered one, weights
};

// A robot on its way through a walk.
class ClosedLoop
{
public:
  ClosedLoop(const std::string& name, const AnswerSettings& settings)
      : robot_(load_robot(name)), settings_(settings), gait_(robot_, steps(robot_)),
        mujoco_(robot_, {.rotors = true, .ground = true}), of_joints_(mujoco_.tree().T.inverse())
  {
  }

  // most: of a push forwards or backwards on the trunk, for a tenth of a second at random within each step, N
  Walked walk(double most, unsigned seed)
  {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> either(-1.0, 1.0);
    const int trunk = mujoco_.id(mjOBJ_BODY, robot_.link(robot_.trunk).name);
    mjData& data = mujoco_.data();
    set_out();

    Walked walked;
    StreamMemory memory;
    double push = 0.0, pushed_at = 0.0, squares = 0.0;
    Eigen::Vector2d off = Eigen::Vector2d::Zero();
    int samples = 0, step = -1;
    auto phase = gait_.phases().begin();
    for (std::int64_t ms = 0; walked.to_the_end; ++ms)
    {
      const double t = 1e-3 * static_cast<double>(ms);
      while (phase != gait_.phases().end() && t >= phase->end)
        ++phase;
      if (phase == gait_.phases().end())
        break;
      if (phase->step != step)
      {
        step = phase->step;
        push = most * either(random);
        pushed_at = t + 0.5 * (1.0 + either(random)) * (gait_.options().step_time - 0.1);
      }

      const DesiredState plan = gait_.at(t, *phase);
      const Eigen::VectorXd q = of_joints_ * (map(data.qpos) - mujoco_.tree().offset), v = of_joints_ * map(data.qvel);
      const Eigen::VectorXd error = plan.q - q;
      const auto angles = error.head(robot_.num_coordinates());
      walked.to_the_end = angles.cwiseAbs().maxCoeff() < 1.0;
      squares += angles.squaredNorm() / static_cast<double>(angles.size());

      DesiredState desired = plan;
      desired.utime = 1000 * ms + 1;
      desired.stream_id = 1;
      desired.q = q;
      desired.v = v;
      desired.a = plan.a + 400.0 * error + kDamping * (plan.v - v);
      const Result<Answer> answered = answer(robot_, settings_, desired, memory);
      const Answer* found = std::get_if<Answer>(&answered);
      walked.refused += found ? 0 : 1;
      if (found)
        apply(found->torque);
      data.xfrc_applied[6 * trunk] = t >= pushed_at && t < pushed_at + 0.1 ? push : 0.0;
      for (int i = 0; i < 2; ++i)
        mj_step(&mujoco_.model(), &data);
      if (found)
        for (const Side side : kSides)
        {
          const Wrench& wrench = found->ground[static_cast<std::size_t>(side)].wrench;
          off += (force_on(side) - Eigen::Vector2d(wrench.fx, wrench.fz)).cwiseAbs2();
        }
      ++samples;
    }
    walked.tracking = std::sqrt(squares / samples);
    walked.reactions = (off / (2.0 * samples)).cwiseSqrt() / robot_.weight();
    return walked;
  }

  static constexpr double kDamping = 40.0;

private:
  static GaitOptions steps(const Robot& robot)
  {
    GaitOptions options = default_gait(robot);
    options.steps = kSteps;
    return options;
  }
  Eigen::Map<Eigen::VectorXd> map(mjtNum* numbers) const { return {numbers, mujoco_.model().nv}; }

  void set_out()
  {
    mjData& data = mujoco_.data();
    mj_resetData(&mujoco_.model(), &data);
    const DesiredState start = gait_.at(0.0, gait_.phases().front());
    const JointTree::Motion motion = mujoco_.tree().motion(start.q, start.v, start.a);
    map(data.qpos) = motion.q;
    map(data.qvel) = motion.v;
    mj_forward(&mujoco_.model(), &data);
  }
  void apply(const VectorJ& torque)
  {
    const Eigen::VectorXd force = input_matrix(robot_) * torque;
    map(mujoco_.data().qfrc_applied) = of_joints_.transpose() * force;
  }
  // of the ground on a foot
  Eigen::Vector2d force_on(Side side) const
  {
    const mjModel& model = mujoco_.model();
    const mjData& data = mujoco_.data();
    const int body = mujoco_.id(mjOBJ_BODY, robot_.link(robot_.foot(side).link).name);
    Eigen::Vector2d force = Eigen::Vector2d::Zero();
    for (int i = 0; i < data.ncon; ++i)
    {
      const mjContact& contact = data.contact[i];
      const bool first = model.geom_bodyid[contact.geom1] == body, second = model.geom_bodyid[contact.geom2] == body;
      if (!first && !second)
        continue;
      mjtNum local[6], world[3];
      mj_contactForce(&model, &data, i, local);
      mju_rotVecMatT(world, local, contact.frame);
      force += (second ? 1.0 : -1.0) * Eigen::Vector2d(world[0], world[2]);
    }
    return force;
  }

  Robot robot_;
  AnswerSettings settings_;
  Gait gait_;
  MujocoModel mujoco_;
  Eigen::MatrixXd of_joints_;
};

AnswerSettings relaxed()
{
  return {};
}

AnswerSettings nearest(NearestMetric metric)
{
  AnswerSettings settings;
  settings.methods.infeasible = OnInfeasible::nearest;
  settings.nearest = {.metric = metric, .contact_damping = ClosedLoop::kDamping, .margin = 0.005};
  return settings;
}

} // namespace

TEST_CASE("a simulated robot walks on what is answered, with the reactions that are answered", "[closed_loop][slow]")
{
  const std::string robot = GENERATE("ck", "human-subject01");
  CAPTURE(robot);
  for (const AnswerSettings& settings : {relaxed(), nearest(NearestMetric::mass), nearest(NearestMetric::angles)})
  {
    const Walked walked = ClosedLoop(robot, settings).walk(0.0, 0);
    CHECK(walked.to_the_end);
    CHECK(walked.refused == 0);
    // the ground gives way by its softness, and feet land with the speed that is left
    CHECK(walked.tracking < 2.5e-3);
    CHECK(walked.reactions.x() < 0.006);
    CHECK(walked.reactions.y() < 0.02);
  }
}

#ifdef NDEBUG
TEST_CASE("with a push in every step the robot walks by the nearest motion, and falls without", "[closed_loop][slow]")
{
  int fell = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed)
  {
    CAPTURE(seed);
    fell += ClosedLoop("ck", relaxed()).walk(100.0, seed).to_the_end ? 0 : 1;
    for (const NearestMetric metric : {NearestMetric::mass, NearestMetric::angles})
    {
      const Walked walked = ClosedLoop("ck", nearest(metric)).walk(100.0, seed);
      CHECK(walked.to_the_end);
      CHECK(walked.refused == 0);
    }
  }
  CHECK(fell == kSeeds);
}
#endif

} // namespace closed_loop_test
