#include "nearest_oracle.h"

#include "decompositions.h"
#include "stance/joint_friction.h"

#include <Eigen/Dense>
#include <vector>

namespace torqued::oracle
{

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace
{

// Room of a row that may have a multiplier, in the row's own unit: a method chooses with room of 1e-10 in every row,
// and by what one row gains another may move by up to some 10⁵ times as much.
constexpr double kActive = 1e-4;

Motion completed(const Robot& robot, const DesiredState& desired)
{
  return std::get<Motion>(complete_motion(robot, desired));
}

// a mechanism's vector in the rows of the equation of motion
VectorXd in_rows(const Robot& robot, const VectorQ& of_mechanism)
{
  const int n = robot.num_coordinates();
  VectorXd rows(n + (robot.fixed_root() ? 0 : 2));
  rows.head(n) = of_mechanism.head(n);
  if (!robot.fixed_root())
    rows.tail<2>() = of_mechanism.tail<2>();
  return rows;
}

// where a foot's components begin in the rows of J, from which a fixed root's own contact is missing; −1 if they are
Index row_of(const Robot& robot, const Support& support, Side side)
{
  if (support.of(side) == Contact::none || robot.is_root(robot.foot(side)))
    return -1;
  if (side == Side::left || robot.is_root(robot.foot(Side::left)))
    return 0;
  return wrench_components(support.of(Side::left));
}

struct Rows
{
  ReactionRows all;

  explicit Rows(Index n) : all{MatrixXd(0, n), VectorXd(0)} {}
  // c·(own components) ≥ bound
  void add(Index at, const VectorXd& c, double bound, double unit)
  {
    const Index k = all.h.size();
    all.G.conservativeResize(k + 1, Eigen::NoChange);
    all.h.conservativeResize(k + 1);
    all.G.row(k).setZero();
    all.G.row(k).segment(at, c.size()) = c.transpose() / unit;
    all.h(k) = bound / unit;
  }
};

// the share of F_z that the windows leave a foot; empty where they leave it all
std::optional<double> window(const Support& support, Side side)
{
  const bool leads = side == support.leading;
  const bool sole = support.of(side) == Contact::sole, other_sole = support.of(other(side)) == Contact::sole;
  if (support.of(other(side)) == Contact::none || (!sole && !other_sole))
    return {};
  if (sole && other_sole)
    return std::min(1.0, 2.0 * (leads ? support.load_transfer : 1.0 - support.load_transfer));
  if (sole)
    return {};
  return leads ? support.phase : 1.0 - support.phase;
}

// from where to where along a sole the pressure may be; the margin ends where a window closes
std::pair<double, double> ends(const Foot& foot, const Support& support, Side side, double margin, bool windows)
{
  double heel = margin, toe = margin;
  const Contact beside = support.of(other(side));
  if (windows && (beside == Contact::heel || beside == Contact::toe))
  {
    if (side == support.leading)
      heel *= support.phase;
    else
      toe *= 1.0 - support.phase;
  }
  return {foot.heel_x() + heel, foot.toe_x() - toe};
}

// M − h_p f_x' − x f_z' as a function of (f_x, f_z, M): the moment about the point x of a sole
Vector3d about(const Foot& foot, const Vector2d& along, double x)
{
  const Vector2d upward(-along.y(), along.x());
  const Vector2d f = -foot.ankle_height() * along - x * upward;
  return {f.x(), f.y(), 1.0};
}

Vector2d along_sole(const Kinematics& now, const Foot& foot)
{
  return (position(now, foot.toe) - position(now, foot.heel)).normalized();
}

// |C z − N y − t| for the best z ≥ 0 and any y, over |t|
double left_of(const MatrixXd& C, const MatrixXd& N, const VectorXd& t, double scale)
{
  if (N.cols() == 0)
    return (C * non_negative_least_squares(C, t) - t).norm() / scale;
  // what is orthogonal to all columns of N, which need not be independent
  const Eigen::ColPivHouseholderQR<MatrixXd> decomposition = [&]
  {
    Eigen::ColPivHouseholderQR<MatrixXd> result;
    result.setThreshold(1e-9);
    result.compute(N);
    return result;
  }();
  const Index rank = decomposition.rank(), left = N.rows() - rank;
  const MatrixXd Qt = decomposition.householderQ().adjoint();
  const MatrixXd A = Qt.bottomRows(left) * C;
  const VectorXd b = Qt.bottomRows(left) * t;
  return (A * non_negative_least_squares(A, b) - b).norm() / scale;
}

} // namespace

VectorXd non_negative_least_squares(const MatrixXd& A_given, const VectorXd& b)
{
  const Index n = A_given.cols();
  VectorXd z = VectorXd::Zero(n);
  if (n == 0 || b.size() == 0)
    return z;
  const VectorXd length = A_given.colwise().norm().cwiseMax(1e-300).transpose();
  const MatrixXd A = A_given * length.cwiseInverse().asDiagonal();
  std::vector<Index> free;
  const double least = 1e-13 * b.norm();
  VectorXd passed = VectorXd::Zero(n); // columns that gained nothing
  for (int steps = 0; steps < 200; ++steps)
  {
    const VectorXd gain = A.transpose() * (b - A * z);
    Index enters = -1;
    for (Index j = 0; j < n; ++j)
      if (z(j) == 0.0 && passed(j) == 0.0 && gain(j) > least && (enters < 0 || gain(j) > gain(enters)))
        enters = j;
    if (enters < 0)
      break;
    free.push_back(enters);
    for (bool first = true;; first = false)
    {
      MatrixXd F(A.rows(), static_cast<Index>(free.size()));
      for (std::size_t k = 0; k < free.size(); ++k)
        F.col(static_cast<Index>(k)) = A.col(free[k]);
      const VectorXd s = F.colPivHouseholderQr().solve(b);
      if (first && s(s.size() - 1) <= 0.0)
      {
        free.pop_back();
        passed(enters) = 1.0;
        break;
      }
      double step = 1.0;
      for (std::size_t k = 0; k < free.size(); ++k)
        if (const double to = s(static_cast<Index>(k)); to <= 0.0)
          step = std::min(step, z(free[k]) / (z(free[k]) - to));
      std::vector<Index> stay;
      for (std::size_t k = 0; k < free.size(); ++k)
      {
        double& now = z(free[k]);
        now += step * (s(static_cast<Index>(k)) - now);
        if (step < 1.0 && s(static_cast<Index>(k)) <= 0.0 && now <= 1e-15 * (1.0 + std::abs(s(static_cast<Index>(k)))))
          now = 0.0;
        if (now > 0.0)
          stay.push_back(free[k]);
        else
          now = 0.0;
      }
      free = stay;
      if (step == 1.0 || free.empty())
      {
        passed.setZero();
        break;
      }
    }
  }
  return length.cwiseInverse().asDiagonal() * z;
}

NearestProblem::NearestProblem(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired,
                               const StreamMemory& memory)
{
  const Support& support = desired.support;
  const Motion motion = completed(robot, desired);
  const EquationOfMotion equation = equation_of_motion(robot, motion, support, Coordinates::absolute);
  const int joints = robot.num_joints();
  const VectorXd v = in_rows(robot, motion.v);
  base = motion.now.base;
  base_rate = motion.v.tail<2>();
  a_d = in_rows(robot, motion.a);
  B = equation.B;
  J = equation.J;
  VectorXd rotors(joints);
  for (int j = 0; j < joints; ++j)
    rotors(j) = robot.actuators[static_cast<std::size_t>(j)].rotor_inertia;
  M = MatrixXd(equation.M) + B * rotors.asDiagonal() * B.transpose();
  VectorXd friction(joints);
  const VectorXd rates = B.transpose() * v;
  for (int j = 0; j < joints; ++j)
    friction(j) = joint_friction(robot.actuators[static_cast<std::size_t>(j)], rates(j), 0.0);
  f = equation.h + equation.g + B * friction;

  const double c = settings.nearest.contact_damping;
  b = settings.nearest.contacts == NearestContacts::rest ? VectorXd(-equation.Jdot_v - c * (J * v)) : VectorXd(J * a_d);
  b_terms = equation.Jdot_v.cwiseAbs() + c * (J.cwiseAbs() * v.cwiseAbs());

  W = M;
  if (settings.nearest.metric == NearestMetric::angles)
  {
    W.setZero();
    const double per_length = 1.0 / (robot.leg_length * robot.leg_length);
    W.diagonal().setConstant(per_length);
    for (const Link& link : robot.links)
      if (link.coordinate >= 0 && link.coordinate < robot.num_coordinates() && link.joint != JointKind::slide)
        W(link.coordinate, link.coordinate) = 1.0;
  }

  const double weight = robot.weight();
  const double total = weight / robot.mechanism.gravity();
  // Newton's law of the whole robot: the last row of M a + h + g
  const double F_z = robot.fixed_root() ? total : (M * a_d + equation.h + equation.g)(a_d.size() - 1);
  Rows rows(J.rows());
  torque_unit.setConstant(joints, weight * robot.leg_length);
  w_unit.setConstant(J.rows(), weight);
  contact_unit.setOnes(J.rows());
  for (const Side side : kSides)
  {
    const Index at = row_of(robot, support, side);
    if (at < 0)
      continue;
    const Foot& foot = robot.foot(side);
    const Constrained& constrained = settings.methods.of<Constrained>();
    double f_min = constrained.f_min.value_or(foot.f_min);
    if (const auto share = window(support, side); share && constrained.windows)
      f_min = std::min(f_min, std::max(0.0, *share * F_z));
    rows.add(at, Vector2d(0.0, 1.0), f_min, weight);
    rows.add(at, Vector2d(1.0, foot.friction), 0.0, weight);
    rows.add(at, Vector2d(-1.0, foot.friction), 0.0, weight);
    if (support.of(side) != Contact::sole)
      continue;
    const double length = foot.toe_x() - foot.heel_x();
    const auto [heel, toe] = ends(foot, support, side, settings.nearest.margin, constrained.windows);
    const Vector2d along = along_sole(motion.now, foot);
    rows.add(at, about(foot, along, heel), 0.0, weight * length);
    rows.add(at, -about(foot, along, toe), 0.0, weight * length);
    w_unit(at + 2) = weight * length;
    contact_unit(at + 2) = 1.0 / length; // an angle × sole length counts as a length
  }
  conditions = rows.all;
  windows = Rows(J.rows()).all;

  least.resize(joints);
  most.resize(joints);
  const bool follows = memory.answered && memory.stream_id == desired.stream_id && memory.utime < desired.utime;
  for (int j = 0; j < joints; ++j)
  {
    const Actuator& actuator = robot.actuators[static_cast<std::size_t>(j)];
    most(j) = actuator.torque_limit;
    least(j) = -most(j);
    if (settings.rate_limits == OnExcess::clamp && follows)
    {
      const double step = actuator.rate_limit * 1e-6 * static_cast<double>(desired.utime - memory.utime);
      most(j) = std::min(most(j), memory.torque(j) + step);
      least(j) = std::max(least(j), memory.torque(j) - step);
    }
  }
}

void NearestProblem::set_windows(const Robot& robot, const AnswerSettings& settings, const DesiredState& desired,
                                 const VectorXd& a)
{
  Rows rows(J.rows());
  const Support& support = desired.support;
  const Motion motion = completed(robot, desired);
  const EquationOfMotion equation = equation_of_motion(robot, motion, support, Coordinates::absolute);
  const double F_z = (M * a + equation.h + equation.g)(a.size() - 1);
  for (const Side side : kSides)
  {
    const Index at = row_of(robot, support, side);
    if (at < 0 || !settings.methods.of<Constrained>().windows)
      continue;
    const Foot& foot = robot.foot(side);
    const double weight = robot.weight();
    if (const auto share = window(support, side))
      rows.add(at, Vector2d(0.0, -1.0), -*share * F_z, weight);
    const Contact beside = support.of(other(side));
    if (support.of(side) != Contact::sole || beside == Contact::sole || beside == Contact::none)
      continue;
    const double length = foot.toe_x() - foot.heel_x();
    const Vector3d moment = about(foot, along_sole(motion.now, foot), foot.heel_x() + support.phase * length);
    rows.add(at, side == support.leading ? Vector3d(-moment) : moment, 0.0, weight * length);
  }
  windows = rows.all;
}

double NearestProblem::residual(const Answered& found) const
{
  const VectorXd ground = J.transpose() * found.w, motors = B * found.torque;
  const VectorXd left = M * found.a + f - motors - ground;
  const double terms = std::max({1.0, (M.cwiseAbs() * found.a.cwiseAbs()).maxCoeff(), f.cwiseAbs().maxCoeff(),
                                 ground.cwiseAbs().maxCoeff(), motors.cwiseAbs().maxCoeff()});
  return left.allFinite() ? left.cwiseAbs().maxCoeff() / terms : std::numeric_limits<double>::infinity();
}

double NearestProblem::contact_error(const Answered& found) const
{
  if (J.rows() == 0)
    return 0.0;
  const VectorXd left = J * found.a - b;
  const double terms = std::max({1.0, (J.cwiseAbs() * found.a.cwiseAbs()).maxCoeff(), b_terms.maxCoeff()});
  return left.allFinite() ? left.cwiseAbs().maxCoeff() / terms : std::numeric_limits<double>::infinity();
}

double NearestProblem::out_of_range(const Answered& found) const
{
  return std::max({0.0, (found.torque - most).maxCoeff(), (least - found.torque).maxCoeff()});
}

VectorXd NearestProblem::lacking(const Answered& found) const
{
  return (conditions.h - conditions.G * found.w).cwiseMax(0.0);
}

bool NearestProblem::full_rank() const
{
  if (J.rows() == 0)
    return true;
  const VectorXd values = singular_values(J);
  return values.minCoeff() > 1e-6 * values.maxCoeff();
}

namespace
{

// The columns of multipliers that may be used at an answer, in units of torques and reactions: of motors at an end of
// their range, and of rows that hold with no room.
struct Columns
{
  const NearestProblem& problem;
  MatrixXd all;

