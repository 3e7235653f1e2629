#include "catch.h"
#include "decompositions.h"
#include "matchers.h"
#include "oracles.h"

#include "methods/quadratic_program.h"

#include <Eigen/LU>

namespace quadratic_program_test
{

using namespace torqued;
using enum QuadraticProgramStatus;

namespace
{

#ifdef NDEBUG
constexpr int kPrograms = 12000;
#else
constexpr int kPrograms = 600;
#endif

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using oracle::uniform;

int whole(oracle::Random& random, int from, int to)
{
  return std::uniform_int_distribution<int>(from, to)(random);
}

Eigen::VectorXd vector(oracle::Random& random, int n, double from = -1.0, double to = 1.0)
{
  Eigen::VectorXd v(n);
  for (int i = 0; i < n; ++i)
    v(i) = uniform(random, from, to);
  return v;
}

// Its rows and columns are of order 1; the condition number is up to some 100 times that given.
Eigen::MatrixXd positive(oracle::Random& random, int n, double condition = 1.0)
{
  Eigen::MatrixXd M(n, n);
  for (int i = 0; i < n; ++i)
    M.col(i) = vector(random, n);
  const Eigen::MatrixXd Q = oracle::orthogonal(M);
  Eigen::VectorXd eigenvalues = vector(random, n, 0.1, 10.0);
  if (n > 0)
    eigenvalues(0) /= condition;
  const Eigen::MatrixXd H = Q * eigenvalues.asDiagonal() * Q.transpose();
  return 0.5 * (H + H.transpose());
}

/// Rows one by one.
struct RowList
{
  std::vector<Eigen::VectorXd> a;
  std::vector<double> b;

