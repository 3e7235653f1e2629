#include "motion/lcm_log.h"

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

// the record that bytes begin with, if it is whole
std::optional<LogRecord> whole_record(std::string_view bytes)
{
  if (!bytes.starts_with(kSyncWord) || bytes.size() < kHeader)
    return {};
  Cursor header(std::as_bytes(std::span(bytes)).subspan(kSyncWord.size(), kHeader - kSyncWord.size()));
  const std::int64_t number = header.int64();
  const std::int64_t timestamp = header.int64();
  const auto channel_size = std::size_t{static_cast<std::uint32_t>(header.int32())};
  const auto data_size = std::size_t{static_cast<std::uint32_t>(header.int32())};
  if (channel_size + data_size > bytes.size() - kHeader)
    return {};
  return LogRecord{number, timestamp, bytes.substr(kHeader, channel_size),
                   std::as_bytes(std::span(bytes)).subspan(kHeader + channel_size, data_size)};
}

// where a log begins; of one that was cut at its front, at its first whole record with a channel that LCM can have
std::optional<std::size_t> first_record(std::string_view bytes)
{
  if (bytes.starts_with(kSyncWord))
    return 0;
  constexpr std::size_t longest_channel = 63;
  for (std::size_t at = 0; (at = bytes.find(kSyncWord, at)) != std::string_view::npos; ++at)
    if (const auto record = whole_record(bytes.substr(at));
        record && !record->channel.empty() && record->channel.size() <= longest_channel &&
        std::ranges::all_of(record->channel, [](char c) { return c > ' ' && c <= '~'; }))
      return at;
  return {};
}

} // namespace

bool LogReader::is_log(std::string_view bytes)
{
  return first_record(bytes).has_value();
}

LogReader::LogReader(std::string_view bytes) : bytes_(bytes), cut_(first_record(bytes).value_or(0)) {}

std::optional<LogRecord> LogReader::next()
{
  while (at_ < bytes_.size())
  {
    const std::string_view rest = bytes_.substr(at_);
    if (const auto record = whole_record(rest))
    {
      at_ += kHeader + record->channel.size() + record->data.size();
      return record;
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
