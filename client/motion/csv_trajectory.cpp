#include "motion/csv_trajectory.h"

#include "methods/method_settings.h"
#include "motion/column_names.h"
#include "motion/csv_lines.h"
#include "motion/differentiation.h"
#include "motion/failure.h"
#include "motion/motion_columns.h"
#include "motion/support_course.h"
#include "motion/table_text.h"
#include "text/number.h"
#include "text/plain_text.h"
#include "text/printable.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>
#include <vector>

namespace torqued
{

namespace
{

constexpr std::int64_t kLatest = std::int64_t{1} << 61; // µs, so that no difference of two times overflows

// a cell for a complaint
std::string quoted_cell(const std::string& cell)
{
  constexpr std::size_t longest = 40;
  if (cell.empty())
    return "nothing";
  return fmt::format("\"{}\"", printable(cell.size() > longest ? cell.substr(0, longest) + "..." : cell));
}

// Reads the lines of a CSV one after another; all complaints carry the present line.
class CsvTrajectory
{
public:
  CsvTrajectory(std::string_view text, const std::string& file, const CoordinateNames& names,
                const Differentiation& how)
      : reader_(text, file), names_(names), how_(how)
  {
    trajectory_.file = file;
  }

  Trajectory read()
  {
    columns_ = find_columns(reader_, trajectory_.file, names_, how_.wanted);
    while (reader_.next(line_))
      read_row();
    if (trajectory_.states.empty())
      throw Failure(ExitCode::bad_data,
                    "{}: found no row below the names of the columns; expected one per desired state",
                    trajectory_.file);
    collect_assumptions();
    if (columns_.time)
      trajectory_.seconds = seconds_;
    const WrittenMotion written = written_motion();
    const std::vector<std::string> doubts = doubt_units(written).sentences;
    trajectory_.assumptions.insert(trajectory_.assumptions.end(), doubts.begin(), doubts.end());
    if (how_.wanted)
      find_derivatives(written);
    complete_supports();
    return std::move(trajectory_);
  }

private:
  [[noreturn]] void fail(std::string_view column, std::string_view found, std::string_view expected) const
  {
    fail_in_column(trajectory_.file, line_.number, column, found, expected);
  }

  // a row: one desired state

  const std::string& cell(std::size_t column) const { return line_.cells[column]; }

  double number(std::size_t column) const
  {
    const std::optional<double> value = number_in<double>(cell(column));
    if (!value)
      fail(columns_.names[column], quoted_cell(cell(column)), "a number, such as -0.25 or 1e-3");
    if (!std::isfinite(*value))
      fail(columns_.names[column], quoted_cell(cell(column)), "a finite number");
    return columns_.factors[column] * *value;
  }

  // a position: NaN where none is written, if derivatives do not need all of them
  double position(std::size_t column) const
  {
    const std::string& text = cell(column);
    const bool none = text.empty() || text == "nan" || text == "NaN" || text == "NAN" || text == "NA";
    return how_.wanted && none ? NAN : number(column);
  }

  std::int64_t time()
  {
    const std::size_t column = columns_.utime ? *columns_.utime : *columns_.time;
    std::int64_t utime = 0;
    if (columns_.utime)
    {
      utime = number_in<std::int64_t>(cell(column)).value_or(INT64_MAX);
      if (utime < -kLatest || utime > kLatest)
        fail("utime", quoted_cell(cell(column)), "a whole number of µs");
    }
    if (columns_.time)
    {
      const double seconds = number(*columns_.time);
      if (std::abs(seconds) > 1e-6 * static_cast<double>(kLatest))
        fail("time", quoted_cell(cell(*columns_.time)), "a time in s");
      seconds_.push_back(seconds);
      if (columns_.utime)
        check_agreement(utime);
      else
        utime = std::llround(1e6 * seconds);
    }
    else
    {
      seconds_.push_back(1e-6 * static_cast<double>(utime - first_utime(utime)));
    }
    if (!trajectory_.states.empty() && utime <= trajectory_.states.back().utime)
      fail(columns_.utime ? "utime" : "time",
           fmt::format("{} after {}", quoted_cell(cell(column)), quoted_cell(previous_time_)),
           "a later time in each row, by 1 µs or more");
    previous_time_ = cell(column);
    return utime;
  }

