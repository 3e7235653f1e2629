#include "study/tally.h"

#include "motion/failure.h"
#include "stance/refusal.h"
#include "study/answer_table.h"

#include <fmt/format.h>

namespace torqued
{

namespace
{

// "NAME 3, OTHER 1"
template <typename Counts, typename Name, typename Count> std::string list(const Counts& counts, Name name, Count count)
{
  std::string text;
  for (const auto& [key, value] : counts)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name(key), count(value));
  return text;
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

std::string Tally::rejections() const
{
  const std::string by_reason = list(rejected, reason_name, [](const Rejected& so_far) { return so_far.count; });
  return fmt::format("{} rejected{}{}", num_rejected(), by_reason.empty() ? "" : ": ", by_reason);
}

std::string Tally::flag_line() const
{
  const std::map<std::string, std::int64_t> counts = flags();
  if (counts.empty())
    return "";
  const auto same = [](const auto& value)
  {
    return value;
  };
  return fmt::format("flags: {}\n", list(counts, same, same));
}

std::string Tally::first_of_each() const
{
  std::string lines;
  for (const auto& [reason, so_far] : rejected)
    lines += fmt::format("  {}, first: {}\n", reason_name(reason), so_far.first);
  return lines;
}

void Tally::require_answers(const std::string& file) const
{
  if (answered > 0 || rejected.empty())
    return;
  throw Failure(ExitCode::bad_data,
                fmt::format("{}: no sample was answered: {}; the first: {}", file, rejections(), first));
}

std::string reason_name(std::int32_t reason)
{
  return std::string(name_of(static_cast<Reason>(reason)));
}

} // namespace torqued
