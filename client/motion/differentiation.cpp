#include "motion/differentiation.h"

#include "motion/acceleration_noise.h"
#include "motion/column_names.h"
#include "motion/failure.h"
#include "motion/lowpass.h"
#include "motion/motion_columns.h"
#include "motion/samples.h"
#include "motion/unwrap.h"
#include "text/printable.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>

namespace torqued
{

namespace
{

constexpr double kLongestBridge = 0.1; // s
// shares of noise in accelerations, and accelerations (rad/s², m/s²), that are worth a note
constexpr double kNotableNoise = 0.1, kNotableAcceleration = 0.05;

using Rows = std::vector<std::size_t>;

// The file's motion on its way to derivatives; complaints carry the file's lines.
class Differentiator
{
public:
  Differentiator(const WrittenMotion& written, const Differentiation& how, const std::string& file,
                 const std::vector<std::size_t>& lines)
      : written_(written), how_(how), file_(file), lines_(lines), positions_(written.positions)
  {
  }

  Differentiated run()
  {
    if (written_.times.size() < static_cast<std::size_t>(kFewestSplineSamples))
      throw Failure(ExitCode::bad_data, "{}: found {} rows; expected at least {} for --differentiate", file_,
                    written_.times.size(), kFewestSplineSamples);
    const bool degrees = doubt_units(written_).degrees;
    if (!degrees)
      unwrap_angles();
    samples_ = find_samples(written_.times, positions_, lines_);
    notes_.insert(notes_.end(), samples_.notes.begin(), samples_.notes.end());
    check_ends();
    if (how_.lowpass)
      check_lowpass();
    for (Eigen::Index j = 0; j < positions_.cols(); ++j)
    {
      const Rows rows = samples_of(j);
      check_gaps(j, rows);
      if (!degrees)
        check_jumps(j, rows);
    }
    note_gaps();
    SampledMotion motion = fit();
    if (how_.lowpass)
      motion = smooth(motion);
    return {std::move(motion), samples_.times, std::move(notes_)};
  }

private:
  const std::string& name(Eigen::Index column) const { return written_.columns[static_cast<std::size_t>(column)]; }
  bool is_angle(Eigen::Index column) const { return written_.is_angle[static_cast<std::size_t>(column)]; }
  std::size_t line(std::size_t row) const { return lines_[row]; }

  void unwrap_angles()
  {
    std::map<Eigen::Index, std::vector<CoordinateStep>> turns;
    for (const CoordinateStep& step : unwrap(written_.times, positions_, written_.is_angle))
      turns[step.column].push_back(step);
    for (const auto& [column, steps] : turns)
      notes_.push_back(
          fmt::format("column {}: a whole turn was taken off {} step{} of the angle, the first in line {} ({:.4g} rad)",
                      printable(name(column)), steps.size(), steps.size() == 1 ? "" : "s",
                      line(static_cast<std::size_t>(steps.front().row)), steps.front().size));
  }

  void check_jumps(Eigen::Index column, const Rows& rows) const
  {
    if (const auto jump = find_jump(written_.times, positions_, is_angle(column), column, rows))
      fail_in_column(file_, line(static_cast<std::size_t>(jump->row)), name(column),
                     fmt::format("a step of {:.4g} {} from the sample before, where those around it make expect {:.2g}",
                                 jump->size, is_angle(column) ? "rad" : "m", jump->usual),
                     "a motion without jumps");
  }

  // Frozen frames at an end: nothing lies beyond them that a bridge could stand on. A recording that repeats every
  // frame ends with one, and goes on until half a frame before.
  void check_ends() const
  {
    const std::vector<bool>& frozen = samples_.is_frozen;
    const std::size_t at_start = static_cast<std::size_t>(std::ranges::find(frozen, false) - frozen.begin());
    const std::size_t at_end =
        static_cast<std::size_t>(std::find(frozen.rbegin(), frozen.rend(), false) - frozen.rbegin());
    const bool repeats = at_end == 1 && std::ranges::count(frozen, true) > 2;
    const auto fail = [&](std::size_t row, std::size_t count, std::string_view where)
    {
      throw Failure(ExitCode::bad_data,
                    "{}:{}: found {} frozen frame{} at the motion's {}, while it moves on; expected a motion without: "
                    "leave {} out",
                    file_, line(row), count, count == 1 ? "" : "s", where, count == 1 ? "this row" : "these rows");
    };
    if (at_start > 0)
      fail(0, at_start, "beginning");
    if (at_end > 0 && !repeats)
      fail(frozen.size() - at_end, at_end, "end");
  }

