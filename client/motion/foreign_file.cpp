#include "motion/foreign_file.h"

#include "motion/table_text.h"
#include "text/plain_text.h"

#include <algorithm>
#include <cctype>

namespace torqued
{

namespace
{

using namespace std::string_view_literals;

constexpr std::string_view kBlank = " \t\r\n";

struct Signature
{
  std::string_view begin;
  const char* name;
};

constexpr Signature kSignatures[] = {
    {"\x02\x50"sv, "a C3D file of markers and force plates"},
    {"\x89HDF\r\n\x1a\n"sv, "an HDF5 file, as MATLAB's .mat of version 7.3 is"},
    {"MATLAB 5.0 MAT-file"sv, "a MATLAB .mat file"},
    {"MATLAB 7.3 MAT-file"sv, "a MATLAB .mat file"},
    {"\x93NUMPY"sv, "a NumPy array (.npy)"},
    {"\xd0\xcf\x11\xe0"sv, "an old Excel file (.xls) or another document of Microsoft Office"},
    {"%PDF"sv, "a PDF document"},
    {"\x89PNG"sv, "an image (.png)"},
    {"\xff\xd8\xff"sv, "an image (.jpg)"},
    {"\xfd\x37zXZ"sv, "packed by xz (packed by gzip it would be read)"},
    {"BZh"sv, "packed by bzip2 (packed by gzip it would be read)"},
    {"\x28\xb5\x2f\xfd"sv, "packed by zstd (packed by gzip it would be read)"},
    {"7z\xbc\xaf\x27\x1c"sv, "a 7-Zip archive"},
    {"Rar!\x1a\x07"sv, "a RAR archive"},
    {"PAR1"sv, "a Parquet file"},
    {"ARROW1"sv, "an Arrow (Feather) file"},
    {"SQLite format 3"sv, "an SQLite database, as a ROS 2 bag is"},
    {"#ROSBAG"sv, "a ROS bag"},
    {"\x89MCAP"sv, "an MCAP file"},
    {"\x7f"
     "ELF"sv,
     "a program"},
    {"\xff\xfe\x00\x00"sv, "UTF-32 text (UTF-8 and UTF-16 are read)"},
    {"\x00\x00\xfe\xff"sv, "UTF-32 text (UTF-8 and UTF-16 are read)"},
    {"{\\rtf"sv, "a document (.rtf)"},
    {"PathFileType"sv, "an OpenSim .trc marker file: it has the places of markers, not a robot's coordinates"},
    {"[Force Data]"sv, "a .forces file of force plates: it has no robot's coordinates"},
    {"NO_OF_FRAMES"sv, "a Qualisys .tsv file: it has the places of markers, not a robot's coordinates"},
    {"Format Version,"sv,
     "an OptiTrack Motive export: it has the places of markers and bones, not a robot's coordinates"},
    {"HIERARCHY"sv, "a .bvh motion of a skeleton"},
};

std::string name_of_archive(std::string_view head)
{
  const auto holds = [head](std::string_view part)
  {
    return head.find(part) != std::string_view::npos;
  };
  if (holds("opendocument.spreadsheet"))
    return "an OpenDocument spreadsheet (.ods), which can be saved as CSV";
  if (holds("[Content_Types].xml") || holds("xl/") || holds("_rels/"))
    return "an Excel file (.xlsx), which can be saved as CSV";
  if (holds(".npy"))
    return "NumPy arrays (.npz)";
  return "a ZIP archive, as .xlsx, .ods and .npz files are";
}

std::string name_of_markup(const std::string& head)
{
  const auto holds = [&head](const char* part)
  {
    return head.find(part) != std::string::npos;
  };
  if (holds("<!doctype html") || holds("<html"))
    return "an HTML page";
  if (holds("<robot"))
    return "a robot file (URDF), which --robot takes";
  if (holds("<mujoco"))
    return "a MuJoCo model (MJCF)";
  if (holds("<sdf"))
    return "an SDF model";
  if (holds("<opensimdocument"))
    return "an OpenSim document (model or set-up)";
  return "an XML file";
}

// the text of a robot or a configuration: its first line that says anything is a table's head, or a key with a value
bool is_toml(std::string_view head)
{
  LineCutter lines(head);
  std::string_view line;
  while (lines.next(line))
  {
    line = trimmed(line, kBlank);
    if (line.empty() || line.front() == '#')
      continue;
    std::string_view key = trimmed(line.substr(0, line.find('=')), kBlank);
    if (line.front() == '[')
      key = trimmed(line, "[]");
    return key.size() < line.size() && !key.empty() && lower_case(key) != "sep" &&
           std::ranges::all_of(key,
                               [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-' || c == '.'; });
  }
  return false;
}

} // namespace

std::optional<std::string> foreign_file(std::string_view bytes)
{
  constexpr std::size_t enough = 4096;
  std::string_view head = bytes.substr(0, enough);
  if (head.starts_with("PK\x03\x04"))
    return name_of_archive(head);
  for (const Signature& signature : kSignatures)
    if (head.starts_with(signature.begin))
      return signature.name;
  if (head.size() > 1 && head[1] == '\x50' && head[0] < ' ' && head[0] > 0 && bytes.size() >= 512)
    return kSignatures[0].name; // the parameters begin at another block

  if (head.starts_with("\xef\xbb\xbf"))
    head.remove_prefix(3);
  head = trimmed(head, kBlank);
  if (head.empty())
    return std::nullopt;
  for (const Signature& signature : kSignatures)
    if (head.starts_with(signature.begin))
      return signature.name;
  if (head.front() == '<')
    return name_of_markup(lower_case(head));
  if (head.front() == '{')
    return "a JSON file";
  if (const std::string_view inside = trimmed(head, "[ \t\r\n");
      head.front() == '[' && !inside.empty() &&
      std::string_view("{\"-0123456789").find(inside.front()) != std::string_view::npos)
    return "a JSON file";
  if (is_toml(head))
    return "a TOML file, such as a robot (--robot) or a configuration (--config)";
  return std::nullopt;
}

} // namespace torqued
