/// Files that are no tables and no logs, by their names.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace torqued
{

/// "a ZIP archive, as .xlsx, .ods and .npz files are": what bytes are that begin as a known kind of file does, which is
/// neither a table nor an LCM log; nothing for all others.
std::optional<std::string> foreign_file(std::string_view bytes);

} // namespace torqued
