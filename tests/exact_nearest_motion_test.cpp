#include "catch.h"
#include "matchers.h"
#include "nearest_samples.h"

// CGAL's solver reckons with rational numbers: what it answers is exact
#include <CGAL/MP_Float.h>
#include <CGAL/QP_functions.h>
#include <CGAL/QP_models.h>

namespace exact_nearest_motion_test
{

using namespace torqued;
using oracle::Answered;
using oracle::NearestProblem;

namespace
{

using Program = CGAL::Quadratic_program<double>;

// A program in the y of NearestProblem::reduced(), and, if conditions may be lacking, in what each of them lacks.
struct Exact
{
  NearestProblem::Reduced all;
  Eigen::VectorXd torque_unit;
  Program program{CGAL::LARGER, false, 0, false, 0};
  int rows = 0;

  explicit Exact(const NearestProblem& problem) : all(problem.reduced()), torque_unit(problem.torque_unit)
  {
    for (int j = 0; j < torque_unit.size(); ++j)
      if (std::isfinite(problem.most(j)))
      {
        const Eigen::VectorXd row = all.torque_y.row(j).transpose() / torque_unit(j);
        add(row, (problem.least(j) - all.torque0(j)) / torque_unit(j));
        add(-row, (all.torque0(j) - problem.most(j)) / torque_unit(j));
      }
  }
  int add(const Eigen::VectorXd& row, double bound)
  {
    for (int k = 0; k < row.size(); ++k)
      program.set_a(k, rows, row(k));
    program.set_b(rows, bound);
    return rows++;
  }
  int add_condition(const NearestProblem& problem, int i)
  {
    const Eigen::VectorXd g = problem.conditions.G.row(i).transpose();
    return add(all.w_y.transpose() * g, problem.conditions.h(i) - g.dot(all.w0));
  }
  int variables() const { return static_cast<int>(all.size.size()); }
  // the first n variables; nothing if none keep all rows
  std::optional<Eigen::VectorXd> solve(int n) const
  {
    CGAL::Quadratic_program_options options;
    options.set_pricing_strategy(CGAL::QP_BLAND); // by others some of these programs are taken for unbounded
    const auto solution = CGAL::solve_quadratic_program(program, CGAL::MP_Float(), options);
    REQUIRE((solution.is_optimal() || solution.is_infeasible()));
    if (solution.is_infeasible())
      return {};
    Eigen::VectorXd y(n);
    auto value = solution.variable_values_begin();
    for (double& entry : y)
      entry = CGAL::to_double(*value++);
    return y;
  }
};

// the motion nearest to a_d; nothing if no motion keeps all
std::optional<Eigen::VectorXd> exact_motion(const NearestProblem& problem)
{
  Exact exact(problem);
  for (int i = 0; i < problem.conditions.h.size(); ++i)
    exact.add_condition(problem, i);
  for (int k = 0; k < exact.variables(); ++k)
  {
    exact.program.set_d(k, k, exact.all.size(k) * exact.all.size(k)); // it minimises yᵀ D y and is told 2 D
    exact.program.set_c(k, exact.all.size(k) * exact.all.at(k));
  }
  const auto y = exact.solve(exact.variables());
  if (!y)
    return {};
  return Eigen::VectorXd(exact.all.a0 + exact.all.a_y * *y);
}

// what conditions lack at the least, in least squares
Eigen::VectorXd exact_violation(const NearestProblem& problem)
{
  Exact exact(problem);
  const int n = exact.variables(), lacks = static_cast<int>(problem.conditions.h.size());
  for (int i = 0; i < lacks; ++i)
  {
    exact.program.set_a(n + i, exact.add_condition(problem, i), 1.0);
    exact.program.set_d(n + i, n + i, 1.0);
  }
  return exact.solve(n + lacks).value().tail(lacks);
}

#ifdef NDEBUG
constexpr int kExact = 25; // of each contact pair
constexpr int kLacking = 2;
#else
constexpr int kExact = 2;
constexpr int kLacking = 1;
#endif

} // namespace

TEST_CASE("the nearest motion is the exact one", "[exact_nearest_motion][slow]")
{
  const NearestRobots robots;
  int programs = 0;
  for (const Contact left : kContacts)
    for (const Contact right : kContacts)
    {
      oracle::Random random(81100 + 4 * static_cast<unsigned>(left) + static_cast<unsigned>(right));
      for (int i = 0; i < kExact; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const NearestSample sample = random_sample(random, robots, left, right, i);
        const NearestProblem problem = sample.problem();
        const Answer answer = sample.answer();
        const auto expected = exact_motion(problem);
        if (!expected)
        {
          CHECK((answer.flags & flag::relaxed) != 0);
          continue;
        }
        ++programs;
        // motors stay by rounding within their range, 1e-10 of weight × leg length: light shins are moved by that
        CHECK(mismatch(oracle::answered(sample.robot, sample.desired, answer).a, *expected, 1e-7) == "");
      }
    }
  CHECK(programs > 15 * kExact);
}

TEST_CASE("where nothing keeps all conditions, they lack the exact least", "[exact_nearest_motion]")
{
  const NearestRobots robots;
  for (const Contact left : kContacts)
    for (const Contact right : kContacts)
    {
      if (left == Contact::none && right == Contact::none)
        continue;
      oracle::Random random(81200 + 4 * static_cast<unsigned>(left) + static_cast<unsigned>(right));
      int programs = 0;
      for (int i = 0; programs < kLacking && i < 10'000; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const NearestSample sample = random_sample(random, robots, left, right, i);
        const NearestProblem problem = sample.problem();
        if (problem.feasible() != NearestProblem::Feasible::no)
          continue;
        ++programs;
        CHECK_FALSE(exact_motion(problem));
        const Answered found = oracle::answered(sample.robot, sample.desired, sample.answer());
        // of the weight; conditions that give way have some room
        CHECK(mismatch(problem.lacking(found), exact_violation(problem), 1e-5) == "");
      }
      CHECK(programs == kLacking);
    }
}

} // namespace exact_nearest_motion_test
