/// Small changes of texts.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace torqued
{

/// The ASCII letters in lower case, whatever the locale.
inline std::string lower_case(std::string_view text)
{
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return lower;
}

/// The text without these characters at its ends.
inline std::string_view trimmed(std::string_view text, std::string_view blanks = " \t")
{
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string_view::npos ? "" : text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

} // namespace torqued
