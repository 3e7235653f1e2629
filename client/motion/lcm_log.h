/// Recorded LCM traffic, as lcm-logger writes it.
#pragma once

#include "motion/files.h"
#include "wire/messages.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace torqued
{

/// One recorded message. The views live as long as the bytes that are read.
struct LogRecord
{
  std::int64_t number;    ///< as the logger counted, from 0
  std::int64_t timestamp; ///< µs
  std::string_view channel;
  Bytes data;
};

/// Reads the records of a log one after another.
///
/// liblcm's own reader ends at the first damaged record and trusts lengths; this one looks for the next whole record
/// and counts what it passed over. A logger that was killed leaves a cut record at the end.
class LogReader
{
public:
  /// Whether bytes begin as a log does, or hold a whole record of one that was cut at its front; whatever the file is
  /// called.
  static bool is_log(std::string_view bytes);

  /// The bytes must outlive the reader.
  explicit LogReader(std::string_view bytes);

  /// The next whole record; nothing at the end.
  std::optional<LogRecord> next();
  /// Bytes so far that belong to no whole record; those before the first record from the beginning.
  std::size_t skipped() const { return skipped_; }
  /// Bytes before the first record of a log that begins in the middle of one.
  std::size_t cut() const { return cut_; }

private:
  std::string_view bytes_;
  std::size_t cut_, at_ = cut_, skipped_ = cut_;
};

/// Writes a log. Throws Failure, failed, with the file's name and the reason.
///
/// liblcm's own writer makes seven calls and an allocation of each record.
class LogWriter
{
public:
  explicit LogWriter(const std::string& path) : file_(path) {}

  /// timestamp: µs
  void write(std::string_view channel, std::int64_t timestamp, Bytes data);
  /// Makes sure that all has been written; a log that is not closed this way may be incomplete.
  void close();

private:
  OutputFile file_;
  std::string pending_; // whole records that the file does not have yet
  std::int64_t number_ = 0;
};

} // namespace torqued