  void add(const Eigen::VectorXd& normal, double bound)
  {
    a.push_back(normal);
    b.push_back(bound);
  }
  int size() const { return static_cast<int>(b.size()); }
};

QuadraticProgram program_of(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const RowList& list)
{
  QuadraticProgram program{H, g, {{}, {}, {}}};
  program.rows.A.resize(list.size(), g.size());
  program.rows.b.resize(list.size());
  for (int i = 0; i < list.size(); ++i)
  {
    program.rows.A.row(i) = list.a[static_cast<std::size_t>(i)].transpose();
    program.rows.b(i) = list.b[static_cast<std::size_t>(i)];
  }
  return program;
}

/// What a random program's rows have in common.
enum class Kind
{
  generic,
  different_sizes, ///< of rows, and some rows twice
  equalities,      ///< as two opposite rows, which meet
  cones,           ///< |x| ≤ μ f, |z| ≤ l f with f in [0, 0] or more
  turned_cones,    ///< in other variables
  vertex,          ///< every row through one point
  whole_numbers,
  nearly_parallel, ///< through one point or not, directions that differ by 1e-3 to 1e-6
  bad_condition,   ///< of H, up to 1e10
  closed,          ///< rows whose positive combination leaves only one point or face
  contradiction,   ///< the same, and leaves nothing
};
constexpr int kKinds = 11;

// fewest, most: variables
QuadraticProgram random_program(oracle::Random& random, Kind kind, int fewest = 0, int most = 3)
{
  if (kind == Kind::cones || kind == Kind::turned_cones || kind == Kind::nearly_parallel)
    fewest = std::max(fewest, 2);
  const int n = whole(random, fewest, most);
  const Eigen::VectorXd inside = vector(random, n);
  Eigen::MatrixXd H =
      positive(random, n, kind == Kind::bad_condition ? std::pow(10.0, uniform(random, 2.0, 8.0)) : 1.0);
  Eigen::VectorXd g = vector(random, n, -5.0, 5.0);
  RowList rows;
  // rows that `inside` meets, some with equality
  const auto add_feasible = [&](int count)
  {
    for (int i = 0; i < count; ++i)
    {
      const Eigen::VectorXd a = vector(random, n);
      rows.add(a, a.dot(inside) + std::max(0.0, uniform(random, -0.5, 1.0)));
    }
  };

  switch (kind)
  {
  case Kind::bad_condition:
  case Kind::generic:
    for (int i = whole(random, 0, 20); i > 0; --i)
      rows.add(vector(random, n), uniform(random, -0.3, 1.0));
    break;
  case Kind::different_sizes:
    for (int i = whole(random, 0, 10); i > 0; --i)
    {
      const Eigen::VectorXd a = vector(random, n);
      const double b = uniform(random, -0.3, 1.0);
      rows.add(a, b);
      const double factor = std::pow(10.0, uniform(random, -1.0, 3.0));
      rows.add(factor * a, factor * (b + std::max(0.0, uniform(random, -0.5, 0.5))));
    }
    break;
  case Kind::equalities:
    for (int i = whole(random, 1, std::max(1, n)); i > 0; --i)
    {
      const Eigen::VectorXd a = vector(random, n);
      rows.add(a, a.dot(inside));
      rows.add(-a, -a.dot(inside));
    }
    add_feasible(whole(random, 0, 12));
    break;
  case Kind::cones:
  case Kind::turned_cones:
  {
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(n, n);
    if (kind == Kind::turned_cones)
      turn = positive(random, n);
    const Eigen::VectorXd f = turn.row(0).transpose();
    for (int i = 1; i < n; ++i)
      for (const double sign : {-1.0, 1.0})
        rows.add(sign * turn.row(i).transpose() - uniform(random, 0.05, 0.8) * f, 0.0);
    const double least = whole(random, 0, 1) * uniform(random, 0.0, 2.0);
    rows.add(-f, -least);
    rows.add(f, least + whole(random, 0, 1) * uniform(random, 0.0, 2.0));
    for (int i = whole(random, 0, 4); i > 0; --i)
      rows.add(vector(random, n), uniform(random, -0.2, 1.0) + 2.0 * least);
    break;
  }
  case Kind::vertex:
    for (int i = whole(random, 1, 20); i > 0; --i)
    {
      const Eigen::VectorXd a = vector(random, n);
      rows.add(a, a.dot(inside));
    }
    break;
  case Kind::whole_numbers:
    for (int i = 0; i < n; ++i)
      g(i) = whole(random, -6, 6);
    H = Eigen::MatrixXd::Identity(n, n) * whole(random, 1, 3);
    for (int i = whole(random, 0, 14); i > 0; --i)
    {
      Eigen::VectorXd a(n);
      for (int j = 0; j < n; ++j)
        a(j) = whole(random, -2, 2);
      rows.add(a, whole(random, -1, 4));
    }
    break;
  case Kind::nearly_parallel:
    for (int i = whole(random, 1, 6); i > 0; --i)
    {
      const Eigen::VectorXd a = vector(random, n);
      const double slack = whole(random, 0, 1) * uniform(random, 0.0, 1.0);
      const double angle = std::pow(10.0, uniform(random, -6.0, -3.0));
      for (int j = whole(random, 2, 3); j > 0; --j)
      {
        const Eigen::VectorXd turned = a + angle * vector(random, n);
        rows.add(turned, turned.dot(inside) + slack);
      }
    }
    break;
  case Kind::closed:
  case Kind::contradiction:
  {
    Eigen::VectorXd a = Eigen::VectorXd::Zero(n);
    double b = kind == Kind::closed ? 0.0 : -uniform(random, 0.01, 1.0);
    for (int i = whole(random, 1, n + 1); i > 0; --i)
    {
      const Eigen::VectorXd normal = vector(random, n);
      const double bound = normal.dot(inside);
      const double weight = uniform(random, 0.1, 2.0);
      rows.add(normal, bound);
      a -= weight * normal;
      b -= weight * bound;
    }
    rows.add(a, b);
    add_feasible(whole(random, 0, 8));
    break;
  }
  }

  // in any order
  for (int i = rows.size() - 1; i > 0; --i)
  {
    const int j = whole(random, 0, i);
    std::swap(rows.a[static_cast<std::size_t>(i)], rows.a[static_cast<std::size_t>(j)]);
    std::swap(rows.b[static_cast<std::size_t>(i)], rows.b[static_cast<std::size_t>(j)]);
  }
  return program_of(H, g, rows);
}

// The first few rows only.
void keep(Rows& rows, int count)
{
  const int m = std::min(rows.size(), count);
  rows.A = Eigen::MatrixXd(rows.A.topRows(m));
  rows.b = Eigen::VectorXd(rows.b.head(m));
}

using Long = long double;
using LongVector = Eigen::Matrix<Long, Eigen::Dynamic, 1, 0, 2 * kMaxVariables, 1>;
using LongMatrix = Eigen::Matrix<Long, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * kMaxVariables, 2 * kMaxVariables>;

/// Tries every set of rows as the active one, in extended precision, and keeps the point that comes nearest to the
/// conditions of the optimum.
class Enumeration
{
public:
  explicit Enumeration(const QuadraticProgram& program)
      : rows_(program.rows), n_(static_cast<int>(program.g.size())), A_(program.rows.A.cast<Long>()),
        b_(program.rows.b.cast<Long>())
  {
    try_from(0, program.H.cast<Long>(), program.g.cast<Long>());
  }

  double residual() const { return static_cast<double>(least_); } ///< of the conditions, in units of the rows
  Eigen::VectorXd y() const { return y_.cast<double>(); }

private:
  void try_from(int i, const LongMatrix& H, const LongVector& g)
  {
    if (least_ < 1e-14L)
      return;
    if (i == rows_.size())
      return try_set(H, g);
    try_from(i + 1, H, g);
    const LongVector a = A_.row(i).transpose();
    chosen_.push_back(i);
    if (rows_.soft[i])
      try_from(i + 1, H + a * a.transpose(), g - b_(i) * a);
    else if (static_cast<int>(normals_.size()) < n_)
    {
      // what is left of the normal after those chosen before
      LongVector rest = a;
      for (int times = 0; times < 2; ++times)
        for (const LongVector& q : normals_)
          rest -= q.dot(rest) * q;
      if (rest.norm() > 1e-10L * a.norm())
      {
        normals_.push_back(rest.normalized());
        hard_.push_back(i);
        try_from(i + 1, H, g);
        hard_.pop_back();
        normals_.pop_back();
      }
    }
    chosen_.pop_back();
  }

