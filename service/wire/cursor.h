/// Walking over a message before it is decoded.
#pragma once

#include "wire/messages.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <endian.h>
#include <utility>

namespace torqued
{

/// Walks over a message in network byte order without ever leaving it; once it would, ok() is false and stays so.
class Cursor
{
public:
  explicit Cursor(Bytes bytes) : bytes_(bytes) {}

  void skip(std::size_t count)
  {
    ok_ = ok_ && count <= bytes_.size() - at_;
    if (ok_)
      at_ += count;
  }
  std::int64_t int64() { return static_cast<std::int64_t>(be64toh(next<std::uint64_t>())); }
  std::int32_t int32() { return static_cast<std::int32_t>(be32toh(next<std::uint32_t>())); }
  int int8() { return static_cast<std::int8_t>(next<std::uint8_t>()); }
  double real() { return std::bit_cast<double>(int64()); }
  /// A count of array members; more than any message of ours has is as wrong as a negative one
  std::size_t count()
  {
    const std::int32_t value = int32();
    constexpr std::int32_t most = 1 << 16;
    ok_ = ok_ && value >= 0 && value <= most;
    return ok_ ? static_cast<std::size_t>(value) : 0;
  }
  /// A text ends with a zero, and has none inside: LCM's encoders would cut it there.
  void skip_text()
  {
    const std::size_t start = at_;
    const auto length = static_cast<std::uint32_t>(int32());
    ok_ = ok_ && length >= 1 && length <= bytes_.size() - at_;
    if (ok_)
    {
      const Bytes text = bytes_.subspan(at_, length);
      ok_ = std::ranges::find(text, std::byte{0}) == text.end() - 1;
    }
    skip(ok_ ? length : bytes_.size() - start + 1);
  }
  void skip_texts(std::size_t count)
  {
    for (std::size_t i = 0; ok_ && i < count; ++i)
      skip_text();
  }

  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && at_ == bytes_.size(); }

private:
  // the next bytes as they are; 0 if the message ends before
  template <typename Unsigned> Unsigned next()
  {
    const std::size_t start = at_;
    skip(sizeof(Unsigned));
    Unsigned value = 0;
    if (ok_)
      std::memcpy(&value, bytes_.data() + start, sizeof(Unsigned));
    return value;
  }

  Bytes bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

/// Decodes what has been walked to its end; false, and the message unchanged, if it has not.
template <typename Message> bool decode_checked(Bytes bytes, const Cursor& walked, Message& message)
{
  if (!walked.at_end())
    return false;
  Message decoded;
  if (decoded.decode(bytes.data(), 0, static_cast<int>(bytes.size())) != static_cast<int>(bytes.size()))
    return false;
  message = std::move(decoded);
  return true;
}

/// A cursor behind the fingerprint; not ok() if that is another type's.
template <typename Message> Cursor after_fingerprint(Bytes bytes)
{
  Cursor cursor(bytes);
  if (cursor.int64() != Message::getHash())
    cursor.skip(bytes.size() + 1);
  return cursor;
}

} // namespace torqued
