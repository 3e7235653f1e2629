#include "catch.h"
#include "matchers.h"
#include "oracles.h"

#include "methods/quadratic_program.h"

// CGAL's solver reckons with rational numbers: what it answers is exact
#include <CGAL/MP_Float.h>
#include <CGAL/QP_functions.h>
#include <CGAL/QP_models.h>

#include <cmath>

namespace exact_quadratic_program_test
{

using namespace torqued;

namespace
{

int whole(oracle::Random& random, int from, int to)
{
  return std::uniform_int_distribution<int>(from, to)(random);
}

/// A program of whole numbers.
struct WholeProgram
{
  Eigen::MatrixXi H, A;
  Eigen::VectorXi g, b;

  void add(const Eigen::VectorXi& a, int bound)
  {
    A.conservativeResize(A.rows() + 1, g.size());
    b.conservativeResize(A.rows());
    A.bottomRows(1) = a.transpose();
    b(b.size() - 1) = bound;
  }

  QuadraticProgram rounded() const
  {
    return {H.cast<double>(), g.cast<double>(), {A.cast<double>(), b.cast<double>(), {}}};
  }

  CGAL::Quadratic_program<int> exact() const
  {
    CGAL::Quadratic_program<int> program(CGAL::SMALLER, false, 0, false, 0);
    for (int i = 0; i < g.size(); ++i)
    {
      program.set_c(i, g(i));
      for (int j = 0; j <= i; ++j)
        program.set_d(i, j, H(i, j)); // it minimises yᵀ D y and is told 2 D
    }
    for (int i = 0; i < b.size(); ++i)
    {
      for (int j = 0; j < g.size(); ++j)
        program.set_a(j, i, A(i, j));
      program.set_b(i, b(i));
    }
    return program;
  }
};

Eigen::VectorXi whole_vector(oracle::Random& random, int n, int size)
{
  Eigen::VectorXi v(n);
  for (int& entry : v)
    entry = whole(random, -size, size);
  return v;
}

Eigen::MatrixXi whole_matrix(oracle::Random& random, int rows, int columns)
{
  Eigen::MatrixXi M(rows, columns);
  for (int& entry : M.reshaped())
    entry = whole(random, -3, 3);
  return M;
}

// Every third one with all rows through one point, every third one of equalities and cones. flat: H has no more than
// half of full rank, and g is such that the objective is bounded.
WholeProgram random_program(oracle::Random& random, int kind, int most_variables, bool flat = false)
{
  const int n = whole(random, 1, most_variables);
  const Eigen::MatrixXi M = whole_matrix(random, n, flat ? n / 2 : n);
  WholeProgram program{M * M.transpose(), Eigen::MatrixXi(0, n), whole_vector(random, n, 20), Eigen::VectorXi(0)};
  if (flat)
    program.g = M * whole_vector(random, n / 2, 5);
  else
    program.H += Eigen::MatrixXi::Identity(n, n);
  const Eigen::VectorXi inside = whole_vector(random, n, 3);
  const int count = whole(random, 0, 12);
  if (kind == 0)
    for (int i = 0; i < count; ++i)
      program.add(whole_vector(random, n, 4), whole(random, -2, 10));
  else if (kind == 1)
    for (int i = 0; i < count; ++i)
    {
      const Eigen::VectorXi a = whole_vector(random, n, 4);
      program.add(a, a.dot(inside));
    }
  else
  {
    const Eigen::VectorXi f = whole_vector(random, n, 2);
    const int least = whole(random, 0, 2);
    program.add(-f, -least);
    program.add(f, least + whole(random, -1, 1));
    for (int i = whole(random, 0, 3); i > 0; --i)
    {
      const Eigen::VectorXi a = whole_vector(random, n, 2);
      const int factor = whole(random, 0, 1);
      program.add(a - factor * f, 0);
      program.add(-a - factor * f, whole(random, 0, 1));
    }
  }
  return program;
}

} // namespace

TEST_CASE("the solution of whole numbers is the exact one", "[exact_quadratic_program]")
{
#ifdef NDEBUG
  constexpr int kPrograms = 2000;
#else
  constexpr int kPrograms = 200;
#endif
  oracle::Random random(1);
  const int most_variables = GENERATE(3, 8, kMaxVariables);
  CAPTURE(most_variables);
  int infeasible_ones = 0;
  for (int i = 0; i < kPrograms; ++i)
  {
    const WholeProgram program = random_program(random, i % 3, most_variables);
    const auto expected = CGAL::solve_quadratic_program(program.exact(), CGAL::MP_Float());
    const QuadraticProgramSolution found = solve(program.rounded());
    CAPTURE(i, program.H, program.g, program.A, program.b);
    REQUIRE((expected.is_optimal() || expected.is_infeasible()));
    REQUIRE(found.status ==
            (expected.is_optimal() ? QuadraticProgramStatus::optimal : QuadraticProgramStatus::infeasible));
    if (expected.is_infeasible())
    {
      ++infeasible_ones;
      continue;
    }
    Eigen::VectorXd y(program.g.size());
    auto value = expected.variable_values_begin();
    for (double& entry : y)
      entry = CGAL::to_double(*value++);
    // entries up to 30, in programs of order 1 to 100: what rounding leaves is below 1e-12
    CHECK(mismatch(found.y, y, 1e-10) == "");
    CHECK(kkt_residuals(program.rounded(), found.y, found.lambda).largest() <= 1e-12);
  }
  CHECK(infeasible_ones > 0.07 * kPrograms);
  CHECK(infeasible_ones < 0.6 * kPrograms);
}

TEST_CASE("a flat program of whole numbers has the exact gradient and value", "[exact_quadratic_program]")
{
#ifdef NDEBUG
  constexpr int kPrograms = 1500;
#else
  constexpr int kPrograms = 150;
#endif
  oracle::Random random(2);
  const int most_variables = GENERATE(3, 8, kMaxVariables);
  CAPTURE(most_variables);
  int optimal_ones = 0;
  for (int i = 0; i < kPrograms; ++i)
  {
    const WholeProgram program = random_program(random, i % 3, most_variables, true);
    const auto expected = CGAL::solve_quadratic_program(program.exact(), CGAL::MP_Float());
    const QuadraticProgram rounded = program.rounded();
    const QuadraticProgramSolution found =
        solve_semidefinite(rounded, BoundedVector<kMaxVariables>::Zero(program.g.size()));
    CAPTURE(i, program.H, program.g, program.A, program.b);
    REQUIRE((expected.is_optimal() || expected.is_infeasible()));
    REQUIRE(found.status ==
            (expected.is_optimal() ? QuadraticProgramStatus::optimal : QuadraticProgramStatus::infeasible));
    if (expected.is_infeasible())
      continue;
    ++optimal_ones;
    // several y may be the minimum, but all have one gradient, H y + g
    Eigen::VectorXd y(program.g.size());
    auto value = expected.variable_values_begin();
    for (double& entry : y)
      entry = CGAL::to_double(*value++);
    const Eigen::VectorXd gradient = rounded.H * found.y, exact = rounded.H * y;
    CHECK(mismatch(gradient, exact, 1e-9) == "");
    const auto value_at = [&](const Eigen::VectorXd& at)
    {
      return 0.5 * at.dot(rounded.H * at) + rounded.g.dot(at);
    };
    CHECK(std::abs(value_at(found.y) - value_at(y)) <= 1e-10 * (1.0 + std::abs(value_at(y))));
    CHECK(kkt_residuals(rounded, found.y, found.lambda).largest() <= 1e-12);
  }
  CHECK(optimal_ones > 0.4 * kPrograms);
}

} // namespace exact_quadratic_program_test