  void try_set(const LongMatrix& H, const LongVector& g)
  {
    const int k = static_cast<int>(hard_.size());
    LongVector z(n_ + k);
    if (n_ + k > 0)
    {
      LongMatrix K = LongMatrix::Zero(n_ + k, n_ + k);
      LongVector right(n_ + k);
      K.topLeftCorner(n_, n_) = H;
      right.head(n_) = -g;
      for (int j = 0; j < k; ++j)
      {
        K.row(n_ + j).head(n_) = A_.row(hard_[static_cast<std::size_t>(j)]);
        K.col(n_ + j).head(n_) = A_.row(hard_[static_cast<std::size_t>(j)]).transpose();
        right(n_ + j) = b_(hard_[static_cast<std::size_t>(j)]);
      }
      Eigen::FullPivLU<LongMatrix> lu(K);
      lu.setThreshold(0.0L);
      z = lu.solve(right);
    }
    const LongVector y = z.head(n_);
    Long worst = 0.0L;
    for (int j = 0; j < k; ++j)
      worst = std::max(worst, -z(n_ + j) * A_.row(hard_[static_cast<std::size_t>(j)]).norm());
    auto next = chosen_.begin();
    for (int i = 0; i < rows_.size() && worst < least_; ++i)
    {
      const bool chosen = next != chosen_.end() && *next == i;
      if (chosen)
        ++next;
      if (chosen && !rows_.soft[i])
        continue;
      const Long size = std::max({A_.row(i).norm() * y.norm(), std::abs(b_(i)), 1.0L});
      const Long lacks = (A_.row(i).dot(y) - b_(i)) / size;
      worst = std::max(worst, chosen ? -lacks : lacks);
    }
    if (worst < least_)
    {
      least_ = worst;
      y_ = y;
    }
  }

