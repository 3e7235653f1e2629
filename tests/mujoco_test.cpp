// Every robot once more, told to MuJoCo link by link: an engine in three dimensions that shares nothing with ours.

#include "catch.h"
#include "matchers.h"
#include "states.h"

#include "torque/equations.h"

#include <cstring>
#include <memory>
#include <mujoco/mujoco.h>

using namespace torqued;

namespace
{

// Both sum the same terms in another order, and MuJoCo turns 3 × 3 inertias about the robot's centre of mass: rounding,
// and the least masses and inertias below, 1e-12 of 1.
constexpr double kTolerance = 1e-9;
// What MuJoCo asks of all that moves, above 1e-15, in place of our 0.
constexpr double kLeast = 1e-12;

// an angle that is linear in our coordinates: row · q + offset
struct Linear
{
  Eigen::RowVectorXd row;
  double offset;

  Linear operator-(const Linear& other) const { return {row - other.row, offset - other.offset}; }
};

// A robot as an MJCF model. Its y axis points away from us, so that a turn about −y is counter-clockwise in the picture
// with x to the right and z up. Joints turn a link against its parent, whatever our coordinates are.
class Model
{
public:
  Model(const Robot& robot, bool rotors) : robot_(robot), rotors_(rotors)
  {
    const Link& root = robot.link(robot.root());
    const Linear still{Eigen::RowVectorXd::Zero(size()), 0.0};
    std::string joints;
    if (!robot.fixed_root())
    {
      joints = joint("base_x", "slide", "1 0 0", coordinate(robot.num_coordinates())) +
               joint("base_z", "slide", "0 0 1", coordinate(robot.num_coordinates() + 1)) +
               hinge(root.name, coordinate(root.coordinate));
    }
    const std::string text = fmt::format(
        "<mujoco><compiler angle=\"radian\" inertiafromgeom=\"false\"/><option gravity=\"0 0 {}\"/>"
        "<worldbody>{}</worldbody></mujoco>",
        -robot.mechanism.gravity(),
        body(robot.root(), {0.0, 0.0}, 0.0, joints, robot.fixed_root() ? still : coordinate(root.coordinate)));
    load(text);
  }

  mjModel& model() { return *model_; }
  mjData& data() { return *data_; }
  // q̇ of MuJoCo from ours
  const Eigen::MatrixXd& T() const { return T_; }

  // sets the state, and computes what it needs
  void set(const State& state, const Eigen::VectorXd& v, const Eigen::VectorXd& a)
  {
    Eigen::Map<Eigen::VectorXd>(data_->qpos, model_->nq) = T_ * state.q + offset_;
    Eigen::Map<Eigen::VectorXd>(data_->qvel, model_->nv) = T_ * v;
    Eigen::Map<Eigen::VectorXd>(data_->qacc, model_->nv) = T_ * a;
    mj_inverse(model_.get(), data_.get());
  }

  // generalized forces in our coordinates
  Eigen::VectorXd ours(const mjtNum* force) const
  {
    return T_.transpose() * Eigen::Map<const Eigen::VectorXd>(force, model_->nv);
  }

  Eigen::MatrixXd mass_matrix() const
  {
    Eigen::MatrixXd M(model_->nv, model_->nv);
    mj_fullM(model_.get(), M.data(), data_->qM);
    return T_.transpose() * M * T_;
  }

  int id(mjtObj kind, const std::string& name) const { return mj_name2id(model_.get(), kind, name.c_str()); }

private:
  struct Joint
  {
    std::string name;
    Linear angle;
  };

  int size() const { return robot_.num_coordinates() + (robot_.fixed_root() ? 0 : 2); }
  Linear coordinate(int index) const { return {Eigen::RowVectorXd::Unit(size(), index), 0.0}; }

  std::string joint(const std::string& name, const char* type, const char* axis, const Linear& angle)
  {
    joints_.push_back({name, angle});
    return fmt::format("<joint name=\"{}\" type=\"{}\" axis=\"{}\" armature=\"{}\"/>", name, type, axis,
                       rotors_ ? rotor(name) : 0.0);
  }
  std::string hinge(const std::string& name, const Linear& angle) { return joint(name, "hinge", "0 -1 0", angle); }

  // of the motor between a link and its parent
  double rotor(const std::string& link) const
  {
    for (const Actuator& actuator : robot_.actuators)
      for (const auto& [child, parent] :
           {std::pair(actuator.on, actuator.against), std::pair(actuator.against, actuator.on)})
        if (robot_.link(child).name == link && robot_.link(child).parent == parent)
          return actuator.rotor_inertia;
    return 0.0;
  }

  static std::string frame(const std::string& name, const Eigen::Vector2d& at, double angle)
  {
    return fmt::format("<body name=\"{}\" pos=\"{} 0 {}\" axisangle=\"0 -1 0 {}\">", name, at.x(), at.y(), angle);
  }
  // a body of equal moments of inertia: only that about y matters
  static std::string inertial(double mass, const Eigen::Vector2d& com, double inertia)
  {
    const double I = std::max(inertia, kLeast);
    return fmt::format("<inertial pos=\"{} 0 {}\" mass=\"{}\" diaginertia=\"{} {} {}\"/>", com.x(), com.y(),
                       std::max(mass, kLeast), I, I, I);
  }

