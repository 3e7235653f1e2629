#include "client/files.h"

#include "client/failure.h"

#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <system_error>
#include <utility>

namespace torqued
{

std::string read_file(const std::string& path)
{
  std::FILE* file = std::fopen(path.c_str(), "rb");
  bool good = file != nullptr;
  std::string bytes;
  constexpr std::size_t step = 1 << 18;
  // a pipe has no size, and a log that is being recorded grows; for others this spares the copies of a growing text
  std::error_code no_size;
  if (const std::uintmax_t size = std::filesystem::file_size(path, no_size); good && !no_size)
    bytes.reserve(size + step);
  while (good)
  {
    const std::size_t size = bytes.size();
    bytes.resize(size + step);
    const std::size_t count = std::fread(bytes.data() + size, 1, step, file);
    bytes.resize(size + count);
    good = !std::ferror(file);
    if (count < step)
      break;
  }
  const int error = errno;
  if (file)
    std::fclose(file);
  if (!good)
    throw Failure(ExitCode::bad_data,
                  fmt::format("{}: cannot be read: {}", path, std::generic_category().message(error)));
  return bytes;
}

OutputFile::OutputFile(const std::string& path)
    : path_(path == "-" ? "standard output" : path), file_(path == "-" ? stdout : std::fopen(path.c_str(), "wb"))
{
  if (!file_)
    fail();
}

OutputFile::~OutputFile()
{
  if (file_ && file_ != stdout)
    std::fclose(file_);
}

void OutputFile::write(std::string_view text)
{
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size())
    fail();
}

void OutputFile::flush()
{
  if (std::fflush(file_) != 0)
    fail();
}

void OutputFile::close()
{
  flush();
  if (file_ != stdout && std::fclose(std::exchange(file_, nullptr)) != 0)
    fail();
}

void OutputFile::fail() const
{
  throw Failure(ExitCode::failed,
                fmt::format("{}: cannot be written: {}", path_, std::generic_category().message(errno)));
}

void require_other_file(const std::string& input, const std::string& output)
{
  std::error_code neither_exists;
  if (std::filesystem::equivalent(input, output, neither_exists))
    throw Failure(ExitCode::usage, fmt::format("{} would be written over {}, which is read", output, input));
}

} // namespace torqued
