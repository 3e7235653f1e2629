#include "catch.h"
#include "double_support.h"
#include "matchers.h"
#include "run_torquectl.h"
#include "temporary_folder.h"

#include "answer/answer.h"
#include "motion/lcm_log.h"
#include "motion/trajectory.h"
#include "robot/files/load.h"
#include "stance/projection.h"

#include <cmath>

namespace projection_test
{

using namespace torqued;
using oracle::Vector9;

namespace
{

constexpr double kOnContact = 1e-9;  // m, rad, and per s and s²
constexpr double kUnchanged = 1e-12; // likewise
constexpr double kReported = 0.01;   // of what is reported

// A walk as its file has it; the base point's numbers last, if it is given.
struct Sample
{
  oracle::Motion motion;
  std::array<Contact, 2> contact;
  double t;
};

Contact contact_of(const std::string& name)
{
  for (const Contact contact : {Contact::none, Contact::heel, Contact::sole, Contact::toe})
    if (name == name_of(contact))
      return contact;
  throw std::invalid_argument(name);
}

const char* const kNames[] = {"q0", "q1", "q2", "q3", "q4", "q5", "q6", "xH", "zH"};

std::vector<Sample> read_walk(const std::string& path)
{
  const auto lines = rows(path);
  const auto at = [&](const std::string& name)
  {
    return static_cast<std::size_t>(std::find(lines[0].begin(), lines[0].end(), name) - lines[0].begin());
  };
  std::vector<Sample> samples;
  for (std::size_t i = 1; i < lines.size(); ++i)
  {
    Sample& sample = samples.emplace_back();
    for (Eigen::Index k = 0; k < 9; ++k)
      for (auto [vector, prefix] :
           {std::pair(&sample.motion.X, ""), std::pair(&sample.motion.V, "d"), std::pair(&sample.motion.A, "dd")})
      {
        const std::size_t column = at(prefix + std::string(kNames[k]));
        (*vector)(k) = column < lines[0].size() ? std::stod(lines[i][column]) : 0.0;
      }
    sample.contact = {contact_of(lines[i][at("contactL")]), contact_of(lines[i][at("contactR")])};
    sample.t = 1e-6 * std::stod(lines[i][at("utime")]);
  }
  return samples;
}

std::string write_walk(const std::vector<Sample>& samples, bool base_given)
{
  std::string text = "utime";
  const int n = base_given ? 9 : 7;
  for (const char* prefix : {"", "d", "dd"})
    for (int k = 0; k < n; ++k)
      text += std::string(",") + prefix + kNames[k];
  text += ",contactL,contactR\n";
  for (const Sample& sample : samples)
  {
    text += fmt::format("{}", std::llround(1e6 * sample.t));
    for (const Vector9* vector : {&sample.motion.X, &sample.motion.V, &sample.motion.A})
      for (int k = 0; k < n; ++k)
        text += fmt::format(",{:.17g}", (*vector)(k));
    text += fmt::format(",{},{}\n", name_of(sample.contact[0]), name_of(sample.contact[1]));
  }
  return text;
}

// Waves on every coordinate, up to 1 mrad and 1 mm, with their derivatives.
void disturb(std::vector<Sample>& samples, oracle::Random& random)
{
  for (Eigen::Index k = 0; k < 9; ++k)
    for (int wave = 0; wave < 3; ++wave)
    {
      const double size = 1e-3 / 3.0, omega = oracle::uniform(random, 3.0, 40.0);
      const double begin = oracle::uniform(random, 0.0, 6.0);
      for (Sample& sample : samples)
      {
        sample.motion.X(k) += size * std::sin(omega * sample.t + begin);
        sample.motion.V(k) += size * omega * std::cos(omega * sample.t + begin);
        sample.motion.A(k) -= size * omega * omega * std::sin(omega * sample.t + begin);
      }
    }
}

// world x of the heel if the foot were flat where it is
double mark(const oracle::Biped& biped, Side side, Contact contact, const Vector9& X)
{
  const double x = biped.contact_point(side, contact, X).x();
  return contact == Contact::heel ? x : contact == Contact::toe ? x - biped.l_p - biped.l_p1 : x - biped.l_p;
}

double largest(const Eigen::VectorXd& values)
{
  return values.size() > 0 ? values.cwiseAbs().maxCoeff() : 0.0;
}

// what a sample's contacts miss, x apart
struct Missed
{
  double height = 0.0, tilt = 0.0, speed = 0.0, acceleration = 0.0;
};

Missed missed(const oracle::Biped& biped, const Sample& sample)
{
  Missed missed;
  for (const Side side : kSides)
  {
    const auto& [X, V, A] = sample.motion;
    const Contact contact = sample.contact[static_cast<std::size_t>(side)];
    if (contact == Contact::none)
      continue;
    const double height = contact == Contact::sole ? biped.h_p : 0.0;
    missed.height = std::max(missed.height, std::abs(biped.contact_point(side, contact, X).y() - height));
    if (contact == Contact::sole)
      missed.tilt = std::max(missed.tilt, std::abs(X(side == Side::left ? 0 : 5)));
    const Eigen::MatrixXd J = biped.J(side, contact, X);
    missed.speed = std::max(missed.speed, largest(J * V));
    missed.acceleration = std::max(missed.acceleration, largest(J * A + biped.Jdot_V(side, contact, X, V)));
  }
  return missed;
}

// A number of the report, by the words before it.
double reported(const std::string& report, const std::string& what)
{
  const std::size_t line = report.find("\n  " + what + "  ");
  CAPTURE(report, what);
  REQUIRE(line != std::string::npos);
  return std::stod(report.substr(line + what.size() + 3));
}

} // namespace

TEST_CASE("a disturbed walk is moved back onto its contacts, and how far is told", "[projection]")
{
  const TemporaryFolder folder;
  oracle::Random random(701);
  for (const std::string name : {"ck", "rk"})
  {
    CAPTURE(name);
    const oracle::Biped biped = name == "ck" ? oracle::Biped() : oracle::shipped_rk();
    const std::string walk = folder.file("walk.csv"), projected = folder.file("projected.csv");
    REQUIRE(run({"gait", "--robot", name, "--rate", "50", "-o", walk}).code == 0);
    std::vector<Sample> samples = read_walk(walk);
    const std::vector<Sample> clean = samples;
    disturb(samples, random);
    const std::string disturbed = folder.write("disturbed.csv", write_walk(samples, true));
    const Run done = run({"project", disturbed, "--robot", name, "-o", projected});
    CAPTURE(done.err);
    REQUIRE(done.code == 0);
    const std::vector<Sample> moved = read_walk(projected);
    REQUIRE(moved.size() == samples.size());

    // on its contacts, each stance at one place
    Missed before;
    for (std::size_t i = 0; i < moved.size(); ++i)
    {
      CAPTURE(i);
      CHECK(moved[i].contact == samples[i].contact);
      const Missed now = missed(biped, moved[i]), was = missed(biped, samples[i]);
      CHECK(now.height < kOnContact);
      CHECK(now.tilt < kOnContact);
      CHECK(now.speed < kOnContact);
      CHECK(now.acceleration < kOnContact);
      before.tilt = std::max(before.tilt, was.tilt);
      before.speed = std::max(before.speed, was.speed);
      before.acceleration = std::max(before.acceleration, was.acceleration);
      // and where it was, as well as 1 mm and 1 mrad of noise let one know: legs lift it by a lever of 1 m / 0.4 m
      CHECK((moved[i].motion.X - clean[i].motion.X).cwiseAbs().maxCoeff() < 0.01);
    }
    double farthest = 0.0;
    for (const Side side : kSides)
    {
      const auto k = static_cast<std::size_t>(side);
      for (std::size_t i = 0; i < moved.size();)
      {
        std::size_t end = i;
        double mean = 0.0;
        for (; end < moved.size() && moved[end].contact[k] != Contact::none; ++end)
          mean += mark(biped, side, samples[end].contact[k], samples[end].motion.X);
        mean /= static_cast<double>(end - i);
        for (std::size_t j = i; j < end; ++j)
        {
          CAPTURE(j);
          CHECK(std::abs(mark(biped, side, moved[j].contact[k], moved[j].motion.X) - mean) < kOnContact);
          const Eigen::Vector2d point = biped.contact_point(side, samples[j].contact[k], samples[j].motion.X);
          const double height = samples[j].contact[k] == Contact::sole ? biped.h_p : 0.0;
          farthest =
              std::max(farthest, std::hypot(point.y() - height,
                                            mark(biped, side, samples[j].contact[k], samples[j].motion.X) - mean));
        }
        i = std::max(end, i + 1);
      }
    }

    // the report
    std::array<double, 2> by_angle{}, by_base{};
    double rate = 0.0, acceleration = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < moved.size(); ++i)
    {
      const Vector9 change = moved[i].motion.X - samples[i].motion.X;
      by_angle[0] = std::max(by_angle[0], change.head<7>().cwiseAbs().maxCoeff());
      by_base[0] = std::max(by_base[0], change.tail<2>().cwiseAbs().maxCoeff());
      squares += change.head<7>().squaredNorm();
      rate = std::max(rate, (moved[i].motion.V - samples[i].motion.V).head<7>().cwiseAbs().maxCoeff());
      acceleration = std::max(acceleration, (moved[i].motion.A - samples[i].motion.A).head<7>().cwiseAbs().maxCoeff());
    }
    CHECK(by_angle[0] > 1e-4);
    CHECK(std::abs(reported(done.out, "position") / farthest - 1.0) < kReported);
    CHECK(std::abs(reported(done.out, "angle of a sole") / before.tilt - 1.0) < kReported);
    CHECK(std::abs(reported(done.out, "speed") / before.speed - 1.0) < kReported);
    CHECK(std::abs(reported(done.out, "acceleration") / before.acceleration - 1.0) < kReported);
    CHECK(std::abs(reported(done.out, "coordinates") / by_angle[0] - 1.0) < kReported);
    CHECK(std::abs(reported(done.out, "base point") / by_base[0] - 1.0) < kReported);
    CHECK(std::abs(reported(done.out, "coordinates' rates") / rate - 1.0) < kReported);
    CHECK(std::abs(reported(done.out, "coordinates' accelerations") / acceleration - 1.0) < kReported);
    const std::size_t rms = done.out.find("rms", done.out.find("\n  coordinates  "));
    CHECK(
        std::abs(std::stod(done.out.substr(rms + 4)) / std::sqrt(squares / (7.0 * static_cast<double>(moved.size()))) -
                 1.0) < kReported);

    // a second time nothing is left to do, and nothing was to do with the walk as it was made
    for (const std::string& consistent : {projected, walk})
    {
      const std::string again = folder.file("again.csv");
      REQUIRE(run({"project", consistent, "--robot", name, "-o", again}).code == 0);
      const std::vector<Sample> one = read_walk(consistent), two = read_walk(again);
      for (std::size_t i = 0; i < one.size(); ++i)
      {
        CAPTURE(consistent, i);
        CHECK(mismatch(two[i].motion.X, one[i].motion.X, kUnchanged) == "");
        CHECK(mismatch(two[i].motion.V, one[i].motion.V, kUnchanged) == "");
        CHECK(mismatch(two[i].motion.A, one[i].motion.A, kUnchanged) == "");
      }
    }
  }
}

