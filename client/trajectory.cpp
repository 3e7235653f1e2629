#include "client/trajectory.h"

#include "client/csv_lines.h"
#include "client/failure.h"
#include "client/files.h"
#include "client/lcm_log.h"
#include "client/spline.h"
#include "client/support_course.h"
#include "robot/printable.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

namespace torqued
{

namespace
{

constexpr std::int64_t kLatest = std::int64_t{1} << 61; // µs, so that no difference of two times overflows

// a cell for a complaint
std::string shown(const std::string& cell)
{
  constexpr std::size_t longest = 40;
  if (cell.empty())
    return "nothing";
  return fmt::format("\"{}\"", printable(cell.size() > longest ? cell.substr(0, longest) + "..." : cell));
}

// the whole cell as a number, in every locale; a plus sign is no part of std::from_chars' numbers
template <typename Number> bool parse(std::string_view cell, Number& number)
{
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-')
    cell.remove_prefix(1);
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  return error == std::errc() && end == cell.data() + cell.size();
}

// "dq0" and "ddq0" for order 1 and 2
std::vector<std::string> derivative_names(const std::vector<std::string>& names, int order)
{
  std::vector<std::string> derived;
  for (const std::string& name : names)
    derived.push_back(std::string(static_cast<std::size_t>(order), 'd') + name);
  return derived;
}

// Reads the lines of a CSV one after another; all complaints carry the present line.
class CsvTrajectory
{
public:
  CsvTrajectory(std::string_view text, const std::string& file, const CoordinateNames& names, bool differentiate)
      : reader_(text, file), names_(names), differentiate_(differentiate)
  {
    trajectory_.file = file;
  }

  Trajectory read()
  {
    if (!reader_.next(line_))
      throw Failure(
          ExitCode::bad_data,
          fmt::format("{}: found no line that names columns; expected one such as time,q0,...", trajectory_.file));
    read_header();
    while (reader_.next(line_))
      read_row();
    if (trajectory_.states.empty())
      throw Failure(ExitCode::bad_data,
                    fmt::format("{}: found no row below the names of the columns; expected one per desired state",
                                trajectory_.file));
    if (differentiate_)
      differentiate();
    complete_supports();
    return std::move(trajectory_);
  }

private:
  [[noreturn]] void fail(std::string_view column, std::string_view found, std::string_view expected) const
  {
    throw Failure(ExitCode::bad_data, fmt::format("{}:{}: column {}: found {}; expected {}", trajectory_.file,
                                                  line_.number, printable(std::string(column)), found, expected));
  }

  // the header: which cell of a row is what

  using Column = std::optional<std::size_t>;

  Column find(const std::string& name) const
  {
    const auto found = columns_.find(name);
    return found == columns_.end() ? Column() : found->second;
  }
  std::vector<std::string> missing(const std::vector<std::string>& names) const
  {
    std::vector<std::string> absent;
    std::copy_if(names.begin(), names.end(), std::back_inserter(absent), [&](const auto& name) { return !find(name); });
    return absent;
  }
  [[noreturn]] void fail_missing(const std::vector<std::string>& absent, std::string_view expected) const
  {
    fail(absent.front(), fmt::format("no column {}", fmt::join(absent, ", ")), expected);
  }
  std::vector<std::size_t> indices(const std::vector<std::string>& names) const
  {
    std::vector<std::size_t> columns;
    for (const std::string& name : names)
      columns.push_back(columns_.at(name));
    return columns;
  }

  void read_header()
  {
    header_ = line_.cells;
    for (std::size_t i = 0; i < header_.size(); ++i)
      if (!header_[i].empty() && !columns_.emplace(header_[i], i).second)
        fail(header_[i], "it twice", "it once");

    time_ = find("time");
    utime_ = find("utime");
    if (!time_ && !utime_)
      fail("time", "no column time or utime", "time (s) or utime (µs)");
    if (time_ && utime_)
      fail("utime", "both time and utime", "one of the two");
    const std::vector<std::string> contacts{"contactL", "contactR"};
    if (const auto absent = missing(contacts); !absent.empty())
      fail_missing(absent, "what carries at each foot: 0 to 3, or none, heel, sole, toe");
    contacts_ = indices(contacts);
    leading_ = find("leading");
    load_transfer_ = find("load_transfer");
    phase_ = find("phase");
    method_ = find("method");
    choose_coordinates();
    choose_base();
    find_motion();
  }