  // a link, its frame turned by `angle` against its parent's where its joints are 0, and all that hangs on it; phi: its
  // angle against the world
  std::string body(int index, const Eigen::Vector2d& at, double angle, const std::string& joints, const Linear& phi)
  {
    const Link& link = robot_.link(index);
    std::string text = frame(link.name, at, angle) + joints + inertial(link.mass, link.com, link.inertia);
    for (const Side side : kSides)
      if (const Foot& foot = robot_.foot(side); foot.link == index)
        for (const auto& [name, r] :
             {std::pair("ankle", foot.ankle_at), std::pair("heel", foot.heel_at), std::pair("toe", foot.toe_at)})
          text += fmt::format("<site name=\"{}_{}\" pos=\"{} 0 {}\"/>", name_of(side), name, r.x(), r.y());
    for (const int child : robot_.order)
      if (robot_.link(child).parent == index)
        text += hung(child, phi);
    return text + "</body>";
  }

  std::string hung(int index, const Linear& parent)
  {
    const Link& link = robot_.link(index);
    const Linear still{Eigen::RowVectorXd::Zero(size()), link.angle};
    switch (link.joint)
    {
    case JointKind::floating: break;
    case JointKind::revolute:
    {
      const Linear own = coordinate(link.coordinate);
      return body(index, link.at, 0.0, hinge(link.name, own - parent), own);
    }
    case JointKind::rolling:
    {
      // The bar is a link with hinges of its own, and the circles are gears that make its angle depend on the others.
      // It has no mass, but the least that MuJoCo takes for a body that moves.
      const Linear own = coordinate(link.coordinate);
      const double r_p = link.parent_radius;
      const double r_c = link.child_radius;
      const Linear bar{(r_p * parent.row + r_c * own.row) / (r_p + r_c),
                       (r_p * parent.offset + r_c * own.offset) / (r_p + r_c) + link.angle};
      const std::string name = link.name + "_bar";
      const std::string hinge_of_bar = hinge(name, bar - parent);
      const std::string hinge_of_link = hinge(link.name, own - bar);
      return frame(name, link.at, 0.0) + hinge_of_bar + inertial(kLeast, {0.0, 0.0}, kLeast) +
             body(index, {0.0, -(r_p + r_c)}, 0.0, hinge_of_link, own) + "</body>";
    }
    case JointKind::parallel: return body(index, link.at, 0.0, hinge(link.name, still - parent), still);
    case JointKind::slide:
      return body(index, link.at, 0.0, joint(link.name, "slide", "0 1 0", coordinate(link.coordinate)), parent);
    case JointKind::fixed: return body(index, link.at, link.angle, "", Linear{parent.row, parent.offset + link.angle});
    }
    throw std::invalid_argument("a joint that MuJoCo was not told of");
  }

  void load(const std::string& text)
  {
    struct Files : mjVFS
    {
      Files() { mj_defaultVFS(this); }
      ~Files() { mj_deleteVFS(this); }
    };
    const auto files = std::make_unique<Files>(); // 2 MB
    mj_makeEmptyFileVFS(files.get(), "robot.xml", static_cast<int>(text.size()));
    std::memcpy(files->filedata[mj_findFileVFS(files.get(), "robot.xml")], text.data(), text.size());
    char error[500] = "";
    model_.reset(mj_loadXML("robot.xml", files.get(), error, sizeof error));
    if (!model_)
      throw std::invalid_argument(fmt::format("{}\n{}", error, text));
    data_.reset(mj_makeData(model_.get()));

    T_.resize(model_->nv, size());
    offset_.resize(model_->nv);
    if (model_->nv != static_cast<int>(joints_.size()))
      throw std::invalid_argument("MuJoCo has other joints than it was told of");
    for (const auto& [name, angle] : joints_)
    {
      const int row = model_->jnt_dofadr[id(mjOBJ_JOINT, name)];
      T_.row(row) = angle.row;
      offset_(row) = angle.offset;
    }
  }