  // The last time, and the utime beside it, are as far from those of the first row: each may be rounded to µs.
  void check_agreement(std::int64_t utime) const
  {
    const double elapsed = 1e-6 * static_cast<double>(utime - first_utime(utime));
    const double spacing = std::max(std::abs(seconds_.front()), std::abs(seconds_.back())) * 0x1p-50;
    if (std::abs(seconds_.back() - seconds_.front() - elapsed) > 1e-6 + spacing)
      fail("time",
           fmt::format("{}, {:.6f} s after the first row", quoted_cell(cell(*columns_.time)),
                       seconds_.back() - seconds_.front()),
           fmt::format("{:.6f} s after it, as utime says, or only one of the two columns", elapsed));
  }

  std::int64_t first_utime(std::int64_t utime) const
  {
    return trajectory_.states.empty() ? utime : trajectory_.states.front().utime;
  }

  std::int8_t contact(std::size_t column) const
  {
    const std::string word = lower_case(cell(column));
    for (const Contact contact : {Contact::none, Contact::heel, Contact::sole, Contact::toe})
      if (word == name_of(contact) || word == std::to_string(static_cast<int>(contact)))
        return static_cast<std::int8_t>(contact);
    fail(columns_.names[column], quoted_cell(cell(column)), "0, 1, 2, 3, or none, heel, sole, toe");
  }

  std::int8_t leading() const
  {
    const std::string word = lower_case(cell(*columns_.leading));
    const bool left = word == "l" || word == name_of(Side::left);
    if (!left && word != "r" && word != name_of(Side::right))
      fail("leading", quoted_cell(cell(*columns_.leading)), "L or R");
    return left ? desired_state_t::LEFT : desired_state_t::RIGHT;
  }

  std::int8_t method() const
  {
    const std::string& word = cell(*columns_.method);
    if (word.empty() || word == "default" || word == name_of(Method::none))
      return desired_state_t::DEFAULT;
    if (const Method named = method_named(word); named != Method::none)
      return static_cast<std::int8_t>(named);
    const std::optional<std::int8_t> value = number_in<std::int8_t>(word);
    if (!value)
      fail("method", quoted_cell(word), fmt::format("default, {}, or a method's number", method_names()));
    return *value;
  }

  // As many as there are names; cells and names without anything may be left out at the end of a line.
  void check_cells() const
  {
    const std::vector<std::string>& cells = line_.cells;
    const std::vector<std::string>& names = columns_.names;
    const std::size_t both = std::min(cells.size(), names.size());
    const auto extra = cells.begin() + static_cast<std::ptrdiff_t>(both);
    const auto missing = names.begin() + static_cast<std::ptrdiff_t>(both);
    const auto is_empty = [](const std::string& text)
    {
      return text.empty();
    };
    if (std::all_of(extra, cells.end(), is_empty) && std::all_of(missing, names.end(), is_empty))
      return;

    const char separator = reader_.text().separator();
    for (const std::string& cell : cells)
      if (const std::optional<char> other = other_separator(cell, separator))
        throw Failure(ExitCode::bad_data,
                      "{}:{}: found {} in a row; expected {} between cells, as in the names of the columns",
                      trajectory_.file, line_.number, name_of_separator(*other), name_of_separator(separator));
    if (separator == ',' && cells.size() > names.size() + 1 &&
        std::ranges::none_of(cells, [](const std::string& text) { return text.find('.') != std::string::npos; }))
      throw Failure(
          ExitCode::bad_data,
          "{}:{}: found {} cells without a decimal point below {} names; expected as many cells as names: decimal "
          "commas cannot be told from the commas between cells, which must be semicolons or tabs then",
          trajectory_.file, line_.number, cells.size(), names.size());
    if (cells.size() < names.size())
      fail(names[cells.size()], fmt::format("nothing, the row ends after {} cells", cells.size()),
           fmt::format("{} cells", names.size()));
    fail(fmt::format("{}", names.size() + 1), quoted_cell(cell(names.size())), fmt::format("{} cells", names.size()));
  }