  void choose_coordinates()
  {
    const auto no_absolute = missing(names_.absolute);
    const auto no_relative = missing(names_.relative);
    relative_ = !no_absolute.empty() && no_relative.size() < no_absolute.size();
    coordinates_ = relative_ ? names_.relative : names_.absolute;
    if (!no_absolute.empty() && !no_relative.empty())
      fail_missing(relative_ ? no_relative : no_absolute,
                   fmt::format("all of {} (absolute), or all of {} (relative)", fmt::join(names_.absolute, ", "),
                               fmt::join(names_.relative, ", ")));
  }

  void choose_base()
  {
    if (names_.base[0].empty() || names_.base[1].empty())
      return;
    const std::vector<std::string> positions(names_.base.begin(), names_.base.end());
    std::vector<std::string> all = positions;
    for (const int order : {1, 2})
      for (const std::string& name : derivative_names(positions, order))
        all.push_back(name);
    if (missing(all).size() == all.size())
      return;
    const auto& needed = differentiate_ ? positions : all;
    if (const auto absent = missing(needed); !absent.empty())
      fail_missing(absent,
                   fmt::format("all of {}, or no base columns and the resting foot places the base{}",
                               fmt::join(needed, ", "), differentiate_ ? "" : "; --differentiate finds derivatives"));
    base_given_ = true;
  }

  void find_motion()
  {
    std::vector<std::string> all = coordinates_;
    if (base_given_)
      all.insert(all.end(), names_.base.begin(), names_.base.end());
    motion_[0] = indices(all);
    if (differentiate_)
      return;
    const auto velocities = derivative_names(all, 1);
    const auto accelerations = derivative_names(all, 2);
    auto absent = missing(velocities);
    for (const std::string& name : missing(accelerations))
      absent.push_back(name);
    if (!absent.empty())
      fail_missing(absent, "all derivatives, or --differentiate to find them by a spline through the samples");
    motion_[1] = indices(velocities);
    motion_[2] = indices(accelerations);
  }

  // a row: one desired state

  const std::string& cell(std::size_t column) const { return line_.cells[column]; }

  double number(std::size_t column) const
  {
    double value = 0.0;
    if (!parse(cell(column), value))
      fail(header_[column], shown(cell(column)), "a number, such as -0.25 or 1e-3");
    if (!std::isfinite(value))
      fail(header_[column], shown(cell(column)), "a finite number");
    return value;
  }

  std::int64_t time()
  {
    std::int64_t utime = 0;
    if (utime_)
    {
      if (!parse(cell(*utime_), utime) || utime < -kLatest || utime > kLatest)
        fail("utime", shown(cell(*utime_)), "a whole number of µs");
      seconds_.push_back(1e-6 * static_cast<double>(utime - first_utime(utime)));
    }
    else
    {
      const double seconds = number(*time_);
      if (std::abs(seconds) > 1e-6 * static_cast<double>(kLatest))
        fail("time", shown(cell(*time_)), "a time in s");
      utime = std::llround(1e6 * seconds);
      seconds_.push_back(seconds);
    }
    if (!trajectory_.states.empty() && utime <= trajectory_.states.back().utime)
      fail(utime_ ? "utime" : "time",
           fmt::format("{} after {}", shown(cell(utime_ ? *utime_ : *time_)), shown(previous_time_)),
           "a later time in each row, by 1 µs or more");
    previous_time_ = cell(utime_ ? *utime_ : *time_);
    return utime;
  }

  std::int64_t first_utime(std::int64_t utime) const
  {
    return trajectory_.states.empty() ? utime : trajectory_.states.front().utime;
  }

  std::int8_t contact(std::size_t column) const
  {
    for (const Contact contact : {Contact::none, Contact::heel, Contact::sole, Contact::toe})
      if (cell(column) == name_of(contact) || cell(column) == std::to_string(static_cast<int>(contact)))
        return static_cast<std::int8_t>(contact);
    fail(header_[column], shown(cell(column)), "0, 1, 2, 3, or none, heel, sole, toe");
  }

  std::int8_t leading() const
  {
    if (cell(*leading_) != "L" && cell(*leading_) != "R")
      fail("leading", shown(cell(*leading_)), "L or R");
    return cell(*leading_) == "L" ? desired_state_t::LEFT : desired_state_t::RIGHT;
  }

  std::int8_t method() const
  {
    const std::string& word = cell(*method_);
    if (word.empty() || word == "default" || word == name_of(Method::none))
      return desired_state_t::DEFAULT;
    for (const NamedMethod& known : kMethods)
      if (word == known.name)
        return static_cast<std::int8_t>(known.method);
    int value = 0;
    if (!parse(word, value) || value < INT8_MIN || value > INT8_MAX)
    {
      std::vector<std::string_view> known;
      for (const NamedMethod& named : kMethods)
        known.push_back(named.name);
      fail("method", shown(word), fmt::format("default, {}, or a method's number", fmt::join(known, ", ")));
    }
    return static_cast<std::int8_t>(value);
  }