  const Rows& rows_;
  int n_;
  Eigen::Matrix<Long, Eigen::Dynamic, Eigen::Dynamic> A_;
  Eigen::Matrix<Long, Eigen::Dynamic, 1> b_;
  std::vector<int> chosen_, hard_;
  std::vector<LongVector> normals_;
  Long least_ = std::numeric_limits<Long>::infinity();
  LongVector y_;
};

} // namespace

TEST_CASE("the solution is the best of all sets of active rows", "[quadratic_program][slow]")
{
  oracle::Random random(1);
  int infeasible_ones = 0;
  int most_steps = 0;
  for (int i = 0; i < kPrograms; ++i)
  {
    const Kind kind = static_cast<Kind>(i % kKinds);
    const QuadraticProgram program = random_program(random, kind);
    const Enumeration expected(program);
    const QuadraticProgramSolution found = solve(program);
    CAPTURE(i, static_cast<int>(kind), program.g.size(), program.rows.size(), expected.residual());
    CHECK((expected.residual() < 1e-12 || expected.residual() > 1e-7)); // no program lies at the edge
    REQUIRE(found.status == (expected.residual() < 1e-9 ? optimal : infeasible));
    most_steps = std::max(most_steps, found.steps);
    if (found.status == infeasible)
      ++infeasible_ones;
    else
    {
      CHECK(kkt_residuals(program, found.y, found.lambda).largest() <= 1e-10);
      // rounding times the condition number, 1e10 at the worst
      CHECK(mismatch(found.y, expected.y(), kind == Kind::bad_condition ? 1e-6 : 1e-8) == "");
    }
  }
  CHECK(infeasible_ones > 0.15 * kPrograms);
  CHECK(most_steps < 20);
}

TEST_CASE("of four to six variables too the solution is the best of all sets of active rows",
          "[quadratic_program][slow]")
{
  oracle::Random random(16);
  int infeasible_ones = 0, violated = 0;
  for (int i = 0; i < kPrograms / 10; ++i)
  {
    const Kind kind = static_cast<Kind>(i % kKinds);
    QuadraticProgram program = random_program(random, kind, 4, 6);
    keep(program.rows, 10);
    if (i % 3 == 0)
      for (int j = 0; j < program.rows.size(); ++j)
        program.rows.soft[static_cast<std::size_t>(j)] = whole(random, 0, 2) == 0;
    const Enumeration expected(program);
    const QuadraticProgramSolution found = solve(program);
    CAPTURE(i, static_cast<int>(kind), program.g.size(), program.rows.size(), expected.residual());
    REQUIRE(found.status == (expected.residual() < 1e-9 ? optimal : infeasible));
    infeasible_ones += found.status == infeasible;
    CHECK(found.steps < 40);
    if (found.status != optimal)
      continue;
    CHECK(kkt_residuals(program, found.y, found.lambda).largest() <= 1e-10);
    CHECK(mismatch(found.y, expected.y(), kind == Kind::bad_condition ? 1e-6 : 1e-8) == "");
    for (int j = 0; j < program.rows.size(); ++j)
      violated += program.rows.soft[static_cast<std::size_t>(j)] && found.lambda(j) > 1e-3;
  }
  CHECK(infeasible_ones > kPrograms / 200);
  CHECK(violated > kPrograms / 100);
}

TEST_CASE("of four to six variables, rows through one point are met, and violations are the least",
          "[quadratic_program]")
{
  oracle::Random random(17);
  int violated = 0;
  for (int i = 0; i < kPrograms / 4; ++i)
  {
    const Kind kind = static_cast<Kind>(i % kKinds);
    QuadraticProgram program = random_program(random, kind, 4, 6);
    const int n = static_cast<int>(program.g.size());
    const QuadraticProgramSolution found = solve(program);
    CAPTURE(i, static_cast<int>(kind), n);
    if (kind == Kind::vertex || kind == Kind::equalities || kind == Kind::nearly_parallel || kind == Kind::closed)
      REQUIRE(found.status == optimal);
    REQUIRE(found.status != not_solved);
    if (found.status == optimal)
      CHECK(kkt_residuals(program, found.y, found.lambda).largest() <= 1e-10);

    // what can be met is met by the least violation, too; in any case it is one by its own conditions
    for (int j = 0; j < program.rows.size(); ++j)
      program.rows.soft[static_cast<std::size_t>(j)] = whole(random, 0, 3) > 0;
    const QuadraticProgramSolution least = least_violation(program.rows, vector(random, n));
    if (program.rows.soft.count() == static_cast<std::size_t>(program.rows.size()) || found.status == optimal)
      REQUIRE(least.status == optimal);
    if (least.status != optimal)
      continue;
    program.H.setZero();
    program.g.setZero();
    CHECK(kkt_residuals(program, least.y, least.lambda).largest() <= 1e-9);
    const bool met = program.rows.size() == 0 || least.lambda.maxCoeff() < 1e-7;
    CHECK(met == (found.status == optimal));
    violated += !met;
  }
  CHECK(violated > kPrograms / 40);
}

TEST_CASE("with soft rows too the solution is the best of all sets of active rows", "[quadratic_program]")
{
  oracle::Random random(2);
  int violated = 0;
  for (int i = 0; i < kPrograms / 4; ++i)
  {
    const Kind kind = static_cast<Kind>(i % kKinds);
    QuadraticProgram program = random_program(random, kind);
    const bool all_soft = i % 4 == 0;
    keep(program.rows, 8);
    for (int j = 0; j < program.rows.size(); ++j)
      program.rows.soft[j] = all_soft || whole(random, 0, 1) == 0;
    const Enumeration expected(program);
    const QuadraticProgramSolution found = solve(program);
    CAPTURE(i, static_cast<int>(kind), program.g.size(), program.rows.size(), expected.residual());
    REQUIRE(found.status == (expected.residual() < 1e-9 ? optimal : infeasible));
    if (all_soft)
      CHECK(found.status == optimal);
    if (found.status != optimal)
      continue;
    CHECK(kkt_residuals(program, found.y, found.lambda).largest() <= 1e-10);
    CHECK(mismatch(found.y, expected.y(), kind == Kind::bad_condition ? 1e-6 : 1e-8) == "");
    for (int j = 0; j < program.rows.size(); ++j)
      if (program.rows.soft[j])
      {
        const double v = program.rows.A.row(j).dot(found.y) - program.rows.b(j);
        CHECK(mismatch(found.lambda(j), std::max(0.0, v), 1e-10) == "");
        violated += v > 1e-3;
      }
  }
  CHECK(violated > kPrograms / 4);
}

TEST_CASE("rows through one point are met, however near to parallel they are", "[quadratic_program]")
{
  oracle::Random random(3);
  for (int i = 0; i < kPrograms; ++i)
  {
    const int n = whole(random, 1, 3);
    const Eigen::VectorXd inside = vector(random, n);
    RowList rows;
    for (int group = whole(random, 1, 4); group > 0; --group)
    {
      const Eigen::VectorXd a = vector(random, n);
      for (int j = whole(random, 1, 4); j > 0; --j)
      {
        const double angle = whole(random, 0, 2) * std::pow(10.0, uniform(random, -7.0, 0.0));
        const double factor = (2 * whole(random, 0, 1) - 1) * std::pow(10.0, uniform(random, -1.0, 1.5));
        const Eigen::VectorXd turned = factor * (a + angle * vector(random, n));
        rows.add(turned, turned.dot(inside));
      }
    }
    const Eigen::MatrixXd H = positive(random, n, std::pow(10.0, uniform(random, 0.0, 8.0)));
    const QuadraticProgram program = program_of(H, H * vector(random, n, -3.0, 3.0), rows);
    const QuadraticProgramSolution found = solve(program);
    CAPTURE(i);
    REQUIRE(found.status == optimal);
    CHECK(kkt_residuals(program, found.y, found.lambda).largest() <= 1e-9);
    CHECK(found.steps < 50);
  }
}

TEST_CASE("neither the order of the rows nor their size matters", "[quadratic_program]")
{
  oracle::Random random(4);
  for (int i = 0; i < kPrograms / 4; ++i)
  {
    const Kind kind = static_cast<Kind>(i % kKinds);
    if (kind == Kind::bad_condition || kind == Kind::nearly_parallel) // as exact as their condition allows
      continue;
    const QuadraticProgram program = random_program(random, kind);
    const int m = program.rows.size();
    QuadraticProgram turned = program;
    turned.rows.A = program.rows.A.colwise().reverse();
    turned.rows.b = program.rows.b.reverse();
    QuadraticProgram scaled = program;
    for (int j = 0; j < m; ++j)
    {
      const double factor = std::pow(10.0, uniform(random, -1.0, 2.0));
      scaled.rows.A.row(j) *= factor;
      scaled.rows.b(j) *= factor;
    }
    const QuadraticProgramSolution expected = solve(program);
    CAPTURE(i, static_cast<int>(kind));
    for (const QuadraticProgram& other : {turned, scaled})
    {
      const QuadraticProgramSolution found = solve(other);
      REQUIRE(found.status == expected.status);
      CHECK(mismatch(found.y, expected.y, 1e-9) == "");
    }
  }
}

TEST_CASE("from the working set of another program the solution is the same", "[quadratic_program]")
{
  oracle::Random random(14);
  int continued = 0, shorter = 0;
  for (int i = 0; i < kPrograms; ++i)
  {
    const Kind kind = static_cast<Kind>(i % kKinds);
    if (kind == Kind::bad_condition || kind == Kind::nearly_parallel) // as exact as their condition allows
      continue;
    QuadraticProgram program = random_program(random, kind);
    const QuadraticProgramSolution before = solve(program);
    for (int j = 0; j < program.rows.size(); ++j)
    {
      program.rows.soft[static_cast<std::size_t>(j)] =
          program.rows.soft[static_cast<std::size_t>(j)] || whole(random, 0, 1) == 0;
      const double factor = std::pow(10.0, uniform(random, -1.0, 2.0));
      program.rows.A.row(j) *= factor;
      program.rows.b(j) = factor * (program.rows.b(j) + uniform(random, -0.1, 0.1));
    }
    const QuadraticProgramSolution expected = solve(program);
    const QuadraticProgramSolution found = solve(program, before.active);
    CAPTURE(i, static_cast<int>(kind));
    REQUIRE(found.status == expected.status);
    if (found.status != optimal)
      continue;
    CHECK(mismatch(found.y, expected.y, 1e-9) == "");
    CHECK(kkt_residuals(program, found.y, found.lambda).largest() <= kKktTolerance);
    ++continued;
    shorter += found.steps < expected.steps ? 1 : 0;
  }
  CHECK(continued > kPrograms / 4);
  CHECK(shorter > continued / 4); // or there would be no use in it
}

TEST_CASE("a cone that is closed leaves one point", "[quadratic_program]")
{
  // |x| ≤ 0.6 f, |m| ≤ 0.1 f, 0 ≤ f ≤ 0; the program would rather have all of them
  RowList rows;
  const auto add = [&rows](double x, double m, double f, double b)
  {
    rows.add(Eigen::Vector3d(x, m, f), b);
  };
  add(1.0, 0.0, -0.6, 0.0);
  add(-1.0, 0.0, -0.6, 0.0);
  add(0.0, 1.0, -0.1, 0.0);
  add(0.0, -1.0, -0.1, 0.0);
  add(0.0, 0.0, -1.0, 0.0);
  add(0.0, 0.0, 1.0, 0.0);
  const QuadraticProgram program = program_of(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-1.0, 2.0, -3.0), rows);
  const QuadraticProgramSolution found = solve(program);
  REQUIRE(found.status == optimal);
  CHECK(mismatch(found.y, Eigen::Vector3d::Zero(), 1e-15) == "");
  CHECK(kkt_residuals(program, found.y, found.lambda).largest() <= 1e-15);

