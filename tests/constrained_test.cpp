#include "double_support.h"
#include "matchers.h"
#include "methods/constrained.h"
#include "methods/least_torque.h"
#include "methods/torque_solution.h"
#include "states.h"

#include "methods/quadratic_program.h"
#include "stance/checks.h"

#include <functional>
#include <vector>

namespace constrained_test
{

using namespace torqued;
using oracle::Vector9;

namespace
{

constexpr Contact kLoaded[] = {Contact::heel, Contact::sole, Contact::toe};

enum class Kind
{
  contact,
  torque,
  window
};

// c·w ≤ bound, over what is much
struct Condition
{
  Kind kind;
  Eigen::VectorXd c;
  double bound;
};

// The conditions as geometry says them, on all of w.
std::vector<Condition> conditions(const Case& now, const MethodSettings& settings)
{
  const Constrained& constrained = settings.of<Constrained>();
  const Support& support = now.support();
  const double weight = now.robot.weight(), F_z = now.d()(1), p = support.phase, s = support.load_transfer;
  const Eigen::Index n_w = support.wrench_components();
  std::vector<Condition> all;
  const auto add = [&](Kind kind, const Eigen::VectorXd& c, double bound, double scale)
  {
    all.push_back({kind, c / scale, bound / scale});
  };
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  for (const Side side : kSides)
  {
    const bool leading = side == support.leading;
    const Foot& foot = now.robot.foot(side);
    const auto own = [&](const Eigen::Vector3d& of_foot)
    {
      Eigen::VectorXd c = Eigen::VectorXd::Zero(n_w);
      const int components = wrench_components(support.of(side));
      c.segment(support.row(side), components) = of_foot.head(components);
      return c;
    };
    double f_min = constrained.f_min.value_or(foot.f_min);
    if (constrained.windows)
    {
      std::optional<double> share;
      if (leading_sole && trailing_sole)
        share = std::min(1.0, leading ? 2.0 * s : 2.0 - 2.0 * s);
      else if ((leading_sole || trailing_sole) && support.of(side) != Contact::sole)
        share = leading ? p : 1.0 - p;
      if (share)
      {
        add(Kind::window, own({0.0, 1.0, 0.0}), *share * F_z, weight);
        f_min = std::min(f_min, std::max(0.0, *share * F_z));
      }
    }
    add(Kind::contact, own({0.0, -1.0, 0.0}), -f_min, weight);
    add(Kind::contact, own({1.0, -foot.friction, 0.0}), 0.0, weight);
    add(Kind::contact, own({-1.0, -foot.friction, 0.0}), 0.0, weight);
    if (support.of(side) != Contact::sole)
      continue;
    // pressure between heel and toe: its moment about the heel is not negative, about the toe not positive
    const Eigen::Vector2d ankle = now.biped.ankle(side, now.motion.X);
    const auto about = [&](const Eigen::Vector2d& point) -> Eigen::Vector3d
    {
      const Eigen::Vector2d r = point - ankle;
      return {r.y(), -r.x(), 1.0};
    };
    const Eigen::Vector2d heel = now.biped.contact_point(side, Contact::heel, now.motion.X);
    const Eigen::Vector2d toe = now.biped.contact_point(side, Contact::toe, now.motion.X);
    const double scale = weight * (toe - heel).norm();
    add(Kind::contact, own(-about(heel)), 0.0, scale);
    add(Kind::contact, own(about(toe)), 0.0, scale);
    if (constrained.windows && leading_sole != trailing_sole)
      add(Kind::window, own((leading ? 1.0 : -1.0) * about(heel + p * (toe - heel))), 0.0, scale);
  }
  // τ = B⁺ (r − Jᵀ w), column by column
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(n_w);
  Eigen::MatrixXd torque(6, n_w);
  for (Eigen::Index k = 0; k < n_w; ++k)
    torque.col(k) = now.torque(Eigen::VectorXd::Unit(n_w, k)) - now.torque(none);
  const Eigen::VectorXd rest = now.torque(none);
  for (int j = 0; j < 6; ++j)
  {
    const double limit = now.robot.actuators[static_cast<std::size_t>(j)].torque_limit;
    if (!std::isfinite(limit))
      continue;
    const double scale = std::max(limit, 1e-3 * weight * now.robot.leg_length);
    add(Kind::torque, torque.row(j).transpose(), limit - rest(j), scale);
    add(Kind::torque, -torque.row(j).transpose(), limit + rest(j), scale);
  }
  return all;
}

// Σ of squares of what conditions of a kind lack at w
double lacking(const std::vector<Condition>& all, Kind kind, const Eigen::VectorXd& w)
{
  double sum = 0.0;
  for (const Condition& condition : all)
    if (condition.kind == kind)
      sum += std::pow(std::max(0.0, condition.c.dot(w) - condition.bound), 2);
  return sum;
}

// A quadratic program on what serves the motion, and its solution by trying every set of active conditions.
struct Program
{
  Eigen::VectorXd one;
  Eigen::MatrixXd others;
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  std::vector<Condition> all;

