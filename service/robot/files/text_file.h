/// Files as text, and what is wrong with them.
#pragma once

#include <stdexcept>
#include <string>

namespace torqued
{

/// A file, or a value in it, that cannot be used. what() is one line:
/// "FILE:LINE: KEY: what was found; what would be right".
class FileError : public std::runtime_error
{
public:
  using std::runtime_error::runtime_error;
};

/// A file's text. Throws FileError if it cannot be read or is larger than any file we take (1 MB).
std::string read_text_file(const std::string& path);

} // namespace torqued