  // a force of at least 1 is not to be had from it
  add(0.0, 0.0, -1.0, -1.0);
  CHECK(solve(program_of(program.H, program.g, rows)).status == infeasible);
}

TEST_CASE("a soft row that is far away changes nothing", "[quadratic_program]")
{
  oracle::Random random(15);
  int infeasible_ones = 0;
  for (int i = 0; i < kPrograms; ++i)
  {
    const Kind kind = static_cast<Kind>(i % kKinds);
    const QuadraticProgram program = random_program(random, kind);
    const QuadraticProgramSolution found = solve(program);
    QuadraticProgram with_soft = program;
    const int m = program.rows.size();
    with_soft.rows.A.conservativeResize(m + 1, Eigen::NoChange);
    with_soft.rows.b.conservativeResize(m + 1);
    with_soft.rows.A.row(m).setConstant(1e-3);
    with_soft.rows.b(m) = 1e12;
    with_soft.rows.soft.set(static_cast<std::size_t>(m));
    const QuadraticProgramSolution expected = solve(with_soft);
    CAPTURE(i, static_cast<int>(kind));
    REQUIRE(found.status == expected.status);
    infeasible_ones += found.status == infeasible ? 1 : 0;
    if (found.status == optimal)
      CHECK(mismatch(found.y, expected.y, kind == Kind::bad_condition ? 1e-6 : 1e-8) == "");
  }
  CHECK(infeasible_ones > 0.15 * kPrograms);
  // what one row shrinks by is too little to be divided by
  RowList rows;
  rows.add(Eigen::VectorXd::Constant(1, 2e-155), -1e-10);
  CHECK(solve(program_of(Eigen::MatrixXd::Identity(1, 1), Eigen::VectorXd::Zero(1), rows)).status != optimal);
}