  std::optional<Eigen::VectorXd> solve(bool windows) const
  {
    const Eigen::Index n = g.size();
    std::vector<Eigen::VectorXd> a;
    std::vector<double> b;
    for (const Condition& condition : all)
      if (windows || condition.kind != Kind::window)
      {
        a.emplace_back(others.transpose() * condition.c);
        b.push_back(condition.bound - condition.c.dot(one));
      }
    std::optional<Eigen::VectorXd> best;
    double least = std::numeric_limits<double>::infinity();
    std::vector<std::size_t> active;
    const auto try_active = [&]
    {
      const auto k = static_cast<Eigen::Index>(active.size());
      Eigen::MatrixXd KKT = Eigen::MatrixXd::Zero(n + k, n + k);
      Eigen::VectorXd rhs(n + k);
      KKT.topLeftCorner(n, n) = H;
      rhs.head(n) = -g;
      for (Eigen::Index i = 0; i < k; ++i)
      {
        KKT.col(n + i).head(n) = a[active[static_cast<std::size_t>(i)]];
        KKT.row(n + i).head(n) = a[active[static_cast<std::size_t>(i)]].transpose();
        rhs(n + i) = b[active[static_cast<std::size_t>(i)]];
      }
      const Eigen::VectorXd y = oracle::solve_square(KKT, rhs).head(n);
      if (!y.allFinite())
        return;
      for (std::size_t i = 0; i < a.size(); ++i)
        if (!(a[i].dot(y) - b[i] <= 1e-9))
          return;
      const double value = 0.5 * y.dot(H * y) + g.dot(y);
      if (value < least)
      {
        least = value;
        best = y;
      }
    };
    const std::function<void(std::size_t)> extend = [&](std::size_t from)
    {
      try_active();
      if (static_cast<Eigen::Index>(active.size()) == n)
        return;
      for (std::size_t i = from; i < a.size(); ++i)
      {
        active.push_back(i);
        extend(i + 1);
        active.pop_back();
      }
    };
    extend(0);
    if (!best)
      return {};
    return Eigen::VectorXd(one + others * *best);
  }
};

Program program(const Case& now, const MethodSettings& settings)
{
  const Constrained& constrained = settings.of<Constrained>();
  Program program{now.one(), now.others(), {}, {}, conditions(now, settings)};
  // columns of one size, so that tolerances mean the same for each
  program.others = now.robot.weight() * program.others.colwise().normalized();
  const Eigen::Index n = program.others.cols();
  const Eigen::VectorXd tau = now.torque(program.one);
  Eigen::MatrixXd T(6, n);
  for (Eigen::Index k = 0; k < n; ++k)
    T.col(k) = now.torque(program.one + program.others.col(k)) - tau;
  const Eigen::MatrixXd W =
      constrained.weights.size() > 0 ? Eigen::MatrixXd(constrained.weights) : Eigen::MatrixXd::Identity(6, 6);
  program.H = T.transpose() * W * T;
  program.g = T.transpose() * W * tau;
  if (constrained.reference_weight > 0.0)
  {
    Eigen::VectorXd V(program.one.size());
    V.setConstant(std::pow(now.robot.leg_length, 2));
    for (const Side side : kSides)
      if (now.support().of(side) == Contact::sole)
        V(now.support().row(side) + 2) = 1.0;
    const Eigen::MatrixXd kV = constrained.reference_weight * V.asDiagonal();
    const Eigen::VectorXd off = program.one - Eigen::VectorXd(now.solution(Method::zmp_transition).w);
    program.H += program.others.transpose() * kV * program.others;
    program.g += program.others.transpose() * kV * off;
  }
  const double scale = program.H.trace();
  program.H /= scale;
  program.g /= scale;
  return program;
}

std::int32_t flags(const Case& now, const TorqueSolution& solution)
{
  std::int32_t flags = 0;
  for (const Side side : kSides)
    flags |= contact_flags(now.robot, now.robot.foot(side), now.equations.foot(side), now.support().of(side),
                           solution.ground[static_cast<std::size_t>(side)]);
  for (std::size_t j = 0; j < now.robot.actuators.size(); ++j)
    if (std::abs(solution.torque(static_cast<int>(j))) > now.robot.actuators[j].torque_limit * (1.0 + 1e-7))
      flags |= flag::over_torque;
  return flags;
}

// A walking robot with both feet on the ground; x_zmp between the outermost points that can carry, or beyond.
Case walking(oracle::Random& random, int i, Contact left, Contact right, double beyond)
{
  const Stance stance{left, right, i % 4 < 2 ? Side::left : Side::right};
  auto [biped, motion] = posed(random, i, stance);
  // named, because Clang captures structured bindings by themselves only from version 16
  const auto reach = [&, &biped = biped, &motion = motion](Side side, Contact contact, Contact end)
  {
    return biped.contact_point(side, contact == Contact::sole ? end : contact, motion.X).x();
  };
  const double from = reach(other(stance.leading), stance.leading == Side::left ? right : left, Contact::heel);
  const double to = reach(stance.leading, stance.leading == Side::left ? left : right, Contact::toe);
  ask_of_ground(random, biped, stance, from + oracle::uniform(random, -beyond, 1.0 + beyond) * (to - from), motion);
  Robot robot = biped.robot();
  for (Actuator& actuator : robot.actuators)
    actuator.torque_limit =
        oracle::uniform(random, 0.0, 1.0) < 0.5 ? oracle::uniform(random, 50.0, 400.0) : actuator.torque_limit;
  // each at its ends, too, and never both at the same one
  const auto or_end = [&](double share, double first)
  {
    return i % 7 == 0 ? first : i % 7 == 1 ? 1.0 - first : share;
  };
  const double p = or_end(oracle::uniform(random, 0.0, 1.0), 0.0), s = or_end(oracle::uniform(random, 0.0, 1.0), 1.0);
  return Case(biped, robot, motion, left, right, stance.leading, s, p);
}

MethodSettings random_settings(oracle::Random& random, int i)
{
  MethodSettings settings;
  if (i % 3 != 0)
  {
    Eigen::MatrixXd root(6, 6);
    for (double& entry : root.reshaped())
      entry = oracle::uniform(random, -1.0, 1.0);
    settings.of<Constrained>().weights = root * root.transpose() + 0.2 * Eigen::MatrixXd::Identity(6, 6);
  }
  if (i % 5 == 1)
    settings.of<Constrained>().reference_weight = std::pow(10.0, oracle::uniform(random, -3.0, 1.0));
  if (i % 5 == 2)
    settings.of<Constrained>().f_min = oracle::uniform(random, 0.0, 100.0);
  return settings;
}

// Trying every active set costs some milliseconds a case.
constexpr int kEnumerated = kCases > 100 ? 60 : 2;

} // namespace

TEST_CASE("constrained is the least torque that meets all conditions, wherever trying every active set finds one",
          "[constrained]")
{
  oracle::Random random(601);
  int feasible = 0, relaxed_windows = 0, infeasible = 0;
  for (const Contact left : kLoaded)
    for (const Contact right : kLoaded)
      for (int i = 0; i < kEnumerated; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const Case now = walking(random, i, left, right, 0.2);
        const MethodSettings settings = random_settings(random, i);
        const Program oracle = program(now, settings);
        const TorqueSolution found = now.solution(Method::constrained, settings);
        const double unit = size(now, found);
        const std::optional<Eigen::VectorXd> expected = oracle.solve(true);
        CHECK(found.relaxed == !expected);
        if (expected)
        {
          ++feasible;
          CHECK((now.torque(*expected) - found.torque).cwiseAbs().maxCoeff() < 1e-8 * unit);
          CHECK((*expected - found.w).cwiseAbs().maxCoeff() < 1e-6 * unit);
          CHECK(flags(now, found) == 0);
          for (const Kind kind : {Kind::contact, Kind::torque, Kind::window})
            CHECK(lacking(oracle.all, kind, found.w) < 1e-18);
          continue;
        }
        MethodSettings refusing = settings;
        refusing.infeasible = OnInfeasible::refuse;
        if (oracle.solve(false))
        {
          // only the windows gave way; that is no refusal
          ++relaxed_windows;
          CHECK(flags(now, found) == 0);
          CHECK(now.solution(Method::constrained, refusing).relaxed);
        }
        else
        {
          ++infeasible;
          CHECK((flags(now, found) != 0 || settings.of<Constrained>().f_min));
          const auto refused = now.solve(Method::constrained, refusing);
          REQUIRE(std::holds_alternative<Refusal>(refused));
          CHECK(std::get<Refusal>(refused).reason() == Reason::infeasible);
        }
      }
  const int cases = feasible + relaxed_windows + infeasible;
  CHECK(feasible > cases / 5);
  CHECK(relaxed_windows > cases / 50);
  CHECK(infeasible > cases / 10);
}

TEST_CASE("what cannot be met lacks least: contacts hold the longest, then motors, then windows", "[constrained]")
{
  oracle::Random random(602);
  int relaxed = 0;
  for (const Contact left : kLoaded)
    for (const Contact right : kLoaded)
      for (int i = 0; i < kCases / 4; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const Case now = walking(random, i, left, right, 0.4);
        const MethodSettings settings = random_settings(random, i);
        const TorqueSolution found = now.solution(Method::constrained, settings);
        if (!found.relaxed)
          continue;
        ++relaxed;
        const std::vector<Condition> all = conditions(now, settings);
        const double contact = lacking(all, Kind::contact, found.w), torque = lacking(all, Kind::torque, found.w);
        const double window = lacking(all, Kind::window, found.w);
        CHECK(contact + torque + window > 1e-18);
        // no other reaction is better in that order: tried near and far
        const Eigen::MatrixXd others = now.others().colwise().normalized();
        for (int k = 0; k < 60; ++k)
        {
          Eigen::VectorXd way(others.cols());
          for (double& entry : way)
            entry = oracle::uniform(random, -1.0, 1.0);
          const double far = std::pow(10.0, oracle::uniform(random, -4.0, 3.0));
          const Eigen::VectorXd w = Eigen::VectorXd(found.w) + far * (others * way);
          // relaxed rows have room for rounding, 1e-9 of contacts, 1e-8 of motors and windows; what one row gains
          // another may lose some ten times over, and v changes v² by 2 v
          const auto slack = [](double sum, double room)
          {
            return 100.0 * room * std::sqrt(sum) + 100.0 * room * room;
          };
          const double other_contact = lacking(all, Kind::contact, w);
          REQUIRE(other_contact > contact - slack(contact, 1e-9));
          if (other_contact > contact)
            continue;
          const double other_torque = lacking(all, Kind::torque, w);
          REQUIRE(other_torque > torque - slack(torque, 1e-8));
          if (other_torque <= torque)
            REQUIRE(lacking(all, Kind::window, w) > window - slack(window, 1e-8));
        }
      }
  CHECK(relaxed > 50 * kCases / 500);
}

TEST_CASE("windows that give way alone lack no more than they must, and then the torque is the least", "[constrained]")
{
  oracle::Random random(607);
  int relaxed = 0, dearer = 0;
  for (const Contact left : kLoaded)
    for (const Contact right : kLoaded)
      for (int i = 0; i < kCases / 2; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const Case now = walking(random, i, left, right, 0.0);
        const MethodSettings settings = random_settings(random, i);
        const TorqueSolution found = now.solution(Method::constrained, settings);
        const Program sought = program(now, settings);
        if (!found.relaxed ||
            lacking(sought.all, Kind::contact, found.w) + lacking(sought.all, Kind::torque, found.w) > 1e-18)
          continue;

        // first the least violation of windows alone, then the least torque with windows no wider than that
        const Eigen::Index n = sought.g.size(), m = static_cast<Eigen::Index>(sought.all.size());
        QuadraticProgram staged{sought.H, sought.g, {{}, {}, {}}};
        staged.rows.A.resize(m, n);
        staged.rows.b.resize(m);
        for (Eigen::Index row = 0; row < m; ++row)
        {
          const Condition& condition = sought.all[static_cast<std::size_t>(row)];
          staged.rows.A.row(row) = condition.c.transpose() * sought.others;
          staged.rows.b(row) = condition.bound - condition.c.dot(sought.one);
          staged.rows.soft[static_cast<std::size_t>(row)] = condition.kind == Kind::window;
        }
        const QuadraticProgramSolution least = least_violation(staged.rows, Eigen::VectorXd::Zero(n));
        REQUIRE(least.status == QuadraticProgramStatus::optimal);
        for (Eigen::Index row = 0; row < m; ++row)
          staged.rows.b(row) = std::max(staged.rows.b(row), staged.rows.A.row(row).dot(least.y)) + 1e-9;
        staged.rows.soft.reset();
        const QuadraticProgramSolution expected = solve(staged);
        REQUIRE(expected.status == QuadraticProgramStatus::optimal);
        ++relaxed;

        // relaxed rows have 1e-8 of room; some conditions pass that on enlarged
        const auto lack = [&](const Eigen::VectorXd& w)
        {
          return std::sqrt(lacking(sought.all, Kind::window, w));
        };
        CHECK(lack(found.w) <= lack(sought.one + sought.others * least.y) + 1e-6);
        const auto cost = [&](const Eigen::VectorXd& w)
        {
          const Eigen::VectorXd y = oracle::solve(sought.others, w - sought.one);
          return 0.5 * y.dot(sought.H * y) + sought.g.dot(y);
        };
        const double at_least = cost(sought.one + sought.others * expected.y);
        CHECK(cost(found.w) <= at_least + 1e-5 * std::max(1.0, std::abs(at_least)));
        const QuadraticProgramSolution without =
            solve({sought.H, sought.g, {Bounded<kMaxRows, 3>(0, n), BoundedVector<kMaxRows>(0), {}}});
        dearer += at_least > cost(sought.one + sought.others * without.y) + 1e-3 ? 1 : 0;
      }
  CHECK(relaxed > kCases / 10);
  CHECK(dearer > relaxed / 2); // or it would not matter whether windows come first
}

TEST_CASE("where no condition is active constrained is procedure 1, else it costs more, and with windows still more",
          "[constrained][slow]")
{
  oracle::Random random(603);
  int inactive = 0, active = 0, windowed = 0;
  for (const Contact left : kLoaded)
    for (const Contact right : kLoaded)
      for (int i = 0; i < 2 * kCases; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const Case now = walking(random, i, left, right, 0.0);
        MethodSettings settings = random_settings(random, 3 * i + (i % 2 == 0 ? 0 : 1)); // W or none, no reference
        settings.of<Constrained>().reference_weight = 0.0;
        settings.of<Constrained>().f_min = 0.0; // a window may lower it
        settings.of<Constrained>().windows = false;
        settings.of<InternalWrench>().weights = settings.of<Constrained>().weights;
        const Eigen::MatrixXd W = settings.of<Constrained>().weights.size() > 0
                                      ? Eigen::MatrixXd(settings.of<Constrained>().weights)
                                      : Eigen::MatrixXd::Identity(6, 6);
        const auto cost = [&](const TorqueSolution& solution)
        {
          return 0.5 * solution.torque.dot(W * solution.torque);
        };
        const TorqueSolution free = now.solution(Method::internal_wrench, settings);
        const TorqueSolution plain = now.solution(Method::constrained, settings);
        bool meets = true;
        for (const Condition& condition : conditions(now, settings))
          meets = meets && condition.c.dot(Eigen::VectorXd(free.w)) <= condition.bound;
        if (meets)
        {
          ++inactive;
          CHECK((plain.torque - free.torque).cwiseAbs().maxCoeff() < 1e-8 * size(now, free));
        }
        if (plain.relaxed)
          continue;
        active += meets ? 0 : 1;
        CHECK(cost(plain) >= cost(free) * (1.0 - 1e-9));
        settings.of<Constrained>().windows = true;
        const TorqueSolution windows = now.solution(Method::constrained, settings);
        if (windows.relaxed)
          continue;
        ++windowed;
        CHECK(cost(windows) >= cost(plain) * (1.0 - 1e-9));
      }
  CAPTURE(inactive, active, windowed);
  CHECK(windowed > kCases);
  CHECK(inactive > kCases / 10);
  CHECK(active > kCases);
}

TEST_CASE("a heavy reference leads to the reactions of zmp_transition", "[constrained]")
{
  oracle::Random random(604);
  int cases = 0, kept = 0; // kept: references that meet all conditions
  for (const Contact left : kLoaded)
    for (const Contact right : kLoaded)
      for (int i = 0; i < kCases / 10 + 1; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        Case now = walking(random, i, left, right, 0.0);
        for (Actuator& actuator : now.robot.actuators)
          actuator.torque_limit = std::numeric_limits<double>::infinity();
        MethodSettings settings;
        settings.of<Constrained>().windows = false;
        settings.of<Constrained>().reference_weight = 1e7;
        const TorqueSolution reference = now.solution(Method::zmp_transition);
        ++cases;
        if (flags(now, reference) != 0)
          continue;
        ++kept;
        const TorqueSolution found = now.solution(Method::constrained, settings);
        CHECK((found.w - reference.w).cwiseAbs().maxCoeff() < 1e-4 * now.robot.weight());
      }
  CAPTURE(cases, kept);
  CHECK(kept > cases / 10);
}

TEST_CASE("a foot's least load is kept, as far as the window leaves it", "[constrained]")
{
  oracle::Random random(605);
  int bound = 0;
  for (int i = 0; i < kCases; ++i)
  {
    CAPTURE(i);
    Case now = walking(random, i, Contact::sole, Contact::sole, 0.0);
    for (Actuator& actuator : now.robot.actuators)
      actuator.torque_limit = std::numeric_limits<double>::infinity();
    const double F_z = now.d()(1), s = now.support().load_transfer;
    const double f_min = 0.1 * now.robot.weight();
    for (Foot& foot : now.robot.feet)
      foot.f_min = f_min;
    const TorqueSolution found = now.solution(Method::constrained);
    if (found.relaxed)
      continue;
    const auto load = [&](Side side)
    {
      return found.ground[static_cast<std::size_t>(side)].fz;
    };
    const double room = 1e-8 * now.robot.weight();
    const double leading = std::min(f_min, 2.0 * s * F_z), trailing = std::min(f_min, 2.0 * (1.0 - s) * F_z);
    CHECK(load(now.support().leading) > leading - room);
    CHECK(load(now.support().trailing()) > trailing - room);
    bound += load(now.support().leading) < leading + room || load(now.support().trailing()) < trailing + room ? 1 : 0;
    // the setting stands above the robot's
    MethodSettings settings;
    settings.of<Constrained>().f_min = 0.0;
    settings.of<Constrained>().windows = false;
    MethodSettings windows = settings;
    windows.of<Constrained>().windows = true;
    const Case without = [&]
    {
      Case copy = now;
      for (Foot& foot : copy.robot.feet)
        foot.f_min = 0.0;
      return copy;
    }();
    CHECK(now.solution(Method::constrained, windows).torque == without.solution(Method::constrained).torque);
  }
  CHECK(bound > kCases / 50);
}

TEST_CASE("every motor keeps its limit, however many there are", "[constrained]")
{
  oracle::Random random(608);
  int robots = 0, bound = 0;
  for (Robot robot : all_kinds_of_motors())
  {
    if (robot.num_joints() <= kJointBlock)
      continue;
    ++robots;
    for (const Contact left : kLoaded)
      for (const Contact right : kLoaded)
      {
        const Support contacts{{left, right}, Side::left, 0.5, 0.5};
        if (check_contacts(robot, contacts))
          continue;
        for (int i = 0; i < kStates / 20; ++i)
        {
          CAPTURE(robot.name, name_of(left), name_of(right), i);
          const DesiredState desired = desired_of(robot, random_state(random, robot), contacts);
          const auto equations = std::get<SupportEquations>(support_equations(robot, desired));
          const auto solve = [&]
          {
            return solve_torques(robot, equations, contacts, Method::constrained, {}, 1e-3);
          };
          for (Actuator& motor : robot.actuators)
            motor.torque_limit = std::numeric_limits<double>::infinity();
          const auto free = solve();
          if (std::holds_alternative<Refusal>(free))
            continue;
          const VectorJ torque = std::get<TorqueSolution>(free).torque;
          // one motor at a time has a little less than it would have
          for (int j = 0; j < robot.num_joints(); ++j)
          {
            for (int k = 0; k < robot.num_joints(); ++k)
              robot.actuators[static_cast<std::size_t>(k)].torque_limit = (k == j ? 0.999 : 2.0) * std::abs(torque(k));
            const auto limited = solve();
            if (std::holds_alternative<Refusal>(limited))
              continue;
            const TorqueSolution& found = std::get<TorqueSolution>(limited);
            if (found.relaxed)
              continue;
            for (int k = 0; k < robot.num_joints(); ++k)
              CHECK(std::abs(found.torque(k)) <=
                    robot.actuators[static_cast<std::size_t>(k)].torque_limit * (1.0 + 1e-7));
            bound += j >= kJointBlock ? 1 : 0;
          }
        }
      }
  }
  CHECK(robots > 0);
  CHECK(bound > 0);
}

TEST_CASE("no friction, no torque, weights of a millionth: conditions hold or give way, and the numbers stay finite",
          "[constrained]")
{
  oracle::Random random(606);
  for (const Contact left : kLoaded)
    for (const Contact right : kLoaded)
      for (int i = 0; i < kCases / 10 + 1; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        Case now = walking(random, i, left, right, 0.1);
        MethodSettings settings;
        if (i % 3 == 0)
          for (Foot& foot : now.robot.feet)
            foot.friction = 0.0;
        if (i % 3 == 1)
          for (Actuator& actuator : now.robot.actuators)
            actuator.torque_limit = 0.0;
        if (i % 3 == 2)
          settings.of<Constrained>().weights = Eigen::VectorXd::LinSpaced(6, 1e-6, 1e-5).asDiagonal();
        const TorqueSolution found = now.solution(Method::constrained, settings);
        CHECK(found.torque.allFinite());
        CHECK(dynamics_residual(now.robot, now.equations, found) < 1e-9 * size(now, found));
        if (i % 3 == 0)
        {
          // the total horizontal force has to come from somewhere
          CHECK(found.relaxed);
          CHECK((flags(now, found) & flag::slips) != 0);
        }
        if (i % 3 == 1)
        {
          CHECK(found.relaxed);
          CHECK((flags(now, found) & flag::over_torque) != 0);
        }
      }
}

TEST_CASE("standing straight with the feet together, where weights do not tell reactions apart, both feet share",
          "[constrained]")
{
  const oracle::Biped ck;
  oracle::Motion motion;
  motion.X << 0, 0, 0, 0, 0, 0, 0, 0, 0.855;
  motion.V.setZero();
  motion.A.setZero();
  const Case now(ck, motion, Contact::sole, Contact::sole, Side::left, 0.5, 0.5);
  const TorqueSolution found = now.solution(Method::constrained);
  CHECK_FALSE(found.relaxed);
  CHECK(flags(now, found) == 0);
  CHECK(mismatch(found.ground[0].fz, 0.5 * now.robot.weight(), 1e-6) == "");
  CHECK(mismatch(found.torque, found.torque.reverse(), 1e-6) == "");

  const auto refused = now.solve(Method::internal_wrench);
  REQUIRE(std::holds_alternative<Refusal>(refused));
  CHECK(std::get<Refusal>(refused).reason() == Reason::numerical);
  CHECK(std::string(std::get<Refusal>(refused).detail()).starts_with("an internal wrench between the feet needs no"));

  // a little apart they are told apart, and the torques hardly change
  motion.X << 0, 0.01, -0.01, 0.01, -0.01, 0, 0, 0, 0.855;
  const TorqueSolution apart =
      Case(ck, motion, Contact::sole, Contact::sole, Side::left, 0.5, 0.5).solution(Method::constrained);
  CHECK((apart.torque - found.torque).cwiseAbs().maxCoeff() < 3.0);
}

TEST_CASE("with nothing to choose the method is none, and conditions show as flags", "[constrained]")
{
  oracle::Random random(607);
  const Stance stance{Contact::sole, Contact::heel, Side::right};
  auto [biped, motion] = posed(random, 0, stance);
  ask_of_ground(random, biped, stance, biped.contact_point(Side::left, Contact::toe, motion.X).x() + 0.1, motion);
  Case now(biped, motion, Contact::sole, Contact::none, Side::left, 0.0, 0.0);
  MethodSettings settings;
  settings.infeasible = OnInfeasible::refuse;
  const TorqueSolution found = now.solution(Method::constrained, settings);
  CHECK(found.method == Method::none);
  CHECK_FALSE(found.relaxed);
  CHECK((flags(now, found) & flag::tips) != 0);
}

} // namespace constrained_test
