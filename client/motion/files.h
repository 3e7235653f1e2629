/// Files that torquectl reads and writes, of any size.
#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace torqued
{

/// A file's bytes, mapped where that is possible; a file without a size, such as a pipe, is read, and one that gzip has
/// packed is unpacked. A file that is mapped may grow, but whoever shortens it ends this process.
class InputFile
{
public:
  /// Throws Failure, bad_data, if it cannot be read or unpacked.
  explicit InputFile(const std::string& path);

  /// They live as long as this.
  std::string_view bytes() const;

private:
  struct Unmap
  {
    std::size_t size;
    void operator()(void* at) const;
  };
  std::unique_ptr<void, Unmap> mapping_;
  std::string read_;
};

/// Whether bytes begin as gzip's files do.
bool is_gzip(std::string_view bytes);
/// What gzip has packed, unpacked: all members of a file one after another; file: the name used in complaints. Throws
/// Failure, bad_data, if it is cut or damaged.
std::string unpack_gzip(std::string_view bytes, const std::string& file);

/// A copy of a file's bytes. Throws as InputFile does.
std::string read_file(const std::string& path);

/// A file that is written from its beginning; "-" is the standard output. Throws Failure, failed, with the file's name
/// and the reason.
class OutputFile
{
public:
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  /// Hands on what has been written so far.
  void flush();
  /// Makes sure that all has been written; a file that is not closed this way may be incomplete.
  void close();

private:
  [[noreturn]] void fail() const;

  std::string path_;
  std::FILE* file_;
};

/// Refuses to write over what is read: throws Failure, usage, if both are the same file.
void require_other_file(const std::string& input, const std::string& output);

} // namespace torqued
