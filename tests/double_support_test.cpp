#include "catch.h"
#include "double_support.h"
#include "matchers.h"
#include "methods/constrained.h"
#include "methods/least_torque.h"
#include "methods/linear_transition.h"
#include "methods/pseudo_inverse.h"
#include "methods/torque_solution.h"
#include "states.h"
#include "trunk_wrench.h"

#include "robot/files/toml_robot.h"
#include "stance/checks.h"

#include <functional>

namespace double_support_test
{

using namespace torqued;
using oracle::Vector9;

namespace
{

constexpr Contact kContacts[] = {Contact::none, Contact::heel, Contact::sole, Contact::toe};
constexpr Contact kLoaded[] = {Contact::heel, Contact::sole, Contact::toe};

Side random_side(oracle::Random& random)
{
  return oracle::uniform(random, 0.0, 1.0) < 0.5 ? Side::left : Side::right;
}

// Calls law with random cases of a contact pair: ck and rk in turn, kCases of each.
void for_random_cases(oracle::Random& random, Contact left, Contact right, const std::function<void(Case&)>& law)
{
  for (int i = 0; i < 2 * kCases; ++i)
  {
    const oracle::Biped biped = random_biped(random, i);
    CAPTURE(name_of(left), name_of(right), i);
    Case now(biped, oracle::random_consistent_motion(random, biped, left, right), left, right, random_side(random),
             oracle::uniform(random, 0.0, 1.0), oracle::uniform(random, 0.0, 1.0));
    law(now);
  }
}

void for_double_supports(oracle::Random& random, const std::function<void(Case&)>& law)
{
  for (const Contact left : kLoaded)
    for (const Contact right : kLoaded)
      for_random_cases(random, left, right, law);
}

JointWeights random_weights(oracle::Random& random)
{
  Eigen::MatrixXd root(6, 6);
  for (double& entry : root.reshaped())
    entry = oracle::uniform(random, -1.0, 1.0);
  return root * root.transpose() + 0.2 * Eigen::MatrixXd::Identity(6, 6);
}

// the least ½ τᵀ W τ over all w that serve the motion, W = root rootᵀ
Eigen::VectorXd least_torque_oracle(const Case& now, const Eigen::MatrixXd& W)
{
  const Eigen::MatrixXd root = oracle::upper_root(W);
  const Eigen::VectorXd w = now.one();
  const Eigen::MatrixXd others = now.others();
  Eigen::MatrixXd T(6, others.cols());
  for (Eigen::Index k = 0; k < others.cols(); ++k)
    T.col(k) = now.torque(w + others.col(k)) - now.torque(w);
  const Eigen::VectorXd y = oracle::solve(root * T, -root * now.torque(w));
  return now.torque(w + others * y);
}

double objective(const Eigen::VectorXd& torque, const Eigen::MatrixXd& W)
{
  return 0.5 * torque.dot(W * torque);
}

std::string name(Method method)
{
  return std::string(name_of(method));
}

} // namespace

TEST_CASE("each contact pair leaves as many reactions free as counting says, and all of them serve the motion",
          "[double_support]")
{
  oracle::Random random(401);
  for (const Contact left : kContacts)
    for (const Contact right : kContacts)
    {
      const int n_w = wrench_components(left) + wrench_components(right);
      const int rank = n_w == 0 ? 0 : n_w == 2 ? 2 : 3;
      for_random_cases(random, left, right,
                       [&](Case& now)
                       {
                         const Eigen::MatrixXd G = now.G();
                         // moments in N × metre compare with forces: no scaling is needed to see the rank
                         CHECK(oracle::rank(G) == rank);
                         CHECK(mismatch(now.equations.d, now.d(), 1e-12) == "");
                         const AdmissibleReactions all = now.all();
                         const ReactionTorques torques = now.torques(all);
                         CHECK(all.redundancy == n_w - rank);
                         CHECK(all.redundancy == now.support().redundancy());
                         // degrees of freedom of the motion: 9 − n_w; beyond them the six motors are redundant
                         if (all.redundancy > 0)
                           CHECK(all.redundancy == 6 - (9 - n_w));

                         CHECK(mismatch(G * all.Z(), Eigen::MatrixXd::Zero(3, all.redundancy), 1e-13) == "");
                         CHECK(all.rows.topRightCorner(n_w, 3 - all.redundancy).isZero(0.0));
                         CHECK(torques.tau0.tail<kMaxJoints - 6>().isZero(0.0));
                         CHECK(torques.T.bottomRows<kMaxJoints - 6>().isZero(0.0));
                         if (n_w % 2 == 1)
                           CHECK(all.rows.row(n_w).isZero(0.0));
                         CHECK(mismatch(G * all.w0() + all.unmet, now.d(), 1e-12) == "");
                         if (rank == 3)
                           CHECK(all.unmet == Eigen::Vector3d::Zero());
                         Eigen::VectorXd y(all.redundancy);
                         for (double& entry : y)
                           entry = oracle::uniform(random, -100.0, 100.0);
                         const Eigen::VectorXd w = all.w0() + all.Z() * y;
                         const Eigen::VectorXd tau = torques.tau0.head<6>() + torques.T.topRows<6>() * y;
                         const Vector9 rest = now.r() - now.B() * tau - now.J().transpose() * w;
                         // a floating root keeps what no reaction meets
                         Vector9 unmet = Vector9::Zero();
                         unmet(6) = all.unmet(2);
                         unmet.tail<2>() = all.unmet.head<2>();
                         CHECK(mismatch(rest, unmet, 1e-10 * (1.0 + 100.0 * n_w)) == "");
                         // y is what the foot carries that is not on its sole; of two soles, the leading one
                         const Support& support = now.support();
                         if (left == Contact::sole || right == Contact::sole)
                         {
                           const bool trailing = support.of(support.trailing()) == Contact::sole;
                           const Side free = trailing ? support.leading : support.trailing();
                           const int components = wrench_components(support.of(free));
                           CHECK(all.w0().segment(support.row(free), components).isZero(0.0));
                           CHECK(all.Z().middleRows(support.row(free), components).isIdentity(0.0));
                         }
                         if (all.redundancy > 0)
                           CHECK(oracle::rank(torques.T.topRows<6>()) == all.redundancy);
                       });
    }
}

TEST_CASE("an imbalance on one contact point is the moment about it that the whole robot lacks", "[double_support]")
{
  oracle::Random random(402);
  for (const Contact contact : {Contact::heel, Contact::toe})
    for_random_cases(
        random, contact, Contact::none,
        [&](Case& now)
        {
          const Eigen::Vector2d p = now.biped.contact_point(Side::left, contact, now.motion.X);
          const Eigen::Vector2d lever = now.motion.X.tail<2>() - p;
          const Eigen::Vector3d d = now.d();
          CHECK(mismatch(now.all().unmet, Eigen::Vector3d(0.0, 0.0, d(2) + cross(lever, d.head<2>())), 1e-11) == "");
          CHECK(now.all().w0().head<2>() == now.equations.d.head<2>());
        });
}

TEST_CASE("two contact points at one place count as one: an imbalance is refused, a balance leaves two forces free",
          "[double_support]")
{
  oracle::Random random(403);
  for (int i = 0; i < 100; ++i)
  {
    CAPTURE(i);
    const oracle::Biped biped = random_biped(random, i);
    oracle::Motion motion = oracle::random_motion(random);
    // the right leg lies upon the left one
    const auto lay = [](Vector9& x)
    {
      x(3) = x(2);
      x(4) = x(1);
      x(5) = x(0);
    };
    lay(motion.X);
    lay(motion.V);
    lay(motion.A);
    // the trunk turns so that the moment about the point vanishes
    const auto moment = [&](double acceleration)
    {
      motion.A(6) = acceleration;
      const Case now(biped, motion, Contact::toe, Contact::toe, Side::left, 0.5, 0.5);
      return now.all().unmet(2);
    };
    const double at_0 = moment(0.0), at_1 = moment(1.0);
    REQUIRE(std::abs(at_1 - at_0) > 1e-3);
    motion.A(6) = at_0 / (at_0 - at_1);

    const Case now(biped, motion, Contact::toe, Contact::toe, Side::left, 0.5, 0.5);
    CHECK(now.all().redundancy == 2);
    CHECK(now.all().rank() == 2);
    for (const Method method : {Method::pseudo_inverse, Method::constrained})
    {
      const TorqueSolution found = now.solution(method);
      CHECK(dynamics_residual(now.robot, now.equations, found) < 1e-9 * size(now, found));
    }
    for (const Method method : {Method::linear_transition, Method::zmp_transition, Method::internal_wrench,
                                Method::torso_wrench, Method::tracked_reaction, Method::tracked_internal})
    {
      CAPTURE(name(method));
      const auto refused = now.solve(method);
      REQUIRE(std::holds_alternative<Refusal>(refused));
      CHECK(std::get<Refusal>(refused).reason() == Reason::numerical);
    }

    motion.A(6) += 5.0;
    const auto refused =
        Case(biped, motion, Contact::toe, Contact::toe, Side::left, 0.5, 0.5).solve(Method::pseudo_inverse);
    REQUIRE(std::holds_alternative<Refusal>(refused));
    CHECK(std::get<Refusal>(refused).reason() == Reason::under_actuated);
  }
}

TEST_CASE("with every method the equation of motion holds and the ground carries the same in all",
          "[double_support][slow]")
{
  oracle::Random random(404);
  for_double_supports(random,
                      [&](Case& now)
                      {
                        for (const MethodRow& known : methods())
                        {
                          CAPTURE(known.name);
                          const TorqueSolution found = now.solution(known.method);
                          CHECK(found.method == known.method);
                          const Vector9 rest = now.r() - now.B() * found.torque - now.J().transpose() * found.w;
                          const double unit = size(now, found);
                          CHECK(rest.cwiseAbs().maxCoeff() < 1e-10 * unit);
                          CHECK((now.G() * found.w - now.d()).cwiseAbs().maxCoeff() < 1e-10 * unit);
                          // about the ankles, whatever the contact
                          Vector9 at_ankles = now.B() * found.torque;
                          for (const Side side : kSides)
                          {
                            const Wrench& wrench = found.ground[static_cast<std::size_t>(side)];
                            at_ankles += now.biped.J(side, Contact::sole, now.motion.X).transpose() *
                                         Eigen::Vector3d(wrench.fx, wrench.fz, wrench.moment);
                          }
                          CHECK((now.r() - at_ankles).cwiseAbs().maxCoeff() < 1e-10 * unit);
                        }
                      });
}

TEST_CASE("contacts do no work: the torques' power is the same with every method", "[double_support]")
{
  oracle::Random random(405);
  for_double_supports(random,
                      [&](Case& now)
                      {
                        const double power = now.motion.V.dot(now.r());
                        for (const MethodRow& known : methods())
                        {
                          CAPTURE(known.name);
                          const TorqueSolution found = now.solution(known.method);
                          CHECK(std::abs(now.motion.V.dot(now.B() * found.torque) - power) < 1e-9 * size(now, found));
                        }
                      });
}

TEST_CASE("pseudo-inverse is (27): the shortest vector of torques and of the reactions of the foot that is not fixed",
          "[double_support]")
{
  oracle::Random random(406);
  for_double_supports(random,
                      [&](Case& now)
                      {
                        // the fixed foot's rows leave the equations by a basis of the motions that it allows
                        const Support& support = now.support();
                        const bool trailing = support.of(support.trailing()) == Contact::sole;
                        const bool leading = support.of(support.leading) == Contact::sole;
                        Eigen::MatrixXd N = Eigen::MatrixXd::Identity(9, 9);
                        std::vector<Side> counted{Side::left, Side::right};
                        if (trailing || leading)
                        {
                          const Side fixed = trailing ? support.trailing() : support.leading;
                          N = oracle::kernel(now.J(fixed));
                          counted = {other(fixed)};
                        }
                        const auto system = [&](double torque_unit, const Eigen::Vector3d& reaction_units)
                        {
                          Eigen::MatrixXd A(N.cols(), 0);
                          const auto append = [&A](const Eigen::MatrixXd& columns)
                          {
                            A.conservativeResize(Eigen::NoChange, A.cols() + columns.cols());
                            A.rightCols(columns.cols()) = columns;
                          };
                          append(torque_unit * N.transpose() * now.B());
                          for (const Side side : counted)
                          {
                            const Eigen::MatrixXd J = now.J(side);
                            append(N.transpose() * J.transpose() * reaction_units.head(J.rows()).asDiagonal());
                          }
                          return A;
                        };
                        const Eigen::VectorXd rhs = N.transpose() * now.r();
                        const Eigen::VectorXd expected = oracle::solve(system(1.0, Eigen::Vector3d::Ones()), rhs);
                        const TorqueSolution found = now.solution(Method::pseudo_inverse);
                        const double scale = expected.cwiseAbs().maxCoeff();
                        CHECK(mismatch(found.torque / scale, expected.head(6) / scale, 1e-9) == "");
                        Eigen::VectorXd lambda(0);
                        for (const Side side : counted)
                        {
                          const Eigen::Index components = now.J(side).rows();
                          lambda.conservativeResize(lambda.size() + components);
                          lambda.tail(components) = found.w.segment(support.row(side), components);
                        }
                        CHECK(mismatch(lambda / scale, expected.tail(lambda.size()) / scale, 1e-9) == "");

                        // shorter than any other admissible pair
                        const Eigen::VectorXd other_w = Eigen::VectorXd(found.w) + 10.0 * now.others().rowwise().sum();
                        Eigen::VectorXd other_lambda(0);
                        for (const Side side : counted)
                        {
                          const Eigen::Index components = now.J(side).rows();
                          other_lambda.conservativeResize(other_lambda.size() + components);
                          other_lambda.tail(components) = other_w.segment(support.row(side), components);
                        }
                        CHECK(found.torque.squaredNorm() + lambda.squaredNorm() <
                              now.torque(other_w).squaredNorm() + other_lambda.squaredNorm());

                        // weights are units: torques in units of 1/√2 N m and so on
                        MethodSettings weighted;
                        weighted.of<PseudoInverse>().weights = 4.0 * Eigen::MatrixXd::Identity(6, 6);
                        weighted.of<PseudoInverse>().reaction_weights = {0.25, 4.0, 100.0};
                        const Eigen::VectorXd in_units = oracle::solve(system(0.5, {2.0, 0.5, 0.1}), rhs);
                        const TorqueSolution other_units = now.solution(Method::pseudo_inverse, weighted);
                        CHECK(mismatch(other_units.torque / scale, 0.5 * in_units.head(6) / scale, 1e-9) == "");
                      });
}

TEST_CASE("on two soles pseudo-inverse depends on which foot is fixed, and least torque does not", "[double_support]")
{
  oracle::Random random(407);
  int differs = 0, cases = 0;
  for_random_cases(random, Contact::sole, Contact::sole,
                   [&](Case& now)
                   {
                     Case turned = now;
                     turned.desired.support.leading = other(now.support().leading);
                     const auto change = [&](Method method)
                     {
                       const TorqueSolution one = now.solution(method), two = turned.solution(method);
                       return (one.torque - two.torque).cwiseAbs().maxCoeff() / size(now, one);
                     };
                     ++cases;
                     differs += change(Method::pseudo_inverse) > 1e-4 ? 1 : 0;
                     CHECK(change(Method::internal_wrench) < 1e-9);
                   });
  CHECK(differs > 9 * cases / 10);
}

TEST_CASE("procedure 1 is the least torque of all that serve the motion, for every share and either leg first",
          "[double_support][slow]")
{
  oracle::Random random(408);
  for_double_supports(
      random,
      [&](Case& now)
      {
        const Eigen::MatrixXd W = random_weights(random);
        MethodSettings settings;
        settings.of<InternalWrench>().weights = W;
        settings.of<TorsoWrench>().weights = W;
        const TorqueSolution found = now.solution(Method::internal_wrench, settings);
        const double unit = size(now, found);
        // cancellation in the oracle: the square of its condition is not in it, but large internal forces are
        CHECK((found.torque - least_torque_oracle(now, W)).cwiseAbs().maxCoeff() < 1e-8 * unit);
        const TorqueSolution plain = now.solution(Method::internal_wrench);
        CHECK((plain.torque - least_torque_oracle(now, Eigen::MatrixXd::Identity(6, 6))).cwiseAbs().maxCoeff() <
              1e-8 * unit);
        CHECK((now.solution(Method::torso_wrench, settings).torque - found.torque).cwiseAbs().maxCoeff() < 1e-9 * unit);

        // the same by (61) to (65), for every σ, also outside 0 to 1: of all η that leave no moment about a heel or
        // toe, as those of the linear transition do, the one of the least torque
        const double sigma = oracle::uniform(random, -1.0, 2.0);
        const auto carried = [&](const TorqueSolution& solution, double share)
        {
          return oracle::carried_trunk(now.robot, now.equations, now.support(), Reactions(solution.w), share);
        };
        const oracle::CarriedTrunk start = carried(now.solution(Method::linear_transition), sigma);
        const auto torque_at = [&](const Eigen::Vector3d& eta) -> Eigen::VectorXd
        {
          return now.torque(oracle::reactions_below(now.robot, now.equations, now.support(),
                                                    sigma * start.trunk + start.internal + eta));
        };
        const Eigen::VectorXd b1 = torque_at(Eigen::Vector3d::Zero());
        Eigen::MatrixXd B1(6, 3), a1(3, 0);
        for (int k = 0; k < 3; ++k)
          B1.col(k) = torque_at(Eigen::Vector3d::Unit(k)) - b1;
        for (const Side side : kSides)
          if (const Contact contact = now.support().of(side); contact != Contact::sole)
          {
            const Eigen::Vector2d r = now.biped.contact_point(side, contact, now.motion.X) - now.motion.X.tail<2>();
            a1.conservativeResize(3, a1.cols() + 1);
            a1.rightCols<1>() << r.y(), -r.x(), 1.0;
          }
        const Eigen::MatrixXd root = oracle::upper_root(W);
        const Eigen::MatrixXd N =
            a1.cols() == 0 ? Eigen::MatrixXd(Eigen::Matrix3d::Identity()) : oracle::kernel(a1.transpose());
        const Eigen::Vector3d eta = start.internal - N * oracle::solve(root * B1 * N, root * b1);
        // the linear transition may be far from there: between points that nearly stand above one another it needs
        // large internal forces, which cancel
        CHECK((carried(found, sigma).internal - eta).cwiseAbs().maxCoeff() < 1e-6 * unit);

        // a multiple of W is the same rule
        settings.of<InternalWrench>().weights *= 7.0;
        CHECK((now.solution(Method::internal_wrench, settings).torque - found.torque).cwiseAbs().maxCoeff() <
              1e-9 * unit);
        // and so is the other leg called trailing
        Case turned = now;
        turned.desired.support.leading = other(now.support().leading);
        CHECK((turned.solution(Method::internal_wrench, settings).torque - found.torque).cwiseAbs().maxCoeff() <
              1e-9 * unit);
      });
}

TEST_CASE("between two points zmp_transition leaves each foot a share of the total force, at any height",
          "[double_support]")
{
  oracle::Random random(415);
  int shared = 0, clamped = 0;
  for (const Contact left : {Contact::heel, Contact::toe})
    for (const Contact right : {Contact::heel, Contact::toe})
      for_random_cases(random, left, right,
                       [&](Case& now)
                       {
                         const TorqueSolution found = now.solution(Method::zmp_transition);
                         const Eigen::Vector2d F = now.d().head<2>();
                         const Eigen::Vector2d f = found.w.segment<2>(now.support().row(now.support().leading));
                         const double share = f.dot(F) / F.squaredNorm();
                         if (found.clamped)
                         {
                           ++clamped;
                           return;
                         }
                         ++shared;
                         CHECK((f - share * F).norm() < 1e-9 * size(now, found));
                         CHECK(share > -1e-9);
                         CHECK(share < 1.0 + 1e-9);
                       });
  CHECK(shared > kCases);
  CHECK(clamped > kCases / 5);
}

TEST_CASE("both legs carry the trunk: f* is its rate of momentum, and what the legs carry adds up to it",
          "[double_support]")
{
  oracle::Random random(409);
  for_double_supports(random,
                      [&](Case& now)
                      {
                        const oracle::Biped& ck = now.biped;
                        const auto& [X, V, A] = now.motion;
                        const double c = std::cos(X(6)), s = std::sin(X(6));
                        // centre of mass at s3 (−sin q6, cos q6) from the hip
                        const Eigen::Vector2d com = ck.s3 * Eigen::Vector2d(-s, c);
                        const Eigen::Vector2d acceleration =
                            Eigen::Vector2d(A(7), A(8) + ck.gravity) +
                            ck.s3 * (A(6) * Eigen::Vector2d(-c, -s) - V(6) * V(6) * Eigen::Vector2d(-s, c));
                        const Eigen::Vector2d force = ck.m3 * acceleration;
                        const Eigen::Vector3d expected(force.x(), force.y(), ck.I3 * A(6) + cross(com, force));
                        const Reactions chosen(now.solution(Method::linear_transition).w);
                        const oracle::CarriedTrunk found =
                            oracle::carried_trunk(now.robot, now.equations, now.support(), chosen, 0.0);
                        CHECK(mismatch(found.trunk, expected, 1e-10) == "");
                      });
}

TEST_CASE("procedures 3 and 4 are the linear transition, and a clamp changes the internal wrench, not the torques",
          "[double_support]")
{
  oracle::Random random(410);
  int clamped = 0, cases = 0;
  for_double_supports(random,
                      [&](Case& now)
                      {
                        if (cases % 10 == 0)
                          now.desired.support.load_transfer = cases % 20 == 0 ? 0.0 : 1.0;
                        MethodSettings settings;
                        if (cases % 3 == 0)
                          settings.of<LinearTransition>().leading_cop = 0.3;
                        const TorqueSolution linear = now.solution(Method::linear_transition, settings);
                        const TorqueSolution reaction = now.solution(Method::tracked_reaction, settings);
                        const TorqueSolution internal = now.solution(Method::tracked_internal, settings);
                        const double unit = size(now, linear);
                        CHECK((reaction.torque - linear.torque).cwiseAbs().maxCoeff() < 1e-10 * unit);
                        CHECK((reaction.w - linear.w).cwiseAbs().maxCoeff() < 1e-10 * unit);
                        CHECK((internal.torque - linear.torque).cwiseAbs().maxCoeff() < 1e-10 * unit);
                        CHECK((internal.w - linear.w).cwiseAbs().maxCoeff() < 1e-10 * unit);
                        CHECK_FALSE(reaction.clamped);

                        // [η; σ̄] by the pseudo-inverse of [1 f*], and what the paper's η would leave of (71)
                        const auto found = std::get<oracle::CarriedTrunk>(oracle::tracked_internal(
                            now.robot, now.equations, now.support(), settings.of<LinearTransition>()));
                        const oracle::CarriedTrunk x =
                            oracle::carried_trunk(now.robot, now.equations, now.support(), Reactions(linear.w), 0.0);
                        // (71): what one leg carries determines both feet's reactions
                        const WrenchVector below =
                            oracle::reactions_below(now.robot, now.equations, now.support(), x.internal);
                        CHECK((below - linear.w).cwiseAbs().maxCoeff() < 1e-10 * unit);
                        Eigen::Matrix<double, 3, 4> both;
                        both << Eigen::Matrix3d::Identity(), found.trunk;
                        const Eigen::Vector4d least = oracle::solve(both, x.internal + x.sigma * x.trunk);
                        CHECK(mismatch(found.sigma, std::clamp(least(3), 0.0, 1.0), 1e-9) == "");
                        CHECK(internal.clamped == (least(3) < 0.0 || least(3) > 1.0));
                        CHECK((found.internal + found.sigma * found.trunk - least.head<3>() - least(3) * found.trunk)
                                  .cwiseAbs()
                                  .maxCoeff() < 1e-9 * unit);
                        const double kept = (least.head<3>() - found.internal).cwiseAbs().maxCoeff();
                        CHECK((kept > 1e-6 * unit) ==
                              (std::abs(found.sigma - least(3)) * found.trunk.cwiseAbs().maxCoeff() > 1e-6 * unit));
                        clamped += internal.clamped ? 1 : 0;
                        ++cases;
                      });
  CHECK(clamped > cases / 20);
  CHECK(clamped < cases);
}

TEST_CASE("at both ends of double support procedure 4 clamps, because the unloaded leg hangs from the hip",
          "[double_support]")
{
  // upright on both soles, one before the other, at rest
  for (const double s : {0.0, 1.0})
  {
    const oracle::Biped ck;
    oracle::Motion motion;
    motion.X << 0, -0.3, 0.1, 0.3, -0.1, 0, 0, 0, 0.84;
    motion.V.setZero();
    motion.A.setZero();
    const Case now(ck, motion, Contact::sole, Contact::sole, Side::right, s, 0.5);
    CHECK(now.solution(Method::tracked_internal).clamped);
    const auto found = std::get<oracle::CarriedTrunk>(
        oracle::tracked_internal(now.robot, now.equations, now.support(), LinearTransition{}));
    CHECK(found.sigma == 1.0 - s);
    // what the unloaded leg does to the trunk is its weight
    const Eigen::Vector3d trailing = found.internal + found.sigma * found.trunk;
    const double unloaded = s == 0.0 ? found.trunk(1) - trailing(1) : trailing(1);
    CHECK(mismatch(unloaded, -(ck.m0 + ck.m1 + ck.m2) * ck.gravity, 1e-11) == "");
  }
}

TEST_CASE("the least torque is that of the motors, rotors and friction included", "[double_support]")
{
  oracle::Random random(411);
  for_double_supports(random,
                      [&](Case& now)
                      {
                        make_motors_real(now.robot, random);
                        now.equations = std::get<SupportEquations>(support_equations(now.robot, now.desired));
                        Case without = now;
                        const Vector9 r = now.r();
                        // τ_f stands beside the torques that reach the links
                        const VectorJ friction = oracle::solve(now.B(), Vector9(now.equations.r - r));
                        CHECK(friction.cwiseAbs().minCoeff() > 0.0);
                        const Eigen::MatrixXd W = random_weights(random);
                        MethodSettings settings;
                        settings.of<InternalWrench>().weights = W;
                        settings.of<Constrained>().weights = W;
                        settings.of<Constrained>().windows = false;
                        const TorqueSolution found = now.solution(Method::internal_wrench, settings);
                        const Eigen::VectorXd other_w = Eigen::VectorXd(found.w) + now.others().rowwise().sum();
                        const auto motors = [&](const Eigen::VectorXd& w)
                        {
                          return Eigen::VectorXd(now.torque(w) + friction);
                        };
                        CHECK((found.torque - motors(found.w)).cwiseAbs().maxCoeff() < 1e-9 * size(now, found));
                        CHECK(objective(found.torque, W) < objective(motors(other_w), W));
                        CHECK(objective(found.torque, W) <
                              objective(motors(Eigen::VectorXd(found.w) - now.others().rowwise().sum()), W));
                      });
}

TEST_CASE("mirrored, every method gives the mirrored torques and reactions", "[double_support]")
{
  oracle::Random random(412);
  const auto mirrored = [](const Vector9& x)
  {
    Vector9 result = x;
    for (int i = 0; i < 6; ++i)
      result(i) = x(5 - i);
    return result;
  };
  for_double_supports(random,
                      [&](Case& now)
                      {
                        const Support& support = now.support();
                        const Case other_side(now.biped,
                                              {mirrored(now.motion.X), mirrored(now.motion.V), mirrored(now.motion.A)},
                                              support.contact[1], support.contact[0], other(support.leading),
                                              support.load_transfer, support.phase);
                        for (const MethodRow& known : methods())
                        {
                          CAPTURE(known.name);
                          const TorqueSolution one = now.solution(known.method);
                          const TorqueSolution two = other_side.solution(known.method);
                          const double unit = size(now, one);
                          CHECK((one.torque - two.torque.reverse()).cwiseAbs().maxCoeff() < 1e-8 * unit);
                          for (const std::size_t side : {0, 1})
                          {
                            CHECK(std::abs(one.ground[side].fx - two.ground[1 - side].fx) < 1e-8 * unit);
                            CHECK(std::abs(one.ground[side].fz - two.ground[1 - side].fz) < 1e-8 * unit);
                            CHECK(std::abs(one.ground[side].moment - two.ground[1 - side].moment) < 1e-8 * unit);
                          }
                        }
                      });
}

TEST_CASE("rolling knees of no radius are pin knees with every method", "[double_support]")
{
  oracle::Random random(413);
  for (const Contact left : kLoaded)
    for (const Contact right : kLoaded)
      for (int i = 0; i < kCases; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const oracle::Biped ck = oracle::random_ck(random);
        oracle::Biped rk = ck;
        rk.r1 = 1e-9;
        rk.r2 = 2e-9;
        const oracle::Motion motion = oracle::random_consistent_motion(random, ck, left, right);
        const Case one(ck, motion, left, right, Side::right, 0.3, 0.6),
            two(rk, motion, left, right, Side::right, 0.3, 0.6);
        for (const MethodRow& known : methods())
        {
          CAPTURE(known.name);
          const TorqueSolution pin = one.solution(known.method), rolling = two.solution(known.method);
          // lengths differ by some 1e-9 m, and internal forces amplify it by the torques' condition
          CHECK((pin.torque - rolling.torque).cwiseAbs().maxCoeff() < 1e-5 * size(one, pin));
        }
      }
}

TEST_CASE("another place of the knees' motors divides their torques, unless torque itself is chosen",
          "[double_support]")
{
  oracle::Random random(414);
  int changed = 0, cases = 0;
  for (const Contact left : kLoaded)
    for (const Contact right : kLoaded)
      for (int i = 0; i < kCases; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        oracle::Biped thigh = oracle::random_rk(random, Placement::bar_parent);
        oracle::Biped shin = thigh;
        shin.knee = Placement::bar_child;
        const oracle::Motion motion = oracle::random_consistent_motion(random, thigh, left, right);
        const Case one(thigh, motion, left, right, Side::left, 0.7, 0.2),
            two(shin, motion, left, right, Side::left, 0.7, 0.2);
        Eigen::VectorXd ratio = Eigen::VectorXd::Ones(6); // of the torques: κ of the thigh's over κ of the shin's
        ratio(1) = ratio(4) = thigh.kappa() / shin.kappa();
        for (const Method method :
             {Method::linear_transition, Method::tracked_reaction, Method::tracked_internal, Method::zmp_transition})
        {
          const TorqueSolution at_thigh = one.solution(method), at_shin = two.solution(method);
          CHECK((at_thigh.torque.cwiseProduct(ratio) - at_shin.torque).cwiseAbs().maxCoeff() <
                1e-9 * size(two, at_shin) * ratio.maxCoeff());
        }
        // the same rule where W is in the same units: τ'ᵀ W' τ' = τᵀ W τ
        MethodSettings rescaled;
        rescaled.of<InternalWrench>().weights = Eigen::MatrixXd(ratio.cwiseProduct(ratio).cwiseInverse().asDiagonal());
        const TorqueSolution at_thigh = one.solution(Method::internal_wrench);
        const TorqueSolution in_units = two.solution(Method::internal_wrench, rescaled);
        const TorqueSolution at_shin = two.solution(Method::internal_wrench);
        const double unit = size(two, at_shin) * ratio.maxCoeff();
        CHECK((at_thigh.torque.cwiseProduct(ratio) - in_units.torque).cwiseAbs().maxCoeff() < 1e-8 * unit);
        changed += (at_thigh.torque.cwiseProduct(ratio) - at_shin.torque).cwiseAbs().maxCoeff() > 1e-4 * unit ? 1 : 0;
        ++cases;
      }
  CHECK(changed > 9 * cases / 10);
}

TEST_CASE("a robot with fewer motors than a wrench has components is served where its contacts leave as few free",
          "[double_support]")
{
  // a trunk on two straight legs with point feet: two motors, and one internal force
  const Robot robot = read_toml_robot(R"(
name = "stilts"
source = "made up"
gravity = 9.81
[[link]]
name = "trunk"
joint = "floating"
coordinate = "q0"
mass = 20
com = [0, 0.2]
inertia = 0.5
[[link]]
name = "left_leg"
joint = "revolute"
parent = "trunk"
at = [0, 0]
coordinate = "q1"
mass = 5
com = [0, -0.4]
inertia = 0.1
[[link]]
name = "right_leg"
joint = "revolute"
parent = "trunk"
at = [0, 0]
coordinate = "q2"
mass = 5
com = [0, -0.4]
inertia = 0.1
[[foot]]
side = "left"
link = "left_leg"
ankle = [0, -0.8]
friction = 0.8
[[foot]]
side = "right"
link = "right_leg"
ankle = [0, -0.8]
friction = 0.8
)",
                                      "stilts.toml");
  DesiredState desired{};
  desired.support = {{Contact::heel, Contact::heel}, Side::left, 0.5, 0.5};
  desired.q = desired.v = desired.a = VectorQ::Zero(5);
  desired.q.head<3>() << 0.1, 0.4, -0.3;
  const auto equations = std::get<SupportEquations>(support_equations(robot, desired));
  for (const MethodRow& known : methods())
  {
    CAPTURE(known.name);
    const auto solved = solve_torques(robot, equations, desired.support, known.method, {}, 1e-3);
    REQUIRE(std::holds_alternative<TorqueSolution>(solved));
    const TorqueSolution& found = std::get<TorqueSolution>(solved);
    CHECK(dynamics_residual(robot, equations, found) < 1e-10 * robot.weight());
  }
}