  void collect_assumptions()
  {
    for (const std::vector<std::string>& some : {reader_.assumptions(), columns_.assumptions})
      trajectory_.assumptions.insert(trajectory_.assumptions.end(), some.begin(), some.end());
    const std::optional<OpenSimHeader>& opensim = reader_.text().opensim();
    if (opensim && opensim->rows && *opensim->rows != trajectory_.states.size())
      trajectory_.assumptions.push_back(fmt::format("its OpenSim header says nRows={}, but it has {} rows",
                                                    *opensim->rows, trajectory_.states.size()));
  }

  void read_row()
  {
    check_cells();
    desired_state_t state{};
    state.utime = time();
    state.stream_id = 1;
    state.coordinates = columns_.relative ? desired_state_t::RELATIVE : desired_state_t::ABSOLUTE;
    const bool base_given = columns_.base_given && !is_base_empty();
    state.base = base_given ? desired_state_t::GIVEN : desired_state_t::FROM_CONTACT;
    state.left_contact = contact(columns_.contacts[0]);
    state.right_contact = contact(columns_.contacts[1]);
    state.leading_foot = columns_.leading ? leading() : std::int8_t{};
    state.load_transfer = columns_.load_transfer ? number(*columns_.load_transfer) : 0.0;
    state.phase = columns_.phase ? number(*columns_.phase) : 0.0;
    state.method = columns_.method ? method() : std::int8_t{};

    state.num_coordinates = static_cast<std::int32_t>(columns_.coordinates.size());
    const std::array<std::vector<double>*, 3> angles{&state.q, &state.v, &state.a};
    const std::array<double*, 3> base{state.base_q, state.base_v, state.base_a};
    for (std::size_t order = 0; order < 3; ++order)
    {
      angles[order]->resize(columns_.coordinates.size());
      const std::size_t given = base_given ? columns_.motion[order].size() : columns_.coordinates.size();
      for (std::size_t i = 0; i < std::min(given, columns_.motion[order].size()); ++i)
      {
        double& place =
            i < columns_.coordinates.size() ? (*angles[order])[i] : base[order][i - columns_.coordinates.size()];
        place = order == 0 ? position(columns_.motion[0][i]) : number(columns_.motion[order][i]);
      }
    }
    trajectory_.states.push_back(std::move(state));
    trajectory_.places.push_back(line_.number);
  }

  // Whether a row says nothing of the base, as rows do whose motion was FROM_CONTACT beside others that were not.
  bool is_base_empty() const
  {
    if (how_.wanted)
      return false;
    for (const std::vector<std::size_t>& columns : columns_.motion)
      for (std::size_t i = columns_.coordinates.size(); i < columns.size(); ++i)
        if (!cell(columns[i]).empty())
          return false;
    return true;
  }

  // what only the whole file tells

  WrittenMotion written_motion() const
  {
    WrittenMotion written;
    written.time_column = columns_.utime ? "utime" : "time";
    written.times = seconds_;
    written.columns = columns_.coordinates;
    for (const std::string& name : columns_.coordinates)
      written.is_angle.push_back(!names_.displacements.contains(name));
    written.base_given = columns_.base_given;
    if (written.base_given)
    {
      written.columns.insert(written.columns.end(), names_.base.begin(), names_.base.end());
      written.is_angle.insert(written.is_angle.end(), names_.base.size(), false);
    }
    const auto rows = static_cast<Eigen::Index>(trajectory_.states.size());
    const auto coordinates = static_cast<Eigen::Index>(written.columns.size());
    written.positions.resize(rows, coordinates);
    if (!how_.wanted)
      written.velocities.resize(rows, coordinates);
    for (Eigen::Index i = 0; i < rows; ++i)
    {
      const desired_state_t& state = trajectory_.states[static_cast<std::size_t>(i)];
      put(written.positions, i, state.q, state.base_q);
      if (!how_.wanted)
        put(written.velocities, i, state.v, state.base_v);
    }
    return written;
  }

  // one row of coordinates, of which the base's are the last two if it is given
  void put(Eigen::MatrixXd& rows, Eigen::Index row, const std::vector<double>& angles, const double* base) const
  {
    const auto count = static_cast<Eigen::Index>(angles.size());
    rows.row(row).head(count) = Eigen::Map<const Eigen::RowVectorXd>(angles.data(), count);
    if (columns_.base_given)
      rows.row(row).tail<2>() = Eigen::Map<const Eigen::RowVector2d>(base);
  }
  void get(const Eigen::MatrixXd& rows, Eigen::Index row, std::vector<double>& angles, double* base) const
  {
    const auto count = static_cast<Eigen::Index>(angles.size());
    Eigen::Map<Eigen::RowVectorXd>(angles.data(), count) = rows.row(row).head(count);
    if (columns_.base_given)
      Eigen::RowVector2d::Map(base) = rows.row(row).tail<2>();
  }

