#include "motion/files.h"

#include "motion/failure.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <new>
#include <sys/mman.h>
#include <sys/stat.h>
#include <system_error>
#include <utility>

#define ZLIB_CONST // zlib reads bytes that are constant
#include <zlib.h>

namespace torqued
{

bool is_gzip(std::string_view bytes)
{
  return bytes.starts_with("\x1f\x8b\x08");
}

std::string unpack_gzip(std::string_view bytes, const std::string& file)
{
  z_stream stream = {};
  constexpr int gzip_only = 16 + MAX_WBITS;
  if (inflateInit2(&stream, gzip_only) != Z_OK)
    throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);
  const auto fail = [&](std::string_view what, std::size_t unpacked)
  {
    throw Failure(ExitCode::bad_data, "{}: {}, after {} bytes unpacked; expected a whole gzip file", file, what,
                  unpacked);
  };

  std::string unpacked;
  std::string piece(1 << 18, '\0');
  while (is_gzip(bytes))
  {
    inflateReset(&stream);
    for (int state = Z_OK; state != Z_STREAM_END;)
    {
      const std::size_t most = std::numeric_limits<uInt>::max();
      stream.next_in = reinterpret_cast<const Bytef*>(bytes.data());
      stream.avail_in = static_cast<uInt>(std::min(bytes.size(), most));
      const std::size_t given = stream.avail_in;
      stream.next_out = reinterpret_cast<Bytef*>(piece.data());
      stream.avail_out = static_cast<uInt>(piece.size());
      state = inflate(&stream, Z_NO_FLUSH);
      bytes.remove_prefix(given - stream.avail_in);
      unpacked.append(piece, 0, piece.size() - stream.avail_out);
      if (state == Z_BUF_ERROR || (state == Z_OK && bytes.empty() && stream.avail_out > 0))
        fail("the gzip data are cut", unpacked.size());
      if (state == Z_MEM_ERROR)
        throw std::bad_alloc();
      if (state != Z_OK && state != Z_STREAM_END)
        fail(fmt::format("the gzip data are damaged ({})", stream.msg ? stream.msg : "no reason given"),
             unpacked.size());
    }
  }
  if (bytes.find_first_not_of('\0') != std::string_view::npos) // zeros may fill a block of a tape
    fail(fmt::format("{} bytes follow the gzip data", bytes.size()), unpacked.size());
  return unpacked;
}

InputFile::InputFile(const std::string& path)
{
  std::FILE* file = std::fopen(path.c_str(), "rb");
  bool good = file != nullptr;
  struct stat status = {};
  if (good && fstat(fileno(file), &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0)
  {
    const auto size = static_cast<std::size_t>(status.st_size);
    if (void* at = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fileno(file), 0); at != MAP_FAILED)
      mapping_ = std::unique_ptr<void, Unmap>(at, Unmap{size});
  }
  while (good && !mapping_)
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
    throw Failure(ExitCode::bad_data, "{}: cannot be read: {}", path, std::generic_category().message(error));
  if (!is_gzip(bytes()))
    return;
  read_ = unpack_gzip(bytes(), path);
  mapping_.reset();
}

void InputFile::Unmap::operator()(void* at) const
{
  munmap(at, size);
}

std::string_view InputFile::bytes() const
{
  return mapping_ ? std::string_view(static_cast<const char*>(mapping_.get()), mapping_.get_deleter().size) : read_;
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
  throw Failure(ExitCode::failed, "{}: cannot be written: {}", path_, std::generic_category().message(errno));
}

void require_other_file(const std::string& input, const std::string& output)
{
  std::error_code neither_exists;
  if (std::filesystem::equivalent(input, output, neither_exists))
    throw Failure(ExitCode::usage, "{} would be written over {}, which is read", output, input);
}

} // namespace torqued