TEST_CASE("without a base point the feet keep their distance", "[projection]")
{
  const TemporaryFolder folder;
  oracle::Random random(702);
  const oracle::Biped biped;
  const std::string walk = folder.file("walk.csv"), projected = folder.file("projected.csv");
  REQUIRE(run({"gait", "--robot", "ck", "--rate", "50", "-o", walk}).code == 0);
  std::vector<Sample> samples = read_walk(walk);
  disturb(samples, random);
  const Run done =
      run({"project", folder.write("disturbed.csv", write_walk(samples, false)), "--robot", "ck", "-o", projected});
  CAPTURE(done.err);
  REQUIRE(done.code == 0);
  CHECK(done.out.find("base point") == std::string::npos);
  const std::string table = read_file(projected);
  CHECK(table.substr(0, table.find('\n')).find("xH") == std::string::npos);

  const Robot ck = load_robot("ck");
  const Trajectory moved = parse_trajectory(table, projected, coordinate_names(ck), false, Channels());
  std::vector<std::byte> buffer;
  double distance = NAN; // in the sample before, if that was in double support
  int both = 0;
  for (const desired_state_t& message : moved.states)
  {
    const auto state = std::get<DesiredState>(decode_desired_state(encode(message, buffer), ck));
    const auto equations = std::get<SupportEquations>(support_equations(ck, state));
    CHECK(equations.contact_speed < kOnContact);
    CHECK(equations.contact_residual < kOnContact);
    CHECK(equations.sole_tilt < kOnContact);
    if (state.support.redundancy() == 0)
    {
      distance = NAN;
      continue;
    }
    ++both;
    double apart = 0.0;
    for (const Side side : kSides)
    {
      const Contact contact = state.support.of(side);
      const FootPose& foot = equations.foot(side);
      CHECK(std::abs(foot.point(contact).y() - (contact == Contact::sole ? biped.h_p : 0.0)) < kOnContact);
      apart += (side == Side::left ? 1.0 : -1.0) * foothold(ck, equations.now, side, contact);
    }
    CHECK_FALSE(std::abs(apart - distance) >= kOnContact);
    distance = apart;
  }
  CHECK(both > 20);
}

