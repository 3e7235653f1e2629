/// 64-bit FNV-1a, the hash behind model_id and settings_id.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>
#include <string_view>
#include <type_traits>

namespace torqued
{

/// Feed it values in a fixed order; equal values in equal order give equal hashes on every machine.
/// Texts are fed with their length, so that neighbours cannot run into each other; −0.0 counts as 0.0.
class Fnv1a
{
public:
  void add(std::uint64_t value)
  {
    for (int byte = 0; byte < 8; ++byte)
      add_byte(static_cast<unsigned char>(value >> (8 * byte)));
  }
  template <typename Enum>
  requires std::is_enum_v<Enum>
  void add(Enum value) { add(static_cast<int>(value)); }
  void add(int value) { add(static_cast<std::uint64_t>(static_cast<std::int64_t>(value))); }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value == 0.0 ? 0.0 : value)); }
  void add(const Eigen::Vector2d& value)
  {
    add(value.x());
    add(value.y());
  }
  void add(std::string_view text)
  {
    add(static_cast<std::uint64_t>(text.size()));
    for (const char c : text)
      add_byte(static_cast<unsigned char>(c));
  }

  /// The hash so far; never 0, because 0 means "not checked" in messages.
  std::int64_t id() const { return hash_ == 0 ? 1 : std::bit_cast<std::int64_t>(hash_); }

private:
  void add_byte(unsigned char byte) { hash_ = (hash_ ^ byte) * 0x100000001b3ULL; }

  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

} // namespace torqued