  explicit Columns(const NearestProblem& of) : problem(of), all(of.torque_unit.size() + of.w_unit.size(), 0) {}
  void add(const VectorXd& column)
  {
    all.conservativeResize(Eigen::NoChange, all.cols() + 1);
    all.col(all.cols() - 1) = column.cwiseProduct(units());
  }
  VectorXd units() const
  {
    VectorXd result(problem.torque_unit.size() + problem.w_unit.size());
    result << problem.torque_unit, problem.w_unit;
    return result;
  }
  void add_motors(const Answered& found)
  {
    const VectorXd unit = problem.torque_unit;
    for (Index j = 0; j < unit.size(); ++j)
    {
      if (found.torque(j) - problem.least(j) <= kActive * unit(j))
        add(VectorXd::Unit(all.rows(), j));
      if (problem.most(j) - found.torque(j) <= kActive * unit(j))
        add(-VectorXd::Unit(all.rows(), j));
    }
  }
  void add_rows(const ReactionRows& rows, const Answered& found)
  {
    for (Index i = 0; i < rows.h.size(); ++i)
      if (rows.G.row(i).dot(found.w) - rows.h(i) <= kActive)
      {
        VectorXd column = VectorXd::Zero(all.rows());
        column.tail(found.w.size()) = rows.G.row(i).transpose();
        add(column);
      }
  }
};

// τ's and w's rows, one above the other
MatrixXd stacked(const MatrixXd& torque_rows, const MatrixXd& w_rows)
{
  MatrixXd all(torque_rows.rows() + w_rows.rows(), torque_rows.cols());
  all << torque_rows, w_rows;
  return all;
}

} // namespace

double NearestProblem::motion_gradient_left(const Answered& found) const
{
  // with λ of (1) and ν of the contacts:  W δ + M λ + Jᵀ ν = 0,  −Bᵀ λ = α − β,  −J λ = Gᵀ μ
  const Eigen::LLT<MatrixXd> factors(M);
  const VectorXd delta = found.a - a_d;
  const VectorXd p = factors.solve(W * delta);
  const MatrixXd Y = factors.solve(J.transpose());
  Columns columns(*this);
  columns.add_motors(found);
  columns.add_rows(conditions, found);
  const VectorXd units = columns.units();
  const VectorXd t = units.asDiagonal() * stacked(B.transpose() * p, J * p);
  const MatrixXd N = units.asDiagonal() * stacked(B.transpose() * Y, J * Y);
  // rounding of the motion is rounding of its change
  const VectorXd rounding =
      units.asDiagonal() * stacked(B.transpose().cwiseAbs() * p.cwiseAbs(), J.cwiseAbs() * p.cwiseAbs());
  const double rest = 1e-4 * found.a.norm() * units.maxCoeff();
  return left_of(columns.all, N, t, std::max(rounding.norm(), rest));
}

double NearestProblem::violation_gradient_left(const Answered& found) const
{
  const VectorXd v = lacking(found);
  const Eigen::LLT<MatrixXd> factors(M);
  const MatrixXd Y = factors.solve(J.transpose());
  Columns columns(*this);
  columns.add_motors(found);
  const VectorXd units = columns.units();
  const VectorXd t = -(units.asDiagonal() * stacked(VectorXd::Zero(torque_unit.size()), conditions.G.transpose() * v));
  const MatrixXd N = units.asDiagonal() * stacked(B.transpose() * Y, J * Y);
  return left_of(columns.all, N, t, std::max(t.norm(), 1.0));
}

double NearestProblem::choice_gradient_left(const Answered& found, const VectorXd& by_torque, const VectorXd& by_w,
                                            double nothing) const
{
  Columns columns(*this);
  columns.add_motors(found);
  columns.add_rows(conditions, found);
  columns.add_rows(windows, found);
  const VectorXd units = columns.units();
  const VectorXd t = units.asDiagonal() * stacked(by_torque, by_w);
  const MatrixXd N = units.asDiagonal() * stacked(B.transpose(), J);
  return left_of(columns.all, N, t, std::max(t.norm(), nothing));
}

NearestProblem::Reduced NearestProblem::reduced() const
{
  // u = (τ, w) in units: a = a_free + F u, and the contacts' rows C u = d, in least squares where they contradict
  const Index joints = torque_unit.size(), n_w = w_unit.size();
  const Eigen::LLT<MatrixXd> factors(M);
  MatrixXd force(a_d.size(), joints + n_w);
  force << B * torque_unit.asDiagonal(), J.transpose() * w_unit.asDiagonal();
  const MatrixXd F = factors.solve(force);
  const VectorXd a_free = -factors.solve(f);
  VectorXd u0 = VectorXd::Zero(joints + n_w);
  MatrixXd N = MatrixXd::Identity(joints + n_w, joints + n_w);
  if (n_w > 0)
  {
    const VectorXd scale = contact_unit.cwiseInverse();
    const MatrixXd C = scale.asDiagonal() * J * F;
    const VectorXd d = scale.asDiagonal() * (b - J * a_free);
    Eigen::JacobiSVD<MatrixXd> svd(C, Eigen::ComputeFullV | Eigen::ComputeThinU);
    svd.setThreshold(1e-9);
    u0 = svd.solve(d);
    N = svd.matrixV().rightCols(C.cols() - svd.rank());
  }
  // the objective's own axes
  const MatrixXd L = W.llt().matrixU();
  const MatrixXd effect = L * F * N;
  Eigen::JacobiSVD<MatrixXd> svd(effect, Eigen::ComputeFullV | Eigen::ComputeThinU);
  svd.setThreshold(1e-9);
  const MatrixXd V = N * svd.matrixV();
  const Index n = V.cols(), rank = svd.rank();
  Reduced reduced;
  reduced.size = VectorXd::Zero(n);
  reduced.at = VectorXd::Zero(n);
  reduced.size.head(rank) = svd.singularValues().head(rank);
  const VectorXd a0 = a_free + F * u0;
  reduced.at.head(rank) = svd.matrixU().leftCols(rank).transpose() * (L * (a0 - a_d));
  reduced.a0 = a0;
  reduced.a_y = F * V;
  reduced.a_y.rightCols(n - rank).setZero();
  reduced.torque0 = torque_unit.asDiagonal() * u0.head(joints);
  reduced.torque_y = torque_unit.asDiagonal() * V.topRows(joints);
  reduced.w0 = w_unit.asDiagonal() * u0.tail(n_w);
  reduced.w_y = w_unit.asDiagonal() * V.bottomRows(n_w);
  return reduced;
}

NearestProblem::Feasible NearestProblem::feasible() const
{
  // rows K y ≥ k. There is no y if some z ≥ 0 has Kᵀ z = 0 and kᵀ z > 0 [Farkas]; else the least such sum gives the
  // shortest y [Lawson, Hanson 1974, LDP].
  const Reduced all = reduced();
  const Index n = all.size.size();
  MatrixXd K(0, n);
  VectorXd k(0);
  const auto add = [&](const VectorXd& row, double bound)
  {
    K.conservativeResize(K.rows() + 1, Eigen::NoChange);
    k.conservativeResize(K.rows());
    K.bottomRows(1) = row.transpose();
    k(k.size() - 1) = bound;
  };
  for (Index i = 0; i < conditions.h.size(); ++i)
    add(all.w_y.transpose() * conditions.G.row(i).transpose(), conditions.h(i) - conditions.G.row(i).dot(all.w0));
  for (Index j = 0; j < torque_unit.size(); ++j)
    if (std::isfinite(most(j)))
    {
      add(all.torque_y.row(j).transpose() / torque_unit(j), (least(j) - all.torque0(j)) / torque_unit(j));
      add(-all.torque_y.row(j).transpose() / torque_unit(j), (all.torque0(j) - most(j)) / torque_unit(j));
    }
  if (k.size() == 0 || k.maxCoeff() <= 0.0)
    return Feasible::yes;
  MatrixXd E(n + 1, k.size());
  E << K.transpose(), k.transpose();
  const VectorXd unit = VectorXd::Unit(n + 1, n);
  const VectorXd rest = E * non_negative_least_squares(E, unit) - unit;
  if (rest.norm() > 1e-9 && rest(n) < 0.0)
  {
    const VectorXd y = -rest.head(n) / rest(n);
    if ((k - K * y).maxCoeff() <= 1e-9)
      return Feasible::yes;
  }
  return rest.norm() < 1e-7 ? Feasible::no : Feasible::undecided;
}

Answered answered(const Robot& robot, const DesiredState& desired, const Answer& answer)
{
  const Support& support = desired.support;
  const Motion motion = completed(robot, desired);
  Answered found;
  const int n = robot.num_coordinates();
  found.a.resize(n + (robot.fixed_root() ? 0 : 2));
  found.a.head(n) = answer.a;
  if (!robot.fixed_root())
    found.a.tail<2>() = answer.base_a;
  found.torque = answer.torque;
  found.moment_at_point = 0.0;
  Index components = 0;
  for (const Side side : kSides)
    if (row_of(robot, support, side) >= 0)
      components += wrench_components(support.of(side));
  found.w.resize(components);
  for (const Side side : kSides)
  {
    const Index at = row_of(robot, support, side);
    if (at < 0)
      continue;
    const Wrench& wrench = answer.ground[static_cast<std::size_t>(side)].wrench;
    const Vector2d force(wrench.fx, wrench.fz);
    found.w.segment<2>(at) = force;
    if (support.of(side) == Contact::sole)
    {
      found.w(at + 2) = wrench.moment;
      continue;
    }
    const Foot& foot = robot.foot(side);
    const Vector2d lever = position(motion.now, support.of(side) == Contact::heel ? foot.heel : foot.toe) -
                           position(motion.now, foot.ankle);
    const double moment = wrench.moment - (lever.x() * force.y() - lever.y() * force.x());
    found.moment_at_point = std::max(found.moment_at_point, std::abs(moment) / (robot.weight() * robot.leg_length));
  }
  return found;
}

} // namespace torqued::oracle
