#include "catch.h"
#include "decode_dynamics.h"
#include "matchers.h"
#include "states.h"

#include "answer/answer_dynamics.h"
#include "robot/files/load.h"

#include <functional>
#include <map>

namespace answer_dynamics_test
{

using namespace torqued;

namespace
{

dynamics_request_t request_for(const Robot& robot, oracle::Random& random)
{
  dynamics_request_t request{};
  request.request_id = 77;
  if (robot.foot(Side::left).exists())
    request.left_contact = robot.is_root(robot.foot(Side::left)) || robot.foot(Side::left).has_extent()
                               ? dynamics_request_t::SOLE
                               : dynamics_request_t::HEEL;
  if (robot.foot(Side::right).exists())
    request.right_contact = robot.is_root(robot.foot(Side::right)) ? dynamics_request_t::SOLE : dynamics_request_t::TOE;
  const State state = of_mechanism(robot, random_state(random, robot));
  request.num_coordinates = robot.num_coordinates();
  const auto head = [&](const VectorQ& from)
  {
    return std::vector<double>(from.data(), from.data() + robot.num_coordinates());
  };
  request.q = head(state.q);
  request.v = head(state.v);
  request.a = head(state.a);
  for (int i = 0; i < 2 && !robot.fixed_root(); ++i)
  {
    request.base_v[i] = oracle::uniform(random, -1.0, 1.0);
    request.base_a[i] = oracle::uniform(random, -1.0, 1.0);
  }
  return request;
}

dynamics_t answer_to(const Robot& robot, Bytes request)
{
  static std::map<std::int64_t, std::vector<BaseParameter>> parameters; // by model_id: they take a while
  const auto known = parameters.find(robot.model_id);
  const auto& of_robot = known != parameters.end()
                             ? known->second
                             : parameters.emplace(robot.model_id, base_parameters(robot)).first->second;
  dynamics_t reply{};
  answer_dynamics(robot, of_robot, request, reply);
  std::vector<std::byte> buffer;
  dynamics_t heard;
  REQUIRE(decode(encode(reply, buffer), heard));
  return heard;
}

dynamics_t answer_to(const Robot& robot, const dynamics_request_t& request)
{
  std::vector<std::byte> buffer;
  return answer_to(robot, encode(request, buffer));
}

// columns: of a matrix that may have no rows
Eigen::MatrixXd matrix(const std::vector<std::vector<double>>& rows, Eigen::Index columns)
{
  Eigen::MatrixXd result(rows.size(), columns);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < rows[i].size(); ++j)
      result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j];
  return result;
}

Eigen::MatrixXd matrix(const std::vector<std::vector<double>>& rows)
{
  return matrix(rows, rows.empty() ? 0 : static_cast<Eigen::Index>(rows.front().size()));
}

Eigen::VectorXd vector(const std::vector<double>& numbers)
{
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

Eigen::VectorXd rates(const Robot& robot, const std::vector<double>& head, const double* base)
{
  Eigen::VectorXd all(robot.num_coordinates() + (robot.fixed_root() ? 0 : 2));
  all.head(robot.num_coordinates()) = vector(head);
  if (!robot.fixed_root())
    all.tail<2>() << base[0], base[1];
  return all;
}

} // namespace

