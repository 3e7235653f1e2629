#include "client/lcm_log.h"

#include "client/failure.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fmt/format.h>
#include <span>
#include <system_error>

namespace torqued
{

namespace
{

// a record: sync word, event number (8 bytes), timestamp (8), channel's length (4), data's length (4), channel, data
constexpr std::string_view kSyncWord = "\xed\xa1\xda\x01";
constexpr std::size_t kHeader = 28;

} // namespace

bool LogReader::is_log(std::string_view bytes)
{
  return bytes.starts_with(kSyncWord);
}

std::uint64_t LogReader::number_at(std::size_t offset, std::size_t width) const
{
  std::uint64_t number = 0;
  for (const char byte : bytes_.substr(at_ + offset, width))
    number = number << 8 | static_cast<unsigned char>(byte);
  return number;
}

std::optional<LogRecord> LogReader::next()
{
  while (at_ < bytes_.size())
  {
    const std::string_view rest = bytes_.substr(at_);
    if (rest.starts_with(kSyncWord) && rest.size() >= kHeader)
    {
      const std::uint64_t channel_size = number_at(20, 4);
      const std::uint64_t data_size = number_at(24, 4);
      if (channel_size + data_size <= rest.size() - kHeader)
      {
        const std::string_view data = rest.substr(kHeader + channel_size, data_size);
        const LogRecord record{static_cast<std::int64_t>(number_at(4, 8)), static_cast<std::int64_t>(number_at(12, 8)),
                               rest.substr(kHeader, channel_size), std::as_bytes(std::span(data))};
        at_ += kHeader + channel_size + data_size;
        return record;
      }
    }

    // not a whole record: go on at the next sync word
    const std::size_t next = std::min(bytes_.find(kSyncWord, at_ + 1), bytes_.size());
    skipped_ += next - at_;
    at_ = next;
  }
  return {};
}

LogWriter::LogWriter(const std::string& path) : path_(path), log_(path, "w")
{
  if (!log_.good())
    fail();
}

void LogWriter::write(const std::string& channel, std::int64_t timestamp, Bytes data)
{
  // LCM's record wants writable data, and only reads it
  lcm::LogEvent event{0, timestamp, channel, static_cast<std::int32_t>(data.size()),
                      const_cast<std::byte*>(data.data())};
  if (log_.writeEvent(&event) != 0)
    fail();
}

void LogWriter::close()
{
  if (std::fflush(log_.getFilePtr()) != 0)
    fail();
}

void LogWriter::fail() const
{
  throw Failure(ExitCode::failed,
                fmt::format("{}: cannot be written: {}", path_, std::generic_category().message(errno)));
}

} // namespace torqued
