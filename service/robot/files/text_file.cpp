#include "robot/files/text_file.h"

#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <system_error>

namespace torqued
{

namespace
{

constexpr std::size_t kLargestFile = 1'000'000;

} // namespace

std::string read_text_file(const std::string& path)
{
  std::error_code error;
  if (const auto status = std::filesystem::status(path, error);
      std::filesystem::exists(status) && !is_regular_file(status))
    throw FileError(fmt::format("{}: is not a file", path));
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file)
  {
    text.resize(kLargestFile + 1);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad() || !file.is_open() || (text.empty() && !file.eof()))
    throw FileError(fmt::format("{}: cannot be read: {}", path, std::generic_category().message(errno)));
  if (text.size() > kLargestFile)
    throw FileError(
        fmt::format("{}: is larger than {} bytes; no robot or configuration needs that", path, kLargestFile));
  return text;
}

} // namespace torqued