TEST_CASE("an answer is the equation of motion at the state that was asked for, in both kinds of coordinates",
          "[answer_dynamics]")
{
  oracle::Random random(1);
  for (const Robot& robot : all_kinds_of_motors())
    for (int i = 0; i < 20; ++i)
    {
      CAPTURE(robot.name, i);
      dynamics_request_t request = request_for(robot, random);
      request.want_regressor = 1;
      const dynamics_t absolute = answer_to(robot, request);
      REQUIRE(absolute.error == "");
      CHECK(absolute.request_id == 77);
      CHECK(absolute.model_id == robot.model_id);
      CHECK(absolute.n == robot.num_coordinates() + (robot.fixed_root() ? 0 : 2));
      CHECK(absolute.num_joints == robot.num_joints());

      const Eigen::VectorXd v = rates(robot, request.v, request.base_v);
      const Eigen::VectorXd a = rates(robot, request.a, request.base_a);
      const Eigen::MatrixXd M = matrix(absolute.M), C = matrix(absolute.C);
      const Eigen::VectorXd force = vector(absolute.generalized_force);
      CHECK(mismatch(vector(absolute.h), C * v, 1e-11) == "");
      CHECK(mismatch(M * a + vector(absolute.h) + vector(absolute.g), force, 1e-11) == "");

      // what motors take, as the robot's own friction gives it
      VectorQ theta_v = VectorQ::Zero(robot.mechanism.num_theta()), theta_a = theta_v;
      theta_v.head(robot.num_coordinates()) = v.head(robot.num_coordinates());
      theta_a.head(robot.num_coordinates()) = a.head(robot.num_coordinates());
      const Eigen::MatrixXd B = matrix(absolute.B);
      Eigen::VectorXd taken(robot.num_joints());
      for (int j = 0; j < robot.num_joints(); ++j)
      {
        const Actuator& motor = robot.actuators[static_cast<std::size_t>(j)];
        const double rate = B.col(j).dot(v), acceleration = B.col(j).dot(a);
        const double sign = rate > 0.0 ? 1.0 : -1.0;
        taken(j) = motor.rotor_inertia * acceleration + motor.coulomb * sign + motor.viscous * rate +
                   motor.stribeck * sign * std::exp(-std::pow(rate / motor.stribeck_velocity, 2)) +
                   motor.friction_offset;
      }
      CHECK(mismatch(matrix(absolute.Y) * vector(absolute.alpha), force + B * taken, 1e-10) == "");

      // the same question in relative coordinates
      const int n = robot.num_coordinates();
      const Eigen::MatrixXd A = robot.A.topLeftCorner(n, n);
      dynamics_request_t relative_request = request;
      relative_request.coordinates = dynamics_request_t::RELATIVE;
      const auto related = [&](const std::vector<double>& from, bool offset)
      {
        Eigen::VectorXd to = A * vector(from);
        if (offset)
          to += robot.b.head(n);
        return std::vector<double>(to.data(), to.data() + n);
      };
      relative_request.q = related(request.q, true);
      relative_request.v = related(request.v, false);
      relative_request.a = related(request.a, false);
      const dynamics_t relative = answer_to(robot, relative_request);
      Eigen::MatrixXd map = Eigen::MatrixXd::Identity(absolute.n, absolute.n);
      map.topLeftCorner(n, n) = A;
      CHECK(mismatch(map.transpose() * matrix(relative.M) * map, M, 1e-11) == "");
      CHECK(mismatch(map.transpose() * matrix(relative.C) * map, C, 1e-11) == "");
      CHECK(mismatch(map.transpose() * vector(relative.g), vector(absolute.g), 1e-11) == "");
      CHECK(mismatch(map.transpose() * matrix(relative.B), B, 1e-11) == "");
      if (absolute.num_contact_rows > 0)
        CHECK(mismatch(matrix(relative.J) * map, matrix(absolute.J), 1e-11) == "");
      CHECK(mismatch(vector(relative.Jdot_v), vector(absolute.Jdot_v), 1e-11) == "");
      CHECK(mismatch(map.transpose() * matrix(relative.Y), matrix(absolute.Y), 1e-11) == "");
    }
}

TEST_CASE("the contacts that were asked for have their rows, a fixed root's own none", "[answer_dynamics]")
{
  oracle::Random random(2);
  const Robot ck = load_robot("ck");
  dynamics_request_t request = request_for(ck, random);
  CHECK(answer_to(ck, request).num_contact_rows == 5);
  request.right_contact = dynamics_request_t::NONE;
  CHECK(answer_to(ck, request).num_contact_rows == 3);
  request.left_contact = dynamics_request_t::NONE;
  const dynamics_t flight = answer_to(ck, request);
  CHECK(flight.num_contact_rows == 0);
  CHECK(flight.num_parameters == 0);
  CHECK(flight.error == "");
  const Robot six = load_robot("six-link");
  CHECK(answer_to(six, request_for(six, random)).num_contact_rows == 2);
  const Robot compass = load_robot("compass");
  CHECK(answer_to(compass, request_for(compass, random)).num_contact_rows == 0);
}