  void read_row()
  {
    if (line_.cells.size() < header_.size())
      fail(header_[line_.cells.size()], fmt::format("nothing, the row ends after {} cells", line_.cells.size()),
           fmt::format("{} cells", header_.size()));
    if (line_.cells.size() > header_.size())
      fail(fmt::format("{}", header_.size() + 1), shown(cell(header_.size())), fmt::format("{} cells", header_.size()));

    desired_state_t state{};
    state.utime = time();
    state.stream_id = 1;
    state.coordinates = relative_ ? desired_state_t::RELATIVE : desired_state_t::ABSOLUTE;
    state.base = base_given_ ? desired_state_t::GIVEN : desired_state_t::FROM_CONTACT;
    state.left_contact = contact(contacts_[0]);
    state.right_contact = contact(contacts_[1]);
    state.leading_foot = leading_ ? leading() : std::int8_t{};
    state.load_transfer = load_transfer_ ? number(*load_transfer_) : 0.0;
    state.phase = phase_ ? number(*phase_) : 0.0;
    state.method = method_ ? method() : std::int8_t{};

    state.num_coordinates = static_cast<std::int32_t>(coordinates_.size());
    const std::array<std::vector<double>*, 3> angles{&state.q, &state.v, &state.a};
    const std::array<double*, 3> base{state.base_q, state.base_v, state.base_a};
    for (std::size_t order = 0; order < 3; ++order)
    {
      angles[order]->resize(coordinates_.size());
      for (std::size_t i = 0; i < motion_[order].size(); ++i)
      {
        double& place = i < coordinates_.size() ? (*angles[order])[i] : base[order][i - coordinates_.size()];
        place = number(motion_[order][i]);
      }
    }
    trajectory_.states.push_back(std::move(state));
    trajectory_.places.push_back(line_.number);
  }

  // what only the whole file tells

  void differentiate()
  {
    std::vector<desired_state_t>& states = trajectory_.states;
    if (states.size() < static_cast<std::size_t>(kFewestSplineSamples))
      throw Failure(ExitCode::bad_data, fmt::format("{}: found {} rows; expected at least {} for --differentiate",
                                                    trajectory_.file, states.size(), kFewestSplineSamples));
    const auto rows = static_cast<Eigen::Index>(states.size());
    const auto angles = static_cast<Eigen::Index>(coordinates_.size());
    const Eigen::VectorXd times = Eigen::Map<const Eigen::VectorXd>(seconds_.data(), rows).array() - seconds_[0];
    Eigen::MatrixXd values(rows, angles + (base_given_ ? 2 : 0));
    for (Eigen::Index i = 0; i < rows; ++i)
    {
      const desired_state_t& state = states[static_cast<std::size_t>(i)];
      values.row(i).head(angles) = Eigen::Map<const Eigen::RowVectorXd>(state.q.data(), angles);
      if (base_given_)
        values.row(i).tail<2>() = Eigen::Map<const Eigen::RowVector2d>(state.base_q);
    }

    const Derivatives derivatives = spline_derivatives(times, values);
    for (Eigen::Index i = 0; i < rows; ++i)
    {
      desired_state_t& state = states[static_cast<std::size_t>(i)];
      Eigen::Map<Eigen::RowVectorXd>(state.v.data(), angles) = derivatives.first.row(i).head(angles);
      Eigen::Map<Eigen::RowVectorXd>(state.a.data(), angles) = derivatives.second.row(i).head(angles);
      if (base_given_)
      {
        Eigen::Map<Eigen::RowVector2d>(state.base_v) = derivatives.first.row(i).tail<2>();
        Eigen::Map<Eigen::RowVector2d>(state.base_a) = derivatives.second.row(i).tail<2>();
      }
    }
  }

  void complete_supports()
  {
    std::vector<std::int64_t> utime;
    std::vector<Contacts> contacts;
    for (const desired_state_t& state : trajectory_.states)
    {
      utime.push_back(state.utime);
      contacts.push_back({static_cast<Contact>(state.left_contact), static_cast<Contact>(state.right_contact)});
    }
    const std::vector<Support> supports = follow_contacts(utime, contacts);
    for (std::size_t i = 0; i < supports.size(); ++i)
    {
      desired_state_t& state = trajectory_.states[i];
      if (!leading_)
        state.leading_foot = static_cast<std::int8_t>(supports[i].leading);
      if (!load_transfer_)
        state.load_transfer = supports[i].load_transfer;
      if (!phase_)
        state.phase = supports[i].phase;
    }
  }

