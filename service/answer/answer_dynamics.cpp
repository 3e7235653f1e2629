#include "answer/answer_dynamics.h"

#include "wire/finite.h"

#include <algorithm>

namespace torqued
{

namespace
{

// Both return whether all numbers are finite.
template <typename Vector> bool copy_vector(const Vector& from, std::vector<double>& to)
{
  to.assign(from.begin(), from.end());
  return std::ranges::all_of(to, is_finite);
}

template <typename Matrix> bool copy_matrix(const Matrix& from, std::vector<std::vector<double>>& to)
{
  // rows beyond the matrix keep their memory, and are not sent
  if (to.size() < static_cast<std::size_t>(from.rows()))
    to.resize(static_cast<std::size_t>(from.rows()));
  bool finite = true;
  for (Eigen::Index row = 0; row < from.rows(); ++row)
    finite &= copy_vector(from.row(row), to[static_cast<std::size_t>(row)]);
  return finite;
}

constexpr std::string_view kNotFinite = "a result is not finite; the motion's numbers are too large";

// Y and alpha of the reply; whether all of Y is finite
bool describe_parameters(dynamics_t& reply, const Robot& robot, const std::vector<BaseParameter>& parameters,
                         const Motion& motion, Coordinates coordinates)
{
  const auto rows = static_cast<std::size_t>(reply.n);
  reply.num_parameters = static_cast<std::int32_t>(parameters.size());
  reply.alpha.resize(parameters.size());
  reply.Y.resize(rows);
  for (std::vector<double>& row : reply.Y)
    row.resize(parameters.size());
  bool finite = true;
  for (std::size_t i = 0; i < parameters.size(); ++i)
  {
    reply.alpha[i] = parameters[i].value;
    const VectorQ column = in_coordinates(robot, regressor_column(robot, parameters[i], motion), coordinates);
    for (std::size_t row = 0; row < rows; ++row)
      reply.Y[row][i] = column(static_cast<Eigen::Index>(row));
    finite = finite && std::ranges::all_of(column, is_finite);
  }
  return finite;
}

int num_rows(const Robot& robot)
{
  return robot.num_coordinates() + (robot.fixed_root() ? 0 : 2);
}

} // namespace

void reserve(dynamics_t& reply, const Robot& robot, const std::vector<BaseParameter>& parameters)
{
  constexpr int contact_rows = 6;
  reply.error.reserve(256); // more than a refusal's detail
  reply.n = reply.num_reduced = num_rows(robot);
  reply.num_joints = robot.num_joints();
  reply.num_contact_rows = reply.num_multipliers = contact_rows;
  reply.num_parameters = static_cast<std::int32_t>(parameters.size());
  const auto n = static_cast<std::size_t>(reply.n);
  const auto joints = static_cast<std::size_t>(reply.num_joints);
  const auto matrix = [](std::vector<std::vector<double>>& rows, std::size_t height, std::size_t width)
  {
    rows.assign(height, std::vector<double>(width));
  };
  matrix(reply.M, n, n);
  matrix(reply.C, n, n);
  matrix(reply.B, n, joints);
  matrix(reply.J, contact_rows, n);
  matrix(reply.Y, n, parameters.size());
  matrix(reply.F, n, n);
  matrix(reply.Fdot, n, n);
  matrix(reply.F_bar, n, contact_rows);
  matrix(reply.reduced_mass, n, n);
  matrix(reply.reduced_coriolis, n, n);
  matrix(reply.reduced_input, n, joints);
  for (std::vector<double>* vector : {&reply.h, &reply.g, &reply.generalized_force, &reply.reduced_gravity})
    vector->resize(n);
  reply.Jdot_v.resize(contact_rows);
  reply.alpha.resize(parameters.size());
}

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
  reply.model_id = robot.model_id;
  reply.error.clear();
  reply.n = equation.n;
  reply.num_joints = robot.num_joints();
  reply.num_contact_rows = static_cast<std::int32_t>(equation.J.rows());
  reply.num_reduced = reply.num_multipliers = 0;
  bool finite =
      copy_matrix(equation.M, reply.M) && copy_matrix(equation.C, reply.C) && copy_vector(equation.h, reply.h) &&
      copy_vector(equation.g, reply.g) && copy_matrix(equation.B, reply.B) && copy_matrix(equation.J, reply.J) &&
      copy_vector(equation.Jdot_v, reply.Jdot_v) && copy_vector(equation.generalized_force, reply.generalized_force);
  if (!finite || !describe_parameters(reply, robot, parameters, motion, coordinates))
    return refuse_request(reply, robot, reply.request_id, kNotFinite);
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
  reply.num_reduced = static_cast<std::int32_t>(found.F.cols());
  reply.num_multipliers = static_cast<std::int32_t>(found.F_bar.cols());
  finite = copy_matrix(found.F, reply.F) && copy_matrix(found.Fdot, reply.Fdot) &&
           copy_matrix(found.F_bar, reply.F_bar) && copy_matrix(reduced.mass, reply.reduced_mass) &&
           copy_matrix(reduced.coriolis, reply.reduced_coriolis) &&
           copy_vector(reduced.gravity, reply.reduced_gravity) && copy_matrix(reduced.input, reply.reduced_input);
  if (!finite)
    refuse_request(reply, robot, reply.request_id, kNotFinite);
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
  const std::vector<BaseParameter> none;
  describe_motion(reply, robot, wanted.want_regressor ? parameters : none, std::get<Motion>(motion),
                  wanted.state.support, wanted.coordinates,
                  wanted.want_reduced ? std::optional(EliminationMethod::partitioning) : std::nullopt);
}

} // namespace torqued