TEST_CASE("rows that contradict each other by rounding have a solution between them", "[quadratic_program]")
{
  // x ≤ 0 and x ≥ gap, each of which counts as met where it lacks no more than kRowTolerance; with other variables, or
  // none
  const int n = GENERATE(1, 2, 3);
  const auto between = [n](double gap, double factor)
  {
    RowList rows;
    rows.add(factor * Eigen::VectorXd::Unit(n, 0), 0.0);
    rows.add(-factor * Eigen::VectorXd::Unit(n, 0), -factor * gap);
    return solve(program_of(Eigen::MatrixXd::Identity(n, n), -Eigen::VectorXd::Unit(n, n - 1), rows));
  };
  for (const double factor : {1.0, 0.25})
    for (const double share : {0.5, 1.5, 1.9})
    {
      const double gap = share * kRowTolerance / factor;
      const QuadraticProgramSolution found = between(gap, factor);
      CAPTURE(n, factor, share);
      REQUIRE(found.status == optimal);
      CHECK(found.y(0) > -2.0 * gap);
      CHECK(found.y(0) < 3.0 * gap);
      if (n > 1)
        CHECK(mismatch(found.y(n - 1), 1.0, 1e-15) == "");
    }
  CHECK(between(2.5 * kRowTolerance, 1.0).status == infeasible);
  CHECK(between(1e-3, 1.0).status == infeasible);
}

TEST_CASE("rows without a normal, and programs without variables, ask only for b", "[quadratic_program]")
{
  for (const int n : {0, 2})
  {
    const auto with_b = [n](double b, bool soft)
    {
      RowList rows;
      rows.add(Eigen::VectorXd::Zero(n), 1.0);
      rows.add(Eigen::VectorXd::Zero(n), b);
      QuadraticProgram program = program_of(Eigen::MatrixXd::Identity(n, n), Eigen::VectorXd::Constant(n, -2.0), rows);
      program.rows.soft[1] = soft;
      return program;
    };
    for (const double b : {2.0, 0.0, -1e-13}) // the last is rounding
      for (const bool soft : {false, true})
      {
        const QuadraticProgramSolution met = solve(with_b(b, soft));
        REQUIRE(met.status == optimal);
        CHECK(mismatch(met.y, Eigen::VectorXd::Constant(n, 2.0), 1e-15) == "");
        CHECK(met.lambda == Eigen::Vector2d::Zero());
      }
    CHECK(solve(with_b(-1e-9, false)).status == infeasible);
    CHECK(solve(with_b(-3.0, false)).status == infeasible);
    const QuadraticProgramSolution violated = solve(with_b(-3.0, true));
    REQUIRE(violated.status == optimal);
    CHECK(mismatch(violated.y, Eigen::VectorXd::Constant(n, 2.0), 1e-15) == "");
    CHECK(violated.lambda == Eigen::Vector2d(0.0, 3.0));
  }
  const QuadraticProgramSolution empty = solve(program_of(Eigen::MatrixXd(0, 0), Eigen::VectorXd(0), {}));
  CHECK(empty.status == optimal);
  CHECK(empty.y.size() == 0);
}

TEST_CASE("what has no minimum is not solved", "[quadratic_program]")
{
  RowList rows;
  rows.add(Eigen::Vector2d(1.0, 0.0), 1.0);
  rows.add(Eigen::Vector2d(0.0, 1.0), 1.0);
  const auto status_with = [&rows](const Eigen::Matrix2d& H)
  {
    return solve(program_of(H, Eigen::Vector2d(-2.0, 0.5), rows)).status;
  };
  Eigen::Matrix2d H = Eigen::Vector2d(1.0, 1e-10).asDiagonal();
  CHECK(status_with(H) == optimal);
  for (const double last : {0.0, -1.0, -1e-10})
  {
    H(1, 1) = last;
    CHECK(status_with(H) == not_solved);
  }
  H << 0.1, 0.3, 0.3, 0.9; // singular but for rounding
  CHECK(status_with(H) == not_solved);
  H << 1.0, 2.0, 2.0, 1.0;
  CHECK(status_with(H) == not_solved);

  // two directions in which it falls: the determinant is positive
  H << -1.0, 0.0, 0.0, -1.0;
  CHECK(status_with(H) == not_solved);
  const auto status_of_three = [](double diagonal, double others)
  {
    Eigen::Matrix3d all = Eigen::Matrix3d::Constant(others);
    all.diagonal().setConstant(diagonal);
    return solve(program_of(all, Eigen::Vector3d(-2.0, 0.5, 1.0), RowList())).status;
  };
  CHECK(status_of_three(1.0, 0.9) == optimal);
  CHECK(status_of_three(1.0, 1.1) == not_solved);
  CHECK(status_of_three(1.0, 3.0) == not_solved);
}

