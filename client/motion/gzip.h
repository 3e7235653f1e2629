/// Files that gzip has packed.
#pragma once

#include <string>
#include <string_view>

namespace torqued
{

/// Whether bytes begin as gzip's files do.
bool is_gzip(std::string_view bytes);

/// The bytes unpacked, of all members one after another. Throws Failure, bad_data, for a file that is cut or damaged;
/// file: the name used in the complaint.
std::string unpack_gzip(std::string_view bytes, const std::string& file);

} // namespace torqued
