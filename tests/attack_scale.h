/// How long attacks last.
#pragma once

#include <cstdlib>
#include <string>

namespace torqued
{

/// How many times as long as in a short run: ATTACK_SCALE; without it, 1.
inline int attack_scale()
{
  const char* const text = std::getenv("ATTACK_SCALE");
  return text == nullptr || *text == '\0' ? 1 : std::stoi(text);
}

} // namespace torqued