TEST_CASE("what is not finite is not solved", "[quadratic_program]")
{
  RowList rows;
  rows.add(Eigen::Vector2d(1.0, 0.0), 1.0);
  rows.add(Eigen::Vector2d(0.0, 1.0), -1.0);
  rows.add(Eigen::Vector2d(1.0, 1.0), 3.0); // not active
  QuadraticProgram program = program_of(Eigen::Matrix2d::Identity(), Eigen::Vector2d(-2.0, 0.5), rows);
  const bool soft = GENERATE(false, true);
  program.rows.soft[1] = soft;
  CAPTURE(soft);
  REQUIRE(solve(program).status == optimal);
  REQUIRE(least_violation(program.rows, program.g).status == optimal);
  const auto check = [&program](double& entry, bool of_rows)
  {
    const double finite = entry;
    for (const double value : {kNaN, kInfinity, -kInfinity, 1e200})
    {
      entry = value;
      CHECK(solve(program).status == not_solved);
      if (of_rows)
        CHECK(least_violation(program.rows, Eigen::Vector2d::Zero()).status == not_solved);
    }
    entry = finite;
  };
  for (double& entry : program.H.reshaped())
    check(entry, false);
  for (double& entry : program.g)
    check(entry, false);
  for (double& entry : program.rows.A.reshaped())
    check(entry, true);
  for (double& entry : program.rows.b)
    check(entry, true);
  for (const double value : {kNaN, kInfinity})
    CHECK(least_violation(program.rows, Eigen::Vector2d(0.0, value)).status == not_solved);
}

TEST_CASE("KKT residuals tell how far a point is from optimal", "[quadratic_program]")
{
  // minimise ½ |y|² − 10 y_1 for 2 y_1 ≤ 4, and softly y_2 ≥ 3: y = (2, −1.5) less what is not exact below
  RowList rows;
  rows.add(Eigen::Vector2d(2.0, 0.0), 4.0);
  rows.add(Eigen::Vector2d(0.0, -1.0), -3.0);
  rows.add(Eigen::Vector2d(0.0, 1.0), 5.0);
  QuadraticProgram program = program_of(Eigen::Matrix2d::Identity(), Eigen::Vector2d(-10.0, 0.0), rows);
  program.rows.soft[1] = true;
  const Eigen::Vector2d y(2.0, 1.5);
  const Eigen::Vector3d lambda(4.0, 1.5, 0.0);
  CHECK(kkt_residuals(program, y, lambda).largest() == 0.0);
  CHECK(mismatch(solve(program).y, y, 1e-15) == "");
  CHECK(mismatch(solve(program).lambda, lambda, 1e-15) == "");

  // H y is of size √2 · 2.5, g and λ_1 a_1 are up to 10; a_1 y is of size 5
  KktResiduals off = kkt_residuals(program, y, lambda + Eigen::Vector3d(0.0, 0.0, 0.1));
  CHECK(mismatch(off.stationarity, 0.1 / 10.0, 1e-15) == "");
  CHECK(mismatch(off.complementarity, 0.1 / 4.0 * 3.5 / 5.0, 1e-15) == "");
  off = kkt_residuals(program, y, Eigen::Vector3d(4.0, 1.5, -0.1));
  CHECK(mismatch(off.sign, 0.1 / 4.0, 1e-15) == "");
  off = kkt_residuals(program, y, Eigen::Vector3d(4.0, 1.2, 0.0));
  CHECK(mismatch(off.violation, 0.3 / 3.0, 1e-15) == "");
  CHECK(off.sign == 0.0);
  off = kkt_residuals(program, Eigen::Vector2d(2.2, 1.5), lambda);
  CHECK(mismatch(off.violation, 0.4 / (2.0 * std::hypot(2.2, 1.5)), 1e-15) == "");
  CHECK(off.largest() == std::max(off.violation, off.stationarity));
  CHECK(kkt_residuals(program, Eigen::Vector2d(2.0, kNaN), lambda).largest() > 1.0);
}

