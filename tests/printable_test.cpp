#include "catch.h"

#include "text/number.h"
#include "text/printable.h"

#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace printable_test
{

using namespace torqued;

namespace
{

// A character's UTF-8, also of what is none: surrogates, and what is longer than need be.
std::string encoded(std::uint32_t code, int size)
{
  if (size == 1)
    return {static_cast<char>(code)};
  std::string bytes;
  for (int i = 0; i < size - 1; ++i, code >>= 6)
    bytes.insert(bytes.begin(), static_cast<char>(0x80 | (code & 0x3F)));
  return static_cast<char>((0xF00u >> size) | code) + bytes;
}

} // namespace

TEST_CASE("letters of any script pass, and what a terminal might obey does not", "[printable]")
{
  for (const char* plain :
       {"", "left_ankle", "~ !", "\u00fcber", "90\u00b0", "\u03b8\u0307 = \u03c9", "\u65e5\u672c", "\U0001f9bf"})
    CHECK(printable(plain) == plain);
  for (const auto& [text, shown] : std::vector<std::pair<std::string, std::string>>{
           {"\x1b[2J", "?[2J"},
           {"a\nb\tc\rd\be\x7f", "a?b?c?d?e?"},
           {std::string("a\0b", 3), "a?b"},
           {"\u009b2J \u0080 \u009f", "?2J ? ?"},          // C1
           {"\u202eevil \u202a\u2066\u2069", "?evil ???"}, // turn the order of letters
           {"\u200e\u200f\u061c \u2028\u2029", "??? ??"},  // likewise, and line ends
           {"\xff\xfe q\xb0", "?? q?"},                    // Latin-1
           {"\xc2", "?"},                                  // cut
           {"\xe2\x82", "??"},
           {"\xc2\x1b[2J", "??[2J"},            // an escape where a letter should go on
           {"\xc0\x9b \xe0\x80\x9b", "?? ???"}, // longer than need be
           {"\xed\xa0\x80", "???"},             // a surrogate
           {"\xf4\x90\x80\x80 \xf8\x88\x80\x80\x80", "???? ?????"},
       })
    CHECK(printable(text) == shown);
  // each character in each length
  for (std::uint32_t code = 0; code <= 0x10FFFF; code += code < 0x3000 ? 1 : 251)
  {
    const int shortest = code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
    for (int size = shortest; size <= 4; ++size)
    {
      const std::string text = encoded(code, size);
      const bool passes = size == shortest && !is_surrogate && is_shown(code);
      if (printable(text) != (passes ? text : std::string(size == shortest && !is_surrogate ? 1 : size, '?')))
        FAIL("character " << code << " in " << size << " bytes");
    }
  }
}

TEST_CASE("what is shown is cut between characters, and shows nothing new when it is shown again", "[printable]")
{
  CHECK(printable("abc", 3) == "abc");
  CHECK(printable("abcd", 3) == "abc...");
  CHECK(printable("\u00fc\u00fc\u00fc\u00fc", 3) == "\u00fc\u00fc\u00fc...");
  CHECK(printable("a\x1b\x1b\x1b", 3) == "a??...");
  CHECK(printable(std::string(1'000'000, 'x')).size() == 303);

  std::minstd_rand random(1);
  for (int round = 0; round < 20'000; ++round)
  {
    std::string text(random() % 40, ' ');
    for (char& c : text)
      c = static_cast<char>(round % 2 == 0 ? random() % 256 : 0x80 + random() % 0x60);
    const std::string shown = printable(text, 1000);
    REQUIRE(shown.size() <= text.size());
    REQUIRE(printable(shown, 1000) == shown);
    for (std::string_view rest = shown; !rest.empty();)
    {
      const Utf8Character character = first_character(rest);
      REQUIRE(character.size > 0);
      REQUIRE(is_shown(character.code));
      rest.remove_prefix(character.size);
    }
  }
}

TEST_CASE("a number is the whole of a text, in range, with or without a sign", "[printable]")
{
  for (const auto& [text, number] : std::vector<std::pair<std::string, double>>{
           {"0", 0.0}, {"+5", 5.0}, {"-0.25", -0.25}, {".5", 0.5}, {"5.", 5.0}, {"1e-3", 1e-3}, {"1E3", 1e3}})
    CHECK(number_in<double>(text) == number);
  for (const char* none : {"", "+", "-", "+-5", "++5", " 5", "5 ", "5a", "0x10", "1,5", "1e999", "five"})
  {
    CAPTURE(none);
    CHECK(!number_in<double>(none));
    CHECK(!number_in<int>(none));
  }
  CHECK(number_in<std::int8_t>("-128") == -128);
  CHECK(!number_in<std::int8_t>("128"));
  CHECK(!number_in<int>("1.5"));
  CHECK(!number_in<std::size_t>("-1"));
}

TEST_CASE("of many names the first are listed, of a long name its beginning", "[printable]")
{
  const std::vector<std::string> names{"q0", "q\x1b", "", "abcdef"};
  CHECK(listed(names, 4) == "q0, q?, , abcdef");
  CHECK(listed(names, 3) == "q0, q?, , ...");
  CHECK(listed(names, 4, 3) == "q0, q?, , abc...");
  CHECK(listed(std::vector<std::string>(), 3).empty());
}

} // namespace printable_test