TEST_CASE("every robot that stands on two feet is served by every method, and least torque is the least",
          "[double_support]")
{
  oracle::Random random(416);
  int answered = 0;
  for (const Robot& robot : all_kinds_of_motors())
    for (const Contact left : kLoaded)
      for (const Contact right : kLoaded)
      {
        Support contacts{
            {left, right}, random_side(random), oracle::uniform(random, 0.0, 1.0), oracle::uniform(random, 0.0, 1.0)};
        if (check_contacts(robot, contacts))
          continue;
        for (int i = 0; i < kStates / 40; ++i)
        {
          CAPTURE(robot.name, name_of(left), name_of(right), i);
          const DesiredState desired = desired_of(robot, random_state(random, robot), contacts);
          const auto equations = std::get<SupportEquations>(support_equations(robot, desired));
          const Eigen::MatrixXd T =
              reaction_torques(robot, equations, contacts, admissible_reactions(robot, equations, contacts))
                  .T.topRows(robot.num_joints());
          for (const MethodRow& known : methods())
          {
            CAPTURE(known.name);
            const auto solved = solve_torques(robot, equations, contacts, known.method, {}, 1e-3);
            if (const Refusal* refusal = std::get_if<Refusal>(&solved))
            {
              // a foot of a made-up robot may hang on no joint that an internal wrench could load
              const Eigen::VectorXd sizes = oracle::singular_values(T);
              CHECK(refusal->reason() == Reason::numerical);
              CHECK((T.rows() < T.cols() || sizes.minCoeff() < 1e-8 * sizes.maxCoeff()));
              continue;
            }
            const TorqueSolution& found = std::get<TorqueSolution>(solved);
            ++answered;
            const double unit = 1.0 + std::max(found.w.cwiseAbs().maxCoeff(), equations.r.cwiseAbs().maxCoeff());
            CHECK(dynamics_residual(robot, equations, found) < 1e-9 * unit);
            if (known.method != Method::internal_wrench && known.method != Method::torso_wrench)
              continue;
            // its gradient along what (2) leaves free vanishes
            const Eigen::VectorXd slope = T.transpose() * found.torque;
            CHECK(slope.cwiseAbs().maxCoeff() < 1e-8 * unit * T.cwiseAbs().maxCoeff());
          }
        }
      }
  CHECK(answered > 500 * (kStates / 40));
}

TEST_CASE("methods stand in the order of their numbers, whatever order they are listed in", "[double_support]")
{
  std::vector<MethodRow> rows(methods().rbegin(), methods().rend());
  const std::vector<MethodRow> sorted = by_number(rows);
  for (std::size_t i = 0; i < sorted.size(); ++i)
  {
    CHECK(static_cast<std::size_t>(sorted[i].method) == i + 1);
    CHECK(sorted[i].name == methods()[i].name);
    CHECK(name_of(sorted[i].method) == sorted[i].name);
  }
  rows.back() = rows.front(); // one twice, one missing
  CHECK_THROWS_AS(by_number(rows), std::logic_error);
}

} // namespace double_support_test