TEST_CASE("a bad request is answered with one line that says what would be right", "[answer_dynamics]")
{
  oracle::Random random(3);
  const Robot ck = load_robot("ck");
  struct Row
  {
    std::function<void(dynamics_request_t&)> damage;
    std::string error;
  };
  const std::vector<Row> rows{
      {[](auto& r) { r.coordinates = 2; }, "coordinates is 2; expected ABSOLUTE (0) or RELATIVE (1)"},
      {[](auto& r) { r.left_contact = -1; }, "left_contact is -1; expected NONE (0), HEEL (1), SOLE (2) or TOE (3)"},
      {[](auto& r) { r.right_contact = 4; }, "right_contact is 4; expected NONE (0), HEEL (1), SOLE (2) or TOE (3)"},
      {[](auto& r) { r.want_regressor = 2; }, "want_regressor is 2; expected 0 or 1"},
      {[](auto& r) { r.want_reduced = 3; }, "want_reduced is 3; expected 0 or 1"},
      {[](auto& r) { r.base_v[1] = NAN; }, "base_v[1] is nan; expected a finite number"},
      {[](auto& r) { r.base_a[0] = INFINITY; }, "base_a[0] is inf; expected a finite number"},
      {[](auto& r) { r.q[3] = NAN; }, "q[3] is nan; expected a finite number"},
      {[](auto& r) { r.v[0] = -INFINITY; }, "v[0] is -inf; expected a finite number"},
      {[](auto& r) { r.a[6] = NAN; }, "a[6] is nan; expected a finite number"},
      {[](auto& r) { r.v[6] = 1e200; }, "a result is not finite; the motion's numbers are too large"},
      {[](auto& r)
       {
         r.num_coordinates = 6;
         r.q.pop_back();
         r.v.pop_back();
         r.a.pop_back();
       },
       "num_coordinates is 6; expected 7 for ck"},
  };
  for (const Row& row : rows)
  {
    dynamics_request_t request = request_for(ck, random);
    row.damage(request);
    const dynamics_t reply = answer_to(ck, request);
    CHECK(reply.error == row.error);
    CHECK(reply.request_id == 77);
    CHECK(reply.n == 0);
    CHECK(reply.M.empty());
  }
  const Robot compass = load_robot("compass");
  dynamics_request_t request = request_for(compass, random);
  request.base_v[0] = 1.0;
  CHECK(answer_to(compass, request).error ==
        "base_v is (1, 0) and base_a (0, 0); the root of compass is fixed: all are 0");
  request.base_v[0] = 0.0;
  request.left_contact = dynamics_request_t::HEEL;
  CHECK(answer_to(compass, request).error.find("stands as SOLE (2)") != std::string::npos);
}

