/// Why a desired state is not answered: a value, not an exception, and made without allocating.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <string_view>
#include <utility>
#include <variant>

namespace torqued
{

/// Numbered as in rejection_t.
enum class Reason : std::int32_t
{
  undecodable = 1,
  wrong_model = 2,
  wrong_size = 3,
  not_finite = 4,
  out_of_range = 5,
  unknown_method = 6,
  out_of_order = 7,
  stale = 8,
  other_stream = 9,
  inconsistent = 10,
  under_actuated = 11,
  infeasible = 12,
  over_limit = 13,
  not_supported = 14,
  numerical = 15
};

/// The reason's name as rejection_t spells it, e.g. "OUT_OF_RANGE"; "UNKNOWN" for any other number.
std::string_view name_of(Reason reason);

/// A reason, and one line that says which field, its value and what would be right.
class Refusal
{
public:
  /// detail: a format text and what it formats; cut after 240 characters.
  template <typename... Args>
  Refusal(Reason reason, fmt::format_string<Args...> detail, Args&&... args) : reason_(reason)
  {
    const auto end = fmt::format_to_n(detail_.data(), detail_.size(), detail, std::forward<Args>(args)...);
    length_ = std::min(end.size, detail_.size());
  }

  Reason reason() const { return reason_; }
  std::string_view detail() const { return {detail_.data(), length_}; }

private:
  Reason reason_;
  std::size_t length_;
  std::array<char, 240> detail_;
};

template <typename T> using Result = std::variant<T, Refusal>;

} // namespace torqued