  void find_derivatives(const WrittenMotion& written)
  {
    Differentiated found = differentiate(written, how_, trajectory_.file, trajectory_.places);
    for (std::size_t i = 0; i < trajectory_.states.size(); ++i)
    {
      desired_state_t& state = trajectory_.states[i];
      const auto row = static_cast<Eigen::Index>(i);
      get(found.motion.position, row, state.q, state.base_q);
      get(found.motion.velocity, row, state.v, state.base_v);
      get(found.motion.acceleration, row, state.a, state.base_a);
    }
    seconds_ = std::move(found.times);
    trajectory_.assumptions.insert(trajectory_.assumptions.end(), found.notes.begin(), found.notes.end());
  }

  void complete_supports()
  {
    std::vector<std::int64_t> utime;
    std::vector<Contacts> contacts;
    for (const desired_state_t& state : trajectory_.states)
    {
      // of the frames where times were put back on them
      const std::int64_t taken =
          how_.wanted ? std::llround(1e6 * (seconds_[utime.size()] - seconds_.front())) : state.utime;
      utime.push_back(utime.empty() ? taken : std::max(taken, utime.back() + 1));
      contacts.push_back({static_cast<Contact>(state.left_contact), static_cast<Contact>(state.right_contact)});
    }
    const std::vector<Support> supports = follow_contacts(utime, contacts);
    for (std::size_t i = 0; i < supports.size(); ++i)
    {
      desired_state_t& state = trajectory_.states[i];
      if (!columns_.leading)
        state.leading_foot = static_cast<std::int8_t>(supports[i].leading);
      if (!columns_.load_transfer)
        state.load_transfer = supports[i].load_transfer;
      if (!columns_.phase)
        state.phase = supports[i].phase;
    }
    if (stands_throughout(contacts))
      assume_half(supports.front());
    else if (!columns_.load_transfer)
      note_ends_in_double_support(contacts);
  }

  // A double support that the file cuts has no known time, so that where the load is when it begins, or ends, is a
  // guess.
  void note_ends_in_double_support(const std::vector<Contacts>& contacts)
  {
    const bool begins = std::ranges::count(contacts.front(), Contact::none) == 0;
    const bool ends = std::ranges::count(contacts.back(), Contact::none) == 0;
    if (begins || ends)
      trajectory_.assumptions.push_back(
          fmt::format("the motion {} on both feet, and no column load_transfer says how the load is shared then: it is "
                      "handed over in the whole time of that double support, so that the {} row{} on one foot alone",
                      begins && ends ? "begins and ends"
                      : begins       ? "begins"
                                     : "ends",
                      begins && ends ? "first and the last"
                      : begins       ? "first"
                                     : "last",
                      begins && ends ? "s stand" : " stands"));
  }

  // says what a robot that stands throughout is given because the columns do not say
  void assume_half(const Support& support)
  {
    const bool sole = support.of(Side::left) == Contact::sole, other_sole = support.of(Side::right) == Contact::sole;
    std::vector<std::string_view> assumed;
    if (!columns_.load_transfer)
      assumed.push_back("load_transfer");
    if (!columns_.phase && sole != other_sole)
      assumed.push_back("phase");
    if (!assumed.empty())
      trajectory_.assumptions.push_back(fmt::format(
          "both feet keep their contacts throughout, and no column says {}: 0.5, half of the load handed over; a "
          "posture that is not symmetric still loads its feet unequally under the method constrained",
          fmt::join(assumed, " and ")));
  }

  CsvReader reader_;
  const CoordinateNames& names_;
  const Differentiation& how_;
  CsvLine line_;
  Trajectory trajectory_;

  MotionColumns columns_;
  std::vector<double> seconds_; // not rounded to µs
  std::string previous_time_;
};

} // namespace

Trajectory parse_csv_trajectory(std::string_view text, const std::string& file, const CoordinateNames& names,
                                const Differentiation& how)
{
  return CsvTrajectory(text, file, names, how).read();
}

} // namespace torqued
