// The answered torques, given to MuJoCo's equation of motion on contacts that do not give way.

#include "catch.h"
#include "matchers.h"
#include "mujoco_model.h"
#include "nearest_samples.h"

#include "stance/joint_friction.h"

#include <map>

namespace nearest_mujoco_test
{

using namespace torqued;
using oracle::Answered;

namespace
{

#ifdef NDEBUG
constexpr int kSamples = 100; // of each contact pair
#else
constexpr int kSamples = 6;
#endif

// J and J̇ v of the contacts, as MuJoCo has them at a motion without acceleration
struct Contacts
{
  Eigen::MatrixXd J;
  Eigen::VectorXd Jdot_v;

  Contacts(MujocoModel& model, const Robot& robot, const Support& support) : Jdot_v(support.wrench_components())
  {
    const int n = model.model().nv; // of MuJoCo's joints
    Eigen::MatrixXd of_joints(Jdot_v.size(), n);
    mj_rnePostConstraint(&model.model(), &model.data());
    for (const Side side : kSides)
    {
      const Contact contact = support.of(side);
      if (contact == Contact::none)
        continue;
      const int row = support.row(side);
      const char* point = contact == Contact::sole ? "ankle" : contact == Contact::heel ? "heel" : "toe";
      const int site = model.id(mjOBJ_SITE, fmt::format("{}_{}", name_of(side), point));
      REQUIRE(site >= 0);
      Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> moving(3, n), turning(3, n);
      mj_jac(&model.model(), &model.data(), moving.data(), turning.data(), model.data().site_xpos + 3 * site,
             model.id(mjOBJ_BODY, robot.link(robot.foot(side).link).name));
      mjtNum acceleration[6]; // turn and travel; MuJoCo lifts the world by gravity
      mj_objectAcceleration(&model.model(), &model.data(), mjOBJ_SITE, site, acceleration, 0);
      of_joints.row(row) = moving.row(0);
      of_joints.row(row + 1) = moving.row(2);
      Jdot_v.segment<2>(row) << acceleration[3], acceleration[5] - robot.mechanism.gravity();
      if (contact == Contact::sole)
      {
        of_joints.row(row + 2) = -turning.row(1);
        Jdot_v(row + 2) = -acceleration[1];
      }
    }
    J = of_joints * model.tree().T;
  }
};

} // namespace

TEST_CASE("MuJoCo's robot, its contacts held, does with the answered torques what was answered", "[nearest_mujoco]")
{
  const NearestRobots robots;
  std::map<const Robot*, MujocoModel> models;
  for (const Contact left : kContacts)
    for (const Contact right : kContacts)
    {
      oracle::Random random(83100 + 4 * static_cast<unsigned>(left) + static_cast<unsigned>(right));
      for (int i = 0; i < kSamples; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        NearestSample sample = random_sample(random, robots, left, right, i);
        sample.settings.nearest.contacts = NearestContacts::rest;
        const Robot& robot = sample.robot;
        MujocoModel& model =
            models.try_emplace(&robot, robot, MujocoModel::Parts{.rotors = true, .feet = true}).first->second;
        const oracle::NearestProblem problem = sample.problem();
        if (!problem.full_rank())
          continue;
        const Answered found = oracle::answered(robot, sample.desired, sample.answer());

        const Motion motion = std::get<Motion>(complete_motion(robot, sample.desired));
        VectorQ q = sample.desired.q;
        q.tail<2>() = motion.now.base;
        const Eigen::VectorXd v = motion.v;
        const Eigen::Index n = v.size();
        model.inverse(model.tree().motion(q, v, Eigen::VectorXd::Zero(n)));
        const Eigen::VectorXd bias = model.ours(model.data().qfrc_bias);
        const Contacts contacts(model, robot, sample.desired.support);
        Eigen::VectorXd motors = found.torque; // what is left of them
        const VectorJ rates = joint_rates(robot, motion.v.head(robot.mechanism.num_theta()));
        for (int j = 0; j < robot.num_joints(); ++j)
          motors(j) -= joint_friction(robot.actuators[static_cast<std::size_t>(j)], rates(j), 0.0);

        // M a − Jᵀ w = B τ − bias,  J a = −J̇ v − c J v
        const Eigen::Index rows = contacts.J.rows();
        Eigen::MatrixXd KKT = Eigen::MatrixXd::Zero(n + rows, n + rows);
        KKT.topLeftCorner(n, n) = model.mass_matrix();
        KKT.topRightCorner(n, rows) = -contacts.J.transpose();
        KKT.bottomLeftCorner(rows, n) = contacts.J;
        Eigen::VectorXd given(n + rows);
        given << input_matrix(robot) * motors - bias,
            -contacts.Jdot_v - sample.settings.nearest.contact_damping * (contacts.J * v);
        const Eigen::VectorXd does = oracle::solve_square(KKT, given);
        // both are rounded before masses of grams and kilograms are set against each other
        CHECK(mismatch(does.head(n), found.a, 1e-9) == "");
        CHECK(mismatch(does.tail(rows), found.w, 1e-9) == "");
      }
    }
}

} // namespace nearest_mujoco_test
