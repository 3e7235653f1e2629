#include "client/lcm_log.h"

#include "wire/cursor.h"

#include <algorithm>
#include <endian.h>
#include <span>

namespace torqued
{

namespace
{

// a record: sync word, event number (8 bytes), timestamp (8), channel's length (4), data's length (4), channel, data
constexpr std::string_view kSyncWord = "\xed\xa1\xda\x01";
constexpr std::size_t kHeader = 28;

template <typename Number> void append(std::string& bytes, Number in_network_order)
{
  bytes.append(reinterpret_cast<const char*>(&in_network_order), sizeof(Number));
}

} // namespace

bool LogReader::is_log(std::string_view bytes)
{
  return bytes.starts_with(kSyncWord);
}

std::optional<LogRecord> LogReader::next()
{
  while (at_ < bytes_.size())
  {
    const std::string_view rest = bytes_.substr(at_);
    if (rest.starts_with(kSyncWord) && rest.size() >= kHeader)
    {
      Cursor header(std::as_bytes(std::span(rest)).subspan(kSyncWord.size(), kHeader - kSyncWord.size()));
      const std::int64_t number = header.int64();
      const std::int64_t timestamp = header.int64();
      const auto channel_size = std::size_t{static_cast<std::uint32_t>(header.int32())};
      const auto data_size = std::size_t{static_cast<std::uint32_t>(header.int32())};
      if (channel_size + data_size <= rest.size() - kHeader)
      {
        at_ += kHeader + channel_size + data_size;
        return LogRecord{number, timestamp, rest.substr(kHeader, channel_size),
                         std::as_bytes(std::span(rest)).subspan(kHeader + channel_size, data_size)};
      }
    }

    // not a whole record: go on at the next sync word
    const std::size_t next = std::min(bytes_.find(kSyncWord, at_ + 1), bytes_.size());
    skipped_ += next - at_;
    at_ = next;
  }
  return {};
}

void LogWriter::write(std::string_view channel, std::int64_t timestamp, Bytes data)
{
  pending_ += kSyncWord;
  append(pending_, htobe64(static_cast<std::uint64_t>(number_++)));
  append(pending_, htobe64(static_cast<std::uint64_t>(timestamp)));
  append(pending_, htobe32(static_cast<std::uint32_t>(channel.size())));
  append(pending_, htobe32(static_cast<std::uint32_t>(data.size())));
  pending_ += channel;
  pending_.append(reinterpret_cast<const char*>(data.data()), data.size());
  constexpr std::size_t many = 1 << 18; // more would leave the processor's cache
  if (pending_.size() < many)
    return;
  file_.write(pending_);
  pending_.clear();
}

void LogWriter::close()
{
  file_.write(pending_);
  file_.close();
}

} // namespace torqued
