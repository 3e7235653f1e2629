// Two ways to a least sum of squares, against each other and against what makes it least.

#include "catch.h"
#include "decompositions.h"
#include "matchers.h"
#include "oracles.h"

#include "stance/least_squares.h"

namespace least_squares_test
{

using namespace torqued;

namespace
{

constexpr int kRows = 12;

struct Sum
{
  Eigen::Matrix<double, kRows, 3> A;
  Eigen::Matrix<double, kRows, 1> b;

  explicit Sum(oracle::Random& random)
  {
    for (double& number : A.reshaped())
      number = oracle::uniform(random, -1.0, 1.0);
    for (double& number : b)
      number = oracle::uniform(random, -1.0, 1.0);
  }

  NormalEquations normal(int n) const
  {
    NormalEquations equations(n);
    equations.add<4>(A, b);
    equations.add<kRows - 4>(A.bottomRows<kRows - 4>(), b.tail<kRows - 4>());
    return equations;
  }
  std::optional<Eigen::Vector3d> by_gram_schmidt(int n, double rounding) const
  {
    SumOfSquares sum;
    sum.A.topRows<kRows>() = A;
    sum.b.head<kRows>() = b;
    sum.rows = kRows;
    sum.variables = n;
    return least_squares(sum, rounding);
  }
};

} // namespace

TEST_CASE("the residual of a least sum of squares is orthogonal to all columns, by either way", "[least_squares]")
{
  oracle::Random random(1);
  int both_ways = 0;
  for (int n = 1; n <= 3; ++n)
    for (int i = 0; i < 300; ++i)
    {
      CAPTURE(n, i);
      const Sum sum(random);
      const auto y = sum.by_gram_schmidt(n, 0.0);
      REQUIRE(y);
      CHECK((sum.A.leftCols(n).transpose() * (sum.A * *y + sum.b)).isZero(1e-13));
      CHECK(y->tail(3 - n).isZero(0.0));
      // columns of random numbers are far enough apart in all but a few sums, in which the other way does not answer
      if (const auto normal = sum.normal(n).solution(0.0))
      {
        CHECK(mismatch(*normal, *y, 1e-11) == "");
        ++both_ways;
      }
      else
      {
        CHECK(oracle::singular_values(sum.A.leftCols(n)).minCoeff() < 0.5);
      }
    }
  CAPTURE(both_ways);
  CHECK(both_ways > 800); // of 900
}

TEST_CASE("normal equations do not answer where they would lose digits", "[least_squares]")
{
  oracle::Random random(2);
  for (const double apart : {1e-2, 1e-4, 1e-6})
    for (int k = 1; k < 3; ++k)
    {
      CAPTURE(apart, k);
      Sum sum(random);
      sum.A.col(k) = sum.A.col(0) + apart * Sum(random).b;
      CHECK_FALSE(sum.normal(3).solution(0.0));
      // |A y + b|² is least where no small change makes it less; the other way finds it
      const auto y = sum.by_gram_schmidt(3, 0.0);
      REQUIRE(y);
      CHECK((sum.A.transpose() * (sum.A * *y + sum.b)).isZero(1e-13 * (1.0 + y->norm())));
    }
}

TEST_CASE("columns no longer than rounding have no least sum", "[least_squares]")
{
  oracle::Random random(3);
  Sum sum(random);
  sum.A *= 1e-9;
  CHECK_FALSE(sum.normal(3).solution(1e-8));
  CHECK_FALSE(sum.by_gram_schmidt(3, 1e-8));
  CHECK(sum.normal(3).solution(0.0));
}

} // namespace least_squares_test
