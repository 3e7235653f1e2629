/// Text from outside, before it is shown on a terminal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace torqued
{

/// The most characters of a value that a complaint shows.
inline constexpr std::size_t kLongestShown = 60;
/// The most bytes of a line that is shown whole: a complaint, a note, a line of a log.
inline constexpr std::size_t kLongestLine = 2000;

/// A character at the begin of a text.
struct Utf8Character
{
  std::uint32_t code;
  std::size_t size; ///< bytes; 0 if they are no UTF-8
};

/// Reads the first character of a text that is not empty, as Unicode defines UTF-8: no surrogates, nothing longer than
/// need be.
inline Utf8Character first_character(std::string_view text)
{
  const auto byte = [text](std::size_t i)
  {
    return std::uint32_t{static_cast<unsigned char>(text[i])};
  };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80)
    return {lead, 1};
  const std::size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  constexpr std::uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  if (lead < 0xC2 || lead > 0xF4 || text.size() < size)
    return {0, 0};
  std::uint32_t code = lead & (0xFFu >> (size + 1));
  for (std::size_t i = 1; i < size; ++i)
  {
    if ((byte(i) & 0xC0) != 0x80)
      return {0, 0};
    code = code << 6 | (byte(i) & 0x3F);
  }
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  return code < least[size] || code > 0x10FFFF || is_surrogate ? Utf8Character{0, 0} : Utf8Character{code, size};
}

/// Whether a terminal just shows it: not the control characters, nor those of Unicode that break lines or turn the
/// order of what follows.
inline bool is_shown(std::uint32_t code)
{
  const auto within = [code](std::uint32_t first, std::uint32_t last)
  {
    return code >= first && code <= last;
  };
  return code >= 0x20 && !within(0x7F, 0x9F) && code != 0x61C && !within(0x200E, 0x200F) && !within(0x2028, 0x202E) &&
         !within(0x2066, 0x2069);
}

/// Appends the text to a string or buffer of characters, with a question mark for what a terminal might obey and for
/// each byte that is no UTF-8, and cut after `longest` characters.
template <typename Buffer> void append_printable(Buffer& buffer, std::string_view text, std::size_t longest)
{
  const auto append = [&buffer](std::string_view part)
  {
    buffer.append(part.data(), part.data() + part.size());
  };
  for (std::size_t shown = 0; !text.empty(); ++shown)
  {
    if (shown == longest)
      return append("...");
    const Utf8Character character = first_character(text);
    const std::size_t size = character.size == 0 ? 1 : character.size;
    append(character.size > 0 && is_shown(character.code) ? text.substr(0, size) : "?");
    text.remove_prefix(size);
  }
}

/// The text as append_printable() leaves it.
inline std::string printable(std::string_view text, std::size_t longest = 300)
{
  std::string shown;
  append_printable(shown, text, longest);
  return shown;
}

/// The first of some names: "q0, q1, ...". longest: of each, characters.
template <typename Names> std::string listed(const Names& names, std::size_t most, std::size_t longest = 300)
{
  std::string list;
  std::size_t count = 0;
  for (const auto& name : names)
  {
    if (count == most)
      return list + ", ...";
    list += (count++ > 0 ? ", " : "") + printable(name, longest);
  }
  return list;
}

/// Appends one line for a terminal: printable, and of one that is too long the begin, where it says what is the matter,
/// and the end, where it says what would be right.
template <typename Buffer> void append_printable_line(Buffer& buffer, std::string_view line)
{
  if (line.size() <= kLongestLine)
    return append_printable(buffer, line, kLongestLine);
  constexpr std::size_t end = kLongestLine / 4;
  append_printable(buffer, line.substr(0, kLongestLine - end), kLongestLine);
  append_printable(buffer, " ... ", kLongestLine);
  append_printable(buffer, line.substr(line.size() - end), kLongestLine);
}

/// Lines for a terminal, each as append_printable_line() leaves it.
inline std::string printable_lines(std::string_view text)
{
  std::string shown;
  for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n'))
  {
    append_printable_line(shown, text.substr(0, end));
    shown += '\n';
    text.remove_prefix(end + 1);
  }
  append_printable_line(shown, text);
  return shown;
}

/// The same of a text that is one line: ends of lines within it are shown as what they are, something from outside.
inline std::string printable_line(std::string_view line)
{
  std::string shown;
  append_printable_line(shown, line);
  return shown;
}

} // namespace torqued