  CsvReader reader_;
  const CoordinateNames& names_;
  bool differentiate_;
  CsvLine line_;
  Trajectory trajectory_;

  std::vector<std::string> header_;
  std::map<std::string, std::size_t> columns_;
  Column time_, utime_, leading_, load_transfer_, phase_, method_;
  std::vector<std::size_t> contacts_;
  bool relative_ = false, base_given_ = false;
  std::vector<std::string> coordinates_;
  std::array<std::vector<std::size_t>, 3> motion_; // positions, velocities, accelerations: coordinates, then the base

  std::vector<double> seconds_; // not rounded to µs
  std::string previous_time_;
};

[[noreturn]] void fail_without_states(std::string_view bytes, const Origin& origin, const Channels& channels)
{
  std::set<std::string, std::less<>> heard;
  LogReader log(bytes);
  while (const auto record = log.next())
    heard.emplace(record->channel);
  constexpr std::size_t most = 8;
  std::vector<std::string> some(heard.begin(), std::next(heard.begin(), std::min(heard.size(), most)));
  std::transform(some.begin(), some.end(), some.begin(), [](const std::string& text) { return printable(text); });
  throw Failure(
      ExitCode::bad_data,
      fmt::format("{}: found no desired state on channel {} of this LCM log ({} undecodable there); it holds {}{}; "
                  "--prefix names another channel",
                  origin.file, channels.desired, origin.undecodable, fmt::join(some, ", "),
                  heard.size() > most ? ", ..." : ""));
}

// the desired states of a log, which all are whole; they lie in its bytes
std::vector<Bytes> find_messages(std::string_view bytes, const Channels& channels, Origin& origin)
{
  std::vector<Bytes> messages;
  origin.from_log = true;
  LogReader log(bytes);
  while (const auto record = log.next())
  {
    if (record->channel != channels.desired)
      continue;
    if (is_desired_state(record->data))
    {
      messages.push_back(record->data);
      origin.places.push_back(static_cast<std::size_t>(record->number));
      origin.heard.push_back(record->timestamp);
    }
    else
    {
      ++origin.undecodable;
    }
  }
  origin.damaged_bytes = log.skipped();
  if (messages.empty())
    fail_without_states(bytes, origin, channels);
  return messages;
}

} // namespace

CoordinateNames coordinate_names(const Robot& robot)
{
  return {robot.absolute_names, robot.relative_names, robot.base_names};
}

CoordinateNames coordinate_names(const model_info_t& model)
{
  return {model.absolute_names, model.relative_names, {model.base_names[0], model.base_names[1]}};
}

std::string Origin::place(std::size_t state) const
{
  return from_log ? fmt::format("{}: record {}", file, places[state]) : fmt::format("{}:{}", file, places[state]);
}

Trajectory parse_trajectory(std::string_view bytes, const std::string& file, const CoordinateNames& names,
                            bool differentiate, const Channels& channels)
{
  if (!LogReader::is_log(bytes))
    return CsvTrajectory(bytes, file, names, differentiate).read();
  Trajectory trajectory;
  trajectory.file = file;
  for (const Bytes message : find_messages(bytes, channels, trajectory))
    decode(message, trajectory.states.emplace_back());
  return trajectory;
}

DesiredMessages read_messages(const std::shared_ptr<const InputFile>& input, const std::string& file,
                              const CoordinateNames& names, bool differentiate, const Channels& channels)
{
  if (!LogReader::is_log(input->bytes()))
    return encode_all(CsvTrajectory(input->bytes(), file, names, differentiate).read());
  DesiredMessages desired;
  desired.file = file;
  desired.messages = find_messages(input->bytes(), channels, desired);
  desired.owner = input;
  return desired;
}

DesiredMessages encode_all(const Trajectory& trajectory)
{
  const auto buffers = std::make_shared<std::vector<std::vector<std::byte>>>(trajectory.states.size());
  DesiredMessages desired{trajectory, {}, buffers};
  for (std::size_t i = 0; i < trajectory.states.size(); ++i)
    desired.messages.push_back(encode(trajectory.states[i], (*buffers)[i]));
  return desired;
}

std::vector<std::string> notes(const Origin& origin)
{
  std::vector<std::string> lines;
  if (origin.damaged_bytes > 0)
    lines.push_back(fmt::format("{}: {} bytes belong to no whole record of the log; they were passed over", origin.file,
                                origin.damaged_bytes));
  if (origin.undecodable > 0)
    lines.push_back(fmt::format("{}: {} messages cannot be decoded as desired states; they were passed over",
                                origin.file, origin.undecodable));
  return lines;
}

} // namespace torqued
