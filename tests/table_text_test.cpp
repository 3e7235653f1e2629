#include "catch.h"

#include "motion/column_names.h"
#include "motion/failure.h"
#include "motion/files.h"
#include "temporary_folder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>
#include <zlib.h>

namespace table_text_test
{

using namespace torqued;
using namespace std::string_literals;

namespace
{

using Cells = std::vector<std::string>;

struct Table
{
  std::vector<Cells> lines;
  std::vector<std::string> assumptions;
};

Table read(const std::string& bytes)
{
  CsvReader reader(bytes, "t.csv");
  Table table;
  for (CsvLine line; reader.next(line);)
    table.lines.push_back(line.cells);
  table.assumptions = reader.assumptions();
  return table;
}

// names, then numbers of all forms and words
const std::vector<Cells> kLines{{"time", "q0", "dq0", "contactL"},
                                {"0", "0.5", "-1.25e-3", "sole"},
                                {"0.01", "+.5", "2", "none"},
                                {"0.02", "-3.", "1E+2", "2"}};

std::string text_of(const std::vector<Cells>& lines, const std::string& separator, char decimal_sign = '.',
                    const std::string& line_end = "\n")
{
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i)
  {
    std::string line = fmt::format("{}", fmt::join(lines[i], separator));
    if (i > 0)
      std::replace(line.begin(), line.end(), '.', decimal_sign);
    text += line + line_end;
  }
  return text;
}

std::string utf16(std::string_view ascii, bool big_endian)
{
  std::string bytes;
  for (const char c : ascii)
    bytes += big_endian ? std::string{'\0', c} : std::string{c, '\0'};
  return bytes;
}

std::string packed(const std::string& bytes)
{
  z_stream stream = {};
  REQUIRE(deflateInit2(&stream, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string out(deflateBound(&stream, bytes.size()) + 100, '\0');
  std::string in = bytes;
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  REQUIRE(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

template <typename Act> std::string complaint(const Act& act)
{
  try
  {
    act();
    return "";
  }
  catch (const Failure& failure)
  {
    CHECK(failure.code() == ExitCode::bad_data);
    return failure.what();
  }
}

std::string refusal(const std::string& bytes)
{
  return complaint([&bytes] { read(bytes); });
}

const std::vector<KnownColumn> kKnown{
    {"time", Quantity::time},    {"utime", Quantity::time_stamp}, {"q0", Quantity::angle},
    {"dq0", Quantity::angle, 1}, {"ddq0", Quantity::angle, 2},    {"x", Quantity::length},
    {"dx", Quantity::length, 1}, {"phase", Quantity::share},      {"contactL", Quantity::word},
    {"FxL", Quantity::force},    {"ML", Quantity::moment}};

ColumnNames names_of(const std::string& bytes, std::size_t* rows = nullptr)
{
  CsvReader reader(bytes, "t.csv");
  ColumnNames names = read_column_names(reader, "t.csv", kKnown);
  std::size_t count = 0;
  for (CsvLine line; reader.next(line);)
    ++count;
  if (rows != nullptr)
    *rows = count;
  return names;
}

std::string name_refusal(const std::string& bytes)
{
  return complaint([&bytes] { names_of(bytes); });
}

} // namespace

TEST_CASE("a table is the same with every separator, decimal sign, line end and encoding", "[table_text]")
{
  std::vector<Cells> expected = kLines;
  for (const auto& [separator, name] : std::vector<std::pair<std::string, std::string>>{{",", ""},
                                                                                        {", ", ""},
                                                                                        {";", "semicolons"},
                                                                                        {" ; ", "semicolons"},
                                                                                        {"\t", "tabs"},
                                                                                        {"|", "bars"},
                                                                                        {" ", "spaces"},
                                                                                        {"   ", "spaces"},
                                                                                        {" \t ", "tabs"}})
    for (const char decimal_sign : {'.', ','})
      for (const std::string& line_end : {"\n"s, "\r\n"s, "\r"s, "\n\n"s, "  \n"s})
        for (int encoding = 0; encoding < 6; ++encoding)
        {
          if (name.empty() && decimal_sign == ',')
            continue; // ambiguous
          CAPTURE(separator, decimal_sign, line_end, encoding);
          const std::string text = text_of(kLines, separator, decimal_sign, line_end);
          const bool big_endian = encoding % 2 == 1;
          const std::string bytes = encoding == 0   ? text
                                    : encoding == 1 ? "\xef\xbb\xbf" + text
                                    : encoding < 4  ? utf16(text, big_endian)
                                    : big_endian    ? "\xfe\xff" + utf16(text, true)
                                                    : "\xff\xfe" + utf16(text, false);
          const Table table = read(bytes);
          REQUIRE(table.lines == expected);
          std::vector<std::string> said;
          if (encoding > 1)
            said.push_back(fmt::format("is UTF-16 text ({}-endian)", big_endian ? "big" : "little"));
          if (!name.empty())
            said.push_back(
                fmt::format("cells are separated by {}{}", name, decimal_sign == ',' ? ", decimals by commas" : ""));
          CHECK(table.assumptions == said);
        }
}

TEST_CASE("UTF-16 gives all characters, also those of two units", "[table_text]")
{
  // z, ß, €, and the musical clef U+1D11E
  const std::string units{"\xff\xfez\0\xdf\0\xac\x20\x34\xd8\x1e\xdd\n\0", 14};
  CHECK(read(units).lines == std::vector<Cells>{{"z\xc3\x9f\xe2\x82\xac\xf0\x9d\x84\x9e"}});
  const std::string cut = "t.csv: is UTF-16 text that is cut or damaged; expected whole characters";
  CHECK(refusal(units + "x") == cut);
  CHECK(refusal(std::string{"\xff\xfez\0\x34\xd8z\0", 8}) == cut); // half of a character
}

TEST_CASE("lines end at line feeds, carriage returns or both, and are counted as editors do", "[table_text]")
{
  LineCutter lines("a\r\nb\rc\n\n\r\rd");
  std::string found;
  for (std::string_view line; lines.next(line);)
    found += fmt::format("{}{} ", lines.number(), line);
  CHECK(found == "1a 2b 3c 4 5 6 7d ");
}

TEST_CASE("lines that say nothing are passed over, and % and // above the names", "[table_text]")
{
  CHECK(read("\n ;; ;\n#;\n" + text_of(kLines, ";") + ";;;\n  \n # x\n").lines == kLines);
  const Table table = read("% a walk\n  // of 2 m\n" + text_of(kLines, ","));
  CHECK(table.lines == kLines);
  CHECK(table.assumptions ==
        Cells{"2 lines above the names of the columns begin with % or //; passed over as comments"});
  CHECK(read(text_of(kLines, ",") + "% x\n").lines.size() == kLines.size() + 1);
}

TEST_CASE("a spreadsheet's first line says the separator", "[table_text]")
{
  CHECK(read("sep=;\r\n" + text_of(kLines, ";", ',')).lines == kLines);
  CHECK(read("SEP=,\n" + text_of(kLines, ",")).assumptions.empty());
  CHECK(refusal("sep=x\n") == "t.csv:1: found \"sep=x\"; expected sep= and a comma, a semicolon, a tab or a bar");
}

TEST_CASE("words and quoted cells keep their commas", "[table_text]")
{
  CHECK(read("time;note\n0,5;a, b\n1;\"2;5,5\"\n").lines ==
        std::vector<Cells>{{"time", "note"}, {"0.5", "a, b"}, {"1", "2;5,5"}});
  CHECK(read("time  note\n 0.5   \"a  b\" \n").lines == std::vector<Cells>{{"time", "note"}, {"0.5", "a  b"}});
  CHECK(read("time,q0 (rad; to x)\n1,2\n").assumptions.empty());
}

TEST_CASE("decimal commas in quotes are read, as spreadsheets write them between commas", "[table_text]")
{
  const Table table = read("time,q0,word\n\"0,5\",\"-1,25e-3\",a\n1,\"2,0\",\"b, c\"\n");
  REQUIRE(table.lines.size() == 3);
  CHECK(table.lines[1] == Cells{"0.5", "-1.25e-3", "a"});
  CHECK(table.lines[2] == Cells{"1", "2.0", "b, c"});
  CHECK(table.assumptions == Cells{"decimals are written by commas, in quotes"});
  // beside a point it would be a thousand
  CHECK_THROWS_AS(read("time,q0\n\"1,000\",0.5\n"), Failure);
}

TEST_CASE("mixed separators and mixed decimal signs are refused with their lines", "[table_text]")
{
  CHECK(refusal("time,q0;time\n") ==
        "t.csv:1: found cells between commas and cells between semicolons; expected one separator throughout");
  CHECK(refusal("\ntime;q0\n1;2\n0,5;1\n\n2;0.25\n") ==
        "t.csv:6: found decimal commas (\"0,5\" in line 4) and decimal points (\"0.25\" in line 6); expected one of "
        "the two throughout");
}

TEST_CASE("other kinds of files are named", "[table_text]")
{
  const auto refused_as = [](const std::string& bytes)
  {
    const std::string said = refusal(bytes);
    const std::string begin = "t.csv: is ", end = "; expected a table (CSV) or an LCM log";
    CAPTURE(said);
    REQUIRE((said.starts_with(begin) && said.ends_with(end)));
    return said.substr(begin.size(), said.size() - begin.size() - end.size());
  };
  const std::string zeros(600, '\0');
  CHECK(refused_as("PK\x03\x04....[Content_Types].xml") == "an Excel file (.xlsx), which can be saved as CSV");
  CHECK(refused_as("PK\x03\x04....") == "a ZIP archive, as .xlsx, .ods and .npz files are");
  CHECK(refused_as("\x02\x50" + zeros) == "a C3D file of markers and force plates");
  CHECK(refused_as("PathFileType\t4\t(X/Y/Z)\tw.trc\n") ==
        "an OpenSim .trc marker file: it has the places of markers, not a robot's coordinates");
  CHECK(refused_as("\n <!DOCTYPE html>\n") == "an HTML page");
  CHECK(refused_as("<?xml version=\"1.0\"?>\n<robot name=\"r\">") == "a robot file (URDF), which --robot takes");
  CHECK(refused_as("\xef\xbb\xbf{\"time\": [0]}") == "a JSON file");
  CHECK(refused_as("[ [0, 1]]") == "a JSON file");
  for (const char* const toml : {"# a robot\nname = \"r\"\n", "[[links]]\n", "[daemon.x]\n"})
    CHECK(refused_as(toml) == "a TOML file, such as a robot (--robot) or a configuration (--config)");
  CHECK(refused_as("\x93NUMPY\x01") == "a NumPy array (.npy)");
  CHECK(refused_as("\xff\xfe\0\0t\0\0\0"s) == "UTF-32 text (UTF-8 and UTF-16 are read)");
  CHECK(refused_as("\x01\x02\x03\x04\x05") == "binary, of no kind that is known here");
  CHECK(refused_as(std::string("t\0i", 3)) == "binary, of no kind that is known here");
  CHECK(refusal("time,q0\n1,2\n" + zeros) ==
        "t.csv:3: found a byte of zero; expected text, which has none: the file is cut or damaged");
}

TEST_CASE("a file that gzip has packed is unpacked, whatever its name", "[table_text]")
{
  const TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 200'000; ++i) // more than any buffer
    text += fmt::format("{},{}\n", i, std::sin(i));
  const std::string bytes = packed(text);
  CHECK((read_file(folder.write("a", bytes)) == text));
  CHECK((read_file(folder.write("b", bytes + packed("more") + std::string(512, '\0'))) == text + "more"));
  CHECK(read_file(folder.write("c", packed(""))).empty());
  for (const std::size_t size : {std::size_t{3}, std::size_t{20}, bytes.size() / 2, bytes.size() - 1})
    CHECK(complaint([&] { unpack_gzip(bytes.substr(0, size), "t.gz"); }).starts_with("t.gz: the gzip data are cut, "));
  std::string damaged = bytes;
  damaged[bytes.size() / 2] = static_cast<char>(damaged[bytes.size() / 2] ^ 0x55);
  CHECK(complaint([&] { unpack_gzip(damaged, "t.gz"); }).starts_with("t.gz: the gzip data are damaged ("));
  CHECK(complaint([&] { unpack_gzip(packed("a,b\n") + "xyz", "t.gz"); }) ==
        "t.gz: 3 bytes follow the gzip data, after 4 bytes unpacked; expected a whole gzip file");
}

TEST_CASE("names are known in any case, unless that is ambiguous", "[table_text]")
{
  const ColumnNames names = names_of("TIME,Q0,Dq0,Other\n");
  CHECK(names.names == Cells{"time", "q0", "dq0", "Other"});
  CHECK(names.assumptions == Cells{"names in another case are read: TIME as time, Q0 as q0, Dq0 as dq0"});
  // the right name comes first, and the other is a further column
  for (const std::string text : {"Q0,q0\n", "q0 (deg),q0\n"})
  {
    CHECK(names_of(text).places.at("q0") == 1);
    CHECK(names_of(text).assumptions.empty());
    CHECK(names_of(text).factors == std::vector{1.0, 1.0});
  }
  CHECK(name_refusal("time,q0,q0 \n") == "t.csv:1: column q0: found it twice; expected it once");
  CHECK(name_refusal("Time,TIME\n") == "t.csv:1: column time: found it twice; expected it once");
  CHECK(name_refusal("time,q0 (rad),q0 (deg)\n") == "t.csv:1: column q0: found it twice; expected it once");
}

TEST_CASE("units beside the names or below them are honoured", "[table_text]")
{
  const double degree = std::numbers::pi / 180.0;
  const std::vector<double> factors{1e-3, degree, degree, 1.0, 1e-3, 0.01, 0.01, 1.0, 1e3, 1.0};
  for (const std::string text :
       {"time [ms],q0 (deg),dq0 [deg/s],ddq0 (rad/s^2),x (mm),dx (cm/s),phase (%),contactL (0-3),FxL (kN),ML (N m)\n",
        "time(ms),q0 (\xc2\xb0),dq0(\xc2\xb0/s),ddq0 (rad s\xe2\x81\xbb\xc2\xb2),x [mm],dx [cm "
        "s^-1],phase[%],contactL, "
        "FxL [kN], ML [N*m]\n",
        "time,q0,dq0,ddq0,x,dx,phase,contactL,FxL,ML\nms,deg,deg/s,rad/s/s,mm,cm/s,%,,kN,Nm\n",
        "time,q0,dq0,ddq0,x,dx,phase,contactL,FxL,ML\n(ms),[deg],(deg/sec),,(mm),(cm/s),(%),(-),(kN),(N\xc2\xb7m)\n"})
  {
    CAPTURE(text);
    std::size_t rows = 0;
    const ColumnNames names = names_of(text + "0,1,2,3,4,5,6,7,8,9\n", &rows);
    CHECK(rows == 1);
    REQUIRE(names.factors.size() == factors.size());
    for (std::size_t i = 0; i < factors.size(); ++i)
      CHECK_THAT(names.factors[i], Catch::Matchers::WithinRel(factors[i], 1e-15));
    REQUIRE(!names.assumptions.empty());
    CHECK(names.assumptions.back() ==
          fmt::format("units are converted: time from ms, q0 from {0}, dq0 from {0}{1}, x from mm, dx from {2}, phase "
                      "from %, FxL from kN",
                      text.find("\xc2\xb0") != std::string::npos ? "\xc2\xb0" : "deg",
                      text.find("deg/sec") != std::string::npos ? "/sec" : "/s",
                      text.find("s^-1") != std::string::npos ? "cm s^-1" : "cm/s"));
  }
  CHECK(names_of("time (s),q0 (rad),utime (us)\n").assumptions.empty());
  CHECK(names_of("time,q0\ns,rad\n0,1\n").assumptions == Cells{"line 2 is a row of units"});
}

TEST_CASE("a unit that is none of its column's is refused", "[table_text]")
{
  CHECK(name_refusal("time,q0 (m)\n") ==
        "t.csv:1: column q0: found unit m; expected rad or deg, with /s or /s^2 for its derivatives");
  CHECK(name_refusal("time,dq0 (deg)\n").starts_with("t.csv:1: column dq0: found unit deg; "));
  CHECK(name_refusal("time,q0\ns,kg\n").starts_with("t.csv:2: column q0: found unit kg; "));
  CHECK(name_refusal("utime (ns),q0\n") ==
        "t.csv:1: column utime: found unit ns; expected us, or a column time in another unit");
  CHECK(name_refusal("time,q0 (deg)\ns,rad\n") ==
        "t.csv:2: column q0: found unit rad; expected deg, as beside its name");
  // a row of words is no row of units
  std::size_t rows = 0;
  names_of("time,q0\nx,y\n", &rows);
  CHECK(rows == 1);
}

TEST_CASE("names may stand in the comment above the numbers, and nowhere is said", "[table_text]")
{
  for (const std::string text : {"# of 2020\n# time q0 contactL\n", "#time q0 contactL\n", "% time q0 contactL\n\n"})
  {
    CAPTURE(text);
    std::size_t rows = 0;
    const ColumnNames names = names_of(text + "0.0 1.5 2\n0.1 1.5 sole\n", &rows);
    CHECK(names.names == Cells{"time", "q0", "contactL"});
    CHECK(rows == 2);
    CHECK(names.assumptions ==
          Cells{fmt::format("the names of the columns are those of the comment in line {}", names.line)});
  }
  const std::string expected = "; expected the names of the columns, such as time,q0,...";
  for (const std::string text :
       {"0,1,2\n", "0;0,5;2\n", "0\t1\t2\n", "0 1 2\n", "# time,q0\n0,1,2\n", "# a,b,c\n0,1,2\n"})
  {
    CAPTURE(text);
    const std::string line = text[0] == '#' ? "2" : "1";
    CHECK(name_refusal(text) == "t.csv:" + line + ": no header: the first line holds only numbers" + expected);
  }
  CHECK(name_refusal("0,1,2,L,sole\n") == "t.csv:1: no header: the first line holds a row of numbers" + expected);
}

TEST_CASE("OpenSim's header says whether angles are in degrees", "[table_text]")
{
  const auto file = [](const std::string& says)
  {
    return "walk\nversion=1\n" + says + "nRows=2\nnColumns=4\nendheader\t\t\ntime\tq0\tx\tdq0\n0\t1\t2\t3\n";
  };
  const double degree = std::numbers::pi / 180.0;
  for (const std::string says : {"inDegrees=yes\n", "inDegrees = YES\r\n", "Angles are in degrees.\n"})
  {
    const ColumnNames names = names_of(file(says));
    CHECK(names.factors == std::vector{1.0, degree, 1.0, degree});
    CHECK(names.assumptions == Cells{"its OpenSim header says inDegrees=yes; converted to rad: q0, dq0"});
    CHECK(names.line == 7);
  }
  CHECK(names_of(file("inDegrees=no\n")).factors == std::vector(4, 1.0));
  CHECK(name_refusal(file("")) == "t.csv:6: found an OpenSim header that does not say the unit of angles; expected "
                                  "inDegrees=yes or inDegrees=no above endheader");
  // a unit beside the name is nearer
  CHECK(names_of("x\ninDegrees=yes\nendheader\ntime q0(rad)\n0 1\n").factors == std::vector{1.0, 1.0});
}

} // namespace table_text_test
