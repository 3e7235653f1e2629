#include "page/columns.h"
#include "page/curves.h"
#include "page/drawing.h"
#include "page/report_page.h"
#include "stance/checks.h"
#include "stance/flags.h"
#include "study/answer_table.h"
#include "study/world_path.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace torqued
{

namespace
{

// infinity: null
Json limit(double value)
{
  return std::isfinite(value) ? Json(value) : Json();
}

// the poses of a motion's frames: x, z and angle of each link; NaN where its contacts cannot be
struct Poses
{
  std::vector<float> numbers;
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

// whether an answer has other accelerations than were asked for
bool is_moved(const ReportMotion& motion)
{
  for (const ReportRun& run : motion.runs)
    for (const std::optional<Answer>& answer : run.answers)
      if (answer && (answer->flags & (flag::adjusted | flag::projected)) != 0)
        return true;
  return false;
}

double answered_acceleration(const Robot& robot, const DesiredState& asked, const Answer& answer, int coordinate)
{
  const int n = robot.num_coordinates();
  if (coordinate >= n)
    return answer.base_a(coordinate - n);
  return asked.relative_a.size() > 0 ? robot.A_inverse.row(coordinate).head(n).dot(answer.a) : answer.a(coordinate);
}

double asked_acceleration(const Robot& robot, const DesiredState& asked, int coordinate)
{
  const int n = robot.num_coordinates();
  if (coordinate < n)
    return asked.a(coordinate);
  return asked.base_given ? asked.a.tail<2>()(coordinate - n) : NAN;
}

// each curve's value at a sample; moved: is_moved()
std::vector<Series> answer_series(const Robot& robot, const std::vector<DesiredState>& states, const ReportRun& run,
                                  bool moved)
{
  std::vector<Series> series;
  const auto add = [&](const std::string& name, std::function<double(const Answer&)> of)
  {
    series.push_back({name, [&run, of = std::move(of)](std::size_t i)
                      {
                        return run.answers[i] ? of(*run.answers[i]) : NAN;
                      }});
  };
  for (const CurveSection& section : curve_sections(robot))
    for (const Curve& curve : section.curves)
      if (const auto* of = std::get_if<std::function<double(const Answer&)>>(&curve.of))
        add(curve.name, *of);
      else if (const auto* moving = std::get_if<Acceleration>(&curve.of))
      {
        if (moved)
          series.push_back({curve.name, [&robot, &states, &run, coordinate = moving->coordinate](std::size_t i)
                            {
                              return run.answers[i]
                                         ? answered_acceleration(robot, states[i], *run.answers[i], coordinate)
                                         : NAN;
                            }});
      }
      else if (!run.times.empty())
        series.push_back({curve.name, [&run, time = std::get<double AnswerTime::*>(curve.of)](std::size_t i)
                          {
                            return run.times[i].*time;
                          }});
  add("flags", [](const Answer& answer) { return static_cast<double>(answer.flags); });
  series.back().bits = true;
  return series;
}

// the accelerations that were asked for
std::vector<Series> asked_series(const Robot& robot, const std::vector<DesiredState>& states)
{
  std::vector<Series> series;
  for (const CurveSection& section : curve_sections(robot))
    for (const Curve& curve : section.curves)
      if (const auto* of = std::get_if<Acceleration>(&curve.of))
        series.push_back({curve.name, [&robot, &states, coordinate = of->coordinate](std::size_t i)
                          {
                            return asked_acceleration(robot, states[i], coordinate);
                          }});
  return series;
}

Json agreements(const ReportMotion& motion, const ReportRun& run)
{
  Json list = Json::array();
  const std::vector<bool> all(motion.states.size(), true);
  for (const Channel& channel : motion.measured.channels)
  {
    const Agreement found = agreement(channel, values_of(channel, run.answers), all);
    list.push_back({{"title", title_of(channel)},
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
std::vector<Series> plate_pressure(const Robot& robot, const ReportMotion& motion, const Poses& poses)
{
  // with less load the plates' noise moves it by more than a centimetre
  constexpr double least_load = 0.05;
  std::vector<Series> series;
  for (const Side side : kSides)
    series.push_back({foot_column("cop", side),
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
  return series;
}

Json describe(const Robot& robot, const ReportMotion& motion, const Resolution& resolution)
{
  const std::vector<DesiredState>& states = motion.states;
  const Thinning thinning = thinning_of(states.size(), resolution);
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

  Json json{{"source", motion.source},
            {"start", motion.start},
            {"samples", states.size()},
            {"seconds", seconds(states.size() - 1)}};
  json["time"] = base64(times);
  if (thinning.per_stretch > 0)
    json["curve_time"] = base64(curve_times);
  json["poses"] = base64(poses.numbers);
  std::vector<Series> contacts;
  for (const Side side : kSides)
    contacts.push_back({foot_column("contact", side), [&states, side](std::size_t i)
                        {
                          return static_cast<double>(states[i].support.of(side));
                        }});
  json["frames"] = frame_columns(contacts, thinning);

  const Changes changes = find_changes(states);
  json["longest_change"] = changes.longest;
  const bool moved = is_moved(motion);
  json["runs"] = Json::array();
  for (const ReportRun& run : motion.runs)
  {
    Json described{{"name", run.name}, {"figures", figures(robot, motion, run, changes, poses.distance)}};
    add_columns(described, answer_series(robot, states, run, moved), thinning);
    json["runs"].push_back(std::move(described));
  }
  if (moved)
    add_columns(json["asked"], asked_series(robot, states), thinning);
  for (const bool published : {false, true})
  {
    std::vector<Series> series;
    if (!published && !motion.measured.plates.front().empty())
      series = plate_pressure(robot, motion, poses);
    for (const Channel& channel : motion.measured.channels)
      if (channel.published == published)
        series.push_back({column_of(channel), [&channel](std::size_t i)
                          {
                            return channel.values[i];
                          }});
    if (series.empty())
      continue;
    Json described = Json::object();
    add_columns(described, series, thinning);
    json[published ? "published" : "plates"] = std::move(described);
  }
  return json;
}

Json describe(const std::vector<CurveSection>& sections)
{
  Json list = Json::array();
  for (const CurveSection& section : sections)
  {
    Json curves = Json::array();
    for (const Curve& curve : section.curves)
      curves.push_back({{"name", curve.name},
                        {"title", curve.title},
                        {"unit", curve.unit},
                        {"side", curve.side ? Json(name_of(*curve.side)) : Json()},
                        {"group", curve.group},
                        {"bounds", curve.bounds}});
    list.push_back({{"title", section.title}, {"curves", std::move(curves)}});
  }
  return list;
}

// what does not change while the robot is the same
Json head(const Robot& robot)
{
  Json contacts = Json::array();
  for (const Contact contact : {Contact::none, Contact::heel, Contact::sole, Contact::toe})
    contacts.push_back(name_of(contact));
  return {{"robot", drawing_of(robot)},
          {"sections", describe(curve_sections(robot))},
          {"contacts", std::move(contacts)},
          {"flags", flag_names(~0)},
          {"motions", Json::array()}};
}

} // namespace

std::string live_document(const Robot& robot)
{
  Json document = head(robot);
  document["live"] = true;
  return document.dump();
}

std::string report_document(const Robot& robot, const std::vector<ReportMotion>& motions, const Resolution& resolution,
                            const std::optional<Liveness>& liveness)
{
  Json document = head(robot);
  for (const ReportMotion& motion : motions)
    document["motions"].push_back(describe(robot, motion, resolution));
  if (liveness)
    document["liveness"] = {{"answer_age", liveness->answer_age ? Json(*liveness->answer_age) : Json()},
                            {"status_age", liveness->status_age},
                            {"stopping", liveness->stopping}};
  return document.dump();
}

} // namespace torqued
