/// A motion of the closed-form biped in some support, and all that its equations leave to choose from.
#pragma once

#include "catch.h"
#include "decompositions.h"
#include "methods/torque_solution.h"
#include "oracles.h"

#include <optional>
#include <string>
#include <utility>

namespace torqued
{

/// Random cases of each contact pair and each robot.
#ifdef NDEBUG
inline constexpr int kCases = 500;
#else
inline constexpr int kCases = 8;
#endif

/// A consistent motion of a random biped, and its closed-form equations: D A + H + Q = r = B τ + Jᵀ w.
struct Case
{
  oracle::Biped biped;
  Robot robot;
  oracle::Motion motion;
  DesiredState desired;
  SupportEquations equations;

  Case(const oracle::Biped& built, const oracle::Motion& moves, Contact left, Contact right, Side leading, double s,
       double p)
      : Case(built, built.robot(), moves, left, right, leading, s, p)
  {
  }

  Case(const oracle::Biped& built, const Robot& of, const oracle::Motion& moves, Contact left, Contact right,
       Side leading, double s, double p)
      : biped(built), robot(of), motion(moves), desired(oracle::desired_state(moves, left, right, leading, s))
  {
    desired.support.phase = p;
    equations = std::get<SupportEquations>(support_equations(robot, desired));
  }

  const Support& support() const { return desired.support; }

  oracle::Vector9 r() const { return biped.D(motion.X) * motion.A + biped.H(motion.X, motion.V) + biped.Q(motion.X); }
  Eigen::MatrixXd B() const { return biped.B(); }
  Eigen::MatrixXd J(Side side) const { return biped.J(side, support().of(side), motion.X); }
  Eigen::MatrixXd J() const
  {
    Eigen::MatrixXd both(support().wrench_components(), 9);
    both << J(Side::left), J(Side::right);
    return both;
  }
  // G w = d, with N_B written out
  Eigen::MatrixXd N() const
  {
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(9, 3);
    N(7, 0) = N(8, 1) = 1.0;
    N.col(2).head<7>().setOnes();
    return N;
  }
  Eigen::MatrixXd G() const { return N().transpose() * J().transpose(); }
  Eigen::Vector3d d() const { return N().transpose() * r(); }
  // all w that serve the motion: one of them, and a basis of the others
  Eigen::VectorXd one() const { return oracle::solve(G(), d()); }
  Eigen::MatrixXd others() const { return oracle::kernel(G()); }
  // τ of w: the normal equations of the six columns of B, because the three rows without motors are served
  Eigen::VectorXd torque(const Eigen::VectorXd& w) const { return oracle::solve(B(), r() - J().transpose() * w); }

  AdmissibleReactions all() const { return admissible_reactions(robot, equations, support()); }

  ReactionTorques torques(const AdmissibleReactions& all) const
  {
    return reaction_torques(robot, equations, support(), all);
  }