  void check_lowpass() const
  {
    if (!samples_.frames)
      throw Failure(ExitCode::bad_data,
                    "{}: found times that are no frames of one rate, {:.4g} s apart in the median; expected a frame "
                    "rate for --lowpass",
                    file_, samples_.step);
    if (std::ranges::count(samples_.frames->number, FrameRate::kNone) + kFewestSplineSamples >
        static_cast<std::ptrdiff_t>(samples_.times.size()))
      throw Failure(ExitCode::bad_data, "{}: found fewer than {} frames for --lowpass", file_, kFewestSplineSamples);
    if (2.0 * *how_.lowpass >= samples_.frames->rate)
      throw Failure(ExitCode::bad_data,
                    "{}: found --lowpass {:g} Hz for frames at {:.6g} Hz; expected less than half of their rate", file_,
                    *how_.lowpass, samples_.frames->rate);
  }

  // the rows that are samples of a coordinate
  Rows samples_of(Eigen::Index column) const
  {
    Rows rows;
    for (std::size_t row = 0; row < samples_.times.size(); ++row)
      if (samples_.is_sample[row] && std::isfinite(positions_(static_cast<Eigen::Index>(row), column)))
        rows.push_back(row);
    return rows;
  }

  // Gaps of a coordinate are refused, or counted: missing frames of the file, cells without a number.
  void check_gaps(Eigen::Index column, const Rows& rows)
  {
    if (rows.size() < static_cast<std::size_t>(kFewestSplineSamples))
      fail_in_column(file_, lines_.front(), name(column), fmt::format("{} samples", rows.size()),
                     fmt::format("at least {} for --differentiate", kFewestSplineSamples));
    for (const std::size_t row : {std::size_t{0}, lines_.size() - 1})
      if (!std::isfinite(positions_(static_cast<Eigen::Index>(row), column)))
        fail_in_column(file_, line(row), name(column), "nothing at the motion's end",
                       "a number: only what lies between two samples is bridged");
    for (std::size_t i = 1; i < rows.size(); ++i)
    {
      const std::size_t from = rows[i - 1], to = rows[i];
      const double gap = samples_.times[to] - samples_.times[from] - samples_.step;
      const bool cells = to > from + 1;
      if (gap < 0.5 * samples_.step || !(samples_.is_recording || cells))
        continue;
      if (gap > kLongestBridge + 1e-3 * samples_.step)
        fail_in_column(
            file_, line(to), name(column),
            fmt::format("{} for {:.4g} s, from {:.6g} s after the first row on (line {})",
                        samples_.is_frozen[from + 1] ? "one posture, while the motion goes on," : "no sample",
                        gap + samples_.step, samples_.times[from], line(from)),
            fmt::format("gaps of {:g} s at most, which are bridged", kLongestBridge));
      if (!cells)
        missing_[from] = std::lround(gap / samples_.step);
    }
    for (std::size_t row = 0; row < lines_.size(); ++row)
      if (!std::isfinite(positions_(static_cast<Eigen::Index>(row), column)))
        empty_[row].push_back(column);
  }

  void note_gaps()
  {
    if (!missing_.empty())
    {
      long frames = 0;
      for (const auto& [row, number] : missing_)
        frames += number;
      const std::size_t first = missing_.begin()->first;
      notes_.push_back(fmt::format("{} missing frame{} bridged in {} gap{}, the first between lines {} and {}", frames,
                                   frames == 1 ? "" : "s", missing_.size(), missing_.size() == 1 ? "" : "s",
                                   line(first), line(first + 1)));
    }
    if (!empty_.empty())
    {
      const auto& [row, columns] = *empty_.begin();
      std::vector<std::string> names;
      for (const Eigen::Index column : columns)
        names.push_back(printable(name(column)));
      notes_.push_back(fmt::format("cells without a number bridged in {} row{}, line {} first (column{} {})",
                                   empty_.size(), empty_.size() == 1 ? "" : "s", line(row),
                                   names.size() == 1 ? "" : "s", fmt::join(names, ", ")));
    }
  }

  // at each row, of the splines through the samples
  SampledMotion fit()
  {
    std::map<Rows, std::vector<Eigen::Index>> groups; // coordinates with the same samples
    for (Eigen::Index j = 0; j < positions_.cols(); ++j)
      groups[samples_of(j)].push_back(j);

    const Eigen::VectorXd rows = row_times(), equal = equal_times();
    Eigen::VectorXd instants(rows.size() + equal.size());
    instants << rows, equal;
    SampledMotion motion{positions_, positions_, positions_};
    Eigen::MatrixXd accelerations(equal.size(), positions_.cols());
    for (const auto& [samples, columns] : groups)
    {
      const std::vector<Eigen::Index> index(samples.begin(), samples.end());
      const SampledMotion part = spline(rows(index), positions_(index, columns), instants);
      motion.velocity(Eigen::all, columns) = part.velocity.topRows(rows.size());
      motion.acceleration(Eigen::all, columns) = part.acceleration.topRows(rows.size());
      accelerations(Eigen::all, columns) = part.acceleration.bottomRows(equal.size());
      for (Eigen::Index i = 0; i < rows.size(); ++i)
        for (std::size_t k = 0; k < columns.size(); ++k)
          if (!is_given(static_cast<std::size_t>(i), columns[k]))
            motion.position(i, columns[k]) = part.position(i, static_cast<Eigen::Index>(k));
    }
    if (!how_.lowpass)
      note_noise(equal, accelerations);
    return motion;
  }

