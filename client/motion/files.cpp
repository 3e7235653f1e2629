#include "motion/files.h"

#include "motion/failure.h"
#include "motion/gzip.h"

#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <system_error>
#include <utility>

namespace torqued
{

InputFile::InputFile(const std::string& path)
{
  std::FILE* file = std::fopen(path.c_str(), "rb");
  bool good = file != nullptr;
  struct stat status = {};
  if (good && fstat(fileno(file), &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0)
  {
    const auto size = static_cast<std::size_t>(status.st_size);
    if (void* at = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fileno(file), 0); at != MAP_FAILED)
      mapped_ = {static_cast<const char*>(at), size};
  }
  while (good && mapped_.empty())
  {
    constexpr std::size_t step = 1 << 20;
    const std::size_t size = read_.size();
    read_.resize(size + step);
    const std::size_t count = std::fread(read_.data() + size, 1, step, file);
    read_.resize(size + count);
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
  if (!is_gzip(bytes()))
    return;
  try
  {
    read_ = unpack_gzip(bytes(), path);
    unmap();
  }
  catch (...)
  {
    unmap();
    throw;
  }
}

InputFile::~InputFile()
{
  unmap();
}

void InputFile::unmap()
{
  if (!mapped_.empty())
    munmap(const_cast<char*>(mapped_.data()), mapped_.size());
  mapped_ = {};
}

std::string read_file(const std::string& path)
{
  return std::string(InputFile(path).bytes());
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