TEST_CASE("the projection is the nearest motion that keeps the contacts, for every pair of contacts", "[projection]")
{
  oracle::Random random(703);
  for (const Contact left : {Contact::heel, Contact::sole, Contact::toe, Contact::none})
    for (const Contact right : {Contact::heel, Contact::sole, Contact::toe})
      for (int i = 0; i < kCases / 5; ++i)
      {
        CAPTURE(name_of(left), name_of(right), i);
        const Stance stance{left == Contact::none ? Contact::toe : left, right, i % 4 < 2 ? Side::left : Side::right};
        auto [biped, motion] = posed(random, i, stance);
        for (Eigen::Index k = 0; k < 9; ++k)
          motion.X(k) += oracle::uniform(random, -1e-3, 1e-3);
        const Robot robot = biped.robot();
        const DesiredState desired = oracle::desired_state(motion, left, right);
        const auto result = project(robot, desired);
        REQUIRE(std::holds_alternative<Projection>(result));
        const Projection& found = std::get<Projection>(result);

        const Sample before{motion, {left, right}, 0.0};
        const Sample after{{found.state.q, found.state.v, found.state.a}, {left, right}, 0.0};
        const Missed now = missed(biped, after), was = missed(biped, before);
        CHECK(now.height < kOnContact);
        CHECK(now.tilt < kOnContact);
        CHECK(now.speed < kOnContact);
        CHECK(now.acceleration < kOnContact);
        // without footholds, x is where it is
        CHECK(mismatch(found.before.position, was.height, 1e-9) == "");
        CHECK(mismatch(found.before.tilt, was.tilt, 1e-9) == "");
        CHECK(mismatch(found.before.speed, was.speed, 1e-9) == "");
        CHECK(mismatch(found.before.acceleration, was.acceleration, 1e-9) == "");

        // nearest: the scaled change has no part in the motions that the contacts leave free
        const double length = robot.leg_length;
        const Vector9 scale = (Vector9() << Eigen::Matrix<double, 7, 1>::Constant(length), 1.0, 1.0).finished();
        Eigen::MatrixXd J(desired.support.wrench_components(), 9);
        J << biped.J(Side::left, left, after.motion.X), biped.J(Side::right, right, after.motion.X);
        const Eigen::MatrixXd free = oracle::kernel(J * scale.cwiseInverse().asDiagonal());
        const auto orthogonal = [&](const Vector9& change)
        {
          return (free.transpose() * scale.cwiseProduct(change)).cwiseAbs().maxCoeff();
        };
        CHECK(orthogonal(after.motion.V - motion.V) < 1e-9 * (1.0 + motion.V.norm()));
        CHECK(orthogonal(after.motion.A - motion.A) < 1e-8 * (1.0 + motion.A.norm()));
        // of the pose up to the turn of J on the way, which is as small as the way
        const Vector9 way = after.motion.X - motion.X;
        CHECK(orthogonal(way) < 100.0 * way.squaredNorm() + 1e-12);
      }
}