TEST_CASE("least violation: no set of violated rows is better", "[quadratic_program]")
{
  oracle::Random random(5);
  int violated = 0;
  for (int i = 0; i < kPrograms / 4; ++i)
  {
    const int n = whole(random, 0, 3);
    RowList list;
    const Eigen::VectorXd of_all = vector(random, n);
    for (int j = whole(random, 0, 6); j > 0; --j)
      // some of them parallel or opposite
      list.add(whole(random, 0, 2) ? vector(random, n) : (2.0 * whole(random, 0, 1) - 1.0) * of_all,
               uniform(random, -1.0, 0.5));
    // the few that this gives to be done reach far; where the rows decide, it does not matter to them
    QuadraticProgram program = program_of(1e-13 * Eigen::MatrixXd::Identity(n, n), Eigen::VectorXd::Zero(n), list);
    for (int j = 0; j < list.size(); ++j)
      program.rows.soft[j] = whole(random, 0, 3) > 0;
    const Enumeration expected(program);
    const QuadraticProgramSolution found = least_violation(program.rows, vector(random, n, -3.0, 3.0));
    CAPTURE(i, n, list.size(), expected.residual());
    REQUIRE(found.status == (expected.residual() < 1e-9 ? optimal : infeasible));
    if (found.status != optimal)
      continue;
    program.H.setZero();
    CHECK(kkt_residuals(program, found.y, found.lambda).largest() <= 1e-10);
    for (int j = 0; j < list.size(); ++j)
      if (program.rows.soft[j])
      {
        const double v = std::max(0.0, program.rows.A.row(j).dot(found.y) - program.rows.b(j));
        const double least = std::max(0.0, program.rows.A.row(j).dot(expected.y()) - program.rows.b(j));
        CHECK(mismatch(v, least, 1e-6) == "");
        CHECK(mismatch(found.lambda(j), v, 1e-10) == "");
        violated += v > 1e-3;
      }
  }
  CHECK(violated > kPrograms / 40);
}

TEST_CASE("least violation: nearly parallel rows are not worse than others", "[quadratic_program]")
{
  oracle::Random random(6);
  for (int i = 0; i < kPrograms / 4; ++i)
  {
    const int n = whole(random, 1, 3);
    const Eigen::VectorXd near = vector(random, n);
    RowList list;
    for (int group = whole(random, 1, 3); group > 0; --group)
    {
      const Eigen::VectorXd a = vector(random, n);
      for (int j = whole(random, 1, 3); j > 0; --j)
      {
        const double angle = whole(random, 0, 2) * std::pow(10.0, uniform(random, -4.0, 0.0));
        const Eigen::VectorXd turned = (2 * whole(random, 0, 1) - 1) * (a + angle * vector(random, n));
        list.add(turned, turned.dot(near) + whole(random, 0, 1) * uniform(random, -0.5, 0.5));
      }
    }
    QuadraticProgram program = program_of(Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), list);
    program.rows.soft.set();
    const QuadraticProgramSolution found = least_violation(program.rows, vector(random, n));
    CAPTURE(i);
    REQUIRE(found.status == optimal);
    CHECK(kkt_residuals(program, found.y, found.lambda).largest() <= 1e-9);
    CHECK(found.steps < 200);
  }
}

TEST_CASE("least violation: rows that can be met are met", "[quadratic_program]")
{
  oracle::Random random(7);
  for (int i = 0; i < kPrograms / 4; ++i)
  {
    const Kind kind = static_cast<Kind>(i % kKinds);
    QuadraticProgram program = random_program(random, kind);
    const QuadraticProgramStatus status = solve(program).status;
    program.rows.soft.set();
    const QuadraticProgramSolution found =
        least_violation(program.rows, vector(random, static_cast<int>(program.g.size())));
    CAPTURE(i, static_cast<int>(kind));
    REQUIRE(found.status == optimal);
    CHECK((program.rows.size() == 0 || found.lambda.maxCoeff() < 1e-7) == (status == optimal));

    // and where they are met, nothing moves
    if (status == optimal)
    {
      const QuadraticProgramSolution again = least_violation(program.rows, found.y);
      CHECK(mismatch(again.y, found.y, 1e-7) == "");
    }
    program.rows.soft.reset();
    CHECK(least_violation(program.rows, program.g).status == status);
  }
}

TEST_CASE("least violation: rows that contradict each other share it, as near as can be", "[quadratic_program]")
{
  // x ≤ 0 and x ≥ 2, of the variables turned by some angle: nothing is said about the other one
  for (const double angle : {0.0, 0.3, 1.0})
  {
    const Eigen::Vector2d x(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d other(-x.y(), x.x());
    RowList list;
    list.add(x, 0.0);
    list.add(-x, -2.0);
    Rows rows = program_of(Eigen::Matrix2d::Zero(), Eigen::Vector2d::Zero(), list).rows;
    rows.soft.set();
    QuadraticProgramSolution found = least_violation(rows, -4.0 * x + 7.0 * other);
    REQUIRE(found.status == optimal);
    CHECK(mismatch(found.y, x + 7.0 * other, 1e-8) == "");
    CHECK(mismatch(found.lambda, Eigen::Vector2d(1.0, 1.0), 1e-12) == "");

    rows.soft[0] = false;
    found = least_violation(rows, -4.0 * x + 7.0 * other);
    REQUIRE(found.status == optimal);
    CHECK(mismatch(found.y, 7.0 * other, 1e-8) == "");
    CHECK(mismatch(found.lambda(1), 2.0, 1e-12) == "");

    rows.soft[1] = false;
    CHECK(least_violation(rows, -4.0 * x).status == infeasible);
  }
}

} // namespace quadratic_program_test
