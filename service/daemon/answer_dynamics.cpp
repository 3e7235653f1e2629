#include "daemon/answer_dynamics.h"

#include "wire/finite.h"

#include <algorithm>

namespace torqued
{

namespace
{

template <typename Matrix> void copy_matrix(const Matrix& from, std::vector<std::vector<double>>& to)
{
  // rows beyond the matrix keep their memory, and are not sent
  if (to.size() < static_cast<std::size_t>(from.rows()))
    to.resize(static_cast<std::size_t>(from.rows()));
  for (Eigen::Index row = 0; row < from.rows(); ++row)
    to[static_cast<std::size_t>(row)].assign(from.row(row).begin(), from.row(row).end());
}

template <typename Vector> void copy_vector(const Vector& from, std::vector<double>& to)
{
  to.assign(from.begin(), from.end());
}

template <typename Matrix> bool all(const Matrix& matrix)
{
  return std::all_of(matrix.data(), matrix.data() + matrix.size(), is_finite);
}

bool finite(const EquationOfMotion& equation, const Eigen::MatrixXd& Y)
{
  return all(equation.M) && all(equation.C) && all(equation.h) && all(equation.g) && all(equation.J) &&
         all(equation.Jdot_v) && all(equation.generalized_force) && all(Y);
}

bool finite(const Elimination& elimination, const ReducedForm& reduced)
{
  return all(elimination.F) && all(elimination.Fdot) && all(elimination.F_bar) && all(reduced.mass) &&
         all(reduced.coriolis) && all(reduced.gravity) && all(reduced.input);
}

constexpr std::string_view kNotFinite = "a result is not finite; the motion's numbers are too large";

} // namespace

void refuse_request(dynamics_t& reply, const Robot& robot, std::int64_t request_id, std::string_view error)
{
  reply.request_id = request_id;
  reply.model_id = robot.model_id;
  reply.error = error;
  reply.n = reply.num_joints = reply.num_contact_rows = reply.num_parameters = 0;
  reply.num_reduced = reply.num_multipliers = 0;
}

void describe_motion(dynamics_t& reply, const Robot& robot, const std::vector<BaseParameter>& parameters,
                     const Motion& motion, const Support& support, Coordinates coordinates,
                     std::optional<EliminationMethod> elimination)
{
  const EquationOfMotion equation = equation_of_motion(robot, motion, support, coordinates);
  const Eigen::MatrixXd Y = regressor(robot, parameters, motion);
  if (!finite(equation, Y))
    return refuse_request(reply, robot, reply.request_id, kNotFinite);
  reply.model_id = robot.model_id;
  reply.error.clear();
  reply.n = equation.n;
  reply.num_joints = robot.num_joints();
  reply.num_contact_rows = static_cast<std::int32_t>(equation.J.rows());
  reply.num_parameters = static_cast<std::int32_t>(parameters.size());
  reply.num_reduced = reply.num_multipliers = 0;
  copy_matrix(equation.M, reply.M);
  copy_matrix(equation.C, reply.C);
  copy_vector(equation.h, reply.h);
  copy_vector(equation.g, reply.g);
  copy_matrix(equation.B, reply.B);
  copy_matrix(equation.J, reply.J);
  copy_vector(equation.Jdot_v, reply.Jdot_v);
  copy_vector(equation.generalized_force, reply.generalized_force);

  Eigen::MatrixXd shown(equation.n, Y.cols());
  reply.alpha.clear();
  for (std::size_t i = 0; i < parameters.size(); ++i)
  {
    const auto column = static_cast<Eigen::Index>(i);
    shown.col(column) = in_coordinates(robot, Y.col(column), coordinates);
    reply.alpha.push_back(parameters[i].value);
  }
  copy_matrix(shown, reply.Y);
  if (!elimination)
  {
    // of what is not wanted there are rows of no length
    for (auto* matrix : {&reply.F, &reply.Fdot, &reply.F_bar})
      matrix->resize(static_cast<std::size_t>(equation.n));
    return;
  }

  const Result<Elimination> eliminated = eliminate(equation.J, equation.Jdot, *elimination);
  if (const Refusal* refusal = std::get_if<Refusal>(&eliminated))
    return refuse_request(reply, robot, reply.request_id, refusal->detail());
  const Elimination& found = std::get<Elimination>(eliminated);
  const ReducedForm reduced = reduced_form(equation, found);
  if (!finite(found, reduced))
    return refuse_request(reply, robot, reply.request_id, kNotFinite);
  reply.num_reduced = static_cast<std::int32_t>(found.F.cols());
  reply.num_multipliers = static_cast<std::int32_t>(found.F_bar.cols());
  copy_matrix(found.F, reply.F);
  copy_matrix(found.Fdot, reply.Fdot);
  copy_matrix(found.F_bar, reply.F_bar);
  copy_matrix(reduced.mass, reply.reduced_mass);
  copy_matrix(reduced.coriolis, reply.reduced_coriolis);
  copy_vector(reduced.gravity, reply.reduced_gravity);
  copy_matrix(reduced.input, reply.reduced_input);
}

void answer_dynamics(const Robot& robot, const std::vector<BaseParameter>& parameters, Bytes request, dynamics_t& reply)
{
  const Result<DynamicsRequest> decoded = decode_dynamics_request(request, robot);
  if (const Refusal* refusal = std::get_if<Refusal>(&decoded))
    return refuse_request(reply, robot, read_request_id(request), refusal->detail());
  const DynamicsRequest& wanted = std::get<DynamicsRequest>(decoded);
  const Result<Motion> motion = complete_motion(robot, wanted.state);
  if (const Refusal* refusal = std::get_if<Refusal>(&motion))
    return refuse_request(reply, robot, wanted.request_id, refusal->detail());
  reply.request_id = wanted.request_id;
  static const std::vector<BaseParameter> none;
  describe_motion(reply, robot, wanted.want_regressor ? parameters : none, std::get<Motion>(motion),
                  wanted.state.support, wanted.coordinates,
                  wanted.want_reduced ? std::optional(EliminationMethod::partitioning) : std::nullopt);
}

} // namespace torqued
