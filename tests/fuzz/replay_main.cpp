// Runs a fuzz target on every file of a folder.

#include "robot/files/strict_toml.h"

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fmt/format.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int main(int argc, char** argv)
try
{
  if (argc != 2)
  {
    fmt::print(stderr, "usage: {} FOLDER\n", argv[0]);
    return 64;
  }
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1]))
  {
    fmt::print("{}\n", entry.path().string());
    std::fflush(stdout); // so that the last name is that of the file that ends the process
    const std::string text = torqued::read_text_file(entry.path().string());
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    ++files;
  }
  return files > 0 ? 0 : 1;
}
catch (const std::exception& error)
{
  fmt::print(stderr, "{}\n", error.what());
  return 1;
}