  struct Delete
  {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  const Robot& robot_;
  bool rotors_;
  std::vector<Joint> joints_;
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
  Eigen::MatrixXd T_;
  Eigen::VectorXd offset_;
};

struct Named
{
  std::string name;
  Robot robot;
  int states;
};

std::vector<Named> robots()
{
  std::vector<Named> result;
  for (const std::string_view name : shipped_robot_names())
    result.push_back({std::string(name), load_robot(std::string(name)), kStates});
  oracle::Random random(300);
  for (int i = 0; i < 4; ++i)
  {
    result.push_back({"random ck", oracle::random_ck(random).robot(), kStates / 4});
    result.push_back({"random rk", oracle::random_rk(random).robot(), kStates / 4});
    result.push_back({"random six-link with rolling knees",
                      oracle::SixLink{oracle::random_rk(random), Side::right}.robot(), kStates / 4});
  }
  for (int i = 0; i < 20; ++i)
    result.push_back({fmt::format("tree {}", i), oracle::random_tree(random, i % 2 == 0), kStates / 20});
  return result;
}

template <typename Check> void for_all(const Check& check)
{
  oracle::Random random(301);
  for (const auto& [name, robot, states] : robots())
  {
    CAPTURE(name);
    Model model(robot, false);
    for (int i = 0; i < states; ++i)
    {
      CAPTURE(i);
      check(robot, model, random_state(random, robot));
    }
  }
}

} // namespace

TEST_CASE("MuJoCo moves every robot as we do", "[mujoco]")
{
  for_all(
      [](const Robot& robot, Model& model, const State& state)
      {
        const Support contacts = support(robot, Contact::none, Contact::none);
        const EquationOfMotion ours =
            equation_of_motion(robot, motion_of(robot, state, contacts), contacts, Coordinates::absolute);
        const Eigen::VectorXd zero = Eigen::VectorXd::Zero(state.v.size());
        model.set(state, zero, zero);
        CHECK(mismatch(ours.g, model.ours(model.data().qfrc_bias), kTolerance) == "");
        model.set(state, state.v, state.a);
        CHECK(mismatch(ours.M, model.mass_matrix(), kTolerance) == "");
        CHECK(mismatch(ours.C * state.v + ours.g, model.ours(model.data().qfrc_bias), kTolerance) == "");
        CHECK(mismatch(ours.h + ours.g, model.ours(model.data().qfrc_bias), kTolerance) == "");
        CHECK(mismatch(ours.generalized_force, model.ours(model.data().qfrc_inverse), kTolerance) == "");
      });
}

TEST_CASE("MuJoCo has every foot where we have it, and moves it alike", "[mujoco]")
{
  for_all(
      [](const Robot& robot, Model& model, const State& state)
      {
        model.set(state, state.v, state.a);
        mj_rnePostConstraint(&model.model(), &model.data());
        for (const Side side : kSides)
          for (const auto& [contact, name] :
               {std::pair(Contact::sole, "ankle"), std::pair(Contact::heel, "heel"), std::pair(Contact::toe, "toe")})
          {
            const Foot& foot = robot.foot(side);
            if (!foot.exists() || robot.is_root(foot) || (contact == Contact::sole && !foot.has_extent()))
              continue;
            CAPTURE(name_of(side), name);
            const Support contacts = support(robot, side == Side::left ? contact : Contact::none,
                                             side == Side::right ? contact : Contact::none);
            const Motion motion = motion_of(robot, state, contacts);
            const EquationOfMotion ours = equation_of_motion(robot, motion, contacts, Coordinates::absolute);

            const int site = model.id(mjOBJ_SITE, fmt::format("{}_{}", name_of(side), name));
            REQUIRE(site >= 0);
            const mjtNum* p = model.data().site_xpos + 3 * site;
            Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> moving(3, model.model().nv);
            Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> turning(3, model.model().nv);
            mj_jac(&model.model(), &model.data(), moving.data(), turning.data(), p,
                   model.id(mjOBJ_BODY, robot.link(foot.link).name));
            Eigen::MatrixXd J(ours.J.rows(), moving.cols());
            J.row(0) = moving.row(0);
            J.row(1) = moving.row(2);
            if (contact == Contact::sole)
              J.row(2) = -turning.row(1);
            CHECK(mismatch(ours.J, J * model.T(), kTolerance) == "");

            // of a fixed root, MuJoCo's world is at its frame and ours below its sole
            const Eigen::Vector2d origin = robot.fixed_root() ? motion.now.base : Eigen::Vector2d::Zero();
            CHECK(mismatch(position(motion.now, contact_point(foot, contact)) - origin, Eigen::Vector2d(p[0], p[2]),
                           kTolerance) == "");

            // turn and travel of the site; MuJoCo lifts the world by gravity
            mjtNum acceleration[6];
            mj_objectAcceleration(&model.model(), &model.data(), mjOBJ_SITE, site, acceleration, 0);
            const Eigen::VectorXd needed = ours.J * state.a + ours.Jdot_v;
            CHECK(mismatch(needed.head<2>(),
                           Eigen::Vector2d(acceleration[3], acceleration[5] - robot.mechanism.gravity()),
                           kTolerance) == "");
            if (contact == Contact::sole)
              CHECK(mismatch(needed(2), -acceleration[1], kTolerance) == "");
          }
      });
}

TEST_CASE("MuJoCo's armature is our rotor inertia", "[mujoco]")
{
  const Robot robot = load_robot("rabbit");
  REQUIRE(robot.actuators[0].rotor_inertia > 0.0);
  Model model(robot, true);
  oracle::Random random(302);
  for (int i = 0; i < kStates; ++i)
  {
    CAPTURE(i);
    const State state = random_state(random, robot);
    model.set(state, state.v, state.a);
    DesiredState desired{};
    desired.base_given = true;
    desired.support = support(robot, Contact::none, Contact::none);
    desired.q = state.q;
    desired.v = state.v;
    desired.a = state.a;
    const auto equations = support_equations(robot, desired);
    CHECK(mismatch(std::get<SupportEquations>(equations).r, model.ours(model.data().qfrc_inverse), kTolerance) == "");
  }
}