  Eigen::VectorXd row_times() const
  {
    return Eigen::Map<const Eigen::VectorXd>(samples_.times.data(), static_cast<Eigen::Index>(samples_.times.size()));
  }

  // all frames' times, or without a frame rate as many as there are rows
  Eigen::VectorXd equal_times() const
  {
    if (!samples_.frames)
      return Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(samples_.times.size()), samples_.times.front(),
                                        samples_.times.back());
    const FrameRate& frames = *samples_.frames;
    const std::int64_t last = *std::ranges::max_element(frames.number);
    return Eigen::VectorXd::LinSpaced(last + 1, frames.start, frames.time(last));
  }

  // whether a row's own position is the motion's: not of frozen frames and empty cells
  bool is_given(std::size_t row, Eigen::Index column) const
  {
    return !samples_.is_frozen[row] && std::isfinite(positions_(static_cast<Eigen::Index>(row), column));
  }

  // the same motion through the low-pass, which needs all frames
  SampledMotion smooth(const SampledMotion& motion)
  {
    std::vector<Eigen::Index> rows;
    for (std::size_t row = 0; row < samples_.times.size(); ++row)
      if (samples_.frames->number[row] != FrameRate::kNone)
        rows.push_back(static_cast<Eigen::Index>(row));
    const Eigen::VectorXd instants = row_times(), frame_times = equal_times();
    Eigen::MatrixXd all = motion.position(rows, Eigen::all);
    if (all.rows() < frame_times.size())
      all = spline(instants(rows), all, frame_times).position;
    notes_.push_back(fmt::format(
        "low-passed at {:g} Hz: Butterworth of second order, forward and backward; the cut-off is that of one pass",
        *how_.lowpass));
    return spline(frame_times, lowpass(all, samples_.frames->rate, *how_.lowpass), instants);
  }

  void note_noise(const Eigen::VectorXd& times, const Eigen::MatrixXd& accelerations)
  {
    double worst_share = kNotableNoise;
    std::string note;
    for (Eigen::Index j = 0; j < accelerations.cols(); ++j)
    {
      const AccelerationNoise noise = acceleration_noise(accelerations.col(j));
      if (noise.noise < kNotableAcceleration || noise.noise <= worst_share * noise.rms)
        continue;
      worst_share = noise.noise / noise.rms;
      const auto near = std::lower_bound(samples_.times.begin(), samples_.times.end() - 1, times(noise.worst));
      note = fmt::format("accelerations leap from sample to sample, most in column {}, by {:.2g} of {:.2g} {} rms, "
                         "there most near line {}: noise or corners of the positions, which --lowpass HZ smooths",
                         printable(name(j)), noise.noise, noise.rms, is_angle(j) ? "rad/s²" : "m/s²",
                         line(static_cast<std::size_t>(near - samples_.times.begin())));
    }
    if (!note.empty())
      notes_.push_back(std::move(note));
    note_ends(accelerations);
  }

  // A last, or first, sample that does not go on as those before it bends the spline there, and nowhere else.
  void note_ends(const Eigen::MatrixXd& accelerations)
  {
    constexpr Eigen::Index end = 6;
    constexpr double notable = 4.0; // of the largest acceleration inside
    const Eigen::Index n = accelerations.rows();
    if (n < 6 * end)
      return;
    const auto inside = accelerations.middleRows(end, n - 2 * end).cwiseAbs().colwise().maxCoeff().eval();
    for (const bool first : {true, false})
    {
      const auto largest =
          (first ? accelerations.topRows(end) : accelerations.bottomRows(end)).cwiseAbs().colwise().maxCoeff().eval();
      Eigen::Index column = 0;
      const double ratio = (largest.array() / inside.array().max(kNotableAcceleration)).maxCoeff(&column);
      if (ratio > notable)
        notes_.push_back(fmt::format("accelerations at the motion's {} reach {:.3g} {} in column {}, and {:.3g} "
                                     "elsewhere: its {} samples do not go on like the others",
                                     first ? "beginning" : "end", largest(column), is_angle(column) ? "rad/s²" : "m/s²",
                                     printable(name(column)), inside(column), first ? "first" : "last"));
    }
  }

  const WrittenMotion& written_;
  const Differentiation& how_;
  const std::string& file_;
  const std::vector<std::size_t>& lines_;
  Eigen::MatrixXd positions_; // without whole turns
  Samples samples_;
  std::map<std::size_t, long> missing_;                    // after each row: frames
  std::map<std::size_t, std::vector<Eigen::Index>> empty_; // in each row: coordinates without a number
  std::vector<std::string> notes_;
};

} // namespace

Differentiated differentiate(const WrittenMotion& written, const Differentiation& how, const std::string& file,
                             const std::vector<std::size_t>& lines)
{
  return Differentiator(written, how, file, lines).run();
}

} // namespace torqued
