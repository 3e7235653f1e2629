#include "motion/unit_names.h"

#include "text/plain_text.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string>
#include <utility>

namespace torqued
{

namespace
{

struct Unit
{
  Quantity quantity;
  std::string_view name; // lower case
  double factor;
};

constexpr std::array kUnits{
    Unit{Quantity::share, "%", 1e-2},          Unit{Quantity::time, "s", 1.0},
    Unit{Quantity::time, "sec", 1.0},          Unit{Quantity::time, "seconds", 1.0},
    Unit{Quantity::time, "ms", 1e-3},          Unit{Quantity::time, "us", 1e-6},
    Unit{Quantity::time, "ns", 1e-9},          Unit{Quantity::time_stamp, "us", 1.0},
    Unit{Quantity::angle, "rad", 1.0},         Unit{Quantity::angle, "radians", 1.0},
    Unit{Quantity::angle, "mrad", 1e-3},       Unit{Quantity::angle, "deg", kDegree},
    Unit{Quantity::angle, "degrees", kDegree}, Unit{Quantity::length, "m", 1.0},
    Unit{Quantity::length, "cm", 1e-2},        Unit{Quantity::length, "mm", 1e-3},
    Unit{Quantity::force, "n", 1.0},           Unit{Quantity::force, "kn", 1e3},
    Unit{Quantity::moment, "nm", 1.0},         Unit{Quantity::moment, "nmm", 1e-3},
};

void replace_all(std::string& text, std::string_view from, std::string_view to)
{
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

} // namespace

std::string plain_unit(std::string_view unit)
{
  std::string text = lower_case(unit);
  for (const auto& [from, to] : std::initializer_list<std::pair<std::string_view, std::string_view>>{
           {"\xc2\xb0", "deg"},   // degree sign
           {"\xc2\xb5", "u"},     // micro sign
           {"\xce\xbc", "u"},     // Greek mu
           {"\xc2\xb2", "2"},     // superscript two
           {"\xe2\x81\xbb", "-"}, // superscript minus
           {"\xc2\xb9", "1"},     // superscript one
           {"\xc2\xb7", ""},      // middle dot
           {"\xe2\x8b\x85", ""},  // dot operator
           {"\xb0", "deg"},       // the same in Latin-1
           {"\xb5", "u"},
           {"\xb2", "2"},
           {" ", ""},
           {"*", ""},
           {"/s/s", "/s2"},
           {"/sec", "/s"},
           {"^", ""},
           {"(", ""},
           {")", ""},
       })
    replace_all(text, from, to);
  if (text.ends_with("s-1") || text.ends_with("s-2"))
    text = text.substr(0, text.size() - 3) + (text.back() == '1' ? "/s" : "/s2");
  return text;
}

std::optional<double> unit_factor(Quantity quantity, int order, std::string_view unit)
{
  std::string text = plain_unit(unit);
  for (const std::string_view per : {"", "/s", "/s2"})
    if (order-- == 0)
    {
      if (!text.ends_with(per))
        return std::nullopt;
      text.resize(text.size() - per.size());
      break;
    }
  const auto known =
      std::ranges::find_if(kUnits, [&](const Unit& other) { return other.quantity == quantity && other.name == text; });
  return known == kUnits.end() ? std::nullopt : std::optional(known->factor);
}

std::string_view expected_units(Quantity quantity)
{
  switch (quantity)
  {
  case Quantity::share: return "no unit, or %";
  case Quantity::time: return "s, ms, us or ns";
  case Quantity::time_stamp: return "us, or a column time in another unit";
  case Quantity::angle: return "rad or deg, with /s or /s^2 for its derivatives";
  case Quantity::length: return "m, cm or mm, with /s or /s^2 for its derivatives";
  case Quantity::force: return "N or kN";
  case Quantity::moment: return "N m or N mm";
  default: return "no unit";
  }
}

} // namespace torqued