  Result<TorqueSolution> solve(Method method, const MethodSettings& settings = {}) const
  {
    return solve_torques(robot, equations, support(), method, settings, 1e-3);
  }
  TorqueSolution solution(Method method, const MethodSettings& settings = {}) const
  {
    const auto solved = solve(method, settings);
    if (const Refusal* refusal = std::get_if<Refusal>(&solved))
      FAIL(std::string(name_of(method)) + ": " + std::string(refusal->detail()));
    return std::get<TorqueSolution>(solved);
  }
};

inline oracle::Biped random_biped(oracle::Random& random, int i)
{
  if (i % 2 == 0)
    return oracle::random_ck(random);
  constexpr Placement knees[] = {Placement::links, Placement::bar_parent, Placement::bar_child};
  return oracle::random_rk(random, knees[i / 2 % 3]);
}

/// How precise a torque can be: rounding grows with the reactions and torques that cancel in it.
inline double size(const Case& now, const TorqueSolution& solution)
{
  return 1.0 + std::max(solution.w.cwiseAbs().maxCoeff(), now.equations.r.cwiseAbs().maxCoeff());
}

/// Both feet on the ground z = 0, the leading one before the trailing one, pitched as their contacts need. The contacts
/// named rest, and the motion asks of the ground a force and a zero-moment point that are made up.
struct Stance
{
  Contact left, right;
  Side leading;
  double step = 0.0; ///< how much higher the leading foot stands, m
};

inline int index(Side side, int left, int right)
{
  return side == Side::left ? left : right;
}

/// q of a leg by which its contact point is at the ground's height, knee bent forward; false if the leg does not reach
inline bool put_on_ground(const oracle::Biped& biped, Side side, Contact contact, double ground, oracle::Vector9& X)
{
  const int shin = index(side, 1, 4), thigh = index(side, 2, 3);
  const auto height = [&](double angle)
  {
    X(shin) = angle;
    return biped.contact_point(side, contact == Contact::sole ? Contact::heel : contact, X).y() - ground;
  };
  double high = X(thigh) - 1.8, low = X(thigh) - 0.05;
  if (!(height(high) > 0.0 && height(low) < 0.0))
    return false;
  for (int i = 0; i < 100; ++i)
    (height(0.5 * (high + low)) > 0.0 ? high : low) = 0.5 * (high + low);
  height(low);
  return true;
}

inline double pitch(oracle::Random& random, Contact contact)
{
  return contact == Contact::heel  ? oracle::uniform(random, 0.05, 0.4)
         : contact == Contact::toe ? oracle::uniform(random, -0.6, -0.05)
                                   : 0.0;
}

inline std::optional<oracle::Motion> pose(oracle::Random& random, const oracle::Biped& biped, const Stance& stance)
{
  for (int tries = 0; tries < 1000; ++tries)
  {
    oracle::Motion motion = oracle::random_motion(random);
    oracle::Vector9& X = motion.X;
    X.tail<2>() << 0.0, oracle::uniform(random, 0.7, 1.0) * (biped.l1 + biped.l2 + biped.h_p);
    X(0) = pitch(random, stance.left);
    X(5) = pitch(random, stance.right);
    X(index(stance.leading, 2, 3)) = oracle::uniform(random, 0.2, 0.9);
    X(index(other(stance.leading), 2, 3)) = oracle::uniform(random, -0.6, 0.2);
    const auto ground = [&](Side side)
    {
      return side == stance.leading ? stance.step : 0.0;
    };
    if (!put_on_ground(biped, Side::left, stance.left, ground(Side::left), X) ||
        !put_on_ground(biped, Side::right, stance.right, ground(Side::right), X))
      continue;
    const double toe = biped.contact_point(other(stance.leading), Contact::toe, X).x();
    const double heel = biped.contact_point(stance.leading, Contact::heel, X).x();
    if (heel - toe > 0.05)
      return motion;
  }
  return {};
}

/// of a robot, ck and rk in turn, that can stand like that
inline std::pair<oracle::Biped, oracle::Motion> posed(oracle::Random& random, int i, const Stance& stance)
{
  for (;;)
  {
    const oracle::Biped biped = random_biped(random, i);
    if (const auto motion = pose(random, biped, stance))
      return {biped, *motion};
  }
}

/// Rates and accelerations by which the contacts rest and the ground carries F_z, μ-wise moderate F_x, and presses at
/// x_zmp in all: the nearest to those drawn.
inline void ask_of_ground(oracle::Random& random, const oracle::Biped& biped, const Stance& stance, double x_zmp,
                          oracle::Motion& motion)
{
  Case now(biped, motion, stance.left, stance.right, stance.leading, 0.0, 0.0);
  const Eigen::MatrixXd J = now.J();
  motion.V -= oracle::solve(J, J * motion.V);
  Eigen::VectorXd Jdot_V(J.rows());
  Jdot_V << biped.Jdot_V(Side::left, stance.left, motion.X, motion.V),
      biped.Jdot_V(Side::right, stance.right, motion.X, motion.V);
  motion.A -= oracle::solve(J, J * motion.A + Jdot_V);

  const double F_z = oracle::uniform(random, 0.6, 1.4) * biped.mass() * biped.gravity;
  const double F_x = oracle::uniform(random, -0.7, 0.7) * biped.friction * F_z;
  const Eigen::Vector2d hip = motion.X.tail<2>();
  const Eigen::Vector3d wanted(F_x, F_z, cross(Eigen::Vector2d(x_zmp, 0.0) - hip, Eigen::Vector2d(F_x, F_z)));
  now = Case(biped, motion, stance.left, stance.right, stance.leading, 0.0, 0.0);
  const Eigen::MatrixXd free = oracle::kernel(J);
  const Eigen::MatrixXd effect = now.N().transpose() * biped.D(motion.X) * free;
  motion.A += free * oracle::solve(effect, wanted - now.d());
}

} // namespace torqued
