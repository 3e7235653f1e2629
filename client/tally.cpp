#include "client/tally.h"

#include "torque/refusal.h"

#include <fmt/format.h>

namespace torqued
{

void Tally::reject(std::int32_t reason, const std::string& first)
{
  Rejected& so_far = rejected[reason];
  if (++so_far.count == 1)
    so_far.first = first;
}

std::int64_t Tally::num_rejected() const
{
  std::int64_t count = 0;
  for (const auto& [reason, so_far] : rejected)
    count += so_far.count;
  return count;
}

std::string Tally::rejections() const
{
  std::string text = fmt::format("{} rejected", num_rejected());
  std::string_view separator = ": ";
  for (const auto& [reason, so_far] : rejected)
  {
    text += fmt::format("{}{} {}", separator, reason_name(reason), so_far.count);
    separator = ", ";
  }
  return text;
}

std::string Tally::first_of_each() const
{
  std::string lines;
  for (const auto& [reason, so_far] : rejected)
    lines += fmt::format("  {}, first: {}\n", reason_name(reason), so_far.first);
  return lines;
}

std::string reason_name(std::int32_t reason)
{
  return std::string(name_of(static_cast<Reason>(reason)));
}

} // namespace torqued
