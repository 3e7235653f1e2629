/// Numbers that are written as text.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace torqued
{

/// The number that a whole text is, in every locale; with or without a plus sign. Nothing if it is none, or out of
/// range; nan and inf are numbers.
template <typename Number> std::optional<Number> number_in(std::string_view text)
{
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') // std::from_chars takes no plus
    text.remove_prefix(1);
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

} // namespace torqued