TEST_CASE("a foot that is fixed to the world stays there", "[projection]")
{
  const Robot six_link = load_robot("six-link");
  DesiredState desired{};
  desired.support = {{Contact::sole, Contact::heel}, Side::right, 0.5, 0.5};
  const int n = six_link.mechanism.num_q();
  desired.q = desired.v = desired.a = VectorQ::Zero(n);
  // stance shin and thigh, trunk, swing thigh, shin and foot: the swinging leg before the other one, its heel near the
  // ground
  desired.q.head<6>() << -0.15, -0.05, 0.0, 0.3, 0.05, 0.1;
  Motion motion = std::get<Motion>(complete_motion(six_link, desired));
  // down to the ground by the stance leg
  for (int i = 0; i < 60; ++i)
  {
    const double z = position(motion.now, six_link.foot(Side::right).heel).y();
    desired.q(0) -= 0.2 * z;
    desired.q(1) -= 0.2 * z;
    motion = std::get<Motion>(complete_motion(six_link, desired));
  }
  const double z = position(motion.now, six_link.foot(Side::right).heel).y();
  CAPTURE(z);
  REQUIRE(std::abs(z) < 0.02);
  desired.v.head<6>() << 0.1, -0.2, 0.3, -0.4, 0.5, -0.6;
  desired.a.head<6>() << 1.0, -2.0, 3.0, -4.0, 5.0, -6.0;
  const Projection found = std::get<Projection>(project(six_link, desired));
  CHECK(mismatch(found.before.position, std::abs(z), 1e-9) == "");
  CHECK(found.state.q.tail(n - 6).isApprox(
      (Eigen::VectorXd(n - 6) << Eigen::VectorXd::Zero(n - 8), motion.now.base).finished(), 1e-12));
  CHECK(found.state.v.tail(n - 6).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(found.state.a.tail(n - 6).cwiseAbs().maxCoeff() < 1e-12);
  const auto equations = std::get<SupportEquations>(support_equations(six_link, found.state));
  CHECK(equations.contact_speed < kOnContact);
  CHECK(equations.contact_residual < kOnContact);
  CHECK(std::abs(equations.foot(Side::right).heel.y()) < kOnContact);
}

TEST_CASE("what is not near its contacts is not moved there", "[projection]")
{
  oracle::Random random(704);
  const oracle::Biped ck;
  const Stance stance{Contact::sole, Contact::sole, Side::right};
  const oracle::Motion motion = pose(random, ck, stance).value();
  const Robot robot = ck.robot();
  const auto refused = [&](const oracle::Motion& moved, const Footholds& footholds = {})
  {
    const auto result = project(robot, oracle::desired_state(moved, Contact::sole, Contact::sole), footholds);
    const Refusal* refusal = std::get_if<Refusal>(&result);
    return refusal ? fmt::format("{}: {}", name_of(refusal->reason()), refusal->detail()) : "answered";
  };
  CHECK(refused(motion) == "answered");
  oracle::Motion high = motion;
  high.X(8) += 0.1;
  // both feet are as far, to rounding
  CHECK(refused(high).starts_with("INCONSISTENT: the "));
  CHECK(refused(high).find(" foot is 0.1 m from where its contact has it") != std::string::npos);
  oracle::Motion tilted = motion;
  tilted.X(5) += 0.2;
  CHECK(refused(tilted).find("a sole tilts by 0.2 rad; a motion is projected from up to 0.0395 m and 0.1 rad") !=
        std::string::npos);
  // feet farther apart than straight legs reach, by little
  oracle::Motion wide = motion;
  wide.X.head<6>() << 0.0, -0.5, -0.5, 0.5, 0.5, 0.0;
  wide.X(8) += ck.h_p - ck.ankle(Side::left, wide.X).y();
  Footholds apart{mark(ck, Side::left, Contact::sole, wide.X) - 0.03,
                  mark(ck, Side::right, Contact::sole, wide.X) + 0.03};
  CHECK(refused(wide, apart) == "answered"); // the hip comes down
  wide.X.head<6>() << 0.0, -M_PI / 2, -M_PI / 2, M_PI / 2, M_PI / 2, 0.0;
  wide.X(8) += ck.h_p - ck.ankle(Side::left, wide.X).y();
  apart = {mark(ck, Side::left, Contact::sole, wide.X) - 0.01, mark(ck, Side::right, Contact::sole, wide.X) + 0.01};
  CHECK(refused(wide, apart).starts_with("INCONSISTENT: no motion nearby keeps both contacts: "));
}

TEST_CASE("with project = true the projection is answered, and what was wrong before is told", "[projection]")
{
  oracle::Random random(705);
  for (int i = 0; i < kCases / 5; ++i)
  {
    CAPTURE(i);
    const Stance stance{Contact::sole, i % 2 == 0 ? Contact::heel : Contact::sole, Side::right};
    auto [biped, motion] = posed(random, i, stance);
    const Robot robot = biped.robot();
    AnswerSettings plain, moving;
    moving.project = true;
    const DesiredState off = oracle::desired_state(motion, stance.left, stance.right, stance.leading, 0.4);
    StreamMemory fresh[4];
    const auto found = answer(robot, moving, off, fresh[0]);
    const auto without = answer(robot, plain, off, fresh[1]);
    REQUIRE(std::holds_alternative<Answer>(found));
    const Answer& answered = std::get<Answer>(found);
    CHECK((answered.flags & flag::projected) != 0);
    CHECK((answered.flags & flag::inconsistent) != 0);
    CHECK(mismatch(answered.contact_speed, std::get<Answer>(without).contact_speed, 1e-12) == "");
    CHECK(mismatch(answered.contact_residual, std::get<Answer>(without).contact_residual, 1e-12) == "");
    CHECK((std::get<Answer>(without).flags & flag::projected) == 0);

    const DesiredState on = std::get<DesiredState>(answered_motion(robot, moving, off));
    CHECK(std::get<DesiredState>(answered_motion(robot, plain, off)).v == off.v);
    const Answer direct = std::get<Answer>(answer(robot, plain, on, fresh[2]));
    CHECK((direct.flags & (flag::projected | flag::inconsistent)) == 0);
    CHECK(answered.torque == direct.torque);
    CHECK(answered.zmp == direct.zmp);
    // the accelerations are those of the motion that was answered, beside how far they were moved
    CHECK(answered.a == direct.a);
    CHECK(answered.base_a == direct.base_a);
    CHECK(answered.adjustment == (on.a - off.a).head(robot.num_coordinates()).cwiseAbs().maxCoeff());
    CHECK(answered.adjustment > 0.0);
    CHECK(direct.adjustment == 0.0);
    DesiredState asked_relative = off;
    const auto in_relative = [&robot](const VectorQ& a) -> VectorQ
    {
      const int n = robot.num_coordinates();
      return robot.A.topLeftCorner(n, n) * a.head(n);
    };
    asked_relative.relative_a = in_relative(off.a);
    StreamMemory unused;
    const Answer relative = std::get<Answer>(answer(robot, moving, asked_relative, unused));
    CHECK(mismatch(relative.a, in_relative(on.a), 1e-12) == "");
    CHECK(mismatch(relative.adjustment, in_relative(on.a - off.a).cwiseAbs().maxCoeff(), 1e-9) == "");
    CHECK(relative.torque == answered.torque);
    // what keeps its contacts is answered as without, and without the flag
    const Answer same = std::get<Answer>(answer(robot, moving, on, fresh[3]));
    CHECK((same.flags & flag::projected) == 0);
    CHECK(same.a == on.a.head(robot.num_coordinates()));
    CHECK(same.adjustment == 0.0);
    CHECK(mismatch(same.torque, direct.torque, 1e-9) == "");

    // a tolerance is one of the motion as it was sent
    moving.consistency = OnExcess::refuse;
    const auto refused = answer(robot, moving, off, fresh[0]);
    REQUIRE(std::holds_alternative<Refusal>(refused));
    CHECK(std::get<Refusal>(refused).reason() == Reason::inconsistent);
  }
}

TEST_CASE("joint wrenches are those of the motion that was answered", "[projection]")
{
  const TemporaryFolder folder;
  oracle::Random random(706);
  REQUIRE(run({"gait", "--robot", "ck", "--rate", "50", "--steps", "1", "-o", folder.file("walk.csv")}).code == 0);
  std::vector<Sample> samples = read_walk(folder.file("walk.csv"));
  disturb(samples, random);
  const std::string disturbed = folder.write("disturbed.csv", write_walk(samples, true));
  const std::string config = folder.write("c.toml", "robot = \"ck\"\nproject = true\n");
  const std::string table = folder.file("w.csv"), answers = folder.file("a.csv");
  REQUIRE(run({"wrenches", disturbed, "--config", config, "-o", table}).code == 0);
  REQUIRE(run({"eval", disturbed, "--config", config, "-o", answers}).code == 0);
  const auto wrenches = rows(table), answered = rows(answers);
  REQUIRE(wrenches.size() == samples.size() + 1);
  const auto at = [](const std::vector<std::string>& names, const std::string& name)
  {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  for (std::size_t i = 1; i < wrenches.size(); ++i)
    for (const std::string joint : {"tau_left_ankle", "tau_right_knee"})
      CHECK(mismatch(std::stod(wrenches[i][at(wrenches[0], joint)]), std::stod(answered[i][at(answered[0], joint)]),
                     1e-9) == "");
}

TEST_CASE("torquectl project says what it cannot use", "[projection]")
{
  const TemporaryFolder folder;
  const std::string walk = folder.file("walk.csv"), out = folder.file("out.csv");
  REQUIRE(run({"gait", "--robot", "ck", "--steps", "1", "--rate", "20", "-o", walk}).code == 0);
  const auto says = [](const std::vector<std::string>& words)
  {
    const Run done = run(words);
    return fmt::format("{} {}", done.code, done.err);
  };
  CHECK(
      says({"project", walk, "-o", folder.file("out.lcm")}) ==
      fmt::format("64 torquectl: -o: found \"{}\"; expected a name that ends in .csv, or -\n", folder.file("out.lcm")));
  CHECK(says({"project", walk, "-o", walk}).starts_with("64 torquectl: "));
  const std::string measured = TRAJECTORIES "/subject01-walk/walk.csv";
  CHECK(says({"project", measured, "--robot", "human-subject01", "-o", out})
            .starts_with("65 torquectl: " + measured + ":"));
  CHECK_FALSE(std::filesystem::exists(out)); // nothing half done
  // a log whose base comes and goes
  const std::string mixed = folder.file("mixed.lcm");
  const Robot ck = load_robot("ck");
  Trajectory states = parse_trajectory(read_file(walk), walk, coordinate_names(ck), false, Channels());
  LogWriter log(mixed);
  std::vector<std::byte> buffer;
  states.states[1].base = desired_state_t::FROM_CONTACT;
  for (const std::size_t i : {0U, 1U})
    log.write("TORQUED_DESIRED", states.states[i].utime, encode(states.states[i], buffer));
  log.close();
  CHECK(says({"project", mixed, "--robot", "ck", "-o", out}) ==
        fmt::format("65 torquectl: {}: record 1: base is FROM_CONTACT; expected it GIVEN in all desired states, or "
                    "FROM_CONTACT in all\n",
                    mixed));
  // on the standard output: the table and nothing else
  const Run terminal = run({"project", walk, "--robot", "ck", "-o", "-"});
  CHECK(terminal.out.starts_with("utime,q0,"));
  CHECK(terminal.out.find("moved") == std::string::npos);
  CHECK(terminal.err.find("and was moved by up to\n") != std::string::npos);
}

} // namespace projection_test
