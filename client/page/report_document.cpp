#include "page/report_page.h"
#include "study/answer_table.h"
#include "study/world_path.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

namespace torqued
{

namespace
{

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "columns are written as they lie in memory");

// RFC 4648
std::string base64(const void* data, std::size_t size)
{
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::string text;
  text.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3)
  {
    const std::size_t left = std::min<std::size_t>(3, size - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < left ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= left ? digits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

template <typename Number> std::string base64(const std::vector<Number>& column)
{
  return base64(column.data(), column.size() * sizeof(Number));
}

using Column = std::vector<float>;

// A quantity along a motion: a name, and its value at a sample.
struct Quantity
{
  std::string name;
  std::function<double(std::size_t)> at;
  bool bits = false; // flags: of several samples, those of all
};

// Which samples a page holds: every `stride`-th as a frame; of a motion that has too many, curves over `per_stretch`
// samples each.
struct Thinning
{
  std::size_t samples, stride, per_stretch;

  Thinning(std::size_t count, const Resolution& resolution)
      : samples(count), stride((count + resolution.frames - 1) / resolution.frames),
        per_stretch(stride > 1 ? (count + resolution.stretches - 1) / resolution.stretches : 0)
  {
  }
};

std::int32_t bits_of(const Quantity& quantity, std::size_t from, std::size_t to)
{
  std::int32_t bits = 0;
  for (std::size_t i = from; i < to; ++i)
    if (const double value = quantity.at(i); !std::isnan(value))
      bits |= static_cast<std::int32_t>(value);
  return bits;
}

Column frames(const Quantity& quantity, const Thinning& thinning)
{
  Column column;
  for (std::size_t i = 0; i < thinning.samples; i += thinning.stride)
  {
    const std::size_t end = std::min(i + thinning.stride, thinning.samples);
    column.push_back(static_cast<float>(quantity.bits ? bits_of(quantity, i, end) : quantity.at(i)));
  }
  return column;
}

// of each stretch the least and the largest value, in the order in which they come; twice NaN where there is none
Column extremes(const Quantity& quantity, const Thinning& thinning)
{
  Column column;
  for (std::size_t from = 0; from < thinning.samples; from += thinning.per_stretch)
  {
    double least = NAN, most = NAN;
    bool least_first = true;
    for (std::size_t i = from; i < std::min(from + thinning.per_stretch, thinning.samples); ++i)
    {
      const double value = quantity.at(i);
      if (std::isnan(value))
        continue;
      if (!(value >= least))
      {
        least = value;
        least_first = false;
      }
      if (!(value <= most))
      {
        most = value;
        least_first = true;
      }
    }
    column.push_back(static_cast<float>(least_first ? least : most));
    column.push_back(static_cast<float>(least_first ? most : least));
  }
  return column;
}

Json table(const std::vector<Quantity>& quantities, const std::function<Column(const Quantity&)>& column)
{
  Json columns = Json::object();
  for (const Quantity& quantity : quantities)
    columns[quantity.name] = base64(column(quantity));
  return columns;
}

// columns by frame, and by stretch of a motion that has too many samples
void add_columns(Json& to, const std::vector<Quantity>& quantities, const Thinning& thinning)
{
  to["frames"] = table(quantities, [&](const Quantity& quantity) { return frames(quantity, thinning); });
  if (thinning.per_stretch == 0)
    return;
  std::vector<Quantity> curves;
  std::copy_if(quantities.begin(), quantities.end(), std::back_inserter(curves),
               [](const Quantity& q) { return !q.bits; });
  to["curves"] = table(curves, [&](const Quantity& quantity) { return extremes(quantity, thinning); });
}

Json pair(const Eigen::Vector2d& point)
{
  return {point.x(), point.y()};
}

// infinity: null
Json limit(double value)
{
  return std::isfinite(value) ? Json(value) : Json();
}

// The strokes that draw a link: its own; of a robot without any, as URDFs are, from its joint to the next ones, along
// its foot, or else to twice its centre of mass.
std::vector<Segment> strokes(const Robot& robot, int index)
{
  if (std::any_of(robot.links.begin(), robot.links.end(), [](const Link& link) { return !link.drawing.empty(); }))
    return robot.link(index).drawing;
  const double width = 0.03 * robot.leg_length;
  std::vector<Segment> found;
  const auto add = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to)
  {
    if (!from.isApprox(to))
      found.push_back({from, to, width});
  };
  for (const Link& link : robot.links)
    if (link.parent == index)
      add(Eigen::Vector2d::Zero(), link.at);
  for (const Foot& foot : robot.feet)
    if (foot.link == index)
    {
      add(Eigen::Vector2d::Zero(), foot.ankle_at);
      add(foot.heel_at, foot.toe_at);
    }
  if (found.empty())
    add(Eigen::Vector2d::Zero(), 2.0 * robot.link(index).com);
  return found;
}

// what the picture of the robot is made of
Json describe(const Robot& robot)
{
  Json links = Json::array();
  for (const Link& link : robot.links)
  {
    Json segments = Json::array();
    for (const Segment& segment : strokes(robot, static_cast<int>(&link - robot.links.data())))
      segments.push_back({segment.from.x(), segment.from.y(), segment.to.x(), segment.to.y(), segment.width});
    const std::optional<Side>& leg = robot.leg[static_cast<std::size_t>(&link - robot.links.data())];
    links.push_back({{"name", link.name},
                     {"parent", link.parent},
                     {"at", pair(link.at)},
                     {"rolling", link.joint == JointKind::rolling},
                     {"parent_radius", link.parent_radius},
                     {"radius", link.child_radius},
                     {"side", leg ? Json(name_of(*leg)) : Json()},
                     {"segments", std::move(segments)}});
  }
  Json joints = Json::array();
  for (const Actuator& actuator : robot.actuators)
  {
    // the link whose frame begins at the joint
    const int child =
        robot.link(actuator.on).parent == actuator.against || robot.link(actuator.against).parent != actuator.on
            ? actuator.on
            : actuator.against;
    joints.push_back({{"name", actuator.name},
                      {"child", child},
                      {"limit", limit(actuator.torque_limit)},
                      {"unit", robot.link(child).joint == JointKind::slide ? "N" : "N m"}});
  }
  Json feet = Json::array();
  for (const Foot& foot : robot.feet)
    if (foot.exists())
      feet.push_back({{"side", name_of(foot.side)},
                      {"link", foot.link},
                      {"ankle", pair(foot.ankle_at)},
                      {"heel", pair(foot.heel_at)},
                      {"toe", pair(foot.toe_at)},
                      {"friction", foot.friction}});
  return {{"name", robot.name},        {"weight", robot.weight()},    {"leg_length", robot.leg_length},
          {"links", std::move(links)}, {"joints", std::move(joints)}, {"feet", std::move(feet)}};
}

// the poses of a motion's frames: x, z and angle of each link; NaN where its contacts cannot be
struct Poses
{
  Column numbers;
  double distance = 0.0;                     // that the base goes over the whole motion, m
  std::array<std::vector<double>, 2> angles; // of the feet by sample, rad; NaN as above
};

Poses find_poses(const Robot& robot, const std::vector<DesiredState>& states, const Thinning& thinning)
{
  Poses poses;
  WorldPath path(robot);
  std::optional<double> start;
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    const std::optional<Kinematics> now = path.next(states[i]);
    if (now)
    {
      start = start.value_or(now->base.x());
      poses.distance = now->base.x() - *start;
    }
    for (const Side side : kSides)
    {
      const Foot& foot = robot.foot(side);
      const bool known = now && foot.exists();
      const Eigen::Vector2d e = known ? heading(robot.link(foot.link), *now) : Eigen::Vector2d(NAN, NAN);
      poses.angles[static_cast<std::size_t>(side)].push_back(std::atan2(e.y(), e.x()));
    }
    if (i % thinning.stride != 0)
      continue;
    for (const Link& link : robot.links)
    {
      const Eigen::Vector2d at = now ? position(*now, link.origin) : Eigen::Vector2d(NAN, NAN);
      const Eigen::Vector2d e = now ? heading(link, *now) : Eigen::Vector2d(NAN, NAN);
      poses.numbers.insert(poses.numbers.end(), {static_cast<float>(at.x()), static_cast<float>(at.y()),
                                                 static_cast<float>(std::atan2(e.y(), e.x()))});
    }
  }
  return poses;
}

std::vector<Quantity> answer_quantities(const Robot& robot, const ReportRun& run)
{
  std::vector<Quantity> quantities;
  const auto add = [&](const std::string& name, auto value)
  {
    quantities.push_back({name, [&run, value](std::size_t i)
                          {
                            return run.answers[i] ? static_cast<double>(value(*run.answers[i])) : NAN;
                          }});
  };
  for (int j = 0; j < robot.num_joints(); ++j)
    add("tau_" + robot.actuators[static_cast<std::size_t>(j)].name, [j](const Answer& a) { return a.torque(j); });
  for (const Side side : kSides)
  {
    const auto s = static_cast<std::size_t>(side);
    const std::string letter = side == Side::left ? "L" : "R";
    add("fx" + letter, [s](const Answer& a) { return a.ground[s].wrench.fx; });
    add("fz" + letter, [s](const Answer& a) { return a.ground[s].wrench.fz; });
    add("moment" + letter, [s](const Answer& a) { return a.ground[s].wrench.moment; });
    // there is no centre of pressure without load
    add("cop" + letter, [s, &robot](const Answer& a)
        { return std::abs(a.ground[s].wrench.fz) < kNoLoad * robot.weight() ? NAN : a.ground[s].cop; });
  }
  add("dynamics_residual", [](const Answer& a) { return a.dynamics_residual; });
  add("contact_speed", [](const Answer& a) { return a.contact_speed; });
  add("contact_residual", [](const Answer& a) { return a.contact_residual; });
  add("method", [](const Answer& a) { return static_cast<double>(a.method); });
  add("flags", [](const Answer& a) { return static_cast<double>(a.flags); });
  quantities.back().bits = true;
  if (!run.times.empty())
  {
    quantities.push_back({"compute_us", [&run](std::size_t i)
                          {
                            return run.times[i].compute_us;
                          }});
    quantities.push_back({"delay_us", [&run](std::size_t i)
                          {
                            return run.times[i].delay_us;
                          }});
  }
  return quantities;
}

// "FxL": "fxL"; an actuator's: "tau_left_ankle"
std::string quantity_name(const Channel& channel)
{
  return channel.joint >= 0 ? "tau_" + channel.name : fmt::format("f{}", channel.name.substr(1));
}

Json agreements(const ReportMotion& motion, const ReportRun& run)
{
  Json list = Json::array();
  const std::vector<bool> all(motion.states.size(), true);
  for (const Channel& channel : motion.measured.channels)
  {
    const Agreement found = agreement(channel, values_of(channel, run.answers), all);
    list.push_back({{"channel", quantity_name(channel)},
                    {"published", channel.published},
                    {"unit", channel.unit},
                    {"samples", found.samples},
                    {"rms", limit(found.rms)},
                    {"of_range", limit(found.of_range)}});
  }
  return list;
}

Json figures(const Robot& robot, const ReportMotion& motion, const ReportRun& run, const Changes& changes,
             double distance)
{
  const Outcome outcome = outcome_of(robot, motion.states, run.answers, changes);
  Json jumps = Json::object();
  for (std::size_t kind = 0; kind < changes.kinds.size(); ++kind)
    jumps[changes.kinds[kind]] = outcome.jumps[kind];
  Json flags = Json::object();
  for (const auto& [bit, count] : outcome.flagged)
    flags[flag_names(bit).front()] = count;
  return {{"answered", outcome.answered}, {"unanswered", run.unanswered},
          {"peak", outcome.peak},         {"rms", outcome.rms()},
          {"effort", outcome.effort},     {"work", limit(outcome.work)},
          {"distance", distance},         {"double_support", outcome.double_support},
          {"held", outcome.held},         {"jumps", std::move(jumps)},
          {"flags", std::move(flags)},    {"measured", agreements(motion, run)}};
}

// Centres of pressure of the plates' wrenches, as in answers.
std::vector<Quantity> plate_pressure(const Robot& robot, const ReportMotion& motion, const Poses& poses)
{
  // with less load the plates' noise moves it by more than a centimetre
  constexpr double least_load = 0.05;
  std::vector<Quantity> quantities;
  for (const Side side : kSides)
    quantities.push_back({side == Side::left ? "copL" : "copR",
                          [&robot, &motion, &poses, side](std::size_t i) -> double
                          {
                            const auto s = static_cast<std::size_t>(side);
                            const auto& plates = motion.measured.plates;
                            const Wrench wrench{plates[3 * s][i], plates[3 * s + 1][i], plates[3 * s + 2][i]};
                            if (!(wrench.fz > least_load * robot.weight()))
                              return NAN;
                            FootPose pose{};
                            pose.e = {std::cos(poses.angles[s][i]), std::sin(poses.angles[s][i])};
                            return ground_reaction(robot, robot.foot(side), pose, wrench).cop;
                          }});
  return quantities;
}

Json describe(const Robot& robot, const ReportMotion& motion, const Resolution& resolution)
{
  const std::vector<DesiredState>& states = motion.states;
  const Thinning thinning(states.size(), resolution);
  const auto seconds = [&states](std::size_t i)
  {
    return 1e-6 * static_cast<double>(states[i].utime - states.front().utime);
  };
  std::vector<double> times, curve_times;
  for (std::size_t i = 0; i < states.size(); i += thinning.stride)
    times.push_back(seconds(i));
  for (std::size_t from = 0; thinning.per_stretch > 0 && from < states.size(); from += thinning.per_stretch)
  {
    const double end = seconds(std::min(from + thinning.per_stretch, states.size()) - 1);
    curve_times.insert(curve_times.end(), {0.75 * seconds(from) + 0.25 * end, 0.25 * seconds(from) + 0.75 * end});
  }
  const Poses poses = find_poses(robot, states, thinning);
  const auto contact = [&states](Side side)
  {
    return [&states, side](std::size_t i)
    {
      return static_cast<double>(states[i].support.of(side));
    };
  };

  Json json{{"source", motion.source},
            {"start", motion.start},
            {"samples", states.size()},
            {"seconds", seconds(states.size() - 1)}};
  json["time"] = base64(times);
  if (thinning.per_stretch > 0)
    json["curve_time"] = base64(curve_times);
  json["poses"] = base64(poses.numbers);
  json["frames"] = table({{"contactL", contact(Side::left)}, {"contactR", contact(Side::right)}},
                         [&](const Quantity& quantity) { return frames(quantity, thinning); });

  const Changes changes = find_changes(states);
  json["longest_change"] = changes.longest;
  json["runs"] = Json::array();
  for (const ReportRun& run : motion.runs)
  {
    Json described{{"name", run.name}, {"figures", figures(robot, motion, run, changes, poses.distance)}};
    add_columns(described, answer_quantities(robot, run), thinning);
    json["runs"].push_back(std::move(described));
  }
  for (const bool published : {false, true})
  {
    std::vector<Quantity> quantities;
    if (!published && !motion.measured.plates.front().empty())
      quantities = plate_pressure(robot, motion, poses);
    for (const Channel& channel : motion.measured.channels)
      if (channel.published == published)
        quantities.push_back({quantity_name(channel), [&channel](std::size_t i)
                              {
                                return channel.values[i];
                              }});
    if (quantities.empty())
      continue;
    Json described = Json::object();
    add_columns(described, quantities, thinning);
    json[published ? "published" : "plates"] = std::move(described);
  }
  return json;
}

} // namespace

std::string robot_document(const Robot& robot)
{
  return describe(robot).dump();
}

std::string report_document(const Robot& robot, const std::vector<ReportMotion>& motions, const Resolution& resolution,
                            const std::optional<Liveness>& liveness)
{
  Json document{{"robot", describe(robot)}, {"motions", Json::array()}};
  for (const ReportMotion& motion : motions)
    document["motions"].push_back(describe(robot, motion, resolution));
  if (liveness)
    document["liveness"] = {{"answer_age", liveness->answer_age ? Json(*liveness->answer_age) : Json()},
                            {"status_age", liveness->status_age},
                            {"stopping", liveness->stopping}};
  return document.dump();
}

} // namespace torqued
