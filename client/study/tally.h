/// Counts of answers and rejections, and how they are told.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace torqued
{

struct Tally
{
  struct Rejected
  {
    std::int64_t count = 0;
    std::string first; ///< what was said about the first
  };

  std::int64_t answered = 0;
  std::map<std::int32_t, Rejected> rejected;    ///< key: reason, as in rejection_t
  std::map<std::int32_t, std::int64_t> flagged; ///< answers; key: all flags of an answer
  std::string first;                            ///< what was said about the first rejection of all

  void answer(std::int32_t flags);
  /// said: kept if it is the first of its reason.
  void reject(std::int32_t reason, const std::string& said);
  std::int64_t num_rejected() const;
  /// How many answers carry each flag, by its name; flags that none carries are left out.
  std::map<std::string, std::int64_t> flags() const;

  /// "ck: 428 of 447 samples answered, 19 rejected: UNDER_ACTUATED 12, STALE 7"; then a line of flags, if there are
  /// any, and one of what was said first for each reason. others: what became of other samples, "3 lost, ".
  std::string summary(std::string_view name, std::size_t samples, std::string_view others = "") const;

  /// Throws Failure, bad_data, if there were samples and none was answered: how many were rejected, and why the first.
  void require_answers(const std::string& file) const;
};

/// A reason's name; "UNKNOWN" for any other number.
std::string reason_name(std::int32_t reason);

} // namespace torqued
