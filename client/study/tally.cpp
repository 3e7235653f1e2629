#include "study/tally.h"

#include "motion/failure.h"
#include "stance/refusal.h"
#include "study/answer_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace torqued
{

namespace
{

// "19 rejected: UNDER_ACTUATED 12, STALE 7"
std::string rejections(const Tally& tally)
{
  std::vector<std::string> reasons;
  for (const auto& [reason, so_far] : tally.rejected)
    reasons.push_back(fmt::format("{} {}", reason_name(reason), so_far.count));
  return fmt::format("{} rejected{}{}", tally.num_rejected(), reasons.empty() ? "" : ": ", fmt::join(reasons, ", "));
}

} // namespace

void Tally::answer(std::int32_t flags)
{
  ++answered;
  ++flagged[flags];
}

void Tally::reject(std::int32_t reason, const std::string& said)
{
  if (rejected.empty())
    first = said;
  Rejected& so_far = rejected[reason];
  if (++so_far.count == 1)
    so_far.first = said;
}

std::int64_t Tally::num_rejected() const
{
  std::int64_t count = 0;
  for (const auto& [reason, so_far] : rejected)
    count += so_far.count;
  return count;
}

std::map<std::string, std::int64_t> Tally::flags() const
{
  std::map<std::string, std::int64_t> counts;
  for (const auto& [together, count] : flagged)
    for (const std::string& name : flag_names(together))
      counts[name] += count;
  return counts;
}

std::string Tally::summary(std::string_view name, std::size_t samples, std::string_view others) const
{
  std::string text =
      fmt::format("{}: {} of {} samples answered, {}{}\n", name, answered, samples, others, rejections(*this));
  std::vector<std::string> counts;
  for (const auto& [flag, count] : flags())
    counts.push_back(fmt::format("{} {}", flag, count));
  if (!counts.empty())
    text += fmt::format("flags: {}\n", fmt::join(counts, ", "));
  for (const auto& [reason, so_far] : rejected)
    text += fmt::format("  {}, first: {}\n", reason_name(reason), so_far.first);
  return text;
}

void Tally::require_answers(const std::string& file) const
{
  if (answered > 0 || rejected.empty())
    return;
  throw Failure(ExitCode::bad_data, "{}: no sample was answered: {}; the first: {}", file, rejections(*this), first);
}

std::string reason_name(std::int32_t reason)
{
  return std::string(name_of(static_cast<Reason>(reason)));
}

} // namespace torqued