TEST_CASE("the reduced form that is asked for eliminates the contacts of the same equation", "[answer_dynamics]")
{
  oracle::Random random(5);
  int requests = 0, reduced = 0;
  for (const Robot& robot : all_kinds_of_robots())
    for (int i = 0; i < kStates / 20; ++i)
      for (const std::int8_t coordinates : {dynamics_request_t::ABSOLUTE, dynamics_request_t::RELATIVE})
      {
        CAPTURE(robot.name, i, static_cast<int>(coordinates));
        dynamics_request_t request = request_for(robot, random);
        request.coordinates = coordinates;
        request.want_reduced = 1;
        ++requests;
        const dynamics_t reply = answer_to(robot, request);
        request.want_reduced = 0;
        const dynamics_t without = answer_to(robot, request);
        REQUIRE(without.error == "");
        CHECK(without.num_reduced == 0);
        CHECK(without.num_multipliers == 0);
        if (reply.error != "")
        {
          // contacts that depend on each other: more rows than coordinates, or nearly
          CHECK((reply.error.starts_with("the contacts are not independent: ") ||
                 reply.error.starts_with("the contacts have ")));
          CHECK(reply.n == 0);
          continue;
        }
        ++reduced;
        CHECK(reply.num_multipliers == reply.num_contact_rows);
        REQUIRE(reply.num_reduced == reply.n - reply.num_contact_rows);
        const Eigen::MatrixXd M = matrix(reply.M, reply.n), C = matrix(reply.C, reply.n),
                              B = matrix(reply.B, reply.num_joints), J = matrix(reply.J, reply.n),
                              F = matrix(reply.F, reply.num_reduced), Fdot = matrix(reply.Fdot, reply.num_reduced),
                              F_bar = matrix(reply.F_bar, reply.num_multipliers);
        CHECK(M == matrix(without.M, without.n));
        // F and F̄ grow where contacts nearly depend on each other
        const double size = std::max(
            {1.0, F.size() > 0 ? F.cwiseAbs().maxCoeff() : 0.0, F_bar.size() > 0 ? F_bar.cwiseAbs().maxCoeff() : 0.0});
        const double rounding = 1e-12 * size * size;
        CHECK(mismatch(J * F, Eigen::MatrixXd::Zero(J.rows(), F.cols()), rounding) == "");
        CHECK(mismatch(J * F_bar, Eigen::MatrixXd::Identity(J.rows(), J.rows()), rounding) == "");
        CHECK(mismatch(matrix(reply.reduced_mass, reply.num_reduced), F.transpose() * M * F, rounding) == "");
        CHECK(mismatch(matrix(reply.reduced_coriolis, reply.num_reduced), F.transpose() * (M * Fdot + C * F),
                       rounding) == "");
        CHECK(mismatch(vector(reply.reduced_gravity), F.transpose() * vector(reply.g), rounding) == "");
        CHECK(mismatch(matrix(reply.reduced_input, reply.num_joints), F.transpose() * B, rounding) == "");
        // z' are coordinates' rates: rows of the unit matrix, in order
        Eigen::Index next = 0;
        for (Eigen::Index row = 0; row < F.rows() && next < F.cols(); ++row)
          next += F.row(row) == Eigen::MatrixXd::Identity(F.cols(), F.cols()).row(next) ? 1 : 0;
        CHECK(next == F.cols());
      }
  CAPTURE(requests, reduced);
  CHECK(reduced > 0.6 * requests);
}

TEST_CASE("a request that is cut, extended or no request at all is answered with an error", "[answer_dynamics]")
{
  oracle::Random random(4);
  const Robot ck = load_robot("ck");
  std::vector<std::byte> buffer;
  const Bytes whole = encode(request_for(ck, random), buffer);
  CHECK(whole.size() == dynamics_request_size(ck));
  for (std::size_t size = 0; size < whole.size(); ++size)
  {
    const dynamics_t reply = answer_to(ck, whole.first(size));
    CHECK_FALSE(reply.error.empty());
    CHECK(reply.request_id == (size >= 16 ? 77 : 0));
  }
  std::vector<std::byte> longer(whole.begin(), whole.end());
  for (int extra = 0; extra < 100; ++extra)
  {
    longer.push_back(std::byte{0});
    CHECK(answer_to(ck, longer).error.find("size is ") == 0);
  }
  for (int i = 0; i < 5000; ++i)
  {
    std::vector<std::byte> bytes(random() % 400);
    for (std::byte& byte : bytes)
      byte = static_cast<std::byte>(random());
    CHECK(answer_to(ck, bytes).error.find("the fingerprint is not that of torqued.dynamics_request_t") == 0);
  }
  for (int i = 0; i < 5000; ++i)
  {
    // anything behind the fingerprint: answered or refused, never worse
    std::vector<std::byte> bytes(whole.begin(), whole.end());
    for (int k = 0; k < 4; ++k)
      bytes[8 + random() % (bytes.size() - 8)] = static_cast<std::byte>(random());
    answer_to(ck, bytes);
  }
}

} // namespace answer_dynamics_test
