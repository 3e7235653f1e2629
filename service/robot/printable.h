/// Text from outside, before it is shown on a terminal.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

namespace torqued
{

/// The most characters of a value that a complaint shows.
inline constexpr std::size_t kLongestShown = 60;

/// The text with a question mark for all that is not plain ASCII, because a terminal might obey it, and cut after
/// `longest` characters.
inline std::string printable(std::string text, std::size_t longest = 300)
{
  if (text.size() > longest)
    text = text.substr(0, longest) + "...";
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

} // namespace torqued
