#include "study/measured.h"

#include "motion/column_names.h"
#include "motion/csv_lines.h"
#include "motion/failure.h"
#include "motion/lcm_log.h"
#include "questions/newton_euler.h"
#include "stance/contacts.h"
#include "stance/joint_friction.h"
#include "text/number.h"
#include "text/printable.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace torqued
{

namespace
{

constexpr std::array<const char*, 6> kPlates{"FxL", "FzL", "ML", "FxR", "FzR", "MR"};

// "left_ankle": "pub_ankleL"; nothing for what is on neither side
std::string published_column(const std::string& actuator)
{
  const auto [side, kind] = sided(actuator);
  return side ? fmt::format("pub_{}{}", kind, *side == Side::left ? 'L' : 'R') : "";
}

double measured_number(const std::string& file, std::size_t line, const std::string& column, const std::string& cell)
{
  if (cell.empty())
    return NAN;
  const std::optional<double> value = number_in<double>(cell);
  if (!value || std::isinf(*value))
    fail_in_column(file, line, column, fmt::format("\"{}\"", printable(cell)),
                   "a finite number, or nan or nothing where there is none");
  return *value;
}

using Columns = std::map<std::string, std::vector<double>>; // by name

// those of the columns that the file has
Columns read_columns(std::string_view text, const std::string& file, const std::vector<KnownColumn>& wanted)
{
  CsvReader reader(text, file);
  const ColumnNames names = read_column_names(reader, file, wanted);
  std::map<std::string, std::size_t> places;
  for (const KnownColumn& column : wanted)
    if (const auto found = names.places.find(column.name); found != names.places.end())
      places.insert(*found);
  Columns columns;
  CsvLine line;
  while (!places.empty() && reader.next(line))
    for (const auto& [name, place] : places)
      columns[name].push_back(names.factors[place] * measured_number(file, line.number, name, line.cells.at(place)));
  return columns;
}

using Plates = decltype(Measured::plates);

// all empty if the file has none of their columns
Plates take_plates(Columns& columns, const std::string& file)
{
  Plates plates;
  std::vector<const char*> absent;
  for (std::size_t k = 0; k < kPlates.size(); ++k)
    if (const auto found = columns.find(kPlates[k]); found != columns.end())
      plates[k] = std::move(found->second);
    else
      absent.push_back(kPlates[k]);
  if (!absent.empty() && absent.size() < kPlates.size())
    throw Failure(ExitCode::bad_data,
                  "{}: found no column {}; expected all of FxL, FzL, ML, FxR, FzR, MR, or none of them", file,
                  absent.front());
  return plates;
}

// the torques, by sample, that the measured wrenches leave to the motors
std::vector<VectorJ> bottom_up(const Robot& robot, const std::vector<DesiredState>& states, const Plates& plates)
{
  std::vector<VectorJ> torques;
  for (std::size_t i = 0; i < states.size(); ++i)
  {
    const Result<Motion> completed = complete_motion(robot, states[i]);
    const Motion* motion = std::get_if<Motion>(&completed);
    if (!motion)
    {
      torques.emplace_back(VectorJ::Constant(robot.num_joints(), NAN));
      continue;
    }
    std::array<Eigen::Vector3d, 2> ground;
    for (std::size_t side = 0; side < 2; ++side)
      for (std::size_t k = 0; k < 3; ++k)
        ground[side](static_cast<Eigen::Index>(k)) = plates[3 * side + k][i];
    torques.emplace_back(newton_euler(robot, states[i].q, motion->v, motion->a, ground).torque +
                         joint_friction(robot, motion->v, motion->a));
  }
  return torques;
}

} // namespace

SidedName sided(const std::string& actuator)
{
  for (const Side side : kSides)
    if (const std::string prefix = fmt::format("{}_", name_of(side));
        actuator.starts_with(prefix) && actuator.size() > prefix.size())
      return {side, actuator.substr(prefix.size())};
  return {std::nullopt, actuator};
}

double Channel::of(const Answer& answer) const
{
  const Wrench& wrench = answer.ground[static_cast<std::size_t>(side)].wrench;
  return component == 0 ? wrench.fx : component == 1 ? wrench.fz : answer.torque(joint);
}

double Channel::range() const
{
  double least = INFINITY, most = -INFINITY;
  for (const double value : values)
    if (!std::isnan(value))
    {
      least = std::min(least, value);
      most = std::max(most, value);
    }
  return most < least ? NAN : most - least;
}

std::vector<double> values_of(const Channel& channel, const std::vector<std::optional<Answer>>& answers)
{
  std::vector<double> values;
  for (const std::optional<Answer>& answer : answers)
    values.push_back(answer ? channel.of(*answer) : NAN);
  return values;
}

Measured read_measured(std::string_view bytes, const std::string& file, const Robot& robot,
                       const std::vector<DesiredState>& states)
{
  if (LogReader::is_log(bytes))
    return {};
  std::vector<KnownColumn> wanted;
  for (const std::string name : kPlates)
    wanted.push_back({name, name.starts_with('F') ? Quantity::force : Quantity::moment, 0, false}); // answers have fxL
  for (const Actuator& actuator : robot.actuators)
    if (const std::string column = published_column(actuator.name); !column.empty())
      wanted.push_back({column, Quantity::moment});
  Columns columns = read_columns(bytes, file, wanted);

  Measured measured;
  std::vector<Channel>& channels = measured.channels;
  const auto add_moments = [&](int joint, bool published, std::vector<double> values)
  {
    const std::string& name = robot.actuators[static_cast<std::size_t>(joint)].name;
    channels.push_back({name, sided(name).kind, published, "N m", Side::left, -1, joint, std::move(values)});
  };
  const Plates& plates = measured.plates = take_plates(columns, file);
  if (!plates.front().empty())
  {
    for (const Side side : kSides)
      for (const int component : {0, 1})
      {
        const auto place = 3 * static_cast<std::size_t>(side) + static_cast<std::size_t>(component);
        channels.push_back(
            {kPlates[place], component == 0 ? "Fx" : "Fz", false, "N", side, component, -1, plates[place]});
      }
    const std::vector<VectorJ> torques = bottom_up(robot, states, plates);
    for (int joint = 0; joint < robot.num_joints(); ++joint)
    {
      std::vector<double> values;
      for (const VectorJ& torque : torques)
        values.push_back(torque(joint));
      add_moments(joint, false, std::move(values));
    }
  }
  for (int joint = 0; joint < robot.num_joints(); ++joint)
  {
    const auto found = columns.find(published_column(robot.actuators[static_cast<std::size_t>(joint)].name));
    if (found == columns.end())
      continue;
    for (double& value : found->second)
      value = -value;
    add_moments(joint, true, std::move(found->second));
  }
  return measured;
}

Agreement agreement(const Channel& channel, const std::vector<double>& computed, const std::vector<bool>& chosen)
{
  std::vector<std::pair<double, double>> both;
  for (std::size_t i = 0; i < computed.size(); ++i)
    if (chosen[i] && !std::isnan(computed[i]) && !std::isnan(channel.values[i]))
      both.emplace_back(computed[i], channel.values[i]);

  const auto n = static_cast<double>(both.size());
  double mean_a = 0.0, mean_b = 0.0, squares = 0.0;
  for (const auto& [a, b] : both)
  {
    mean_a += a / n;
    mean_b += b / n;
    squares += (a - b) * (a - b);
  }
  double aa = 0.0, bb = 0.0, ab = 0.0;
  for (const auto& [a, b] : both)
  {
    aa += (a - mean_a) * (a - mean_a);
    bb += (b - mean_b) * (b - mean_b);
    ab += (a - mean_a) * (b - mean_b);
  }
  const double rms = std::sqrt(squares / n); // NaN without samples
  return {static_cast<int>(both.size()), rms, rms / channel.range(), ab / std::sqrt(aa * bb)};
}

} // namespace torqued
